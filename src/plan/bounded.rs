//! The planner `Bounded`, the paper's: Eq. (17) with the domain (15).

use super::bisection::smallest_admissible;
use super::planner::{MOST_SPANS, Planner, Situation, horizontal};
use crate::reach::BoundedDomain;
use crate::robot::{Coordinates, Pose};

impl Planner {
    /// (17) with the domain (15), which assumes x'₀ = 0 at the last set point; `None` if there is no nearer one.
    ///
    /// Two things are asked beyond the paper. The robot must be able to rest at the set point with a little tension to spare, because "at
    /// rest" is not quite that; and the tensions must keep the drives' limits on the way, of which (15) knows only that no cable is slack.
    pub(super) fn bounded(&self, from: &Pose, goal: &Pose) -> Option<Pose> {
        let shape = self.shape?;
        if from == goal || !self.is_horizontal(from, goal) {
            return None;
        }
        let parameters = &self.parameters;
        let in_plane = shape.to_paper(goal);
        let (x_prev, x_f) = (horizontal(&shape.to_paper(from)), horizontal(&in_plane));
        let place = |beta: f64| x_f + (x_prev - x_f) * beta; // (17)
        let at = |beta: f64| {
            let mut set_point = in_plane;
            set_point.0.fixed_rows_mut::<2>(0).copy_from(&place(beta));
            if beta == 0.0 { *goal } else { shape.to_rig(&set_point) }
        };
        let domain = BoundedDomain::new(&shape.robot, &parameters.gains(), x_prev, in_plane.0[2]);
        let mut spans = MOST_SPANS;
        let rates = Coordinates::zeros();
        let at_rest = Situation { pose: from, rates: &rates, set_point: from, hold: 0.0, rest: self.rest };
        let beta = smallest_admissible(parameters.bisection_steps, |beta| {
            let x_d = at(beta);
            domain.contains(&place(beta))
                && self.rests_at(&x_d, self.allowance())
                && self.is_proved(&at_rest, &x_d, 0.0, &mut spans)
        });
        let worth_it = beta == 0.0 || (place(beta) - x_prev).norm() > self.smallest_step();
        (beta < 1.0 && worth_it).then(|| at(beta))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::plan::ControllerParameters;
    use crate::reach::static_workspace;
    use crate::robot::RobotParameters;

    #[test]
    fn literal_sequence_has_four_set_points_on_the_diagonal() {
        let parameters = ControllerParameters::default();
        let goal = Pose::at(0.15, 0.15, 1.0);
        let mut sequence = vec![];
        let mut from = Pose::default();
        while let Some(next) = Planner::from(parameters).bounded(&from, &goal) {
            sequence.push(next.0[0]);
            assert_eq!(next.0[0], next.0[1]);
            from = next;
        }
        let expected = [0.0855, 0.1266, 0.1464, 0.15];
        assert_eq!(sequence.len(), expected.len(), "{sequence:?}");
        for (x, expected) in sequence.iter().zip(expected) {
            assert!((x - expected).abs() < 5e-5, "{sequence:?}");
        }
    }

    #[test]
    fn other_motions_than_horizontal_ones_get_no_set_point() {
        let planner = Planner::from(ControllerParameters::default());
        for goal in [
            Pose::at(0.1, 0.0, 0.9),
            Pose::at(0.0, 0.0, -1.0),
            Pose(Coordinates::new(0.1, 0.0, 1.0, 0.0, 0.0, 0.2)),
        ] {
            assert_eq!(planner.bounded(&Pose::default(), &goal), None);
            assert!(!planner.is_reachable(&Pose::default(), &goal));
        }
    }

    #[test]
    fn a_goal_outside_is_approached_from_inside() {
        let planner = Planner::from(ControllerParameters::default());
        let goal = Pose::at(0.0, 0.4, 1.0);
        let mut from = Pose::default();
        while let Some(next) = planner.bounded(&from, &goal) {
            from = next;
        }
        let inside = crate::reach::in_static_workspace(&RobotParameters::default(), &horizontal(&from));
        assert!(from.0[1] > 0.2 && inside, "{from:?}");
        assert!(!planner.is_reachable(&from, &goal));
    }

    /// (15) and (17) and nothing else.
    fn literal(
        parameters: &ControllerParameters,
        x_prev: &Vector2<f64>,
        x_f: &Vector2<f64>,
        z: f64,
    ) -> Vector2<f64> {
        let domain = BoundedDomain::new(&RobotParameters::default(), &parameters.gains(), *x_prev, z);
        let at = |beta: f64| x_f + (x_prev - x_f) * beta;
        at(smallest_admissible(parameters.bisection_steps, |beta| domain.contains(&at(beta))))
    }

    #[test]
    fn set_points_are_the_papers_bit_for_bit() {
        let mut rng = Pcg64::seed_from_u64(45);
        let facets = static_workspace(&Default::default());
        let mut compared = 0;
        for _ in 0..1000 {
            let mut point = || loop {
                let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
                if facets.iter().all(|facet| facet.slack(&point) > 3e-3) {
                    return point;
                }
            };
            let (mut from, goal) = (point(), point());
            let z = rng.random_range(0.3..2.0);
            let (lambda, eta) = (rng.random_range(1.0..8.0), rng.random_range(1.0..8.0));
            let parameters = ControllerParameters { lambda, eta, ..Default::default() };
            let (planner, pose) = (Planner::from(parameters), |p: &Vector2<f64>| Pose::at(p.x, p.y, z));
            while let Some(next) = planner.bounded(&pose(&from), &pose(&goal)) {
                let expected = literal(&parameters, &from, &goal, z);
                assert_eq!(
                    horizontal(&next),
                    expected,
                    "from {from} to {goal} at z = {z}, gains {lambda}, {eta}"
                );
                from = expected;
                compared += 1;
            }
            let left = (goal - from).norm();
            let step = (literal(&parameters, &from, &goal, z) - from).norm();
            assert!(
                left == 0.0 || step <= planner.smallest_step(),
                "stopped {left} m short, where the paper goes {step} m"
            );
        }
        println!("{compared} set points");
    }
}
