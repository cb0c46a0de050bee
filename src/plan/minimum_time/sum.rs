//! A motion added to legs that come to rest: on to a new goal while the robot still brakes. Derived in docs/minimum-time.md.
//!
//! q(t) = S(t) + D σ(t): S the legs, D the straight way from where they rest to the goal. At each instant the tensions bound σ'' at a given σ and σ': as fast
//! as they allow until a switch, then braking as hard as they allow; the switch is where that ends at the goal.

use super::arc::Timing;
use super::conditions::between;
use super::course::{Leg, Way, add};
use super::path::{Path, Work, narrowed_at_first};
use crate::control::Reference;
use crate::plan::planner::STEEPEST;
use crate::reach::certificate::along::{Piece, Seen};
use crate::robot::dynamics::Placed;
use crate::robot::pose::PITCH;
use crate::robot::{PerCable, Rig, TensionLimits};

/// Switches tried, and how near to the goal one leads, as a share of the way: what is left over is taken out of the way itself.
const SWITCHES: usize = 16;
const NEAR: f64 = 1e-5;
/// Instants looked at in the time that a stop takes.
const INSTANTS: f64 = 20.0;
/// Times nearer to each other than this share of a stride are one.
const ROUNDING: f64 = 1e-6;

/// Legs that run on, and the way that is added to them.
pub struct Sum<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Each comes to rest.
    pub legs: &'a [Leg],
    /// Straight, from where they rest.
    pub path: &'a Path,
    /// Time between two looks at the tensions, s, at most.
    stride: f64,
    /// The path's, narrowed: what is added to keeps them narrowed by more.
    limits: PerCable<TensionLimits>,
}

impl<'a> Sum<'a> {
    /// Looks at the tensions each `stride` seconds, and where an arc ends.
    pub fn new(rig: &'a Rig, legs: &'a [Leg], path: &'a Path, stride: f64) -> Self {
        let narrowed = libm::scalbn(narrowed_at_first(rig), -(legs.len() as i32));
        let limits = path.limits.map(|limits| limits.shrunk(narrowed));
        Self { rig, legs, path, stride, limits }
    }

    /// The fastest motion from σ = σ' = 0 at `begin` (s) to rest at σ = 1; `None` where it is not over before `end` (s). Proved it is not.
    pub fn fastest(&self, begin: f64, end: f64) -> Option<Timing> {
        self.to_the_goal(begin, end).filter(|timing| begin + timing.duration < end)
    }

    /// As fast as can be, then as slow: where from, by halving and by secants. An end that stays twice counts half of what it is off by (the Illinois method).
    fn to_the_goal(&self, begin: f64, end: f64) -> Option<Timing> {
        let fast = self.speeding_up(begin, end);
        let mut low = (0.0, self.braking(Timing::begun_at(0.0), [begin, 0.0])?.end - 1.0);
        let mut high = (fast.duration, None::<f64>);
        let mut was_short = None;
        for _ in 0..SWITCHES {
            let share = high.1.map_or(0.5, |high| (low.1 / (low.1 - high)).clamp(0.01, 0.99));
            let switch = low.0 + share * (high.0 - low.0);
            let rate = fast.at(switch)[1];
            let Some(timing) = self.braking(fast.until(switch), [begin, rate]) else {
                (high, was_short) = ((switch, None), None);
                continue;
            };
            let (reached, off) = (timing.end, timing.end - 1.0);
            if off.abs() < NEAR {
                return Some(timing.over(reached));
            }
            let is_short = off < 0.0;
            let by = if was_short == Some(is_short) { 0.5 } else { 1.0 };
            if is_short {
                (low, high.1) = ((switch, off), high.1.map(|high| by * high));
            } else {
                (low.1, high) = (by * low.1, (switch, Some(off)));
            }
            was_short = Some(is_short);
        }
        None
    }

