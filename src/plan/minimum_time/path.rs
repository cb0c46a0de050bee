//! The fastest motion of any rig along a way through the six coordinates: path timing on a grid, and the proof of what is between.
//!
//! s'' is constant on each interval of the grid, so s'² is linear in s. Backwards from rest at the end follows how fast the platform may be at each place and
//! still be able to stop there; forwards it goes as fast as that allows. The tensions keep their limits at both ends of each interval; that they do in between is
//! proved by the certificate, and where it is not, the limits are narrowed there and the way is timed again. Derived in docs/minimum-time.md.

use serde::{Deserialize, Serialize};

use super::arc::{MOST_ARCS, Timing};
use super::conditions::feasible;
use super::polygon::{Condition, Polygon};
use super::track::Track;
use crate::plan::planner::STEEPEST;
use crate::reach::certificate::along::{Piece, Seen};
use crate::robot::pose::PITCH;
use crate::robot::{LEAST_CABLES, PerCable, Pose, Rig, TensionLimits};

/// Intervals of the grid.
pub const INTERVALS: usize = MOST_ARCS;
/// By how much the limits are narrowed on the grid at first, as a share of the weight: of more than six cables by more, whose tensions have to be shown. How many
/// times as much where that was not enough.
const NARROWED: [f64; 2] = [1e-4, 1e-3];
const MORE: f64 = 4.0;
/// Times that ways are timed, and spans of time that their proofs look at, in one decision of the planner; the spans of a stop besides.
const MOST_TIMINGS: usize = 8;
const MOST_SPANS: usize = 2000;

/// What is left of a decision's work.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    timings: usize,
    pub(super) spans: usize,
    has_bent: bool,
}

impl Work {
    /// Of one decision.
    pub fn of_a_decision() -> Self {
        Self { timings: MOST_TIMINGS, spans: MOST_SPANS, has_bent: false }
    }

    /// Whether a bend may be looked for: once.
    pub fn may_bend(&mut self) -> bool {
        !std::mem::replace(&mut self.has_bent, true)
    }
}

/// A way through the six coordinates, and what is to be kept on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Where it leads.
    pub way: Track,
    /// Limits of the tensions, N.
    pub limits: PerCable<TensionLimits>,
    /// Greatest s'², 1/s².
    pub fastest: f64,
}

/// How much the limits are narrowed at each place of the grid, N.
type Narrowed = [f64; INTERVALS + 1];

impl Path {
    /// Whether a run with so many cables can have left this.
    pub(super) fn is_sound(&self, cables: usize) -> bool {
        self.way.is_sound()
            && self.limits.len() == cables
            && self.limits.iter().all(|limits| limits.min.is_finite() && !limits.max.is_nan())
            && !self.fastest.is_nan()
    }

    /// How long it takes, s, before anything is proved.
    pub fn quickest(&self, rig: &Rig) -> Option<f64> {
        let is_sensible = (0..=INTERVALS).all(|k| rig.can_be_at(&self.pose(place(k))));
        let timing = is_sensible.then(|| self.fastest(rig, &[narrowed_at_first(rig); INTERVALS + 1]));
        Some(timing??.duration)
    }

    /// The fastest motion from rest to rest, and what was seen of its tensions. `None` where none is found and proved with the `work` that is left, and where the
    /// platform cannot rest somewhere on the way.
    pub fn timed(&self, rig: &Rig, work: &mut Work) -> Option<(Timing, Seen)> {
        if !self.is_sensible(rig) {
            return None;
        }
        let mut narrowed = [narrowed_at_first(rig); INTERVALS + 1];
        while work.timings > 0 {
            work.timings -= 1;
            let timing = self.fastest(rig, &narrowed)?;
            let mut seen = Seen::none(rig);
            let failed = self.not_proved(rig, &timing, &mut work.spans, &mut seen);
            if failed == [false; MOST_ARCS] {
                return Some((timing, seen));
            }
            for k in (0..INTERVALS).filter(|k| failed[*k]) {
                narrowed[k] *= MORE;
                narrowed[k + 1] *= MORE;
            }
        }
        None
    }

    /// The same with the limits narrowed by as much everywhere (N), before anything is proved.
    pub(super) fn timed_within(&self, rig: &Rig, narrowed: f64, work: &mut Work) -> Option<Timing> {
        work.timings = work.timings.checked_sub(1)?;
        self.is_sensible(rig).then(|| self.fastest(rig, &[narrowed; INTERVALS + 1]))?
    }

    fn is_sensible(&self, rig: &Rig) -> bool {
        (0..=INTERVALS).all(|k| {
            let pose = self.pose(place(k));
            rig.can_be_at(&pose) && pose.0[PITCH].abs() < STEEPEST
        })
    }

    /// The stop as soon as can be from the place `s` with the speed `v` (1/s) on; `None` where none is proved, as where the motion brakes as hard as it can already.
    pub fn stop(&self, rig: &Rig, s: f64, v: f64) -> Option<Timing> {
        self.stop_in_steps(rig, [s, v], 1)
    }

