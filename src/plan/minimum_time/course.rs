//! A motion under way: along one way, or to a stop on one and then along another.

use serde::{Deserialize, Serialize};

use super::arc::{Along, Timing};
use super::line::Line;
use super::path::Path;
use crate::control::Reference;
use crate::robot::{Coordinates, Pose, Rig};

/// A straight way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "boxing would allocate in a step")]
pub enum Way {
    /// Of the paper's robot, level: s in m.
    Line(Line),
    /// Of any: s from 0 to 1.
    Path(Path),
}

impl Way {
    /// In units of s.
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Line(line) => line.length(),
            Self::Path(_) => 1.0,
        }
    }

    fn stop(&self, rig: &Rig, s: f64, v: f64) -> Option<Timing> {
        match self {
            Self::Line(line) => line.stop(s, v),
            Self::Path(path) => path.stop(rig, s, v),
        }
    }
}

/// A way with a motion along it, in the rig's frame and on the controller's clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    pub(super) way: Way,
    pub(super) timing: Timing,
    /// When it begins, s.
    pub(super) begin: f64,
    /// Where the way begins, and the rates of the coordinates at s' = 1.
    pub(super) from: Pose,
    pub(super) direction: Coordinates,
    /// What holding the commands costs on it, N.
    pub(super) held: f64,
}

impl Leg {
    /// When it ends, s.
    pub(super) fn end(&self) -> f64 {
        self.begin + self.timing.duration
    }

    /// Where it ends.
    pub(super) fn end_pose(&self) -> Pose {
        Pose(self.from.0 + self.direction * self.timing.end)
    }

    fn at(&self, time: f64) -> Reference {
        self.led(self.timing.at(time - self.begin))
    }

    /// Both ends of every arc, with their times, s.
    fn arcs(&self) -> impl Iterator<Item = [(f64, Reference); 2]> {
        let arcs = self.timing.arcs();
        (0..arcs.len()).map(move |k| {
            let begin = arcs[k].begin;
            let end = arcs.get(k + 1).map_or(self.timing.duration, |next| next.begin);
            [begin, end].map(|t| (self.begin + t, self.led(arcs[k].at(t - begin))))
        })
    }

    fn led(&self, [s, v, a]: Along) -> Reference {
        Reference {
            pose: Pose(self.from.0 + self.direction * s),
            rates: self.direction * v,
            accelerations: self.direction * a,
        }
    }

    /// The stop that begins at a time (s) on it: where it rests, rest; where none is proved that ends before it does, itself.
    fn stop(&self, rig: &Rig, time: f64) -> Self {
        let [s, v, _] = self.timing.at(time - self.begin);
        let stop = if v > 0.0 { self.way.stop(rig, s, v) } else { Some(Timing::begun_at(s)) };
        match stop {
            Some(timing) => Self { timing, begin: time, ..self.clone() },
            None => self.clone(),
        }
    }
}

/// One leg, or a stop and the leg after it. At rest at its end from then on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    first: Leg,
    second: Option<Leg>,
    /// What it was planned for, whether it leads there or only towards it.
    goal: Pose,
}

impl Course {
    pub(super) fn new(first: Leg, second: Option<Leg>, goal: &Pose) -> Self {
        Self { first, second, goal: *goal }
    }

    /// Whether it was planned for this goal.
    pub(in crate::plan) fn is_for(&self, goal: &Pose) -> bool {
        self.goal == *goal
    }

    /// When it ends, s.
    pub fn end(&self) -> f64 {
        self.second.as_ref().unwrap_or(&self.first).end()
    }

    /// What holding the commands costs on it, N.
    pub fn held(&self) -> f64 {
        let second = self.second.as_ref().map_or(0.0, |second| second.held);
        self.first.held.max(second)
    }

    /// Where it leads the robot at a time, s.
    pub fn at(&self, time: f64) -> Reference {
        self.leg(time).at(time)
    }

    /// Where it leads the robot at both ends of each arc that has not ended at a time (s).
    pub fn arcs(&self, time: f64) -> impl Iterator<Item = [(f64, Reference); 2]> {
        let legs = [Some(&self.first), self.second.as_ref()].into_iter().flatten();
        legs.flat_map(Leg::arcs).filter(move |[_, (end, _)]| *end >= time)
    }

    /// The leg that brings it to rest as soon as is proved from a time (s) on.
    pub(super) fn stop(&self, rig: &Rig, time: f64) -> Leg {
        self.leg(time).stop(rig, time)
    }

    /// The course that stops from a time (s) on, as soon as is proved.
    pub fn stopped(&self, rig: &Rig, time: f64) -> Self {
        Self::new(self.stop(rig, time), None, &self.goal)
    }

    fn leg(&self, time: f64) -> &Leg {
        self.second.as_ref().filter(|second| second.begin <= time).unwrap_or(&self.first)
    }
}
