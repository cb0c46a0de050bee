//! A number that depends on time within a span: a polynomial and a proved error.

use std::ops::{Add, Mul, Neg, Sub};

/// Coefficients kept.
pub const ORDER: usize = 6;

/// Relative error of a sum of at most ORDER + 2 rounded products: 8 units of rounding of 2⁻⁵³.
const ROUNDING: f64 = 8.0 * f64::EPSILON / 2.0;
/// What makes an error, itself a sum of a few dozen rounded positive terms, an upper bound.
const UPWARDS: f64 = 1.0 + 512.0 * f64::EPSILON;
/// More than all products that underflow in one operation.
const UNDERFLOW: f64 = 1e-290;
/// Relative error granted to exp, expm1, sin, cos, sinh and cosh of the crate libm: 4 units in the last place (of 1 for sine and cosine). `checker/check_arithmetic.py`
/// tries that, and the rounding of every operation, against Arb.
pub const LIBRARY: f64 = 4.0 * f64::EPSILON;

/// All functions of τ in [-1, 1] within `error` of the polynomial Σ cₖ τᵏ.
///
/// Every operation encloses: if the operands contain two functions, the result contains what the operation makes of them. The error
/// takes up the powers of τ that are dropped and all rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Taylor {
    /// c₀ to c₅.
    pub coefficients: [f64; ORDER],
    /// Greatest distance from the polynomial.
    pub error: f64,
}

impl Taylor {
    /// Nothing but 0.
    pub const ZERO: Self = Self { coefficients: [0.0; ORDER], error: 0.0 };

    /// All functions within `error` (0 or more) of `value`.
    pub fn ball(value: f64, error: f64) -> Self {
        let mut ball = Self { error, ..Self::ZERO };
        ball.coefficients[0] = value;
        ball
    }

    /// The constant `value`.
    pub fn constant(value: f64) -> Self {
        Self::ball(value, 0.0)
    }

    /// All functions between 0 and `top`.
    pub fn from_zero_to(top: f64) -> Self {
        Self::ball(0.5 * top, 0.5 * top * UPWARDS)
    }

    /// These functions and all within `radius` of them.
    pub fn widened(mut self, radius: f64) -> Self {
        self.error = (self.error + radius) * UPWARDS;
        self
    }

    /// A bound of the absolute value.
    pub fn size(&self) -> f64 {
        (self.polynomial_size() + self.error) * UPWARDS
    }

    fn polynomial_size(&self) -> f64 {
        self.coefficients.iter().map(|c| c.abs()).sum()
    }

    /// Lower and upper bound: exact for the terms up to τ², which are all that is left of a polynomial in a short span.
    pub fn range(&self) -> [f64; 2] {
        let [low, high] = self.extremes().map(|tau| self.parabola(tau));
        let rest: f64 = self.coefficients[3..].iter().map(|c| c.abs()).sum();
        let rest = (rest + self.error + ROUNDING * self.polynomial_size()) * UPWARDS;
        [low - rest, high + rest]
    }

    /// Where the terms up to τ² are least and greatest.
    pub fn extremes(&self) -> [f64; 2] {
        let vertex = -0.5 * self.coefficients[1] / self.coefficients[2];
        let vertex = if vertex.abs() < 1.0 { vertex } else { 1.0 };
        let by_value = |a: &f64, b: &f64| self.parabola(*a).total_cmp(&self.parabola(*b));
        let candidates = [-1.0, 1.0, vertex];
        let least = candidates.into_iter().min_by(by_value).unwrap_or(0.0);
        let greatest = candidates.into_iter().max_by(by_value).unwrap_or(0.0);
        [least, greatest]
    }

    fn parabola(&self, tau: f64) -> f64 {
        self.coefficients[0] + tau * (self.coefficients[1] + tau * self.coefficients[2])
    }

    /// exp(-rate t) for t = middle + half τ; rate ≥ 0.
    pub fn decay(rate: f64, middle: f64, half: f64) -> Self {
        let (value, relative) = exp_minus(rate * middle);
        let mut decay = Self::ZERO;
        let mut series = 1.0; // (-rate half)ᵏ/k!
        for k in 0..ORDER {
            decay.coefficients[k] = value * series;
            series *= -rate * half / (k + 1) as f64;
        }
        // Lagrange's remainder: the next term of the series, times the largest value in the span.
        let (most, relative_most) = exp_minus(rate * (middle - half));
        let remainder = series.abs() * most * (1.0 + relative_most);
        decay.widened(decay.polynomial_size() * (relative + 4.0 * ROUNDING) + remainder * UPWARDS)
    }