    /// The same in steps of so many places of the grid; on a way of one section.
    pub fn stop_in_steps(&self, rig: &Rig, from: [f64; 2], step: usize) -> Option<Timing> {
        let timing = self.braking(rig, from, step, 1.0)?;
        let failed = self.not_proved(rig, &timing, &mut { MOST_SPANS }, &mut Seen::none(rig));
        (failed == [false; MOST_ARCS]).then_some(timing)
    }

    /// The stop before anything is proved, braking by a `share` of the most.
    pub(super) fn braking(&self, rig: &Rig, [s, v]: [f64; 2], step: usize, share: f64) -> Option<Timing> {
        let narrowed = narrowed_at_first(rig);
        let mut timing = Timing::begun_at(s);
        let s = s.max(0.0);
        let (mut here, mut x) = (self.polygon(rig, s, narrowed), v * v);
        let first = (0..=INTERVALS).find(|k| place(*k) > s)?;
        for k in (first..=INTERVALS).filter(|k| k % step == 0) {
            let ds = place(k) - timing.end;
            // Before the next place, where it can.
            let hard = |[least, greatest]: [f64; 2]| (share * least).max(least).min(greatest);
            let least = hard(here.between(x.min(here.highest()?))?);
            if x + 2.0 * ds * least <= 0.0 {
                timing.push(x.sqrt(), [least, 0.0], timing.end - 0.5 * x / least, 0.0);
                x = 0.0;
                break;
            }
            let next = self.polygon(rig, place(k), narrowed);
            here.clip_to_reach(&next, ds);
            let least = hard(here.between(x.min(here.highest()?))?);
            let after = (x + 2.0 * ds * least).max(0.0);
            timing.push(x.sqrt(), [(after - x) / (2.0 * ds), 0.0], place(k), after.sqrt());
            (here, x) = (next, after);
        }
        let is_held = x == 0.0 && self.polygon(rig, timing.end, narrowed).has_rest();
        is_held.then_some(timing)
    }

    fn pose(&self, s: f64) -> Pose {
        self.way.pose(s)
    }

    /// What is feasible at a place, with the limits narrowed.
    fn polygon(&self, rig: &Rig, s: f64, narrowed: f64) -> Polygon {
        let limits = self.limits.map(|limits| limits.shrunk(narrowed));
        let mut polygon = feasible(rig, &limits, self.way.section(s), s);
        if self.fastest.is_finite() {
            polygon.clip(&Condition { a: 0.0, x: 1.0, bound: self.fastest });
        }
        polygon
    }

    fn fastest(&self, rig: &Rig, narrowed: &Narrowed) -> Option<Timing> {
        let at = |k: usize| self.polygon(rig, place(k), narrowed[k]);
        let ds = 1.0 / INTERVALS as f64;
        // What leads from a place to the next, where s'² is at most `most`.
        let leading = |mut here: Polygon, next: &Polygon, most: f64| {
            here.clip_to_reach(next, ds);
            here.clip(&Condition { a: 2.0 * ds, x: 1.0, bound: most });
            here
        };
        let mut most = [0.0; INTERVALS + 1];
        let mut next = at(INTERVALS);
        if !next.has_rest() {
            return None;
        }
        // A corner of the polygons, which rounding must not cut off.
        most[INTERVALS] = STILL * next.highest()?;
        for k in (0..INTERVALS).rev() {
            let here = at(k);
            if !here.has_rest() {
                return None;
            }
            most[k] = leading(here.clone(), &next, most[k + 1]).highest()?;
            next = here;
        }
        let mut timing = Timing::begun_at(0.0);
        let (mut here, mut x) = (next, 0.0);
        for k in 0..INTERVALS {
            let next = at(k + 1);
            let polygon = leading(here, &next, most[k + 1]);
            let [_, greatest] = polygon.between(f64::min(x, polygon.highest()?))?;
            let is_last = k + 1 == INTERVALS;
            let after = if is_last { 0.0 } else { (x + 2.0 * ds * greatest).max(0.0).min(most[k + 1]) };
            if x + after <= 0.0 {
                return None;
            }
            timing.push(x.sqrt(), [(after - x) / (2.0 * ds), 0.0], place(k + 1), after.sqrt());
            (here, x) = (next, after);
        }
        Some(timing)
    }

    /// Which arcs are not proved to keep the limits.
    fn not_proved(
        &self,
        rig: &Rig,
        timing: &Timing,
        spans: &mut usize,
        seen: &mut Seen,
    ) -> [bool; MOST_ARCS] {
        let mut failed = [false; MOST_ARCS];
        for (k, (arc, duration)) in timing.spans().enumerate() {
            let piece = Piece::new(arc.part(self.way.section(arc.s), 0.0), duration);
            failed[k] = !piece.is_proved(rig, &self.limits, spans, seen);
        }
        failed
    }
}

