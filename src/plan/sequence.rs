//! From rest to rest: the set points to a goal, and what stands in the way of one that cannot be reached.

use nalgebra::Vector2;
use thiserror::Error;

use super::extremes::{Extremes, TensionAt, extremes, extremes_of_course};
use super::nearest::{nearest_admissible, workspace_facets};
use super::{ControllerParameters, Planner, PlannerKind};
use crate::control::{self, Barrier};
use crate::reach::quadratic_program::SolverError;
use crate::robot::rig::SINGULARITY_THRESHOLD;
use crate::robot::{Pose, Rig, Shape};

/// Set points after which a plan is given up.
pub const MOST_SET_POINTS: usize = 1000;
/// Halvings of the distance to the border that the nearest point keeps.
const HALVINGS: usize = 20;
/// Nothing new happens farther than this many radii of the rig from it.
const FAR: f64 = 10.0;
/// Points looked at between the nearest point and the goal.
const POINTS: u32 = 2000;

/// The set points from rest at a pose to a goal, or as far as there are any.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// In their order.
    pub set_points: Vec<Pose>,
    /// The smallest tension predicted, and in which step (from 1); `None` if no step is made.
    pub smallest: Option<(usize, TensionAt)>,
    /// How long it takes, s, of a planner that says so.
    pub duration: Option<f64>,
    /// Whether the goal may be among set points that are no longer looked for.
    pub given_up: bool,
    /// Why the goal is not among the set points.
    pub obstacle: Option<Obstacle>,
}

/// What stands between the last set point and the goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Whether the wrench matrix is singular at the goal.
    pub singular: bool,
    /// The cable and the moment at which the step from the last set point straight to the goal breaks a limit; `None` if it
    /// breaks none or meets a singular pose.
    pub broken: Option<Extremes>,
    /// The nearest pose that can be reached.
    pub nearest: Option<Pose>,
    /// Where, between there and the goal, a tension first reaches a limit with the platform at rest.
    pub barrier: Option<(Barrier, Pose)>,
    /// Whether, with no barrier, a tension comes nearer to its limit on that way than the planner lets it, with the platform at rest.
    pub is_tight: bool,
    /// Whether, with no barrier, the tensions on that way become so large that the platform cannot be held ([`Planner::is_firm`]).
    pub is_loose: bool,
    /// Whether `maxTensionRate` is too small for a motion on from the last set point ([`Planner::is_kept_by_rate`]).
    pub is_kept_by_rate: bool,
}

/// No plan can be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// No tensions tell what happens on the way.
    #[error("the way to a set point leads through a singular pose")]
    Singular,
    /// The solver gives no answer.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

impl Sequence {
    /// What the planner of `parameters` gives a robot that rests at `from`, each set point waited for until it is reached.
    ///
    /// # Errors
    /// [`SequenceError`].
    pub fn new(parameters: &ControllerParameters, from: &Pose, to: &Pose) -> Result<Self, SequenceError> {
        let (rig, gains) = (&parameters.rig, parameters.gains());
        // Where the controller would make for.
        let aim = Planner::from(*parameters).aim(from, to);
        let set_points = set_points(parameters, from, &aim);
        let (mut at, mut smallest, mut duration) = (*from, None::<(usize, TensionAt)>, None);
        for (i, next) in set_points.iter().enumerate() {
            let step = match Planner::from(*parameters).course_from_rest(&at, next) {
                Some(course) => {
                    duration = Some(duration.unwrap_or(0.0) + course.end());
                    extremes_of_course(rig, &course)
                }
                None => extremes(rig, &gains, &at, next),
            };
            let step = step.ok_or(SequenceError::Singular)?.smallest;
            at = *next;
            if smallest.is_none_or(|(_, so_far)| step.tension < so_far.tension) {
                smallest = Some((i + 1, step));
            }
        }
        let goal = goal_looked_at(parameters.planner, from, to);
        let is_long = at != aim && set_points.len() == MOST_SET_POINTS;
        let given_up = is_long && barrier(rig, &goal, &goal).is_none();
        let obstacle = if given_up || at == *to {
            None
        } else {
            let nearest = match parameters.planner {
                PlannerKind::Bounded => nearest_level(parameters, from, to)?.or((at != *from).then_some(at)),
                PlannerKind::Exact | PlannerKind::MinimumTime => Some(at),
            };
            let nearest_or_last = nearest.unwrap_or(at);
            Some(Obstacle {
                singular: rig.regularity(to) < SINGULARITY_THRESHOLD,
                broken: extremes(rig, &gains, &at, to).filter(|direct| {
                    parameters.planner != PlannerKind::MinimumTime && direct.first_outside.is_some()
                }),
                nearest,
                barrier: barrier(rig, &nearest_or_last, &goal),
                is_tight: is_any(parameters, &nearest_or_last, &goal, |planner, at| {
                    planner.margin_at(at) <= 2.0 * planner.allowance()
                }),
                is_kept_by_rate: Planner::from(*parameters).is_kept_by_rate(&at, &aim),
                is_loose: is_any(parameters, &nearest_or_last, &goal, |planner, at| !planner.is_firm(at)),
            })
        };
        Ok(Self { set_points, smallest, duration, given_up, obstacle })
    }