    /// (1 - exp(-rate t))/rate for t = middle + half τ: the integral of [`Self::decay`] from 0; t where the rate is 0.
    pub fn integrated_decay(rate: f64, middle: f64, half: f64) -> Self {
        let whole = if rate == 0.0 { middle } else { -libm::expm1(-rate * middle) / rate };
        let integrand = Self::decay(rate, middle, half);
        let mut integral = Self::ball(whole, 0.0);
        for k in 1..ORDER {
            integral.coefficients[k] = integrand.coefficients[k - 1] * half / k as f64;
        }
        // The integrand's error and its last term, over half the span; the conditioning of expm1 and of the division is 1.
        let last = integrand.coefficients[ORDER - 1].abs() / ORDER as f64;
        let rounding = 2.0 * (LIBRARY + ROUNDING) * integral.polynomial_size();
        integral.widened((integrand.error + last) * half * UPWARDS + rounding)
    }

    /// (sin, cos).
    pub fn sin_cos(&self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.coefficients[0]);
        let [sin, cos] = [sin, cos].map(|value| Self::ball(value, LIBRARY));
        let mut step = *self;
        step.coefficients[0] = 0.0;
        let (mut sin_step, mut cos_step) = (Self::ZERO, Self::ZERO);
        let (mut power, mut factorial) = (Self::constant(1.0), 1.0);
        for k in 0..ORDER {
            let term = power * (1.0 / factorial);
            match k % 4 {
                0 => cos_step = cos_step + term,
                1 => sin_step = sin_step + term,
                2 => cos_step = cos_step - term,
                _ => sin_step = sin_step - term,
            }
            power = power * step;
            factorial *= (k + 1) as f64;
        }
        let remainder = power.size() / factorial * UPWARDS;
        let (sin_step, cos_step) = (sin_step.widened(remainder), cos_step.widened(remainder));
        (sin * cos_step + cos * sin_step, cos * cos_step - sin * sin_step)
    }

    /// One over functions that are greater than 0; without bound where they may not be.
    ///
    /// With a polynomial r near it, |1/s - r| = |1 - s r|/s.
    pub fn inverse(&self) -> Self {
        let least = self.range()[0];
        if least <= 0.0 {
            return Self::ball(0.0, f64::INFINITY);
        }
        let s = &self.coefficients;
        let mut inverse = Self::constant(1.0 / s[0]);
        for k in 1..ORDER {
            let r = &inverse.coefficients;
            let sum: f64 = (1..=k).map(|j| s[j] * r[k - j]).sum();
            inverse.coefficients[k] = -sum / s[0];
        }
        let distance = (Self::constant(1.0) - *self * inverse).size() / least;
        inverse.widened(distance * UPWARDS)
    }

    /// The square root of functions that are 0 or more; `None` where the polynomial near it is not positive.
    ///
    /// With a polynomial r near it, |√s - r| = |s - r²|/(√s + r) is at most |s - r²|/r.
    pub fn sqrt(&self) -> Option<Self> {
        let s = &self.coefficients;
        let mut root = Self::constant(s[0].sqrt());
        for k in 1..ORDER {
            let r = &root.coefficients;
            let cross: f64 = (1..k).map(|j| r[j] * r[k - j]).sum();
            root.coefficients[k] = (s[k] - cross) / (2.0 * r[0]);
        }
        let least = root.range()[0];
        let distance = (*self - root * root).size() / least;
        (least > 0.0).then(|| root.widened(distance * UPWARDS))
    }
}

/// exp(-x) and a bound of its relative error, which an argument rounded in the last place shares.
fn exp_minus(x: f64) -> (f64, f64) {
    (libm::exp(-x), LIBRARY + x.abs() * f64::EPSILON)
}

impl Add for Taylor {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        let mut rounded = 0.0;
        for k in 0..ORDER {
            self.coefficients[k] += other.coefficients[k];
            rounded += self.coefficients[k].abs();
        }
        self.error = (self.error + other.error + ROUNDING * rounded) * UPWARDS;
        self
    }
}

impl Neg for Taylor {
    type Output = Self;

    fn neg(mut self) -> Self {
        self.coefficients = self.coefficients.map(|c| -c);
        self
    }
}

impl Sub for Taylor {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul<f64> for Taylor {
    type Output = Self;

    fn mul(mut self, factor: f64) -> Self {
        let mut rounded = 0.0;
        for k in 0..ORDER {
            self.coefficients[k] *= factor;
            rounded += self.coefficients[k].abs();
        }
        self.error = (self.error * factor.abs() + ROUNDING * rounded + UNDERFLOW) * UPWARDS;
        self
    }
}

impl Mul for Taylor {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self.coefficients, &other.coefficients);
        let mut product = Self::ZERO;
        let mut dropped = 0.0;
        for i in 0..ORDER {
            for j in 0..ORDER - i {
                product.coefficients[i + j] += a[i] * b[j];
            }
            for j in ORDER - i..ORDER {
                dropped += (a[i] * b[j]).abs();
            }
        }
        let (size_a, size_b) = (self.polynomial_size(), other.polynomial_size());
        let spread = size_a * other.error + size_b * self.error + self.error * other.error;
        product.error = (spread + dropped + ROUNDING * size_a * size_b + UNDERFLOW) * UPWARDS;
        product
    }
}

