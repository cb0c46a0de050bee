//! Eq. (17): the next set point on the way to the goal.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::aim::Search;
use super::interface::{ControllerParameters, PlannerKind, Rest, size};
use super::minimum_time::Course;
use crate::control::estimator::FASTEST_DIVERGENCE;
use crate::control::{static_margin, static_tensions, swing};
use crate::robot::pose::{LARGEST_PITCH, PITCH};
use crate::robot::{Coordinates, ParameterError, PerCable, Pose, Rig, Shape, TensionLimits};

/// Spans of time that the certificate looks at in one decision, for all the set points that are tried: what bounds the work.
pub(super) const MOST_SPANS: usize = 600;
/// Pitch up to which the planner sends the robot, which may be a little off.
pub const STEEPEST: f64 = LARGEST_PITCH - 1e-2;
/// No pose is reachable farther than this many radii of the rig from the middle of its anchors.
pub const FAR: f64 = 100.0;

/// A set point nearer to the last one than this share of what counts as rest is not worth giving.
const SMALLEST_STEP: f64 = 0.005;

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
    /// What counts as rest.
    pub rest: Rest,
}

impl Situation<'_> {
    /// The steady-state test of Fig. 4: at rest at the set point, to within what counts as that.
    pub fn is_steady(&self) -> bool {
        self.is_steady_within(1.0, 1.0)
    }

    /// The same with the tolerances of the pose and of the rates multiplied.
    pub fn is_steady_within(&self, of_pose: f64, of_rates: f64) -> bool {
        let error = self.pose.minus(self.set_point);
        let is_within = |q: &Coordinates, factor: f64| {
            q.fixed_rows::<3>(0).norm() < factor * self.rest.position
                && q.fixed_rows::<3>(3).amax() < factor * self.rest.angle
        };
        is_within(&error, of_pose) && is_within(self.rates, of_rates)
    }

    /// Whether the motion is, to within what counts as rest, and a step to `goal` would be, a translation of the paper's robot with zero
    /// orientation.
    pub(super) fn is_level(&self, shape: &Shape, goal: &Pose) -> bool {
        let turning = self.rates.fixed_rows::<3>(3).amax();
        turning < self.rest.angle
            && is_upright(&shape.to_paper(goal))
            && [self.pose, self.set_point]
                .into_iter()
                .all(|pose| tilt(&shape.to_paper(pose)) < self.rest.angle)
    }
}

/// Gives set points towards a goal: its parameters, and what follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SavedParameters", into = "ControllerParameters")]
pub struct Planner {
    pub(super) parameters: ControllerParameters,
    /// The paper's robot, where the rig is that.
    pub(super) shape: Option<Shape>,
    pub(super) rest: Rest,
    /// The rig's size in units of the paper's.
    pub(super) size: f64,
    pub(super) middle: Vector3<f64>,
    /// Farthest from there that poses are looked at, m.
    pub(super) far: f64,
}

impl From<ControllerParameters> for Planner {
    fn from(parameters: ControllerParameters) -> Self {
        let rig = &parameters.rig;
        Self {
            shape: Shape::of(rig).ok(),
            rest: parameters.rest(),
            size: size(rig),
            middle: rig.middle(),
            far: FAR * rig.radius(),
            parameters,
        }
    }
}

/// Parameters that were saved somewhere: nothing follows from them before they are checked.
#[derive(Deserialize)]
struct SavedParameters(ControllerParameters);

impl TryFrom<SavedParameters> for Planner {
    type Error = ParameterError;

