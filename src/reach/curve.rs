//! The functions of time that the facets are made of, and their extremes.

use crate::control::{Gains, Response};

/// a + b f(t) + c φ(t) + d exp(-(λ₀ + η₀) t) for t ≥ 0, with f and φ of [`Response`]: what every linear expression in x, x', x'' of
/// a translation is, and also (g - z'') x + z x'' (docs/exact.md).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Value at rest, t → ∞.
    pub a: f64,
    /// Factor of f, which goes from 1 to 0.
    pub b: f64,
    /// Factor of φ, which goes from 0 over a hump to 0.
    pub c: f64,
    /// Factor of the fastest exponential.
    pub d: f64,
}

/// Smallest and largest value, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Infimum over t ≥ 0.
    pub min: f64,
    /// Time of the infimum, s; infinite if it is the value at rest.
    pub argmin: f64,
    /// Supremum over t ≥ 0.
    pub max: f64,
}

impl Curve {
    /// Value at `t`; infinite `t` is rest.
    pub fn at(&self, gains: &Gains, t: f64) -> f64 {
        if t == f64::INFINITY {
            return self.a;
        }
        let [f, phi] = Response::at(gains, t).unit();
        self.a + self.b * f + self.c * phi + self.d * libm::exp(-(gains.lambda + gains.eta) * t)
    }

    /// The extremes: at t = 0, at rest, or where the derivative vanishes, which without the last term is at one time in closed form and
    /// with it at two times at most.
    pub fn extremes(&self, gains: &Gains) -> Extremes {
        let start = self.a + self.b + self.d;
        let mut extremes = Extremes { min: self.a, argmin: f64::INFINITY, max: self.a };
        extremes.include(start, 0.0);
        let stationary = if self.d == 0.0 {
            [self.stationary_without_d(gains), None]
        } else {
            self.stationary_with_d(gains)
        };
        for t in stationary.into_iter().flatten() {
            extremes.include(self.at(gains, t), t);
        }
        extremes
    }

    /// b f' + c φ' = 0, that is φ'/φ = b λ₀ η₀/c = ρ. φ'/φ falls from infinity to -min(λ₀, η₀).
    fn stationary_without_d(&self, gains: &Gains) -> Option<f64> {
        let (slow, fast) = ordered(gains);
        let rho = self.b * slow * fast / self.c;
        let above = rho + slow;
        if !(above > 0.0 && above.is_finite()) {
            return None; // Also for c = 0.
        }
        let x = (fast - slow) / above;
        Some(if x == 0.0 { 1.0 / above } else { libm::log1p(x) / (x * above) })
    }

    /// The derivative times exp(slow t), F = c - (b λ₀ η₀ + c fast) Φ - d S exp(-fast t) with Φ = φ exp(slow t), has a derivative with one
    /// zero in closed form: F is monotone on both sides of it and has at most one zero on each.
    fn stationary_with_d(&self, gains: &Gains) -> [Option<f64>; 2] {
        let (slow, fast) = ordered(gains);
        let pull = self.b * slow * fast + self.c * fast;
        let push = self.d * (slow + fast);
        let spread = fast - slow;
        let f = |t: f64| {
            let big_phi = if spread * t == 0.0 { t } else { -libm::expm1(-spread * t) / spread };
            self.c - pull * big_phi - push * libm::exp(-fast * t)
        };
        // After this time everything but `a` is below the rounding error.
        let end = 80.0 / slow;
        let turn = -libm::log(pull / (push * fast)) / slow;
        if turn > 0.0 && turn < end {
            [root(&f, 0.0, turn), root(&f, turn, end)]
        } else {
            [root(&f, 0.0, end), None]
        }
    }
}

impl Extremes {
    fn include(&mut self, value: f64, t: f64) {
        if value < self.min {
            (self.min, self.argmin) = (value, t);
        }
        self.max = self.max.max(value);
    }
}

fn ordered(gains: &Gains) -> (f64, f64) {
    (gains.lambda.min(gains.eta), gains.lambda.max(gains.eta))
}

/// The zero of a monotone function in [low, high], if its signs differ there: bisection to the last bit that matters.
fn root(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    let rising = f(high) > 0.0;
    if (f(low) > 0.0) == rising {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn extremes_are_those_of_dense_samples() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        for case in 0..20_000 {
            let lambda = rng.random_range(0.5..8.0);
            let eta = if case % 3 == 0 { lambda } else { rng.random_range(0.5..8.0) };
            let gains = Gains { lambda, eta };
            let mut factor = || rng.random_range(-1.0..1.0);
            let mut curve = Curve { a: factor(), b: factor(), c: 5.0 * factor(), d: factor() };
            if case % 2 == 0 {
                curve.d = 0.0;
            }
            let extremes = curve.extremes(&gains);
            let samples = (0..800).map(|k| curve.at(&gains, 1e-2 * f64::from(k) * f64::from(k) / 80.0));
            let (low, high) =
                samples.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            let slack = 2e-3 * (curve.b.abs() + curve.c.abs() + curve.d.abs());
            assert!(
                extremes.min <= low + 1e-12 && extremes.min >= low - slack,
                "{curve:?} {gains:?}: {extremes:?}, {low}"
            );
            assert!(
                extremes.max >= high - 1e-12 && extremes.max <= high + slack,
                "{curve:?} {gains:?}: {extremes:?}, {high}"
            );
            assert!((curve.at(&gains, extremes.argmin) - extremes.min).abs() < 1e-12);
        }
    }
}
