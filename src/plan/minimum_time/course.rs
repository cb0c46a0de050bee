//! A motion under way: along one way, or to a stop on one and along another, after the stop or added to it.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use super::arc::{Along, Arc, Timing};
use super::line::Line;
use super::path::Path;
use super::smooth::{Gentle, Mean, Ramp};
use super::sum;
use crate::control::Reference;
use crate::reach::certificate::along::{MOST_PARTS, Piece};
use crate::reach::certificate::part::Part;
use crate::reach::certificate::section::Section;
use crate::robot::memory::are_finite;
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
    fn is_sound(&self, cables: usize) -> bool {
        match self {
            Self::Line(line, section) => line.is_sound() && section.is_sound(),
            Self::Path(path) => path.is_sound(cables),
        }
    }

    /// As one of any rig.
    fn path(&self) -> Option<&Path> {
        match self {
            Self::Line(..) => None,
            Self::Path(path) => Some(path),
        }
    }

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
    pub(super) fn section(&self, s: f64) -> &Section {
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
    /// What it leaves to the limits, N.
    pub(super) kept: f64,
    /// What is asked of the tensions' rates, and over which time (s) s is averaged for that: along a path only.
    pub(super) gentle: Option<(Gentle, f64)>,
}

impl Leg {
    fn is_sound(&self, cables: usize) -> bool {
        self.way.is_sound(cables)
            && self.timing.is_sound()
            && self.begin.is_finite()
            && !self.held.is_nan()
            && !self.kept.is_nan()
            && self.gentle.is_none_or(|(gentle, width)| gentle.is_sound() && width.is_finite() && width > 0.0)
    }

    /// When it ends, s.
    pub(super) fn end(&self) -> f64 {
        self.begin + self.mean().map_or(self.timing.duration, |mean| mean.end())
    }

    /// What it is, where s is averaged.
    fn mean(&self) -> Option<Mean<'_>> {
        self.gentle.map(|(_, width)| Mean::new(&self.timing, width))
    }

    /// Where it ends.
    pub(super) fn end_pose(&self) -> Pose {
        self.way.section(self.timing.end).pose(self.timing.end)
    }

    pub(super) fn at(&self, time: f64) -> Reference {
        let t = time - self.begin;
        let along = self.mean().map_or_else(|| self.timing.at(t), |mean| mean.at(t));
        led(self.way.section(along[0]), along)
    }

    fn arc(&self, instant: f64) -> Option<&Arc> {
        let instant = instant - self.begin;
        let is_on = |(arc, duration): &(&Arc, f64)| (arc.begin..arc.begin + duration).contains(&instant);
        self.timing.spans().find(is_on).map(|(arc, _)| arc)
    }

    /// The arc on which it is at an instant, as a part of a motion from a time (s) on; `None` before it begins and after it ends.
    pub(super) fn part(&self, instant: f64, from: f64) -> Option<Part> {
        let arc = self.arc(instant)?;
        Some(arc.part(self.way.section(arc.s), from - self.begin - arc.begin))
    }

    /// Where the arc on which it is at an instant leads at a time (s); `None` before it begins and after it ends.
    pub(super) fn led(&self, instant: f64, time: f64) -> Option<Reference> {
        let arc = self.arc(instant)?;
        Some(led(self.way.section(arc.s), arc.at(time - self.begin - arc.begin)))
    }

    /// When its arcs begin and end, s.
    pub(super) fn instants(&self) -> impl Iterator<Item = f64> {
        self.timing.arcs().iter().map(|arc| arc.begin).chain([self.timing.duration]).map(|t| self.begin + t)
    }

    /// Both ends of every arc, or of every ramp, with their times, s.
    fn arcs(&self) -> impl Iterator<Item = [(f64, Reference); 2]> {
        let arcs = self.timing.spans().map(|(arc, duration)| {
            let section = self.way.section(arc.s);
            [0.0, duration].map(|t| (self.begin + arc.begin + t, led(section, arc.at(t))))
        });
        let ramps = self.mean().zip(self.way.path()).map(|(mean, path)| {
            mean.ramps(&path.way, 0.0).map(move |Ramp { begin, duration, .. }| {
                let section = path.way.section(mean.at(begin + 0.5 * duration)[0]);
                [begin, begin + duration].map(|t| (self.begin + t, led(section, mean.at(t))))
            })
        });
        arcs.take_while(|_| self.gentle.is_none()).chain(ramps.into_iter().flatten())
    }

    /// Its arcs or ramps, one after the other.
    fn pieces(&self) -> impl Iterator<Item = Piece> {
        let arcs = self.timing.spans().map(|(arc, duration)| {
            let part = arc.part(self.way.section(arc.s), 0.0);
            Piece::new(part, duration)
        });
        let ramps = self.mean().zip(self.way.path()).map(|(mean, path)| mean.pieces(&path.way, 0.0));
        arcs.take_while(|_| self.gentle.is_none()).chain(ramps.into_iter().flatten())
    }

    /// When it passes where sections join, s.
    fn passes(&self) -> impl Iterator<Item = f64> {
        let arcs = self.way.joints().filter_map(|joint| {
            let arc = self.timing.arcs().iter().find(|arc| arc.s == joint)?;
            Some(arc.begin)
        });
        let mean = self.mean().zip(self.way.path()).map(|(mean, path)| mean.crossings(&path.way));
        let instants = arcs.take_while(|_| self.gentle.is_none()).chain(mean.into_iter().flatten());
        instants.map(|instant| self.begin + instant)
    }

    /// The stop that begins at a time (s) on it: where it rests, rest; where none is proved that ends before it does, itself.
    fn stop(&self, rig: &Rig, time: f64) -> Self {
        if let (Some((gentle, width)), Some(path)) = (self.gentle, self.way.path())
            && time > self.begin
        {
            let stop = path.stop_gently(rig, (&self.timing, width, &gentle), time - self.begin);
            return stop.map_or_else(|| self.clone(), |timing| Self { timing, ..self.clone() });
        }
        let [s, v, _] = self.timing.at(time - self.begin);
        let stop = if v > 0.0 { self.way.stop(rig, s, v) } else { Some(Timing::begun_at(s)) };
        match stop {
            Some(timing) => Self { timing, begin: time, ..self.clone() },
            None => self.clone(),
        }
    }
}

