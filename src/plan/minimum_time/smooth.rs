//! Motions whose tensions change no faster than they may: s is the mean of that of another motion over a time just past, which makes ramps of its jumps. Derived in
//! docs/minimum-time.md, "How fast tensions change".

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use super::arc::{Along, Timing};
use super::course::led;
use super::path::{Path, Work, narrowed_at_first};
use super::track::{MOST_SECTIONS, Track};
use crate::control::tensions;
use crate::reach::certificate::along::{Piece, Seen};
use crate::reach::certificate::part::Part;
use crate::robot::{LEAST_CABLES, PerCable, Rig};

/// The smallest width, and the greatest, as shares of the time that the motion takes without it.
const NARROWEST: f64 = 1e-6;
const WIDEST: f64 = 1e3;
/// Widths that are looked at, and that a proof is tried with, for one timing; each is wider by what was missing, and by this much.
const WIDTHS: usize = 16;
const PROOFS: usize = 3;
const MORE: f64 = 1.002;
/// Times that a way is timed, each with the limits narrowed by so many times as much.
const TIMINGS: usize = 4;
const NARROWER: f64 = 4.0;
/// Commands that are held for less than this share of the width change as if they were held for that long.
const NEAREST: f64 = 1e-3;
/// Pieces that are a smaller share of the width than this are rounding.
const ROUNDING: f64 = 1e-9;
/// Parts of a piece between which tensions are looked at: while a width is looked for, and of more than six cables, whose rate is not proved, in the end.
const PARTS: i32 = 1;
const MANY_PARTS: i32 = 4;
/// How hard a stop brakes, as shares of the most: the first that keeps the rate.
const BRAKING: [f64; 4] = [1.0, 0.8, 0.6, 0.4];
/// Halvings of the time at which s is at a place.
const HALVINGS: usize = 50;

/// What is asked of the tensions' rates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gentle {
    /// The greatest, N/s,
    pub rate: f64,
    /// between two times that are no nearer to each other, s.
    pub apart: f64,
    /// What the law keeps from the limits of more than six cables, N.
    pub margin: f64,
}

/// The means of a motion's s, in arcs of constant s'', from rest to rest.
#[derive(Clone, Copy, Debug)]
pub struct Mean<'a> {
    timing: &'a Timing,
    /// Over this time, s.
    width: f64,
}

/// From s with the speed v and the acceleration a on, with a constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// When it begins and how long it takes, s.
    pub begin: f64,
    pub duration: f64,
    pub along: Along,
    pub jerk: f64,
}

impl<'a> Mean<'a> {
    /// Over `width` (s).
    pub fn new(timing: &'a Timing, width: f64) -> Self {
        Self { timing, width }
    }

    /// When it comes to rest, s.
    pub fn end(&self) -> f64 {
        self.timing.duration + self.width
    }

    /// Where the motion is `t` seconds after its start.
    pub fn at(&self, t: f64) -> Along {
        if t >= self.end() {
            return [self.timing.end, 0.0, 0.0];
        }
        let [now, then] = [t, t - self.width].map(|t| self.of_all(t));
        [self.place(t), (now[0] - then[0]) / self.width, (now[1] - then[1]) / self.width]
    }

    /// Of the motion that is averaged.
    fn of_all(&self, t: f64) -> Along {
        if t < 0.0 { [self.timing.start(), 0.0, 0.0] } else { self.timing.at(t) }
    }

    /// The mean of s; over an arc's part that takes d, s in its middle and s'' d²/24.
    fn place(&self, t: f64) -> f64 {
        let (from, to) = (t - self.width, t);
        let before = (-from).clamp(0.0, self.width);
        let after = (to - self.timing.duration).clamp(0.0, self.width);
        let mut sum = self.timing.start() * before + self.timing.end * after;
        for (arc, duration) in self.timing.spans() {
            let (begin, end) = (arc.begin.max(from), (arc.begin + duration).min(to));
            if end > begin {
                let d = end - begin;
                let [s, _, a] = arc.at(0.5 * (begin + end) - arc.begin);
                sum += (s + a * d * d / 24.0) * d;
            }
        }
        sum / self.width
    }