/// The sum of `terms`, each times its factor.
pub fn combination<const N: usize>(factors: [f64; N], terms: [&Taylor; N]) -> Taylor {
    let mut sum = Taylor::ZERO;
    let mut rounded = 0.0;
    for (factor, term) in factors.into_iter().zip(terms) {
        for k in 0..ORDER {
            let product = factor * term.coefficients[k];
            sum.coefficients[k] += product;
            rounded += product.abs();
        }
        sum.error += factor.abs() * term.error;
    }
    sum.error = (sum.error + ROUNDING * rounded + UNDERFLOW) * UPWARDS;
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Checks that `number` encloses `function` closely: within 1e-15 of what its polynomial and error say, at 21 places.
    fn encloses(number: &Taylor, function: impl Fn(f64) -> f64) {
        let [low, high] = number.range();
        for k in -10..=10 {
            let tau = 0.1 * f64::from(k);
            let value = function(tau);
            let polynomial = number.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c);
            let rounding = 1e-15 * number.size();
            assert!(
                (polynomial - value).abs() <= number.error + rounding,
                "{number:?} at {tau} is not {value}"
            );
            assert!(low - rounding <= value && value <= high + rounding);
        }
    }

    fn random(rng: &mut Pcg64) -> Taylor {
        let mut number = Taylor::ZERO;
        number.coefficients = std::array::from_fn(|_| rng.random_range(-0.3..0.3));
        number.coefficients[0] += 2.0;
        number
    }

    fn value(number: &Taylor, tau: f64) -> f64 {
        number.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c)
    }

    #[test]
    fn operations_enclose_the_functions() {
        let mut rng = Pcg64::seed_from_u64(1);
        for _ in 0..500 {
            let (a, b) = (random(&mut rng), random(&mut rng));
            encloses(&(a * b), |tau| value(&a, tau) * value(&b, tau));
            encloses(&(a - b * 3.0), |tau| value(&a, tau) - 3.0 * value(&b, tau));
            encloses(&combination([0.7, -1.3], [&a, &b]), |tau| 0.7 * value(&a, tau) - 1.3 * value(&b, tau));
            let (sin, cos) = a.sin_cos();
            encloses(&sin, |tau| value(&a, tau).sin());
            encloses(&cos, |tau| value(&a, tau).cos());
            if a.range()[0] > 0.0 {
                encloses(&a.inverse(), |tau| 1.0 / value(&a, tau));
                encloses(&a.sqrt().unwrap(), |tau| value(&a, tau).sqrt());
            }
        }
    }

    #[test]
    fn errors_of_the_operands_are_kept() {
        let mut rng = Pcg64::seed_from_u64(2);
        for _ in 0..500 {
            let (a, b) = (random(&mut rng), random(&mut rng));
            let (da, db) = (rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1));
            let (wide_a, wide_b) = (a.widened(f64::abs(da)), b.widened(f64::abs(db)));
            let (a, b) = (|tau| value(&a, tau) + da, |tau| value(&b, tau) + db);
            encloses(&(wide_a * wide_b), |tau| a(tau) * b(tau));
            encloses(&(wide_a + wide_b), |tau| a(tau) + b(tau));
            encloses(&wide_a.sin_cos().0, |tau| a(tau).sin());
            encloses(&(wide_a * wide_a + Taylor::constant(1.0)).sqrt().unwrap(), |tau| {
                (a(tau) * a(tau) + 1.0).sqrt()
            });
        }
    }

    #[test]
    fn exponentials_enclose_with_an_error_of_sixth_order() {
        for (rate, middle, half) in
            [(3.0, 1.0, 0.2), (8.0, 0.1, 0.1), (0.0, 0.5, 0.5), (1e-9, 2.0, 1.0), (40.0, 3.0, 1.0)]
        {
            let t = |tau: f64| middle + half * tau;
            let integral = |t: f64| if rate == 0.0 { t } else { -f64::exp_m1(-rate * t) / rate };
            encloses(&Taylor::decay(rate, middle, half), |tau| (-rate * t(tau)).exp());
            encloses(&Taylor::integrated_decay(rate, middle, half), |tau| integral(t(tau)));
        }
        let error = |half| Taylor::decay(3.0, 1.0, half).error;
        assert!(error(0.2) < 1e-5 && error(0.1) < error(0.2) / 60.0);
    }

    #[test]
    fn a_parabola_is_bounded_exactly() {
        let mut parabola = Taylor::constant(1.0);
        parabola.coefficients[1] = -0.5;
        parabola.coefficients[2] = 0.5;
        let [low, high] = parabola.range();
        assert!(
            (low - 0.875).abs() < 1e-14 && (high - 2.0).abs() < 1e-14 && parabola.extremes() == [0.5, -1.0]
        );
    }

    #[test]
    fn zero_has_no_enclosed_root_and_no_inverse() {
        assert_eq!(Taylor::constant(0.0).sqrt(), None);
        assert_eq!(Taylor::ball(0.1, 0.2).inverse().size(), f64::INFINITY);
    }
}
