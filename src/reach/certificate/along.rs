//! The proof along a way through the six coordinates, or a sum of ways, piece by piece.

use arrayvec::ArrayVec;

use super::Range;
use super::motion::{Motion, Span};
use super::part::Part;
use super::search::Finding;
use super::shown::{Shown, look};
use super::taylor::Taylor;
use crate::robot::{Coordinates, PerCable, Pose, Rig, TensionLimits};

/// Motions that are summed.
pub const MOST_PARTS: usize = 4;
/// Halvings of a piece before it counts as not proved.
const MOST_HALVINGS: i32 = 10;

/// A part, or the sum of some, for `duration` seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    parts: ArrayVec<Part, MOST_PARTS>,
    /// Added to their sum, m and rad.
    offset: Coordinates,
    /// s.
    pub(super) duration: f64,
}

/// What was seen of the tensions on proved pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    range: Range,
    /// Bound of their first derivatives, N/s,
    pub first: f64,
    /// and of their second, N/s²: both of the polynomials that enclose them.
    pub second: f64,
    /// What the tensions may be off these polynomials, N: of all spans together.
    pub off: f64,
}

impl Seen {
    /// Nothing yet.
    pub fn none(rig: &Rig) -> Self {
        Self { range: Range::none(rig), first: 0.0, second: 0.0, off: 0.0 }
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
        self.off += tensions.iter().map(|tension| tension.error).fold(0.0, f64::max);
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
    /// The parts.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// What is added to their sum, m and rad.
    pub fn offset(&self) -> &Coordinates {
        &self.offset
    }

    /// How long it takes, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// One part alone.
    pub fn new(part: Part, duration: f64) -> Self {
        Self { parts: [part].into_iter().collect(), offset: Coordinates::zeros(), duration }
    }

    /// With another part, counted from `rest`. `None` with more than [`MOST_PARTS`].
    pub fn and(mut self, part: Part, rest: &Pose) -> Option<Self> {
        self.parts.try_push(part).ok()?;
        self.offset -= rest.0;
        Some(self)
    }

    /// Whether every tension of the piece is proved to be strictly within `limits`; of more than six cables, whether it can be. Looks at no more than `spans`
    /// spans of time, and takes those from it. The tensions shown are added to `seen`.
    pub fn is_proved(
        &self,
        rig: &Rig,
        limits: &PerCable<TensionLimits>,
        spans: &mut usize,
        seen: &mut Seen,
    ) -> bool {
        self.is_covered(rig, limits, spans, |(from, to), shown| {
            seen.include(shown.tension, 0.5 * (to - from))
        })
    }

    /// The same. `inside` is shown what proves each span, from a time to another, s.
    pub(super) fn is_covered(
        &self,
        rig: &Rig,
        limits: &PerCable<TensionLimits>,
        spans: &mut usize,
        mut inside: impl FnMut((f64, f64), &Shown),
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
            let motion = self.motion(0.5 * (time + end), 0.5 * (end - time));
            let span = Span::Between(time, end);
            if matches!(look(rig, limits, &motion, span, |shown| inside((time, end), shown)), Finding::Inside)
            {
                time = end;
            } else {
                width *= 0.5;
            }
        }
        true
    }

    /// Within `half` s of an instant.
    pub(super) fn motion(&self, middle: f64, half: f64) -> Motion {
        let nothing = [Taylor::ZERO; 6];
        let coordinates = std::array::from_fn(|k| Taylor::constant(self.offset[k]));
        let mut sum = Motion { coordinates, rates: nothing, accelerations: nothing };
        for part in &self.parts {
            let led = part.led(middle, half);
            for (k, [coordinate, rate, acceleration]) in led.into_iter().enumerate() {
                sum.coordinates[k] = sum.coordinates[k] + coordinate;
                sum.rates[k] = sum.rates[k] + rate;
                sum.accelerations[k] = sum.accelerations[k] + acceleration;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::section::Section;
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
        for run in 0..400 {
            let mut any = |size: f64| rng.random_range(-size..size);
            let from =
                Pose(Coordinates::new(any(0.1), any(0.1), 1.0 + any(0.2), any(0.1), any(0.1), any(0.4)));
            let mut way = || Coordinates::from_fn(|k, _| any(if k < 3 { 0.3 } else { 0.5 }));
            let mut section = Section::straight(&from, &way());
            if run % 2 == 1 {
                section = Section { begin: 0.1, coefficients: [from.0, way(), way(), way()] };
            }
            let beta = if run % 3 == 0 { any(60.0) } else { 0.0 };
            let mut part = || Part { section, s: 0.2 + any(0.2), v: any(2.0), a: any(20.0), beta, jerk: 0.0 };
            let (first, second, duration) = (part(), part(), 0.06 + any(0.05));
            let mut piece = Piece::new(first, duration);
            if run % 4 >= 2 {
                piece = piece.and(second, &section.pose(second.s)).unwrap();
            }
            let mut seen = Seen::none(&rig);
            let found = piece.is_proved(&rig, &rig.limits(), &mut 100, &mut seen);
            let margin = (0..=200).map(|k| {
                let t = piece.duration * f64::from(k) / 200.0;
                let mut sum = [piece.offset, Coordinates::zeros(), Coordinates::zeros()];
                for Part { section, s, v, a, beta, .. } in &piece.parts {
                    let [s, v, a] = super::super::part::along([*s, *v, *a], *beta, t);
                    let (slope, bend) = (section.slope(s), section.bend(s));
                    let led = [section.pose(s).0, slope * v, slope * a + bend * (v * v)];
                    sum = std::array::from_fn(|order| sum[order] + led[order]);
                }
                let tension = tensions(&rig, &Pose(sum[0]), &sum[1], &sum[2], 0.0).unwrap();
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
