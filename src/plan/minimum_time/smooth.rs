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
use crate::robot::memory::are_finite;
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
const BRAKING: [f64; 7] = [1.0, 0.8, 0.6, 0.4, 0.25, 0.15, 0.1];
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

impl Gentle {
    pub(super) fn is_sound(&self) -> bool {
        are_finite(&[self.rate, self.apart, self.margin])
    }
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
        self.pieces(&path.way, from).all(|piece| piece.is_proved(rig, &path.limits, spans, seen))
    }

    /// The pieces that end after `from` (s), along `way`.
    pub fn pieces<'b>(self, way: &'b Track, from: f64) -> impl Iterator<Item = Piece> + use<'a, 'b> {
        self.ramps(way, from).map(move |Ramp { begin, duration, along: [s, v, a], jerk }| {
            let section = *way.section(self.place(begin + 0.5 * duration));
            Piece::new(Part { section, s, v, a, beta: 0.0, jerk }, duration)
        })
    }

    /// The same: where nothing else tells it in the end, with more than six cables, once more and more closely.
    fn rate_looked_at(&self, rig: &Rig, way: &Track, gentle: &Gentle, from: f64) -> Option<f64> {
        let found = self.rate_seen(rig, way, gentle, [from, PARTS.into()])?;
        let is_enough = rig.cables.len() == LEAST_CABLES || found > gentle.rate;
        if is_enough { Some(found) } else { self.rate_seen(rig, way, gentle, [from, MANY_PARTS.into()]) }
    }

    /// The rate that a proof has shown of six cables, N/s; of more the tensions shown are not those of the law.
    fn rate_proved(&self, rig: &Rig, gentle: &Gentle, seen: &Seen) -> f64 {
        let is_shown = rig.cables.len() == LEAST_CABLES;
        if is_shown { seen.first + 2.0 * seen.off / gentle.apart.max(NEAREST * self.width) } else { 0.0 }
    }

    /// Whether it is proved from a time (s) on, with the rate kept.
    fn is_gentle(&self, rig: &Rig, path: &Path, gentle: &Gentle, from: f64, spans: &mut usize) -> bool {
        let mut seen = Seen::none(rig);
        self.rate_looked_at(rig, &path.way, gentle, from).is_some_and(|rate| rate <= gentle.rate)
            && self.is_proved(rig, path, from, spans, &mut seen)
            && self.rate_proved(rig, gentle, &seen) <= gentle.rate
    }
}

impl Path {
    /// The fastest motion from rest to rest whose mean keeps the limits and the rate, the width of that, s, and what was seen of the tensions on it. `None` where none is
    /// found and proved with the `work` that is left.
    pub fn timed_gently(&self, rig: &Rig, gentle: &Gentle, work: &mut Work) -> Option<(Timing, f64, Seen)> {
        let mut narrowed = narrowed_at_first(rig);
        for _ in 0..TIMINGS {
            let (timing, least) = self.slowed(rig, self.timed_within(rig, narrowed, work)?, gentle)?;
            if let Some((width, seen)) = self.width(rig, (&timing, least), gentle, work)? {
                return Some((timing, width, seen));
            }
            narrowed *= NARROWER;
        }
        None
    }

    /// A timing whose tensions jump by J as slow as makes the mean quickest: k times as slow its jumps are J/k², and it takes k T + J/(k² rate) in all. And the width that
    /// the jumps ask for.
    fn slowed(&self, rig: &Rig, timing: Timing, gentle: &Gentle) -> Option<(Timing, f64)> {
        let width = NARROWEST * timing.duration;
        let jump =
            width * Mean::new(&timing, width).rate_seen(rig, &self.way, gentle, [0.0, PARTS.into()])?;
        let times = libm::cbrt(2.0 * jump / (gentle.rate * timing.duration));
        let times = times.max(1.0);
        Some((timing.slowed(times), (jump / (times * times * gentle.rate)).max(width)))
    }

