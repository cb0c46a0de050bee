//! Eq. (17): the next set point on the way to the goal.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::bisection::smallest_admissible;
use super::interface::{ControllerParameters, PlannerKind};
use crate::reach::{BoundedDomain, Curve, ExactDomain, static_workspace};
use crate::robot::{Coordinates, Geometry, Pose, Rig, TensionLimits, dynamics::static_tensions};

/// The motion counts as at rest below these rates, m/s and rad/s,
const REST_SPEED: f64 = 2e-3;
const REST_ANGULAR_RATE: f64 = 1e-2;
/// and as being at a pose within these distances, m and rad.
const NEAR_POSITION: f64 = 2e-3;
const NEAR_ANGLE: f64 = 1e-2;

/// A set point nearer than this to the last one is not worth giving, m and rad.
const SMALLEST_STEP: f64 = 1e-5;
const SMALLEST_TURN: f64 = 5e-5;

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

    /// Whether the motion is, and a step to `goal` would be, a translation with zero orientation.
    pub(super) fn is_level(&self, goal: &Pose) -> bool {
        let turning = self.rates.fixed_rows::<3>(3).amax();
        turning < REST_ANGULAR_RATE && [self.pose, self.set_point, goal].into_iter().all(is_level)
    }
}

/// Gives set points towards a goal. It is its parameters, and what follows from them: the geometry, and the rig that the certificate asks
/// for. Copies share the rig, so that copying allocates nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "ControllerParameters", into = "ControllerParameters")]
pub struct Planner {
    pub(super) parameters: ControllerParameters,
    pub(super) geometry: Geometry,
    pub(super) rig: Arc<Rig>,
}

impl From<ControllerParameters> for Planner {
    fn from(parameters: ControllerParameters) -> Self {
        let limits = TensionLimits { min: parameters.min_tension, max: parameters.max_tension };
        let robot = &parameters.robot;
        let rig = Arc::new(Rig::triangular(robot, limits));
        Self { parameters, geometry: Geometry::new(robot), rig }
    }
}

impl From<Planner> for ControllerParameters {
    fn from(planner: Planner) -> Self {
        planner.parameters
    }
}

impl Planner {
    /// The set point to give now; `None` if there is none nearer to the goal, or, for (15), not before the robot rests.
    pub fn next_set_point(&self, now: &Situation, goal: &Pose) -> Option<Pose> {
        match self.parameters.planner {
            PlannerKind::Bounded if now.is_steady() => bounded(&self.parameters, now.set_point, goal),
            PlannerKind::Bounded => None,
            PlannerKind::Exact => self.exact(now, goal),
        }
    }

    /// Whether the robot can rest at the goal with every tension within its limits, and the planner's domain speaks of the motion to it: for
    /// (15) a move in x and y at constant height, for the exact domain any.
    pub fn is_reachable(&self, from: &Pose, goal: &Pose) -> bool {
        match self.parameters.planner {
            PlannerKind::Bounded => {
                let at_goal = goal.position();
                let domain = within_limits(&self.parameters, at_goal, Vector3::zeros());
                is_horizontal(from, goal) && domain.contains(&at_goal)
            }
            PlannerKind::Exact => goal.0[2] > 0.0 && self.rests_at(goal, 0.0),
        }
    }

    /// Whether at rest every tension keeps `allowance` (N) from its limits.
    pub(super) fn rests_at(&self, pose: &Pose, allowance: f64) -> bool {
        let ControllerParameters { min_tension, max_tension, robot, .. } = &self.parameters;
        let within = |u: f64| u > min_tension + allowance && u < max_tension - allowance;
        static_tensions(robot, &self.geometry, pose).is_some_and(|tension| tension.into_iter().all(within))
    }

    /// From a pose to the goal, m: the way of the attachment that has the farthest to go. For equal angles, the way of them all.
    pub fn distance(&self, pose: &Pose, goal: &Pose) -> f64 {
        let (way, from, to) = (goal.position() - pose.position(), pose.rotation(), goal.rotation());
        let ways = self.geometry.attachment.iter().map(|b| way + (to * b - from * b));
        let length = |way: Vector3<f64>| way.x.hypot(way.y).hypot(way.z);
        ways.map(length).fold(0.0, f64::max).min(f64::MAX)
    }
}

/// Whether a step this far is worth giving.
pub(super) fn is_worth_it(from: &Pose, to: &Pose) -> bool {
    let way = to.minus(from);
    way.fixed_rows::<3>(0).norm() > SMALLEST_STEP || way.fixed_rows::<3>(3).amax() > SMALLEST_TURN
}

/// The exact domain under the tensions that the drives allow.
fn within_limits(
    parameters: &ControllerParameters,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
) -> ExactDomain {
    let limits = TensionLimits { min: parameters.min_tension, max: parameters.max_tension };
    ExactDomain::new(&parameters.robot, &parameters.gains(), limits, position, velocity)
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
    let limits = within_limits(parameters, start, Vector3::zeros());
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

fn is_horizontal(from: &Pose, goal: &Pose) -> bool {
    goal.0[2] > 0.0 && is_level(from) && is_level(goal) && (from.0[2] - goal.0[2]).abs() < NEAR_POSITION
}

/// Whether an orientation counts as zero.
pub(super) fn is_level(pose: &Pose) -> bool {
    pose.0.fixed_rows::<3>(3).amax() < NEAR_ANGLE
}

pub(super) fn horizontal(pose: &Pose) -> Vector2<f64> {
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
        let planner = Planner::from(ControllerParameters::default());
        for goal in [
            Pose::at(0.1, 0.0, 0.9),
            Pose::at(0.0, 0.0, -1.0),
            Pose(Coordinates::new(0.1, 0.0, 1.0, 0.0, 0.0, 0.2)),
        ] {
            assert_eq!(bounded(&planner.parameters, &Pose::default(), &goal), None);
            assert!(!planner.is_reachable(&Pose::default(), &goal));
        }
    }

    #[test]
    fn a_goal_outside_is_approached_from_inside() {
        let planner = Planner::from(ControllerParameters::default());
        let goal = Pose::at(0.0, 0.4, 1.0);
        let mut from = Pose::default();
        while let Some(next) = bounded(&planner.parameters, &from, &goal) {
            from = next;
        }
        let inside = crate::reach::in_static_workspace(&planner.parameters.robot, &horizontal(&from));
        assert!(from.0[1] > 0.2 && inside, "{from:?}");
        assert!(!planner.is_reachable(&from, &goal));
    }

    #[test]
    fn the_distance_of_a_turned_goal_is_the_way_of_the_attachments() {
        let planner = Planner::from(ControllerParameters::default());
        let here = Pose::default();
        assert_eq!(planner.distance(&here, &Pose::at(0.3, 0.0, 0.6)), 0.5);
        // A quarter of a turn takes an attachment along a chord of √2 radii.
        let turned = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2));
        let expected = 2f64.sqrt() * planner.geometry.platform_radius();
        assert!((planner.distance(&here, &turned) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_saved_planner_comes_back_with_its_rig() {
        let robot = crate::robot::RobotParameters { m: 7.0, ..Default::default() };
        let planner = Planner::from(ControllerParameters { robot, ..Default::default() });
        let bytes = postcard::to_stdvec(&planner).unwrap();
        assert_eq!(postcard::from_bytes::<Planner>(&bytes).unwrap(), planner);
        assert_eq!(bytes, postcard::to_stdvec(&planner.parameters).unwrap());
    }
}