/// N.
pub fn narrowed_at_first(rig: &Rig) -> f64 {
    NARROWED[usize::from(rig.cables.len() > LEAST_CABLES)] * rig.weight()
}

/// This share of s'² counts as rest.
const STILL: f64 = 1e-9;

/// Of the grid.
pub fn place(k: usize) -> f64 {
    k as f64 / INTERVALS as f64
}

#[cfg(test)]
mod tests {
    use super::super::Line;
    use super::*;
    use crate::control::{static_margin, tensions};
    use crate::robot::{Coordinates, RigFile, RobotParameters};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn path(rig: &Rig, from: Pose, to: &Pose) -> Path {
        Path { way: Track::straight(&from, to), limits: rig.limits(), fastest: f64::INFINITY }
    }

    /// On a level line of the paper's robot both ways give the same.
    #[test]
    fn a_line_is_timed_as_the_closed_form_times_it() {
        let limits = TensionLimits { min: 0.5, max: 60.0 };
        let rig = Rig::paper(&RobotParameters::default(), limits);
        for to in [Pose::at(0.15, 0.15, 1.0), Pose::at(-0.1, 0.12, 0.8), Pose::at(0.05, 0.1, 1.3)] {
            let from = Pose::default();
            let line = Line::new(&RobotParameters::default(), limits, &from.position(), &to.position());
            let expected = line.fastest(0.0, f64::INFINITY).unwrap().duration;
            let found = path(&rig, from, &to).timed(&rig, &mut Work::of_a_decision()).unwrap().0.duration;
            println!("{expected:.5} s, on the grid {found:.5} s");
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        }
    }

    /// Random ways of three rigs: between the ends of the intervals, and on stops.
    #[test]
    fn tensions_keep_their_limits_between_the_places_of_the_grid_too() {
        for (text, runs) in [
            (include_str!("../../../rigs/paper.toml"), 40),
            (include_str!("../../../rigs/eight.toml"), 12),
            (include_str!("../../../rigs/public/cogiro.toml"), 8),
        ] {
            let RigFile { rig, home, .. } = RigFile::parse(text).unwrap();
            let rig = &rig;
            let mut rng = Pcg64::seed_from_u64(5);
            let mut end = || {
                let mut any = || {
                    Coordinates::from_fn(|k, _| {
                        rng.random_range(-1.0..1.0) * if k < 3 { 0.15 * rig.radius() } else { 0.2 }
                    })
                };
                let poses = std::iter::repeat_with(|| Pose(home.0 + any()));
                poses.take(1000).find(|pose| static_margin(rig, pose) > 0.01 * rig.weight()).unwrap()
            };
            let (mut planned, mut stopped) = (0, 0);
            for run in 0..runs {
                let mut path = path(rig, end(), &end());
                if run % 2 == 1 {
                    let bump = Coordinates::from_fn(|k, _| if k == 2 { -0.03 * rig.radius() } else { 0.02 });
                    path.way = Track::bent(&path.pose(0.0), &path.pose(1.0), &bump);
                }
                let Some((timing, _)) = path.timed(rig, &mut Work::of_a_decision()) else { continue };
                planned += 1;
                let check = |timing: &Timing| {
                    let arcs = timing.arcs();
                    for (k, arc) in arcs.iter().enumerate() {
                        let (end, v) =
                            arcs.get(k + 1).map_or((timing.duration, 0.0), |next| (next.begin, next.v));
                        let [_, at_end, _] = arc.at(end - arc.begin);
                        assert!((at_end - v).abs() < 1e-6, "arc {k} of {}: {at_end} {v} {arc:?}", arcs.len());
                    }
                    for k in 0..=500 {
                        let [s, v, a] = timing.at(timing.duration * f64::from(k) / 500.0);
                        let (slope, bend) = (path.way.section(s).slope(s), path.way.section(s).bend(s));
                        let accelerations = slope * a + bend * (v * v);
                        let tension =
                            tensions(rig, &path.pose(s), &(slope * v), &accelerations, 0.0).unwrap();
                        let is_kept = |(u, limits): (&f64, &TensionLimits)| limits.margin(*u) > -1e-9;
                        assert!(tension.iter().zip(&path.limits).all(is_kept), "{path:?} {tension:?}");
                    }
                };
                check(&timing);
                for share in [0.2, 0.5, 0.7] {
                    let [s, v, _] = timing.at(share * timing.duration);
                    if let Some(stop) = path.stop(rig, s, v) {
                        stopped += 1;
                        check(&stop);
                        assert!(stop.end <= 1.0 && stop.at(stop.duration).eq(&[stop.end, 0.0, 0.0]));
                    }
                }
            }
            println!("{} cables: {planned} of {runs} planned, {stopped} stops", rig.cables.len());
            assert!(planned * 10 >= runs * 9 && stopped > planned);
        }
    }
}