    /// The width, from the least on, with which a timing's mean keeps limits and rate. `None` where no width keeps the rate; nothing within that where the limits are not proved to be kept.
    fn width(
        &self,
        rig: &Rig,
        (timing, least): (&Timing, f64),
        gentle: &Gentle,
        work: &mut Work,
    ) -> Option<Option<(f64, Seen)>> {
        let (mut width, mut proofs) = (least, 0);
        for _ in 0..WIDTHS {
            if width.is_nan() || width > WIDEST * timing.duration {
                return None;
            }
            let mean = Mean::new(timing, width);
            let mut found = mean.rate_looked_at(rig, &self.way, gentle, 0.0)?;
            if found <= gentle.rate && proofs < PROOFS {
                proofs += 1;
                let mut seen = Seen::none(rig);
                if !mean.is_proved(rig, self, 0.0, &mut work.spans, &mut seen) {
                    return Some(None);
                }
                found = mean.rate_proved(rig, gentle, &seen);
                if found <= gentle.rate {
                    return Some(Some((width, seen)));
                }
            }
            width *= MORE * found / gentle.rate;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Coordinates, Pose, RigFile};

    #[test]
    fn a_mean_is_the_mean_of_the_time_just_past() {
        let mut timing = Timing::begun_at(0.2);
        timing.push(0.0, [2.0, 0.0], 1.2, 2.0);
        timing.push(2.0, [-4.0, 0.0], 1.6, 0.8f64.sqrt());
        timing.push(0.8f64.sqrt(), [-1.0, 0.0], 2.0, 0.0);
        for width in [0.01, 0.5, 7.0] {
            let mean = Mean::new(&timing, width);
            let parts = 4000;
            let numeric = |t: f64| {
                let at = |k: i32| mean.of_all(t - width * (f64::from(k) + 0.5) / f64::from(parts))[0];
                (0..parts).map(at).sum::<f64>() / f64::from(parts)
            };
            for k in 0..=50 {
                let t = mean.end() * f64::from(k) / 50.0;
                let [s, v, a] = mean.at(t);
                assert!((s - numeric(t)).abs() < 1e-6, "{s} {t}");
                let h = 1e-4 * width;
                let [before, after] = [mean.at(t - h), mean.at(t + h)];
                assert!(((after[0] - before[0]) / (2.0 * h) - v).abs() < 1e-3, "{v} at {t}");
                assert!(((after[1] - before[1]) / (2.0 * h) - a).abs() < 1e-2 / width, "{a} at {t}");
            }
            let straight = Track::straight(&Pose::default(), &Pose::at(0.1, 0.0, 1.0));
            let mut end = 0.0;
            for Ramp { begin, duration, along: [s, v, a], jerk } in mean.ramps(&straight, 0.0) {
                assert_eq!(begin, end);
                end = begin + duration;
                let reached = s + (v + (0.5 * a + jerk * duration / 6.0) * duration) * duration;
                assert!((reached - mean.at(end)[0]).abs() < 1e-12, "{reached} at {end}");
                assert!((a + jerk * duration - mean.at(end)[2]).abs() < 1e-9);
            }
            assert!((end - mean.end()).abs() < 1e-12);
        }
    }

    /// Straight ways, bent ones and such by way points: tensions and their rates in dense samples, also on stops.
    #[test]
    fn what_is_proved_of_a_mean_is_so() {
        let rig = &RigFile::default().rig.with_limits(crate::robot::TensionLimits { min: 0.5, max: 40.0 });
        let [start, end] = [Pose::at(-0.1, 0.0, 1.0), Pose(Coordinates::new(0.12, 0.1, 0.9, 0.1, 0.0, 0.2))];
        let bump = Coordinates::new(0.0, 0.02, -0.05, 0.0, 0.0, 0.0);
        let ways = [
            Track::straight(&start, &end),
            Track::bent(&start, &end, &bump),
            Track::through(&[start, Pose::at(0.0, 0.08, 0.95), end], 0.3).unwrap(),
        ];
        let (mut planned, mut stops) = (0, 0);
        for (way, rate) in ways.iter().flat_map(|way| [(way, 1500.0), (way, 300.0), (way, 20.0)]) {
            let path = Path { way: way.clone(), limits: rig.limits(), fastest: f64::INFINITY };
            let gentle = Gentle { rate, apart: 1e-3, margin: 0.0 };
            let found = path.timed_gently(rig, &gentle, &mut Work::of_a_decision());
            let Some((timing, width, _)) = found else {
                println!("{rate} N/s: none found");
                continue;
            };
            planned += 1;
            let check = |timing: &Timing, from: f64| {
                let mean = Mean::new(timing, width);
                let (mut most, mut before) = (0.0f64, None::<PerCable<f64>>);
                let step = 1e-3 * (mean.end() - from);
                for k in 0..=1000 {
                    let [s, v, a] = mean.at(from + step * f64::from(k));
                    let led = led(way.section(s), [s, v, a]);
                    let u = tensions(rig, &led.pose, &led.rates, &led.accelerations, 0.0).unwrap();
                    assert!(u.iter().all(|u| (0.5..=40.0).contains(u)), "{u:?}");
                    if let Some(before) = before {
                        let change = u.iter().zip(&before).map(|(u, before)| (u - before).abs() / step);
                        most = change.fold(most, f64::max);
                    }
                    before = Some(u);
                }
                assert!(most <= rate, "{most} {rate}");
                most
            };
            let most = check(&timing, 0.0);
            // Slow ways by way points are slower than they need be.
            assert!(most > 0.6 * rate, "{most} {rate}");
            let before = stops;
            for share in [0.1, 0.3, 0.5] {
                let time = share * timing.duration;
                if let Some(stop) = path.stop_gently(rig, (&timing, width, &gentle), time) {
                    check(&stop, time);
                    let [now, then] = [&timing, &stop].map(|timing| Mean::new(timing, width).at(time));
                    assert!((0..3).all(|k| (now[k] - then[k]).abs() < 1e-9), "{now:?} {then:?}");
                    stops += 1;
                }
            }
            let found = stops - before;
            println!("{rate} N/s: {:.3} s, {most:.1} N/s, {found} stops of 3", timing.duration + width);
        }
        // Where none is found the motion goes on to its end.
        assert!(planned >= 7 && stops > 9, "{planned} of 9, {stops} stops");
    }
}
