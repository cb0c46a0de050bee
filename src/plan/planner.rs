//! Eq. (17): the next set point on the way to the goal.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::interface::{ControllerParameters, PlannerKind};
use crate::robot::pose::PITCH;
use crate::robot::{
    CABLES, Coordinates, Geometry, PerCable, Pose, Rig, TensionLimits, dynamics::static_tensions,
};

/// The motion counts as at rest below these rates, m/s and rad/s,
const REST_SPEED: f64 = 2e-3;
const REST_ANGULAR_RATE: f64 = 1e-2;
/// and as being at a pose within these distances, m and rad.
const NEAR_POSITION: f64 = 2e-3;
const NEAR_ANGLE: f64 = 1e-2;

/// Beyond this pitch, rad, the angles no longer tell the orientation.
pub(super) const LARGEST_PITCH: f64 = 1.4;
/// Pitch up to which the planner sends the robot, which may be a little off.
pub const STEEPEST: f64 = LARGEST_PITCH - NEAR_ANGLE;
/// Nothing is to be had farther than this many times a from the centre of the base.
pub const FAR: f64 = 100.0;

/// A set point nearer than this to the last one is not worth giving, m and rad.
pub(super) const SMALLEST_STEP: f64 = 1e-5;
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

    /// Whether the motion is, to within what counts as rest, and a step to `goal` would be, a translation with zero orientation.
    pub(super) fn is_level(&self, goal: &Pose) -> bool {
        let turning = self.rates.fixed_rows::<3>(3).amax();
        turning < REST_ANGULAR_RATE
            && is_upright(goal)
            && [self.pose, self.set_point].into_iter().all(is_level)
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
            PlannerKind::Bounded if now.is_steady() => {
                let next = self.bounded(now.set_point, goal);
                // What is left of a motion must not slacken a cable either: then it has to wait. (15) itself has room for held commands.
                next.filter(|next| self.is_proved(&Situation { hold: 0.0, ..*now }, next, 0.0))
            }
            PlannerKind::Bounded => None,
            PlannerKind::Exact => self.exact(now, goal),
        }
    }

    /// Whether there is a set point that is not given yet, but will be when the robot has come closer to rest.
    pub fn waits(&self, now: &Situation, goal: &Pose) -> bool {
        self.parameters.planner == PlannerKind::Bounded && self.bounded(now.set_point, goal).is_some()
    }

    /// Whether the robot can rest at the goal with every tension within its limits, and the planner's domain speaks of the motion to it: for
    /// (15) a move in x and y at constant height, for the exact domain any.
    pub fn is_reachable(&self, from: &Pose, goal: &Pose) -> bool {
        match self.parameters.planner {
            PlannerKind::Bounded => is_horizontal(from, goal) && self.rests_at(goal, 0.0),
            PlannerKind::Exact => self.rests_at(goal, 0.0),
        }
    }

    /// Whether the robot can be at rest at this pose, every tension `allowance` (N) inside its limits.
    pub(super) fn rests_at(&self, pose: &Pose, allowance: f64) -> bool {
        self.margin_at(pose) > allowance
    }

    /// How far inside its limits every tension is at rest, N; less than nothing where the robot cannot be at rest.
    pub(super) fn margin_at(&self, pose: &Pose) -> f64 {
        let ControllerParameters { min_tension, max_tension, robot, .. } = &self.parameters;
        let is_sensible =
            pose.0[2] > 0.0 && pose.position().amax() <= FAR * robot.a && pose.0[PITCH].abs() < STEEPEST;
        let tension = static_tensions(robot, &self.geometry, pose).filter(|_| is_sensible);
        let margin = |u: f64| (u - min_tension).min(max_tension - u);
        tension.map_or(f64::NEG_INFINITY, |u| u.into_iter().map(margin).fold(f64::INFINITY, f64::min))
    }

    /// From a pose to the goal, m: the root mean square of the ways of the attachments. For equal orientations the way of them all.
    pub fn distance(&self, pose: &Pose, goal: &Pose) -> f64 {
        // Of numbers that do not overflow when they are squared.
        let ways = self.ways(pose, goal);
        let largest = ways.iter().map(Vector3::amax).fold(0.0, f64::max).min(f64::MAX);
        if largest == 0.0 {
            return 0.0;
        }
        let squares: f64 = ways.iter().map(|way| (way / largest).norm_squared()).sum();
        (largest * (squares / CABLES as f64).sqrt()).min(f64::MAX)
    }

    /// The ways of the attachments from a pose to the goal, m.
    pub(super) fn ways(&self, pose: &Pose, goal: &Pose) -> PerCable<Vector3<f64>> {
        let (way, from, to) = (goal.position() - pose.position(), pose.rotation(), goal.rotation());
        self.geometry.attachment.map(|b| way + (to * b - from * b))
    }
}

/// Whether a step this far is worth giving.
pub(super) fn is_worth_it(from: &Pose, to: &Pose) -> bool {
    let way = to.minus(from);
    way.fixed_rows::<3>(0).norm() > SMALLEST_STEP || way.fixed_rows::<3>(3).amax() > SMALLEST_TURN
}

/// Whether (15) speaks of the motion.
pub(super) fn is_horizontal(from: &Pose, goal: &Pose) -> bool {
    goal.0[2] > 0.0 && is_level(from) && is_level(goal) && (from.0[2] - goal.0[2]).abs() < NEAR_POSITION
}

/// Whether an orientation counts as zero.
fn is_level(pose: &Pose) -> bool {
    tilt(pose) < NEAR_ANGLE
}

/// Whether it is zero.
pub(super) fn is_upright(pose: &Pose) -> bool {
    tilt(pose) == 0.0
}

/// The largest of the angles, whole turns apart, rad.
fn tilt(pose: &Pose) -> f64 {
    pose.minus(&Pose::default()).fixed_rows::<3>(3).amax()
}

pub(super) fn horizontal(pose: &Pose) -> Vector2<f64> {
    Vector2::new(pose.0[0], pose.0[1])
}

#[cfg(test)]
mod tests {
    use super::*;

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
