//! The planner `Exact`: at every tick the farthest set point that is admissible from the state the robot is in, moving or not.
//!
//! Translations with zero orientation are decided by the exact domain, all else by the certificate (docs/exact.md).

use nalgebra::Vector3;

use super::bisection::smallest_admissible;
use super::interface::ControllerParameters;
use super::nearest::{nearest_admissible, workspace_facets};
use super::planner::{Planner, Situation, horizontal, is_level, is_worth_it};
use crate::reach::certificate::{Step, certify_within};
use crate::reach::{ExactDomain, Verdict, static_workspace};
use crate::robot::{Pose, TensionLimits};

/// Tension that is left unused beside the limits, as a part of the weight: what holding the tensions over a step may cost.
/// The cost grows with mass, gains and the length of the step; this is 0.1 N with Table I.
const SAMPLING_MARGIN: f64 = 0.0017;
/// The same for long steps and high gains, as a part of the weight for each unit of (λ₀ + η₀) times the step.
const SAMPLING_RATE: f64 = 0.1;
/// Halvings of the way to a turned goal in the search for the last pose on it at which the robot can rest.
const AIM_HALVINGS: i32 = 52;
/// A goal sideways by more than this many times a is looked for in its direction at this distance, because the solver's precision is
/// relative; one lower than that is made for straight.
const FAR: f64 = 100.0;

impl Planner {
    /// The tension that `Exact` leaves unused in every cable beside the limits, N.
    fn allowance(&self, hold: f64) -> f64 {
        let ControllerParameters { robot, lambda, eta, .. } = &self.parameters;
        robot.m * robot.g * SAMPLING_MARGIN.max(SAMPLING_RATE * (lambda + eta) * hold)
    }

    /// Where `Exact` makes for: the goal, or if the robot cannot rest there, a pose where it can, with twice the margin that it keeps on the
    /// way, so that it is not caught on the edge. For a level goal the nearest one at the goal's height, for a turned one the farthest
    /// on the straight way from `from`.
    pub fn exact_aim(&self, from: &Pose, goal: &Pose, hold: f64) -> Pose {
        if goal.0[2] <= 0.0 {
            *goal
        } else if is_level(goal) {
            self.level_aim(goal, hold).unwrap_or(*goal)
        } else {
            self.turned_aim(from, goal, hold)
        }
    }

    /// `None` if there is no such point or the solver gives no answer.
    fn level_aim(&self, goal: &Pose, hold: f64) -> Option<Pose> {
        let ControllerParameters { robot, min_tension, .. } = &self.parameters;
        // G = g (a/2 - n·p) at rest, and u ≥ u_min where G ≥ 3 a u_min/m.
        let inset = |tension: f64| 3.0 * robot.a * tension / (robot.m * robot.g);
        let least = min_tension + self.allowance(hold);
        let point = horizontal(goal);
        if static_workspace(robot).iter().all(|facet| facet.slack(&point) > inset(least)) {
            return Some(*goal);
        }
        let (margin, far) = (inset(2.0 * least - min_tension), FAR * robot.a);
        if goal.0[2] > far {
            return None;
        }
        let point = point * (far / point.x.hypot(point.y)).min(1.0);
        let nearest = nearest_admissible(&point, &workspace_facets(robot), margin).ok()??;
        let mut aim = *goal;
        aim.0.fixed_rows_mut::<2>(0).copy_from(&nearest.point);
        Some(aim)
    }

    fn turned_aim(&self, from: &Pose, goal: &Pose, hold: f64) -> Pose {
        let allowance = self.allowance(hold);
        if self.rests_at(goal, allowance) {
            return *goal;
        }
        let way = Way { from, goal };
        let beta = smallest_admissible(AIM_HALVINGS, |beta| self.rests_at(&way.at(beta), 2.0 * allowance));
        if beta < 1.0 { way.at(beta) } else { *from }
    }

    /// The active set point is admissible from every state on the way to it, so there is always one (docs/exact.md); `None` if it is
    /// that one.
    pub(super) fn exact(&self, now: &Situation, goal: &Pose) -> Option<Pose> {
        if now.set_point == goal || goal.0[2] <= 0.0 {
            return None;
        }
        let next = if now.is_level(goal) { self.translation(now, goal) } else { self.proved(now, goal) };
        next.filter(|next| next == goal || is_worth_it(now.set_point, next))
    }

    fn translation(&self, now: &Situation, goal: &Pose) -> Option<Pose> {
        let (from, to) = (now.set_point.position(), goal.position());
        let domain = self.domain(now, self.parameters.max_tension);
        if domain.contains(&to) {
            return Some(*goal);
        }
        let certain = domain.farthest(&from, &to);
        // The exact domain is too cautious about the upper limit: what that alone forbids is asked of the certificate.
        let open = self.domain(now, f64::INFINITY).farthest(&from, &to)?;
        let partway = |share: f64| {
            let mut set_point = *goal;
            set_point.0.fixed_rows_mut::<3>(0).copy_from(&(from + (to - from) * share));
            set_point
        };
        let proved = if certain < Some(open) { self.proved(now, &partway(open)) } else { None };
        let left = |set_point: &Pose| (to - set_point.position()).norm();
        proved.into_iter().chain(certain.map(partway)).min_by(|a, b| left(a).total_cmp(&left(b)))
    }