    /// From σ = σ' = 0 at `begin` (s) on with σ'' as great as can be, until `end` (s), σ is 1 or no σ'' keeps the limits.
    fn speeding_up(&self, begin: f64, end: f64) -> Timing {
        let (mut timing, mut rate, mut seen) = (Timing::begun_at(0.0), 0.0, None);
        while timing.end < 1.0 && begin + timing.duration < end && !timing.is_full() {
            let time = begin + timing.duration;
            let h = self.next(time) - time;
            // Not backwards.
            let pick = |[_, greatest]: [f64; 2]| greatest.max(-rate / h);
            let Some((a, ahead)) = self.picked([time, h], [timing.end, rate], seen, pick) else { break };
            timing.push_for(rate, a, h);
            (rate, seen) = ((rate + a * h).max(0.0), ahead);
        }
        timing
    }

    /// From where a motion that began at `begin` (s) has come to with σ' = `rate`, σ'' as small as can be until σ' is 0, and on until the legs rest. `None` where no σ''
    /// keeps the limits.
    fn braking(&self, mut timing: Timing, [begin, mut rate]: [f64; 2]) -> Option<Timing> {
        let rests = self.legs.iter().map(Leg::end).fold(begin, f64::max);
        let mut seen = None;
        loop {
            let time = begin + timing.duration;
            if rate <= 0.0 && time >= rests - ROUNDING * self.stride {
                return Some(timing);
            }
            if timing.is_full() {
                return None;
            }
            let mut h = self.next(time) - time;
            let pick = |[least, _]: [f64; 2]| if rate > 0.0 { least } else { 0.0 };
            let (a, ahead) = self.picked([time, h], [timing.end, rate], seen, pick)?;
            seen = ahead;
            if rate > 0.0 && rate + a * h <= 0.0 {
                h = -rate / a;
                timing.push_for(rate, a, h);
                (rate, seen) = (0.0, None);
            } else {
                timing.push_for(rate, a, h);
                rate += a * h;
            }
        }
    }

    /// The σ'' that is picked from those that keep the limits at both ends of an interval; with those that keep them where it begins, if they were `seen`. And those that keep
    /// them where the next one begins, where they are the same.
    fn picked(
        &self,
        [time, h]: [f64; 2],
        [sigma, rate]: [f64; 2],
        seen: Option<[f64; 2]>,
        pick: impl Fn([f64; 2]) -> f64,
    ) -> Option<(f64, Option<[f64; 2]>)> {
        let middle = time + 0.5 * h;
        let here = match seen {
            Some(seen) => seen,
            None => self.range(middle, time, [sigma, rate])?,
        };
        let ahead = pick(here);
        let (s, v) = (sigma + (rate + 0.5 * ahead * h) * h, (rate + ahead * h).max(0.0));
        let there = self.range(middle, time + h, [s, v])?;
        let both = [here[0].max(there[0]), here[1].min(there[1])];
        let a = pick(both);
        // Where an arc of the legs ends, the next one begins with another acceleration.
        let is_joint = |end: f64| (end - time - h).abs() <= ROUNDING * self.stride;
        let goes_on = a == ahead && !self.legs.iter().flat_map(Leg::instants).any(is_joint);
        (both[0] <= a && a <= both[1]).then_some((a, goes_on.then_some(there)))
    }

    /// The next time to look at the tensions, s.
    fn next(&self, time: f64) -> f64 {
        let soon = time + ROUNDING * self.stride;
        let ends = self.legs.iter().flat_map(Leg::instants);
        ends.filter(|end| *end > soon).fold(time + self.stride, f64::min)
    }

