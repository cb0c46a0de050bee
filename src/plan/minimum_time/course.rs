//! A motion under way: along one way, or to a stop on one and then along another.

use serde::{Deserialize, Serialize};

use super::arc::{Along, Timing};
use super::line::Line;
use super::path::Path;
use crate::control::Reference;
use crate::reach::certificate::section::Section;
use crate::robot::{Pose, Rig};

/// A way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "boxing would allocate in a step")]
pub enum Way {
    /// Straight on, of the paper's robot, level: s in m. And where that is in the rig's own frame.
    Line(Line, Section),
    /// Of any: s from 0 to 1.
    Path(Path),
}

impl Way {
    fn stop(&self, rig: &Rig, s: f64, v: f64) -> Option<Timing> {
        match self {
            Self::Line(line, _) => line.stop(s, v),
            Self::Path(path) => path.stop(rig, s, v),
        }
    }

    /// Where sections join.
    fn joints(&self) -> impl Iterator<Item = f64> {
        let sections = match self {
            Self::Line(..) => &[],
            Self::Path(path) => path.way.sections(),
        };
        sections.iter().skip(1).map(|section| section.begin)
    }

    /// The section that leads on from s.
    fn section(&self, s: f64) -> &Section {
        match self {
            Self::Line(_, section) => section,
            Self::Path(path) => path.way.section(s),
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
        self.way.section(self.timing.end).pose(self.timing.end)
    }

    fn at(&self, time: f64) -> Reference {
        let along = self.timing.at(time - self.begin);
        self.led(self.way.section(along[0]), along)
    }

    /// Both ends of every arc, with their times, s.
    fn arcs(&self) -> impl Iterator<Item = [(f64, Reference); 2]> {
        self.timing.spans().map(|(arc, duration)| {
            let section = self.way.section(arc.s);
            [0.0, duration].map(|t| (self.begin + arc.begin + t, self.led(section, arc.at(t))))
        })
    }

    fn led(&self, section: &Section, [s, v, a]: Along) -> Reference {
        let slope = section.slope(s);
        Reference {
            pose: section.pose(s),
            rates: slope * v,
            accelerations: slope * a + section.bend(s) * (v * v),
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
    pub(in crate::plan) fn new(first: Leg, second: Option<Leg>, goal: &Pose) -> Self {
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

    /// When it passes the way points of its last leg, s.
    pub fn passes(&self) -> impl Iterator<Item = f64> {
        let leg = self.second.as_ref().unwrap_or(&self.first);
        leg.way.joints().filter_map(|joint| {
            let arc = leg.timing.arcs().iter().find(|arc| arc.s == joint)?;
            Some(leg.begin + arc.begin)
        })
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
