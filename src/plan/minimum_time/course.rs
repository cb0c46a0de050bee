//! A motion under way: along one line, or to a stop on one and then along another.

use serde::{Deserialize, Serialize};

use super::arc::Timing;
use super::line::Line;
use crate::control::Reference;
use crate::robot::{Coordinates, Pose};

/// A line with a motion along it, in the rig's frame and on the controller's clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    pub(super) line: Line,
    pub(super) timing: Timing,
    /// When it begins, s.
    pub(super) begin: f64,
    /// Where the line begins, and the rates of the coordinates at 1 m/s along it.
    pub(super) from: Pose,
    pub(super) direction: Coordinates,
    /// What holding the commands costs on it, N.
    pub(super) held: f64,
}

impl Leg {
    /// When it ends, s.
    fn end(&self) -> f64 {
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

    /// The stop that begins at a time (s) on it. `None` where the motion has ended.
    fn stop(&self, time: f64) -> Option<Self> {
        let [s, v, _] = self.timing.at(time - self.begin);
        if time >= self.end() || v <= 0.0 {
            return None;
        }
        Some(Self { timing: self.line.stop(s, v)?, begin: time, ..self.clone() })
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

    /// The leg that brings it to rest soonest from a time (s) on; `None` where it rests. Proved with the course.
    pub(super) fn stop(&self, time: f64) -> Option<Leg> {
        self.leg(time).stop(time)
    }

    /// The course that stops from a time (s) on, as soon as can be; `None` where it rests.
    pub fn stopped(&self, time: f64) -> Option<Self> {
        Some(Self::new(self.stop(time)?, None))
    }

    fn leg(&self, time: f64) -> &Leg {
        self.second.as_ref().filter(|second| second.begin <= time).unwrap_or(&self.first)
    }
}