    /// The σ'' that keep the limits, narrowed, at a time of the interval with an instant.
    fn range(&self, instant: f64, time: f64, [sigma, rate]: [f64; 2]) -> Option<[f64; 2]> {
        let mut sum = Reference::resting(&self.path.way.pose(sigma));
        let way = self.path.way.section(sigma).slope(sigma);
        sum.rates = way * rate;
        for leg in self.legs {
            if let Some(led) = leg.led(instant, time) {
                add(&mut sum, &led, &leg.end_pose());
            }
        }
        if !self.rig.can_be_at(&sum.pose) || sum.pose.0[PITCH].abs() >= STEEPEST {
            return None;
        }
        let placed = Placed::new(self.rig, &sum.pose);
        let rest = placed.required_wrench(&sum.rates, &sum.accelerations);
        between(self.rig, &self.limits, &sum.pose, rest, placed.wrench_of(&way))
    }

    /// Whether the sum with a motion that begins at `begin` (s) is proved to keep the path's limits. What is shown of the tensions is added to `seen`.
    pub fn is_proved(&self, begin: f64, timing: &Timing, work: &mut Work, seen: &mut Seen) -> bool {
        timing.spans().all(|(arc, duration)| {
            let from = begin + arc.begin;
            let part = arc.part(self.path.way.section(arc.s), 0.0);
            let below = self
                .legs
                .iter()
                .filter_map(|leg| Some((leg.part(from + 0.5 * duration, from)?, leg.end_pose())));
            let mut piece = Some(Piece::new(part, duration));
            for (part, rest) in below {
                piece = piece.and_then(|piece| piece.and(part, &rest));
            }
            piece.is_some_and(|piece| piece.is_proved(self.rig, &self.path.limits, &mut work.spans, seen))
        })
    }
}