    /// Whether the goal is reached.
    pub fn is_complete(&self) -> bool {
        !self.given_up && self.obstacle.is_none()
    }
}

/// As far as there are any.
fn set_points(parameters: &ControllerParameters, from: &Pose, to: &Pose) -> Vec<Pose> {
    let planner = Planner::from(*parameters);
    let next = |at: &Pose| planner.next_from_rest(at, to);
    std::iter::successors(next(from), next).take(MOST_SET_POINTS).collect()
}

/// (15) keeps the height of the start, and zero orientation.
fn goal_looked_at(planner: PlannerKind, from: &Pose, to: &Pose) -> Pose {
    match planner {
        PlannerKind::Bounded => Pose::at(to.0[0], to.0[1], from.0[2]),
        PlannerKind::Exact | PlannerKind::MinimumTime => *to,
    }
}

/// The point nearest to the goal, at the height of the start, to which the paper's planner has a plan: as little inside the facets of
/// the static workspace as limits of tension and the planner's own allowances need.
fn nearest_level(
    parameters: &ControllerParameters,
    from: &Pose,
    to: &Pose,
) -> Result<Option<Pose>, SequenceError> {
    let Ok(shape) = Shape::of(&parameters.rig) else { return Ok(None) };
    let facets = workspace_facets(&shape.robot);
    // The solver's precision is relative to the distance.
    let middle = shape.to_rig(&Pose::at(0.0, 0.0, shape.to_paper(to).0[2]));
    let goal = shape.to_paper(&within_reach(&parameters.rig, &middle, to)).position();
    let height = shape.to_paper(from).0[2];
    let over = |point: &Vector2<f64>| shape.to_rig(&Pose::at(point.x, point.y, height));
    let arrives = |place: &Pose| place == from || set_points(parameters, from, place).last() == Some(place);
    let (mut short, mut enough, mut found) = (0.0, 0.5 * shape.robot.a, None);
    for _ in 0..HALVINGS {
        let margin = 0.5 * (short + enough);
        let nearest = nearest_admissible(&goal.xy(), &facets, margin)?.map(|nearest| over(&nearest.point));
        if nearest.as_ref().is_some_and(arrives) {
            (enough, found) = (margin, nearest);
        } else {
            short = margin;
        }
    }
    Ok(found)
}

/// The goal, or if it is far out the point of the way to it from which on nothing new happens.
fn within_reach(rig: &Rig, from: &Pose, goal: &Pose) -> Pose {
    let far = FAR * rig.radius();
    let way = goal.0 - from.0;
    let longest = way.amax();
    if longest <= far { *goal } else { Pose(from.0 + way * (far / longest)) }
}

/// Whether something is so of a pose on the line from one to another. The last points that the planner makes for keep twice its allowance.
fn is_any(
    parameters: &ControllerParameters,
    from: &Pose,
    to: &Pose,
    is_so: impl Fn(&Planner, &Pose) -> bool,
) -> bool {
    let planner = Planner::from(*parameters);
    let to = &within_reach(&parameters.rig, from, to);
    (0..=POINTS).any(|k| {
        let at = Pose(from.0.lerp(&to.0, f64::from(k) / f64::from(POINTS)));
        planner.is_near(&at) && is_so(&planner, &at)
    })
}

/// Where, on the line from one pose to another, a tension first is at or beyond a limit at rest.
fn barrier(rig: &Rig, from: &Pose, to: &Pose) -> Option<(Barrier, Pose)> {
    let to = &within_reach(rig, from, to);
    (0..=POINTS).find_map(|k| {
        let at = Pose(from.0.lerp(&to.0, f64::from(k) / f64::from(POINTS)));
        control::barrier(rig, &at).map(|limit| (limit, at))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_move_takes_four_set_points_and_a_goal_outside_names_what_forbids_it() {
        let parameters = ControllerParameters::default();
        let start = Pose::default();
        let there = Sequence::new(&parameters, &start, &Pose::at(0.15, 0.15, 1.0)).unwrap();
        assert!(there.is_complete() && there.set_points.len() == 4, "{there:?}");
        for planner in PlannerKind::ALL {
            let parameters = ControllerParameters { planner, ..parameters };
            let outside = Sequence::new(&parameters, &start, &Pose::at(0.0, 0.4, 1.0)).unwrap();
            let obstacle = outside.obstacle.as_ref().unwrap();
            let (nearest, (limit, at)) = (obstacle.nearest.unwrap(), obstacle.barrier.unwrap());
            assert!(!outside.is_complete() && limit.cable == 2 && !limit.is_greatest, "{outside:?}");
            assert!(nearest.0[1] > 0.2 && nearest.0[1] <= at.0[1] && at.0[1] < 0.226, "{outside:?}");
        }
    }
}
