//! A motion along a section of a way, in closed form, and enclosed over a span of time.

use super::section::Section;
use super::taylor::{LIBRARY, ORDER, Taylor};

/// q = `section`(s) with s'' = `a` + `beta` (s(t) - `s`) + `jerk` t, one of the last two 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Of the way.
    pub section: Section,
    /// At its beginning.
    pub s: f64,
    /// 1/s.
    pub v: f64,
    /// 1/s².
    pub a: f64,
    /// 1/s².
    pub beta: f64,
    /// 1/s³.
    pub jerk: f64,
}

/// s, s' and s'' `t` seconds after they were s₀, v₀ and a₀, where s'' = a₀ + β (s - s₀).
///
/// s = s₀ + v₀ t S(rt) + a₀ t²/2 S(rt/2)², s' = v₀ C(rt) + a₀ t S(rt), with r² = |β|, S(x) = sinh(x)/x and C = cosh where β > 0, sin(x)/x and cos
/// where β < 0, both 1 where β = 0.
pub fn along([s, v, a]: [f64; 3], beta: f64, t: f64) -> [f64; 3] {
    let x = beta.abs().sqrt() * t;
    let (whole, half, c) = if beta >= 0.0 {
        (over(libm::sinh(x), x), over(libm::sinh(0.5 * x), 0.5 * x), libm::cosh(x))
    } else {
        (over(libm::sin(x), x), over(libm::sin(0.5 * x), 0.5 * x), libm::cos(x))
    };
    let way = v * t * whole + 0.5 * a * t * t * half * half;
    [s + way, v * c + a * t * whole, a + beta * way]
}

/// sin(x)/x and its like.
fn over(sine: f64, x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { sine / x }
}

impl Part {
    /// The coordinates, their rates and their accelerations within `half` s of an instant `middle` s after its beginning.
    pub(super) fn led(&self, middle: f64, half: f64) -> [[Taylor; 3]; 6] {
        let Self { section, s, v, a, beta, jerk } = *self;
        let mut here = along([s, v, a], beta, middle);
        let grown = jerk * middle;
        here[0] += grown * middle * middle / 6.0;
        here[1] += 0.5 * grown * middle;
        here[2] += grown;
        // Of the few products and functions in it, none greater than cosh.
        let most = libm::cosh(beta.abs().sqrt() * middle.abs()) * (1.0 + 4.0 * LIBRARY);
        let rounding = if beta == 0.0 { 8.0 * f64::EPSILON } else { 32.0 * (f64::EPSILON + LIBRARY) * most };
        let changed = (a * middle).abs() + (grown * middle).abs();
        let moved = (v * middle).abs() + (changed * middle).abs();
        let errors = [
            rounding * (s.abs() + moved),
            rounding * (v.abs() + changed),
            rounding * (a.abs() + grown.abs() + beta.abs() * moved),
        ];
        // s''' = β s' or the jerk: from there on each derivative is β times the last but one.
        let mut derivatives = [0.0; ORDER + 2];
        (derivatives[0], derivatives[1]) = (here[1], here[2]);
        (2..ORDER + 2).for_each(|n| derivatives[n] = beta * derivatives[n - 2]);
        derivatives[2] += jerk;
        let growth = libm::cosh(beta.abs().sqrt() * half) * (1.0 + 4.0 * LIBRARY);
        let [place, rate, acceleration] = [0, 1, 2].map(|order| {
            let mut taylor = Taylor::ball(here[order], errors[order]);
            let mut power = half;
            for k in 1..ORDER {
                taylor.coefficients[k] = derivatives[order + k - 1] * power;
                power *= half / (k + 1) as f64;
            }
            if beta == 0.0 {
                return taylor;
            }
            // Lagrange's remainder: the next derivative, wherever in the span, with the one before the last times β for its own.
            let next =
                derivatives[order + ORDER - 1].abs() + half * (beta * derivatives[order + ORDER - 2]).abs();
            let size = taylor.size();
            taylor.widened(next * growth * power * (1.0 + rounding) + rounding * size)
        });
        section.led(place, rate, acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Coordinates, Pose};

    #[test]
    fn a_part_is_within_what_encloses_it() {
        let section = Section::straight(&Pose(Coordinates::zeros()), &Coordinates::repeat(1.0));
        let laws = [-300.0, -40.0, -1e-3, 0.0, 1e-3, 40.0, 300.0].map(|beta| (beta, 0.0));
        for (beta, jerk) in laws.into_iter().chain([(0.0, 90.0), (0.0, -1000.0)]) {
            let part = Part { section, s: 0.3, v: 0.7, a: -3.0, beta, jerk };
            for (middle, half) in [(0.02, 0.02), (0.1, 0.05), (0.2, 0.005)] {
                let led = part.led(middle, half)[0];
                for k in -50..=50 {
                    let tau = f64::from(k) / 50.0;
                    let t = middle + half * tau;
                    let mut exact = along([0.3, 0.7, -3.0], beta, t);
                    let of_jerk = [jerk * t * t * t / 6.0, jerk * t * t / 2.0, jerk * t];
                    (0..3).for_each(|order| exact[order] += of_jerk[order]);
                    for (taylor, exact) in led.iter().zip(exact) {
                        let polynomial = taylor.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c);
                        assert!((polynomial - exact).abs() <= taylor.error + 1e-14 * exact.abs());
                    }
                }
                let x = f64::abs(beta).sqrt() * half;
                assert!(led[0].error < 1e-11 + x.powi(4), "{} {x}", led[0].error);
            }
        }
    }
}