/// Places of the grid in an arc of a stop that something is added to.
const STEP: usize = 2;

/// Legs of a course.
pub(super) const MOST_LEGS: usize = MOST_PARTS;

/// Legs, each from where those before it come to rest. A leg that begins before they do is added to them. At rest at its end from then on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    legs: ArrayVec<Leg, MOST_LEGS>,
    /// What it was planned for, whether it leads there or only towards it.
    goal: Pose,
}

impl Course {
    pub(in crate::plan) fn new(first: Leg, goal: &Pose) -> Self {
        Self { legs: [first].into_iter().collect(), goal: *goal }
    }

    /// With a leg more, on the way to a goal; `None` with more than [`MOST_LEGS`].
    pub(super) fn and(mut self, leg: Leg, goal: &Pose) -> Option<Self> {
        self.legs.try_push(leg).ok()?;
        Some(Self { goal: *goal, ..self })
    }

    /// Whether a run with so many cables can have left this.
    pub(in crate::plan) fn is_sound(&self, cables: usize) -> bool {
        !self.legs.is_empty() && self.legs.iter().all(|leg| leg.is_sound(cables)) && are_finite(&self.goal.0)
    }

    pub(super) fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// Whether it was planned for this goal.
    pub(in crate::plan) fn is_for(&self, goal: &Pose) -> bool {
        self.goal == *goal
    }

