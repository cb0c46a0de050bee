//! Eq. (17): the next set point on the way to the goal.

use nalgebra::{Vector2, Vector3};

use super::bisection::smallest_admissible;
use super::interface::{ControllerParameters, PlannerKind};
use super::nearest::{nearest_admissible, workspace_facets};
use crate::reach::{BoundedDomain, Curve, ExactDomain, static_workspace};
use crate::robot::{Coordinates, Pose, TensionLimits};

/// The motion counts as at rest below these rates, m/s and rad/s,
const REST_SPEED: f64 = 2e-3;
const REST_ANGULAR_RATE: f64 = 1e-2;
/// and as being at a pose within these distances, m and rad.
const NEAR_POSITION: f64 = 2e-3;
const NEAR_ANGLE: f64 = 1e-2;

/// Tension that the exact domain leaves unused beside `minTension`, as a part of the weight: what holding the tensions over a step may cost.
/// The cost grows with mass, gains and the length of the step; this is 0.1 N with Table I.
const SAMPLING_MARGIN: f64 = 0.0017;
/// The same for long steps and high gains, as a part of the weight for each unit of (λ₀ + η₀) times the step.
const SAMPLING_RATE: f64 = 0.1;
/// A set point nearer than this to the last one is not worth giving, m.
const SMALLEST_STEP: f64 = 1e-5;

/// What the planner starts from: where the robot is, how it moves, where it was last told to go.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Estimated pose.
    pub pose: &'a Pose,
    /// Estimated rates, m/s and rad/s.
    pub rates: &'a Coordinates,
    /// The active set point.
    pub set_point: &'a Pose,
    /// For how long a command is held, s.
    pub hold: f64,
}

impl Situation<'_> {
    /// The steady-state test of Fig. 4: at rest at the set point, to within what counts as that.
    pub fn is_steady(&self) -> bool {
        self.is_steady_within(1.0)
    }

    /// The same with all tolerances multiplied.
    pub fn is_steady_within(&self, factor: f64) -> bool {
        let error = self.pose.minus(self.set_point);
        error.fixed_rows::<3>(0).norm() < factor * NEAR_POSITION
            && error.fixed_rows::<3>(3).amax() < factor * NEAR_ANGLE
            && self.rates.fixed_rows::<3>(0).norm() < factor * REST_SPEED
            && self.rates.fixed_rows::<3>(3).amax() < factor * REST_ANGULAR_RATE
    }
}

/// Whether the robot can rest at the goal with every tension within its limits, and the planner's domain speaks of the motion to it: for
/// (15) a move in x and y at constant height, for the exact domain any translation; both with zero orientation.
pub fn is_reachable(parameters: &ControllerParameters, from: &Pose, goal: &Pose) -> bool {
    let covered = match parameters.planner {
        PlannerKind::Bounded => is_horizontal(from, goal),
        PlannerKind::Exact => is_translation(from, goal),
    };
    let at_goal = goal.position();
    covered && within_limits(parameters, at_goal, Vector3::zeros(), parameters.min_tension).contains(&at_goal)
}

/// The tension that `Exact` keeps in every cable, N.
fn least_tension(parameters: &ControllerParameters, hold: f64) -> f64 {
    let ControllerParameters { robot, lambda, eta, min_tension, .. } = parameters;
    min_tension + robot.m * robot.g * SAMPLING_MARGIN.max(SAMPLING_RATE * (lambda + eta) * hold)
}

/// Where `Exact` makes for: the goal, or if the robot cannot rest there, the nearest point at the goal's height where it can, with twice the
/// margin that it keeps on the way, so that it is not caught on the edge. `None` for a goal that is no translation away, or if the solver gives no answer.
pub fn exact_aim(parameters: &ControllerParameters, from: &Pose, goal: &Pose, hold: f64) -> Option<Pose> {
    if !is_translation(from, goal) {
        return None;
    }
    let robot = &parameters.robot;
    // G = g (a/2 - n·p) at rest, and u ≥ u_min where G ≥ 3 a u_min/m.
    let inset = |tension: f64| 3.0 * robot.a * tension / (robot.m * robot.g);
    let least = least_tension(parameters, hold);
    let point = horizontal(goal);
    if static_workspace(robot).iter().all(|facet| facet.slack(&point) > inset(least)) {
        return Some(*goal);
    }
    let margin = inset(2.0 * least - parameters.min_tension);
    let nearest = nearest_admissible(&point, &workspace_facets(robot), margin).ok()??;
    let mut aim = *goal;
    aim.0.fixed_rows_mut::<2>(0).copy_from(&nearest.point);
    aim.0.iter().all(|coordinate| coordinate.is_finite()).then_some(aim)
}

/// The exact domain under the tensions that the drives allow.
fn within_limits(
    parameters: &ControllerParameters,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    min: f64,
) -> ExactDomain {
    let limits = TensionLimits { min, max: parameters.max_tension };
    ExactDomain::new(&parameters.robot, &parameters.gains(), limits, position, velocity)
}

/// The set point to give now; `None` if there is none nearer to the goal, or, for (15), not before the robot rests.
pub fn next_set_point(parameters: &ControllerParameters, now: &Situation, goal: &Pose) -> Option<Pose> {
    match parameters.planner {
        PlannerKind::Bounded if now.is_steady() => bounded(parameters, now.set_point, goal),
        PlannerKind::Bounded => None,
        PlannerKind::Exact => exact(parameters, now, goal),
    }
}