    fn try_from(SavedParameters(parameters): SavedParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(parameters.into())
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
                next.filter(|next| {
                    self.is_proved(&Situation { hold: 0.0, ..*now }, next, 0.0, &mut { MOST_SPANS })
                })
            }
            PlannerKind::Bounded => None,
            PlannerKind::Exact => self.exact(now, goal),
            PlannerKind::MinimumTime if now.set_point != goal && !self.is_worth_it(now.set_point, goal) => {
                Some(*goal)
            }
            PlannerKind::MinimumTime => self.course(now, None, 0.0, (&[], goal)).map(|(_, to)| to),
        }
    }

    /// Begins the search for where the planner makes for: `Bounded` for the goal itself.
    pub(super) fn search(&self, from: &Pose, goal: &Pose) -> Search {
        match self.parameters.planner {
            PlannerKind::Bounded => Search::ended(goal, goal),
            PlannerKind::Exact | PlannerKind::MinimumTime => self.nearest_rest(from, goal),
        }
    }

    /// The set point to give to a robot that rests at `from`.
    pub fn next_from_rest(&self, from: &Pose, goal: &Pose) -> Option<Pose> {
        self.next_set_point(&self.at_rest(from, &Coordinates::zeros()), goal)
    }

    /// Whether there is a set point to give to a robot that rests at `from` but for `maxTensionRate`.
    pub fn is_kept_by_rate(&self, from: &Pose, goal: &Pose) -> bool {
        let free = ControllerParameters { max_tension_rate: 0.0, ..self.parameters };
        self.parameters.max_tension_rate > 0.0
            && self.next_from_rest(from, goal).is_none()
            && Self::from(free).next_from_rest(from, goal).is_some()
    }

    /// The course that `MinimumTime` takes from rest at `from` to `goal`, or as far as is proved, begun at 0 s; `None` where there is none, and of other planners.
    pub fn course_from_rest(&self, from: &Pose, goal: &Pose) -> Option<Course> {
        let is_meant = self.parameters.planner == PlannerKind::MinimumTime;
        is_meant
            .then(|| self.course(&self.at_rest(from, &Coordinates::zeros()), None, 0.0, (&[], goal)))?
            .map(|(course, _)| course)
    }

    /// The course from rest by way of these poses, without a stop, to rest at the last, begun at 0 s; `None` where none is proved.
    pub fn course_through(&self, poses: &[Pose]) -> Option<Course> {
        let [from, via @ .., goal] = poses else { return None };
        let still = (Coordinates::zeros(), Coordinates::zeros());
        let leg = self.leg_through(&self.at_rest(from, &still.1), &still, (from, via, goal), 0.0)?;
        Some(Course::new(leg, goal))
    }

    /// The course to `goal` that `MinimumTime` goes on with from `begin` (s) on the way along another, by a stop or, where that is sooner, without; `None` where there is none.
    pub fn course_from(&self, course: &Course, begin: f64, goal: &Pose) -> Option<Course> {
        let led = course.at(begin);
        let now = self.at_rest(&led.pose, &led.rates);
        Some(self.course(&now, Some(course), begin, (&[], goal))?.0)
    }

    fn at_rest<'a>(&self, pose: &'a Pose, rates: &'a Coordinates) -> Situation<'a> {
        Situation { pose, rates, set_point: pose, hold: 0.0, rest: self.rest }
    }

    /// Whether there is a set point that is not given yet, but will be when the robot has come closer to rest.
    pub(super) fn waits(&self, now: &Situation, goal: &Pose) -> bool {
        self.parameters.planner == PlannerKind::Bounded && self.bounded(now.set_point, goal).is_some()
    }

    /// Whether the robot can rest at the goal with every tension within its limits, and the planner's domain speaks of the motion to it: for
    /// (15) a move in x and y at constant height, for the exact domain any.
    pub fn is_reachable(&self, from: &Pose, goal: &Pose) -> bool {
        match self.parameters.planner {
            PlannerKind::Bounded => self.is_horizontal(from, goal) && self.rests_at(goal, 0.0),
            PlannerKind::Exact | PlannerKind::MinimumTime => self.rests_at(goal, 0.0),
        }
    }

    /// Whether the robot can be held at rest at this pose, every tension `allowance` (N) inside its limits.
    pub(super) fn rests_at(&self, pose: &Pose, allowance: f64) -> bool {
        self.margin_at(pose) > allowance && self.is_firm(pose)
    }

    /// Whether the controller can hold the robot there: not if the tensions are so large for its mass and inertia that it leaves a pose, from which
    /// it is a little off, faster than the observer follows.
    pub fn is_firm(&self, pose: &Pose) -> bool {
        static_tensions(self.rig(), pose, self.allowance())
            .is_some_and(|tensions| swing(self.rig(), pose, &tensions)[1] <= FASTEST_DIVERGENCE)
    }

    /// Whether poses so far from the rig are looked at.
    pub fn is_near(&self, pose: &Pose) -> bool {
        (pose.position() - self.middle).amax() <= self.far
    }

    /// How far inside its limits every tension can be at rest, N, whatever is not known of it; less than nothing where the robot cannot be at rest.
    pub(super) fn margin_at(&self, pose: &Pose) -> f64 {
        self.known_margin_at(pose) - self.unknown_at(pose)
    }

    /// The same of the rig as it is said to be.
    pub(super) fn known_margin_at(&self, pose: &Pose) -> f64 {
        let is_sensible = self.rig().can_be_at(pose) && self.is_near(pose) && pose.0[PITCH].abs() < STEEPEST;
        if is_sensible { static_margin(self.rig(), pose) } else { f64::NEG_INFINITY }
    }

    /// The rig.
    pub(super) fn rig(&self) -> &Rig {
        &self.parameters.rig
    }

    /// The limits with `margin` (N) kept from them.
    pub(super) fn limits(&self, margin: f64) -> PerCable<TensionLimits> {
        self.rig().limits().map(|limits| limits.shrunk(margin))
    }

    /// Whether a step this far is worth giving.
    pub(super) fn is_worth_it(&self, from: &Pose, to: &Pose) -> bool {
        let way = to.minus(from);
        way.fixed_rows::<3>(0).norm() > self.smallest_step()
            || way.fixed_rows::<3>(3).amax() > SMALLEST_STEP * self.rest.angle
    }

    /// m.
    pub(super) fn smallest_step(&self) -> f64 {
        SMALLEST_STEP * self.rest.position
    }

    /// Whether (15) speaks of the motion: the paper's robot moves level at constant height.
    pub(super) fn is_horizontal(&self, from: &Pose, goal: &Pose) -> bool {
        let Some(shape) = &self.shape else { return false };
        let (from, goal) = (shape.to_paper(from), shape.to_paper(goal));
        goal.0[2] > 0.0
            && [&from, &goal].into_iter().all(|pose| tilt(pose) < self.rest.angle)
            && (from.0[2] - goal.0[2]).abs() < self.rest.position
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
        (largest * (squares / ways.len() as f64).sqrt()).min(f64::MAX)
    }

    /// The ways of the attachments from a pose to the goal, m.
    pub(super) fn ways(&self, pose: &Pose, goal: &Pose) -> PerCable<Vector3<f64>> {
        let (way, from, to) = (goal.position() - pose.position(), pose.rotation(), goal.rotation());
        self.rig().cables.map(|cable| way + (to * cable.attachment - from * cable.attachment))
    }
}

/// Whether the orientation is zero.
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
        let expected = 2f64.sqrt() * planner.rig().platform_radius();
        assert!((planner.distance(&here, &turned) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_saved_planner_comes_back_with_its_rig() {
        let mut parameters = ControllerParameters::default();
        parameters.rig.mass = 7.0;
        let planner = Planner::from(parameters);
        let bytes = postcard::to_stdvec(&planner).unwrap();
        assert_eq!(postcard::from_bytes::<Planner>(&bytes).unwrap(), planner);
        assert_eq!(bytes, postcard::to_stdvec(&planner.parameters).unwrap());
    }
}