    /// When it ends, s.
    pub fn end(&self) -> f64 {
        self.legs.iter().map(Leg::end).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Where it ends.
    pub(super) fn end_pose(&self) -> Pose {
        self.legs.last().map_or(self.goal, Leg::end_pose)
    }

    /// What holding the commands costs on it, N.
    pub fn held(&self) -> f64 {
        self.legs.iter().map(|leg| leg.held).fold(0.0, f64::max)
    }

    /// The pieces of a course from rest, one after the other; `None` of one that goes on from another.
    pub fn pieces(&self) -> Option<impl Iterator<Item = Piece>> {
        let [leg] = &self.legs[..] else { return None };
        Some(leg.pieces().filter(|piece| piece.duration() > 0.0))
    }

    /// When it passes the way points of its last leg, s.
    pub fn passes(&self) -> impl Iterator<Item = f64> {
        self.legs.last().into_iter().flat_map(Leg::passes)
    }

    /// Where it leads the robot at a time, s.
    pub fn at(&self, time: f64) -> Reference {
        let last = self.legs.iter().rposition(|leg| leg.begin <= time).unwrap_or(0);
        let Some(leg) = self.legs.get(last) else { return Reference::resting(&self.goal) };
        let mut sum = leg.at(time);
        for before in self.legs[..last].iter().filter(|before| time < before.end()) {
            add(&mut sum, &before.at(time), &before.end_pose());
        }
        sum
    }

    /// Where it leads the robot at both ends of each arc that has not ended at a time (s).
    pub fn arcs(&self, time: f64) -> impl Iterator<Item = [(f64, Reference); 2]> {
        let arcs = self.legs.iter().enumerate().flat_map(move |(k, leg)| {
            // A leg that is added to others has the ends of their arcs among those of its own.
            let until = self.legs.get(k + 1).map_or(f64::INFINITY, |next| next.begin);
            let own = leg.arcs().take_while(move |[(begin, _), _]| *begin < until);
            own.map(move |ends| self.with_those_before(k, ends))
        });
        arcs.filter(move |[_, (end, _)]| *end >= time)
    }

    fn with_those_before(&self, k: usize, ends: [(f64, Reference); 2]) -> [(f64, Reference); 2] {
        let middle = 0.5 * (ends[0].0 + ends[1].0);
        ends.map(|(time, mut sum)| {
            for before in &self.legs[..k] {
                if let Some(led) = before.led(middle, time) {
                    add(&mut sum, &led, &before.end_pose());
                }
            }
            (time, sum)
        })
    }

    /// The course that stops from a time (s) on, as soon as is proved: legs that stop already go on.
    pub fn stopped(&self, rig: &Rig, time: f64) -> Self {
        let last = self.legs.iter().rposition(|leg| leg.begin <= time).unwrap_or(0);
        let Some(leg) = self.legs.get(last) else { return self.clone() };
        let mut legs: ArrayVec<Leg, MOST_LEGS> =
            self.legs[..last].iter().filter(|before| time < before.end()).cloned().collect();
        let stop = if legs.is_empty() { leg.stop(rig, time) } else { sum::stop(rig, &legs, leg, time) };
        legs.push(stop);
        Self { legs, goal: self.goal }
    }
}

impl Course {
    /// The course that stops from a time (s) on, in few arcs where that is proved.
    pub(super) fn stopped_in_steps(&self, rig: &Rig, time: f64) -> Self {
        let mut stopped = self.stopped(rig, time);
        let now = self.legs.iter().rfind(|leg| leg.begin <= time);
        if let ([stop], Some(Leg { way: Way::Path(path), timing, begin, .. })) = (&mut stopped.legs[..], now)
        {
            let [s, v, _] = timing.at(time - begin);
            let is_one = path.way.sections().len() == 1;
            if let Some(timing) = is_one.then(|| path.stop_in_steps(rig, [s, v], STEP)).flatten() {
                (stop.timing, stop.begin) = (timing, time);
            }
        }
        stopped
    }

    /// A stop on one way that begins at a time (s), braking so many times less hard. What goes on, as where no stop is proved, goes on as it is.
    pub(super) fn gentler(mut self, time: f64, times: f64) -> Self {
        if let [stop] = &mut self.legs[..]
            && stop.begin == time
        {
            stop.timing = stop.timing.clone().stretched(times);
        }
        self
    }

    /// The course from a time (s) on, without the legs that have ended and those that have not begun.
    pub(super) fn going_on(&self, time: f64) -> Self {
        let under_way = |leg: &&Leg| leg.begin <= time && time < leg.end();
        Self { legs: self.legs.iter().filter(under_way).cloned().collect(), goal: self.goal }
    }

    /// What its legs leave to the limits, N.
    pub(super) fn kept(&self) -> f64 {
        self.legs.iter().map(|leg| leg.kept).fold(f64::INFINITY, f64::min)
    }
}

/// Adds a motion, counted from where it rests.
pub(super) fn add(sum: &mut Reference, led: &Reference, rest: &Pose) {
    sum.pose.0 += led.pose.0 - rest.0;
    sum.rates += led.rates;
    sum.accelerations += led.accelerations;
}

/// Where a section leads.
pub(super) fn led(section: &Section, [s, v, a]: Along) -> Reference {
    let slope = section.slope(s);
    Reference {
        pose: section.pose(s),
        rates: slope * v,
        accelerations: slope * a + section.bend(s) * (v * v),
    }
}
