//! From rest to rest by way of other poses, without a stop: `MinimumTime` along one smooth way.

use thiserror::Error;

use super::extremes::{TensionAt, extremes_of_course};
use super::minimum_time::{Course, MOST_SECTIONS, Track};
use super::{ControllerParameters, Planner};
use crate::control::{Barrier, barrier};
use crate::robot::Pose;

/// Way points of one motion.
pub const MOST_WAY_POINTS: usize = MOST_SECTIONS - 1;
/// Places of the way at which it is looked for why there is no motion along it.
const PLACES: i32 = 640;

/// A motion by way of poses, proved.
#[derive(Clone, Debug, PartialEq)]
pub struct Through {
    /// Begun at 0 s.
    pub course: Course,
    /// The smallest tension on it.
    pub smallest: TensionAt,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoWay {
    /// Too many, or two that follow each other are the same.
    #[error(
        "a way leads from pose to pose, each another than the one before, by at most {MOST_WAY_POINTS} way points"
    )]
    Poses,
    /// At a pose on the smooth way the platform cannot rest.
    #[error("the smooth way by these poses leads to {at}, where the platform cannot rest: {why}")]
    NoRest {
        /// In m and rad, for people.
        at: String,
        /// The cable's limit, or what else.
        why: String,
    },
    /// The motion keeps no limits that can be proved.
    #[error(
        "no motion along the smooth way by these poses is proved: it may turn back, or bend too sharply, or leave too little to the limits"
    )]
    NotProved,
}

impl Through {
    /// Of the planner `MinimumTime` of `parameters`: `poses` are the start, the way points in their order, and the goal.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn new(parameters: &ControllerParameters, poses: &[Pose]) -> Result<Self, NoWay> {
        let (planner, rig) = (Planner::from(*parameters), &parameters.rig);
        let way = Track::through(poses, rig.platform_radius()).ok_or(NoWay::Poses)?;
        let course = planner.course_through(poses).ok_or_else(|| {
            let places = (0..=PLACES).map(|k| way.pose(f64::from(k) / f64::from(PLACES)));
            let mut outside = places.filter(|pose| !planner.rests_at(pose, 0.0));
            outside.next().map_or(NoWay::NotProved, |pose| NoWay::NoRest {
                at: format!("({:.3}, {:.3}, {:.3})", pose.0[0], pose.0[1], pose.0[2]),
                why: barrier(rig, &pose).map_or("it is above the anchors".to_owned(), |found| why(&found)),
            })
        })?;
        let smallest = extremes_of_course(rig, &course).ok_or(NoWay::NotProved)?.smallest;
        Ok(Self { course, smallest })
    }
}

fn why(barrier: &Barrier) -> String {
    let Barrier { cable, limit, is_greatest } = barrier;
    let which = if *is_greatest { "above" } else { "below" };
    format!("cable {cable} would be {which} {limit} N")
}
