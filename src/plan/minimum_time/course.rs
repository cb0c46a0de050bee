//! A motion under way: along one way, or to a stop on one and then along another.

use serde::{Deserialize, Serialize};

use super::arc::Timing;
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
        let [s, v, a] = self.timing.at(time - self.begin);
        Reference {
            pose: Pose(self.from.0 + self.direction * s),
            rates: self.direction * v,
            accelerations: self.direction * a,
        }
    }

    /// The stop that begins at a time (s) on it; where none is proved that ends before it does, itself.
    fn stop(&self, rig: &Rig, time: f64) -> Self {
        let [s, v, _] = self.timing.at(time - self.begin);
        let stop = if v > 0.0 { self.way.stop(rig, s, v) } else { None };
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
}

impl Course {
    pub(super) fn new(first: Leg, second: Option<Leg>) -> Self {
        Self { first, second }
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

    /// The leg that brings it to rest as soon as is proved from a time (s) on.
    pub(super) fn stop(&self, rig: &Rig, time: f64) -> Leg {
        self.leg(time).stop(rig, time)
    }

    /// The course that stops from a time (s) on, as soon as is proved.
    pub fn stopped(&self, rig: &Rig, time: f64) -> Self {
        Self::new(self.stop(rig, time), None)
    }

    fn leg(&self, time: f64) -> &Leg {
        self.second.as_ref().filter(|second| second.begin <= time).unwrap_or(&self.first)
    }
}