/// The stop as soon as is proved, from a time (s) on, of a leg that is added to others; where none is, itself.
pub fn stop(rig: &Rig, legs: &[Leg], leg: &Leg, time: f64) -> Leg {
    let Way::Path(path) = &leg.way else { return leg.clone() };
    let [sigma, rate, _] = leg.timing.at(time - leg.begin);
    let sum = Sum::new(rig, legs, path, (leg.end() - time) / INSTANTS);
    let timing = sum.braking(Timing::begun_at(sigma), [time, rate]);
    let is_proved =
        |timing: &Timing| sum.is_proved(time, timing, &mut Work::of_a_decision(), &mut Seen::none(rig));
    match timing.filter(is_proved) {
        Some(timing) => Leg { timing, begin: time, ..leg.clone() },
        None => leg.clone(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use crate::control::{static_margin, tensions};
    use crate::plan::{ControllerParameters, Planner, PlannerKind};
    use crate::robot::{Coordinates, Pose, RigFile};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Moves interrupted at random: the sum keeps the limits in dense samples, and so does its stop; how much sooner it is there than after a stop.
    #[test]
    fn interrupted_moves_go_on_within_the_limits_and_sooner_than_after_a_stop() {
        for (text, turn, runs) in [
            (include_str!("../../../rigs/paper.toml"), 0.0, 60),
            (include_str!("../../../rigs/paper.toml"), 0.2, 60),
        ] {
            let RigFile { rig, home, .. } = RigFile::parse(text).unwrap();
            let parameters =
                ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&rig) };
            let planner = Planner::from(parameters);
            let mut rng = Pcg64::seed_from_u64(7);
            let mut pose = || {
                let mut any = || {
                    Coordinates::from_fn(|k, _| {
                        rng.random_range(-1.0..1.0) * if k < 3 { 0.25 * rig.radius() } else { turn }
                    })
                };
                let poses = std::iter::repeat_with(|| Pose(home.0 + any())).take(10_000);
                let mut above = poses.filter(|pose| rig.can_be_at(pose));
                above.find(|pose| static_margin(&rig, pose) > 0.02 * rig.weight()).unwrap()
            };
            let mut shares = Pcg64::seed_from_u64(8);
            let (mut gains, mut spent, mut stops) = (vec![], vec![], 0);
            for _ in 0..runs {
                let (from, to, then) = (pose(), pose(), pose());
                let Some(first) = planner.course_from_rest(&from, &to) else { continue };
                let begin = first.end() * shares.random_range(0.1..0.9);
                let stopped = first.stopped(&rig, begin);
                let Some(after) = planner.course_from_rest(&stopped.end_pose(), &then) else { continue };
                let sequential = stopped.end() - begin + after.end();
                let asked = Instant::now();
                let Some(course) = planner.course_from(&first, begin, &then) else {
                    panic!("{from:?} {to:?} {then:?} {begin}")
                };
                spent.push(asked.elapsed());
                gains.push((course.end() - begin) / sequential);
                let check = |course: &super::super::Course, from: f64| {
                    for k in 0..=1000 {
                        let time = from + (course.end() - from) * f64::from(k) / 1000.0;
                        let led = course.at(time);
                        let u = tensions(&rig, &led.pose, &led.rates, &led.accelerations, 0.0).unwrap();
                        for (u, cable) in u.iter().zip(&rig.cables) {
                            assert!(cable.limits.margin(*u) > -1e-9, "{u} at {time}: {led:?}");
                        }
                    }
                };
                check(&course, begin);
                let (before, now) = (first.at(begin), course.at(begin));
                assert!(
                    (before.pose.0 - now.pose.0).amax() < 1e-9 && (before.rates - now.rates).amax() < 1e-9
                );
                assert!(course.at(course.end()).pose.minus(&then).amax() < 1e-9);
                for share in [0.1, 0.3, 0.6] {
                    let time = begin + share * (course.end() - begin);
                    let stop = course.stopped(&rig, time);
                    check(&stop, time);
                    let (before, now) = (course.at(time), stop.at(time));
                    assert!(
                        (before.pose.0 - now.pose.0).amax() < 1e-9
                            && (before.rates - now.rates).amax() < 1e-9
                    );
                    stops += usize::from(stop.end() < course.end() - 1e-9);
                }
            }
            gains.sort_by(f64::total_cmp);
            spent.sort();
            let (runs, added) = (gains.len(), gains.iter().filter(|gain| **gain < 1.0 - 1e-9).count());
            println!(
                "{} cables, turned by {turn}: {added} of {runs} sooner, {:.3} of the time after a stop in the median, {:.3} on average, {:.3} at best; {stops} stops; planned in {:?}",
                rig.cables.len(),
                gains[runs / 2],
                gains.iter().sum::<f64>() / runs as f64,
                gains[0],
                spent[runs / 2]
            );
            assert!(added * 4 > runs && stops > runs);
        }
    }

    /// Where no stop is proved the motion goes on: taken for a stop and made gentler it began anew from where it began once.
    #[test]
    fn the_way_to_a_new_goal_begins_where_the_robot_is() {
        let RigFile { rig, home, .. } = RigFile::parse(include_str!("../../../rigs/paper.toml")).unwrap();
        let planner = Planner::from(ControllerParameters {
            planner: PlannerKind::MinimumTime,
            ..ControllerParameters::of(&rig)
        });
        let mut rng = Pcg64::seed_from_u64(9);
        let (mut begun, mut gone_on) = (0, 0);
        for _ in 0..200 {
            let mut any = |k: usize| rng.random_range(-1.0..1.0) * if k < 3 { 0.2 } else { 0.35 };
            let [from, to] = [(); 2].map(|()| Pose(home.0 + Coordinates::from_fn(|k, _| any(k))));
            let Some(first) = planner.course_from_rest(&from, &to) else { continue };
            for share in [0.3, 0.5, 0.8, 0.95] {
                let begin = share * first.end();
                gone_on += usize::from(first.stopped(&rig, begin).end() >= first.end());
                let Some(course) = planner.course_from(&first, begin, &from) else { continue };
                let (before, now) = (first.at(begin), course.at(begin));
                let apart = (before.pose.0 - now.pose.0).amax().max((before.rates - now.rates).amax());
                assert!(apart < 1e-9, "{apart} at {share} from {from:?} to {to:?}");
                begun += 1;
            }
        }
        println!("{begun} begun, {gone_on} without a stop");
        assert!(begun > 300 && gone_on > 10);
    }
}
