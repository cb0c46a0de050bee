//! Eqs. (12) and (13) over a span of time: coordinates, rates and accelerations of the closed loop, enclosed.

use super::margins::Tube;
use super::taylor::Taylor;
use crate::control::Gains;
use crate::robot::{Coordinates, Pose};

/// A new set point given to the law (4) at some state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Pose when the set point is given.
    pub start: Pose,
    /// Rates of the coordinates then, m/s and rad/s.
    pub rates: Coordinates,
    /// The set point.
    pub set_point: Pose,
    /// Gains of the law.
    pub gains: Gains,
}

/// Seconds since the set point was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// From the first time to the second; both may be the same.
    Between(f64, f64),
    /// From a time on for ever; 1/min(λ, η) or later.
    From(f64),
}

/// Coordinates and their derivatives, each over the same span.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// m, rad.
    pub coordinates: [Taylor; 6],
    /// m/s, rad/s.
    pub rates: [Taylor; 6],
    /// m/s², rad/s².
    pub accelerations: [Taylor; 6],
}

impl Span {
    /// The time at τ in [-1, 1]; the beginning of a span without end.
    pub fn time(&self, tau: f64) -> f64 {
        match *self {
            Self::Between(from, to) => (0.5 * (from + to) + 0.5 * (to - from) * tau).max(from).min(to),
            Self::From(from) => from,
        }
    }
}

/// f, f', f'' and φ, φ', φ'' of [`crate::control::Response`] over the span.
///
/// With μ the smaller gain and M the larger, φ = e^(-μt) (1 - e^(-(M-μ)t))/(M - μ), the rest follows from
/// φ' = e^(-μt) - Mφ, f = e^(-μt) + μφ and the differential equation. No case is made of equal gains.
fn responses(gains: &Gains, span: Span) -> [[Taylor; 3]; 2] {
    let (slow_rate, fast_rate) = (gains.lambda.min(gains.eta), gains.lambda.max(gains.eta));
    let difference = fast_rate - slow_rate;
    let (slow, phi) = match span {
        Span::Between(from, to) => {
            let middle = 0.5 * (from + to);
            let half = (to - middle).max(middle - from) * (1.0 + 4.0 * f64::EPSILON);
            let slow = Taylor::decay(slow_rate, middle, half);
            (slow, slow * Taylor::integrated_decay(difference, middle, half))
        }
        Span::From(from) => {
            // Past 1/μ both fall, and (1 - e^(-Δt))/Δ is at most t and at most 1/Δ.
            let top = Taylor::decay(slow_rate, from, 0.0).size();
            let phi = top * from.min(1.0 / difference) * (1.0 + 8.0 * f64::EPSILON);
            (Taylor::from_zero_to(top), Taylor::from_zero_to(phi))
        }
    };
    let product = slow_rate * fast_rate;
    let d_phi = slow - phi * fast_rate;
    let f = [slow + phi * slow_rate, phi * -product, d_phi * -product];
    [f, [phi, d_phi, -(d_phi * (slow_rate + fast_rate)) - phi * product]]
}

impl Step {
    /// The smaller gain, 1/s: how fast the motion dies away in the end.
    pub fn slow_rate(&self) -> f64 {
        self.gains.lambda.min(self.gains.eta)
    }

    /// The larger gain, 1/s.
    pub fn fast_rate(&self) -> f64 {
        self.gains.lambda.max(self.gains.eta)
    }

    /// All motions that stay within `tube` of the closed form.
    pub fn motion(&self, span: Span, tube: &Tube) -> Motion {
        let [f, phi] = responses(&self.gains, span);
        let error = self.start.minus(&self.set_point);
        // What start - set point loses in rounding, and in the sine and arc tangent that bring an angle into [-π, π].
        let rounding = |k: usize| 4.0 * f64::EPSILON * (self.start.0[k].abs() + self.set_point.0[k].abs());
        let moved = |k: usize, derivative: usize| {
            f[derivative] * Taylor::ball(error[k], rounding(k)) + phi[derivative] * self.rates[k]
        };
        Motion {
            coordinates: std::array::from_fn(|k| {
                (moved(k, 0) + Taylor::constant(self.set_point.0[k])).widened(tube.coordinates[k])
            }),
            rates: std::array::from_fn(|k| moved(k, 1).widened(tube.rates[k])),
            accelerations: std::array::from_fn(|k| moved(k, 2).widened(tube.accelerations[k])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Response;
    use rand::{RngExt, SeedableRng};

    fn contains(number: &Taylor, tau: f64, value: f64) -> bool {
        let polynomial = number.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c);
        (polynomial - value).abs() <= number.error + 1e-14 * number.size()
    }

    #[test]
    fn encloses_the_response_in_spans_and_for_ever() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(12);
        for case in 0..2000 {
            let lambda = rng.random_range(0.5..10.0);
            let eta = if case % 4 == 0 { lambda } else { rng.random_range(0.5..10.0) };
            let mut coordinates = || Coordinates::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let (start, rates, set_point) = (Pose(coordinates()), coordinates(), Pose(coordinates()));
            let step = Step { start, rates, set_point, gains: Gains { lambda, eta } };
            let from = rng.random_range(0.0..3.0);
            let last = (1.0 / step.slow_rate()).max(from);
            for (span, end) in [(Span::Between(from, from + 0.3), from + 0.3), (Span::From(last), last + 3.0)]
            {
                let motion = step.motion(span, &Tube::empty());
                for tau in [-1.0, -0.3, 0.4, 1.0] {
                    let begin = span.time(-1.0);
                    let t = begin + 0.5 * (tau + 1.0) * (end - begin);
                    let response = Response::at(&step.gains, t);
                    for k in 0..6 {
                        let [x, v, a] = response.motion(start.0[k], rates[k], set_point.0[k]);
                        let enclosed = [&motion.coordinates, &motion.rates, &motion.accelerations];
                        for (number, value) in enclosed.into_iter().zip([x, v, a]) {
                            assert!(contains(&number[k], tau, value), "{step:?}, {span:?}: {value} at {t}");
                        }
                    }
                }
            }
        }
    }
}
