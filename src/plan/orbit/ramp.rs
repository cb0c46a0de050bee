//! How large an orbit is in time.

use crate::reach::certificate::taylor::Taylor;

/// b(t): a polynomial of degree 5 from any b, b', b'' to rest at another, Eq. (O3); before its begin and
/// after its end as there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    begin: f64,
    duration: f64,
    /// Of the powers of (t - begin)/duration.
    coefficients: [f64; 6],
}

impl Ramp {
    /// From b, b', b'' at `begin` (s) to b = `to` at rest, `duration` s later.
    pub fn to_rest([b, db, ddb]: [f64; 3], to: f64, begin: f64, duration: f64) -> Self {
        let (d, v, a) = (to - b, db * duration, ddb * duration * duration);
        let coefficients = [
            b,
            v,
            0.5 * a,
            10.0 * d - 6.0 * v - 1.5 * a,
            -15.0 * d + 8.0 * v + 1.5 * a,
            6.0 * d - 3.0 * v - 0.5 * a,
        ];
        Self { begin, duration, coefficients }
    }

    pub fn begin(&self) -> f64 {
        self.begin
    }

    pub fn end(&self) -> f64 {
        self.begin + self.duration
    }

    /// b, b', b'' at a time, s.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let s = ((time - self.begin) / self.duration).clamp(0.0, 1.0);
        let (one, two) = (self.derivative(1), self.derivative(2));
        let value = |c: &[f64; 6]| c.iter().rev().fold(0.0, |sum, c| sum * s + c);
        [
            value(&self.coefficients),
            value(&one) / self.duration,
            value(&two) / (self.duration * self.duration),
        ]
    }

    /// b, b', b'' within `half` s of `middle`, between begin and end.
    pub fn enclosed(&self, middle: f64, half: f64) -> [Taylor; 3] {
        let rounding = 4.0 * f64::EPSILON * (middle.abs() + self.begin.abs()) / self.duration;
        let mut s = Taylor::ball((middle - self.begin) / self.duration, rounding);
        s.coefficients[1] = half / self.duration;
        let value = |c: &[f64; 6]| c.iter().rev().fold(Taylor::ZERO, |sum, c| sum * s + Taylor::constant(*c));
        let per = 1.0 / self.duration;
        [
            value(&self.coefficients),
            value(&self.derivative(1)) * per,
            value(&self.derivative(2)) * (per * per),
        ]
    }

    /// Coefficients of the first or second derivative with respect to the share of the duration.
    fn derivative(&self, order: usize) -> [f64; 6] {
        std::array::from_fn(|k| {
            let n = k + order;
            let factor = if order == 1 { n } else { n * (n - 1) };
            if n < 6 { self.coefficients[n] * factor as f64 } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_goes_from_any_state_to_rest() {
        let ramp = Ramp::to_rest([0.4, 0.7, -0.3], 0.0, 2.0, 1.5);
        for (time, wanted) in [(2.0, [0.4, 0.7, -0.3]), (3.5, [0.0; 3]), (9.0, [0.0; 3])] {
            for (found, wanted) in ramp.at(time).into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-14, "{time}: {found} {wanted}");
            }
        }
        let h = 1e-5;
        let [before, here, after] = [2.6 - h, 2.6, 2.6 + h].map(|time| ramp.at(time));
        for k in 0..2 {
            assert!(((after[k] - before[k]) / (2.0 * h) - here[k + 1]).abs() < 1e-8);
        }
    }

    /// What Eq. (O4) bounds b' and b'' by is reached.
    #[test]
    fn the_first_ramp_is_no_steeper_than_said() {
        let ramp = Ramp::to_rest([0.0; 3], 1.0, 0.0, 2.0);
        let samples = (0..=20_000).map(|k| ramp.at(1e-4 * f64::from(k)));
        let [first, second] = samples
            .fold([0.0_f64; 2], |most, [_, d, dd]| [most[0].max(d.abs() * 2.0), most[1].max(dd.abs() * 4.0)]);
        assert!(
            (first - 15.0 / 8.0).abs() < 1e-9 && (second - 5.773_502_69).abs() < 1e-6,
            "{first} {second}"
        );
    }
}
