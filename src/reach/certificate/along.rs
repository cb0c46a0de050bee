//! The proof along a straight way through the six coordinates, in pieces of constant acceleration.

use super::motion::{Motion, Span};
use super::search::{Finding, judge};
use super::statics::cables;
use super::taylor::Taylor;
use super::{Range, redundant};
use crate::robot::{Coordinates, LEAST_CABLES, PerCable, Pose, Rig, TensionLimits};

/// Halvings of a piece before it counts as not proved.
const MOST_HALVINGS: i32 = 10;

/// q = `from` + `way` s with s(t) = `s` + `v` t + `a` t²/2, for `duration` seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// m, rad.
    pub from: Pose,
    /// Of the coordinates, for s from 0 to 1: m, rad.
    pub way: Coordinates,
    /// At its beginning.
    pub s: f64,
    /// 1/s.
    pub v: f64,
    /// 1/s².
    pub a: f64,
    /// s.
    pub duration: f64,
}

/// What was seen of the tensions on proved pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    range: Range,
    /// Bound of their first derivatives, N/s,
    pub first: f64,
    /// and of their second, N/s².
    pub second: f64,
}

impl Seen {
    /// Nothing yet.
    pub fn none(rig: &Rig) -> Self {
        Self { range: Range::none(rig), first: 0.0, second: 0.0 }
    }

    /// What the tension of a cable changes by at most, N.
    pub fn change(&self) -> f64 {
        self.range.change()
    }

    /// Bounds of all tensions, N.
    pub fn extremes(&self) -> [f64; 2] {
        let least = self.range.of_cable.iter().map(|[least, _]| *least).fold(f64::INFINITY, f64::min);
        [least, self.greatest()]
    }

    /// The greatest tension, N.
    pub fn greatest(&self) -> f64 {
        self.range.of_cable.iter().map(|[_, greatest]| *greatest).fold(0.0, f64::max)
    }

    pub(super) fn include(&mut self, tensions: &[Taylor], half: f64) {
        self.range.include(tensions, 0.0);
        for tension in tensions {
            let [mut first, mut second] = [0.0; 2];
            for (k, c) in tension.coefficients.iter().enumerate().skip(1) {
                let k = k as f64;
                first += k * c.abs();
                second += k * (k - 1.0) * c.abs();
            }
            self.first = self.first.max(first / half);
            self.second = self.second.max(second / (half * half));
        }
    }
}

impl Piece {
    /// Whether every tension of the piece is proved to be strictly within `limits`; of more than six cables, whether it can be. Looks at no more than `spans`
    /// spans of time, and takes those from it. The tensions shown are added to `seen`.
    pub fn is_proved(
        &self,
        rig: &Rig,
        limits: &PerCable<TensionLimits>,
        spans: &mut usize,
        seen: &mut Seen,
    ) -> bool {
        let shortest = libm::scalbn(self.duration, -MOST_HALVINGS);
        let (mut time, mut width) = (0.0, self.duration);
        if !self.duration.is_finite() {
            return false;
        }
        while time < self.duration {
            if *spans == 0 || width < shortest {
                return false;
            }
            *spans -= 1;
            let end = if time + width >= self.duration - shortest { self.duration } else { time + width };
            if self.is_within(rig, limits, (time, end), seen) {
                time = end;
            } else {
                width *= 0.5;
            }
        }
        true
    }

    fn is_within(
        &self,
        rig: &Rig,
        limits: &PerCable<TensionLimits>,
        (from, to): (f64, f64),
        seen: &mut Seen,
    ) -> bool {
        let half = 0.5 * (to - from);
        let motion = self.motion(0.5 * (from + to), half);
        let span = Span::Between(from, to);
        if rig.cables.len() == LEAST_CABLES {
            return cables(rig, &motion).is_some_and(|cables| {
                let is_within = judge(&cables.tension, limits, span).is_none();
                if is_within {
                    seen.include(&cables.tension, half);
                }
                is_within
            });
        }
        let found = redundant::look(rig, limits, &motion, (span, 1.0), |_, tensions, _| {
            seen.include(tensions, half);
        });
        matches!(found, Finding::Inside)
    }

    /// Within `half` s of an instant.
    fn motion(&self, middle: f64, half: f64) -> Motion {
        let Self { from, way, s, v, a, .. } = self;
        let (at, speed) = (s + v * middle + 0.5 * a * middle * middle, v + a * middle);
        let rounding = 8.0 * f64::EPSILON * (s.abs() + (v * middle).abs() + (a * middle * middle).abs());
        let mut place = Taylor::ball(at, rounding);
        (place.coefficients[1], place.coefficients[2]) = (speed * half, 0.5 * a * half * half);
        let mut rate = Taylor::ball(speed, 8.0 * f64::EPSILON * (v.abs() + (a * middle).abs()));
        rate.coefficients[1] = a * half;
        Motion {
            coordinates: std::array::from_fn(|k| place * way[k] + Taylor::constant(from.0[k])),
            rates: std::array::from_fn(|k| rate * way[k]),
            accelerations: std::array::from_fn(|k| Taylor::constant(*a) * way[k]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tensions;
    use crate::robot::RigFile;
    use rand::{RngExt, SeedableRng};

    /// Random pieces: what is proved is so in dense samples, and nearly all that is so is proved.
    #[test]
    fn what_is_proved_is_so() {
        let rig = RigFile::default().rig;
        let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
        let (mut proved, mut missed) = (0, 0);
        for _ in 0..400 {
            let mut any = |size: f64| rng.random_range(-size..size);
            let from =
                Pose(Coordinates::new(any(0.1), any(0.1), 1.0 + any(0.2), any(0.1), any(0.1), any(0.4)));
            let way = Coordinates::from_fn(|k, _| any(if k < 3 { 0.3 } else { 0.5 }));
            let piece =
                Piece { from, way, s: 0.2 + any(0.2), v: any(2.0), a: any(20.0), duration: 0.06 + any(0.05) };
            let mut seen = Seen::none(&rig);
            let found = piece.is_proved(&rig, &rig.limits(), &mut 100, &mut seen);
            let margin = (0..=200).map(|k| {
                let t = piece.duration * f64::from(k) / 200.0;
                let (s, v) = (piece.s + piece.v * t + 0.5 * piece.a * t * t, piece.v + piece.a * t);
                let tension =
                    tensions(&rig, &Pose(from.0 + way * s), &(way * v), &(way * piece.a), 0.0).unwrap();
                tension.into_iter().map(|u| u.min(100.0 - u)).fold(f64::INFINITY, f64::min)
            });
            let margin = margin.fold(f64::INFINITY, f64::min);
            assert!(!found || margin > 0.0, "{piece:?} {margin}");
            proved += usize::from(found);
            missed += usize::from(!found && margin > 0.05);
        }
        println!("{proved} proved, {missed} missed");
        assert!(proved > 100 && missed == 0, "{proved} {missed}");
    }
}