/// (17) with the domain (15), which assumes x'₀ = 0 at the last set point. What "at rest" leaves of a motion must not slacken a
/// cable either, so a set point keeps that much from the border of the workspace; and the drives' limits hold, which (15) does not know.
fn bounded(parameters: &ControllerParameters, from: &Pose, goal: &Pose) -> Option<Pose> {
    if from == goal || !is_horizontal(from, goal) {
        return None;
    }
    let (x_prev, x_f, z_c) = (horizontal(from), horizontal(goal), goal.0[2]);
    let at = |beta: f64| x_f + (x_prev - x_f) * beta; // (17)
    let domain = BoundedDomain::new(&parameters.robot, &parameters.gains(), x_prev, z_c);
    let start = Vector3::new(x_prev.x, x_prev.y, z_c);
    let limits = within_limits(parameters, start, Vector3::zeros(), parameters.min_tension);
    let allowance = rest_allowance(parameters, z_c);
    let facets = static_workspace(&parameters.robot);
    let beta = smallest_admissible(parameters.bisection_steps, |beta| {
        let x_d = at(beta);
        domain.contains(&x_d)
            && facets.iter().all(|facet| facet.slack(&x_d) > allowance)
            && limits.contains(&Vector3::new(x_d.x, x_d.y, z_c))
    });
    let mut set_point = *goal;
    set_point.0.fixed_rows_mut::<2>(0).copy_from(&at(beta));
    let worth_it = beta == 0.0 || (at(beta) - x_prev).norm() > SMALLEST_STEP;
    (beta < 1.0 && worth_it).then_some(set_point)
}

/// How far p = x + x'' z/g strays, m, on the way to rest from a state that counts as at rest: the error in position answers with
/// ψ = f + (z/g) f'', the velocity with χ = φ + (z/g) φ''.
fn rest_allowance(parameters: &ControllerParameters, z: f64) -> f64 {
    let gains = parameters.gains();
    let (c, sum, omega2) = (z / parameters.robot.g, gains.lambda + gains.eta, gains.omega_n_squared());
    let largest = |b: f64, c: f64| {
        let extremes = Curve { a: 0.0, b, c, d: 0.0 }.extremes(&gains);
        extremes.max.max(-extremes.min)
    };
    let psi = largest(1.0 - c * omega2, c * omega2 * sum);
    let chi = largest(-c * sum, 1.0 + c * (sum * sum - omega2));
    NEAR_POSITION * psi + REST_SPEED * chi
}

/// The farthest set point towards the goal that is admissible from the state the robot is in, moving or not. The active set point is
/// admissible from every state on the way to it, so there is always one (docs/exact.md).
fn exact(parameters: &ControllerParameters, now: &Situation, goal: &Pose) -> Option<Pose> {
    let turning = now.rates.fixed_rows::<3>(3).amax();
    if now.set_point == goal || !is_translation(now.pose, goal) || turning >= REST_ANGULAR_RATE {
        return None;
    }
    let velocity = now.rates.fixed_rows::<3>(0).into_owned();
    let least = least_tension(parameters, now.hold);
    let domain = within_limits(parameters, now.pose.position(), velocity, least);
    let (from, to) = (now.set_point.position(), goal.position());
    if domain.contains(&to) {
        return Some(*goal);
    }
    let way = (to - from) * domain.farthest(&from, &to)?;
    let mut set_point = *goal;
    set_point.0.fixed_rows_mut::<3>(0).copy_from(&(from + way));
    (way.norm() > SMALLEST_STEP).then_some(set_point)
}

fn is_horizontal(from: &Pose, goal: &Pose) -> bool {
    is_translation(from, goal) && (from.0[2] - goal.0[2]).abs() < NEAR_POSITION
}

fn is_translation(from: &Pose, goal: &Pose) -> bool {
    let level = |pose: &Pose| pose.0.fixed_rows::<3>(3).amax() < NEAR_ANGLE;
    goal.0[2] > 0.0 && level(from) && level(goal)
}

fn horizontal(pose: &Pose) -> Vector2<f64> {
    Vector2::new(pose.0[0], pose.0[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_sequence_has_four_set_points_on_the_diagonal() {
        let parameters = ControllerParameters::default();
        let goal = Pose::at(0.15, 0.15, 1.0);
        let mut sequence = vec![];
        let mut from = Pose::default();
        while let Some(next) = bounded(&parameters, &from, &goal) {
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
        let parameters = ControllerParameters::default();
        for goal in [
            Pose::at(0.1, 0.0, 0.9),
            Pose::at(0.0, 0.0, -1.0),
            Pose(Coordinates::new(0.1, 0.0, 1.0, 0.0, 0.0, 0.2)),
        ] {
            assert_eq!(bounded(&parameters, &Pose::default(), &goal), None);
            assert!(!is_reachable(&parameters, &Pose::default(), &goal));
        }
    }

    #[test]
    fn a_goal_outside_is_approached_from_inside() {
        let parameters = ControllerParameters::default();
        let goal = Pose::at(0.0, 0.4, 1.0);
        let mut from = Pose::default();
        while let Some(next) = bounded(&parameters, &from, &goal) {
            from = next;
        }
        assert!(
            from.0[1] > 0.2 && crate::reach::in_static_workspace(&parameters.robot, &horizontal(&from)),
            "{from:?}"
        );
        assert!(!is_reachable(&parameters, &from, &goal));
    }

    #[test]
    fn exact_takes_the_papers_move_in_one_step_and_a_rise_as_well() {
        let parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
        let start = Pose::default();
        let now = Situation { pose: &start, rates: &Coordinates::zeros(), set_point: &start, hold: 1e-3 };
        for goal in [Pose::at(0.15, 0.15, 1.0), Pose::at(-0.1, 0.05, 0.8)] {
            assert_eq!(next_set_point(&parameters, &now, &goal), Some(goal));
        }
    }
}