    /// The exact domain under the tensions that `Exact` allows.
    fn domain(&self, now: &Situation, max: f64) -> ExactDomain {
        let ControllerParameters { robot, min_tension, .. } = &self.parameters;
        let limits = TensionLimits { min: min_tension + self.allowance(now.hold), max };
        let velocity: Vector3<f64> = now.rates.fixed_rows::<3>(0).into_owned();
        ExactDomain::new(robot, &self.parameters.gains(), limits, now.pose.position(), velocity)
    }

    /// (17) with the certificate: the farthest set point found on the straight way to `goal` in six coordinates.
    fn proved(&self, now: &Situation, goal: &Pose) -> Option<Pose> {
        let way = Way { from: now.set_point, goal };
        let beta =
            smallest_admissible(self.parameters.bisection_steps, |beta| self.is_proved(now, &way.at(beta)));
        (beta < 1.0).then(|| way.at(beta))
    }

    /// Whether the certificate proves the step to `set_point`. Undecided is no.
    fn is_proved(&self, now: &Situation, set_point: &Pose) -> bool {
        let allowance = self.allowance(now.hold);
        let TensionLimits { min, max } = self.rig.limits;
        let limits = TensionLimits { min: min + allowance, max: max - allowance };
        let step = Step {
            start: *now.pose,
            rates: *now.rates,
            set_point: *set_point,
            gains: self.parameters.gains(),
        };
        matches!(certify_within(&self.rig, &limits, &step), Ok(Verdict::Admissible { .. }))
    }
}

/// The straight way in six coordinates; angles turn the short way round.
struct Way<'a> {
    from: &'a Pose,
    goal: &'a Pose,
}

impl Way<'_> {
    /// x_f + β (x_prev - x_f), Eq. (17).
    fn at(&self, beta: f64) -> Pose {
        Pose(self.goal.0 + self.from.minus(self.goal) * beta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PlannerKind;
    use crate::robot::Coordinates;

    fn planner() -> Planner {
        Planner::from(ControllerParameters { planner: PlannerKind::Exact, ..Default::default() })
    }

    fn yaw(angle: f64) -> Pose {
        Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, angle))
    }

    fn next(pose: &Pose, rates: &Coordinates, set_point: &Pose, goal: &Pose) -> Option<Pose> {
        planner().next_set_point(&Situation { pose, rates, set_point, hold: 1e-3 }, goal)
    }

    #[test]
    fn the_papers_move_a_rise_and_a_turn_take_one_step_each() {
        let (start, at_rest) = (Pose::default(), Coordinates::zeros());
        for goal in [Pose::at(0.15, 0.15, 1.0), Pose::at(-0.1, 0.05, 0.8), yaw(0.9)] {
            assert_eq!(next(&start, &at_rest, &start, &goal), Some(goal));
        }
    }

    #[test]
    fn a_turn_too_far_for_one_step_goes_as_far_as_is_proved() {
        let (start, at_rest) = (Pose::default(), Coordinates::zeros());
        // At rest cables go slack at π/3.
        let first = next(&start, &at_rest, &start, &yaw(1.2)).unwrap();
        assert!(first.0[5] > 1.0 && first.0[5] < std::f64::consts::FRAC_PI_3, "{first:?}");
        assert_eq!(
            first.0[5] / 1.2 * 256.0,
            (first.0[5] / 1.2 * 256.0).round(),
            "not on the grid of Eq. (17)"
        );
    }

    #[test]
    fn a_turn_can_be_taken_back_on_the_way() {
        let (pose, rates) = (yaw(0.3), Coordinates::new(0.1, 0.0, 0.05, 0.0, 0.0, 0.8));
        assert_eq!(next(&pose, &rates, &yaw(0.9), &Pose::default()), Some(Pose::default()));
    }

    #[test]
    fn the_active_set_point_turns_back_though_the_robot_is_still_level() {
        let goal = Pose::at(0.05, 0.0, 1.0);
        assert_eq!(next(&Pose::default(), &Coordinates::zeros(), &yaw(0.5), &goal), Some(goal));
    }

    #[test]
    fn where_the_robot_cannot_rest_is_unreachable_and_aimed_at_from_inside() {
        let (planner, start) = (planner(), Pose::default());
        assert!(planner.is_reachable(&start, &yaw(1.0)));
        for goal in [yaw(1.1), yaw(std::f64::consts::FRAC_PI_2), Pose::at(0.0, 0.0, -1.0)] {
            assert!(!planner.is_reachable(&start, &goal), "{goal:?}");
        }
        // Tensions vanish at π/3; here 0.2 N are left.
        let aim = planner.exact_aim(&start, &yaw(1.1), 1e-3);
        let kept = 2.0 * planner.allowance(1e-3);
        assert!(planner.rests_at(&aim, kept) && !planner.rests_at(&yaw(aim.0[5] + 1e-9), kept), "{aim:?}");
    }
}