    /// The pieces of constant jerk that end after `from` (s), cut where the sections of `way` join.
    pub fn ramps(self, way: &Track, from: f64) -> impl Iterator<Item = Ramp> + use<'a> {
        let crossings: ArrayVec<f64, MOST_SECTIONS> = self.crossings(way).collect();
        let ends = std::iter::successors(Some(0.0), move |t| self.next(*t, &crossings));
        let pairs = ends.clone().zip(ends.skip(1));
        pairs.filter(move |(_, end)| *end > from).map(move |(begin, end)| {
            let (middle, width) = (0.5 * (begin + end), self.width);
            let jerk = (self.of_all(middle)[2] - self.of_all(middle - width)[2]) / width;
            Ramp { begin, duration: end - begin, along: self.at(begin), jerk }
        })
    }

    /// The end of the piece that begins at a time, s.
    fn next(&self, t: f64, crossings: &[f64]) -> Option<f64> {
        let instants = self.timing.arcs().iter().map(|arc| arc.begin).chain([self.timing.duration]);
        let ends = instants.flat_map(|instant| [instant, instant + self.width]);
        let later = ends.chain(crossings.iter().copied()).filter(|end| *end > t + ROUNDING * self.width);
        later.reduce(f64::min)
    }

    /// When it passes where the sections of a way join, s.
    pub fn crossings<'b>(self, way: &'b Track) -> impl Iterator<Item = f64> + use<'a, 'b> {
        let within = self.timing.start()..self.timing.end;
        let joints = way.sections().iter().skip(1).map(|section| section.begin);
        joints.filter(move |joint| within.contains(joint)).map(move |joint| {
            let (mut before, mut after) = (0.0, self.end());
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + after);
                *(if self.place(middle) < joint { &mut before } else { &mut after }) = middle;
            }
            after
        })
    }

    /// The greatest rate of a tension by looking at the ends of this many parts of each piece, N/s.
    fn rate_seen(&self, rig: &Rig, way: &Track, gentle: &Gentle, [from, parts]: [f64; 2]) -> Option<f64> {
        let mut most = 0.0f64;
        let mut before: Option<(f64, PerCable<f64>)> = None;
        for ramp in self.ramps(way, from) {
            for k in 0..=parts as i32 {
                let time = ramp.begin + ramp.duration * f64::from(k) / parts;
                let reference = led(way.section(self.place(ramp.begin + 0.5 * ramp.duration)), self.at(time));
                let tension = tensions(
                    rig,
                    &reference.pose,
                    &reference.rates,
                    &reference.accelerations,
                    gentle.margin,
                )?;
                if let Some((earlier, before)) = before.filter(|(earlier, _)| time > *earlier) {
                    let change = tension.iter().zip(&before).map(|(u, before)| (u - before).abs());
                    most = most.max(change.fold(0.0, f64::max) / (time - earlier));
                }
                before = Some((time, tension));
            }
        }
        Some(most)
    }

    /// Whether every tension is proved to stay within the limits from a time (s) on; what is seen of them is added.
    fn is_proved(&self, rig: &Rig, path: &Path, from: f64, spans: &mut usize, seen: &mut Seen) -> bool {
        self.ramps(&path.way, from).all(|Ramp { begin, duration, along: [s, v, a], jerk }| {
            let section = *path.way.section(self.place(begin + 0.5 * duration));
            let part = Part { section, s, v, a, beta: 0.0, jerk };
            Piece::new(part, duration).is_proved(rig, &path.limits, spans, seen)
        })
    }

    /// The greatest rate of a tension from a time (s) on, N/s: of six cables proved with what was `seen`, of more looked at.
    fn rate(&self, rig: &Rig, way: &Track, gentle: &Gentle, from: f64, seen: &Seen) -> Option<f64> {
        if rig.cables.len() > LEAST_CABLES {
            return self.rate_seen(rig, way, gentle, [from, MANY_PARTS.into()]);
        }
        Some(seen.first + 2.0 * seen.off / gentle.apart.max(NEAREST * self.width))
    }

    /// Whether it is proved from a time (s) on, with the rate kept.
    fn is_gentle(&self, rig: &Rig, path: &Path, gentle: &Gentle, from: f64, spans: &mut usize) -> bool {
        let mut seen = Seen::none(rig);
        self.is_proved(rig, path, from, spans, &mut seen)
            && self.rate(rig, &path.way, gentle, from, &seen).is_some_and(|rate| rate <= gentle.rate)
    }
}

impl Path {
    /// The fastest motion from rest to rest whose mean keeps the limits and the rate, the width of that, s, and what was seen of the tensions on it. `None` where none is
    /// found and proved with the `work` that is left.
    pub fn timed_gently(&self, rig: &Rig, gentle: &Gentle, work: &mut Work) -> Option<(Timing, f64, Seen)> {
        let mut narrowed = narrowed_at_first(rig);
        for _ in 0..TIMINGS {
            let timing = self.timed_within(rig, narrowed, work)?;
            if let Some((width, seen)) = self.width(rig, &timing, gentle, work)? {
                return Some((timing, width, seen));
            }
            narrowed *= NARROWER;
        }
        None
    }

    /// The width with which a timing's mean keeps limits and rate. `None` where no width keeps the rate; nothing within that where the limits are not proved to be kept.
    fn width(
        &self,
        rig: &Rig,
        timing: &Timing,
        gentle: &Gentle,
        work: &mut Work,
    ) -> Option<Option<(f64, Seen)>> {
        let (mut width, mut proofs) = (NARROWEST * timing.duration, 0);
        for _ in 0..WIDTHS {
            let mean = Mean::new(timing, width);
            let mut found = mean.rate_seen(rig, &self.way, gentle, [0.0, PARTS.into()])?;
            if found <= gentle.rate && proofs < PROOFS {
                proofs += 1;
                let mut seen = Seen::none(rig);
                if !mean.is_proved(rig, self, 0.0, &mut work.spans, &mut seen) {
                    return Some(None);
                }
                found = mean.rate(rig, &self.way, gentle, 0.0, &seen)?;
                if found <= gentle.rate {
                    return Some(Some((width, seen)));
                }
            }
            width *= MORE * found / gentle.rate;
            if !(width <= WIDEST * timing.duration) {
                return None;
            }
        }
        None
    }

    /// The motion that stops from a time (s) on, as hard as its mean keeps limits and rate; `None` where none that is over sooner is proved.
    pub fn stop_gently(
        &self,
        rig: &Rig,
        (timing, width, gentle): (&Timing, f64, &Gentle),
        time: f64,
    ) -> Option<Timing> {
        if time >= timing.duration {
            return None;
        }
        let [s, v, _] = timing.at(time);
        BRAKING.into_iter().find_map(|share| {
            let stop = timing.until(time).followed_by(&self.braking(rig, [s, v], 1, share)?)?;
            let mut work = Work::of_a_decision();
            let mean = Mean::new(&stop, width);
            (stop.duration < timing.duration && mean.is_gentle(rig, self, gentle, time, &mut work.spans))
                .then_some(stop)
        })
    }
}
