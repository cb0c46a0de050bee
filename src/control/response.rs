//! Eqs. (12) and (13): how a coordinate under the law (4) moves, in closed form, from rest or from any velocity.

use super::{Gains, Reference};
use crate::robot::{Coordinates, Pose};

/// Time constants of the slower gain after which the robot is taken to rest.
const TIME_CONSTANTS: f64 = 20.0;

/// How long a motion under the law takes to come to rest for all purposes, s.
pub fn time_to_rest(gains: &Gains) -> f64 {
    TIME_CONSTANTS / gains.lambda.min(gains.eta)
}

/// `count` instants (two or more) from 0 to `end` (s), denser at the start: where a motion is looked at.
pub fn instants(end: f64, count: usize) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
    let share = move |k: usize| k as f64 / (count - 1) as f64;
    (0..count).map(move |k| end * (share(k) * share(k)))
}

/// Unit responses of e'' + (λ₀ + η₀) e' + λ₀ η₀ e = 0 for an error e = x - x_d, evaluated at one time.
///
/// `f` answers e(0) = 1, e'(0) = 0 and `phi` answers e(0) = 0, e'(0) = 1. One formula serves (12) and (13):
/// φ(t) = (exp(-λ₀ t) - exp(-η₀ t)) / (η₀ - λ₀), continued by t exp(-λ₀ t) where the gains are equal, and
/// f = exp(-λ₀ t) + λ₀ φ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    f: [f64; 3],
    phi: [f64; 3],
}

impl Response {
    /// The response `t` seconds (t ≥ 0) after the start.
    pub fn at(gains: &Gains, t: f64) -> Self {
        let Gains { lambda, eta } = *gains;
        // φ is the same with the gains exchanged; with the slower one in front no exponential can overflow.
        let x = (eta - lambda).abs() * t;
        // (1 - exp(-x))/x without loss of digits near x = 0.
        let quotient = if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x };
        let decay = libm::exp(-lambda * t);
        let phi = t * libm::exp(-lambda.min(eta) * t) * quotient;
        let d_phi = decay - eta * phi;
        let dd_phi = -(lambda + eta) * d_phi - lambda * eta * phi;
        let f = decay + lambda * phi;
        let omega2 = lambda * eta;
        Self { f: [f, -omega2 * phi, -omega2 * d_phi], phi: [phi, d_phi, dd_phi] }
    }

    /// x, x', x'' of a coordinate that started at `x0` with velocity `v0` towards `xd`.
    pub fn motion(&self, x0: f64, v0: f64, xd: f64) -> [f64; 3] {
        let e0 = x0 - xd;
        let [e, de, dde] = std::array::from_fn(|k| e0 * self.f[k] + v0 * self.phi[k]);
        [xd + e, de, dde]
    }

    /// Pose, rates and accelerations of the robot that started at `pose` with `rates` towards `set_point`, all six coordinates;
    /// angles turn the short way round.
    pub fn motion_of(
        &self,
        pose: &Pose,
        rates: &Coordinates,
        set_point: &Pose,
    ) -> (Pose, Coordinates, Coordinates) {
        let [e, de, dde] = self.error_of(&pose.minus(set_point), rates);
        (Pose(set_point.0 + e), de, dde)
    }

    /// The error of the six coordinates and its two derivatives, of one that began with `error` and `rates`: about a reference at rest or in motion.
    pub fn error_of(&self, error: &Coordinates, rates: &Coordinates) -> [Coordinates; 3] {
        std::array::from_fn(|k| error * self.f[k] + rates * self.phi[k])
    }

    /// Pose and rates that were these when the reference was `began`, now that it is `now`.
    pub fn carry(
        &self,
        (pose, rates): (Pose, Coordinates),
        began: &Reference,
        now: &Reference,
    ) -> (Pose, Coordinates) {
        let [error, change, _] = self.error_of(&pose.minus(&began.pose), &(rates - began.rates));
        (Pose(now.pose.0 + error), now.rates + change)
    }

    /// f and φ.
    pub fn unit(&self) -> [f64; 2] {
        [self.f[0], self.phi[0]]
    }

    /// f, f', f'': the normalised step error (x - x_d)/(x₀ - x_d) from rest and its derivatives (1/s, 1/s²).
    pub fn step_error(&self) -> [f64; 3] {
        self.f
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (12), as mended: with the factor t in x'.
    fn critically_damped(w: f64, t: f64, x0: f64, xd: f64) -> [f64; 3] {
        let (d, e) = (x0 - xd, (-w * t).exp());
        [d * e * (1.0 + w * t) + xd, -w * w * d * t * e, d * w * w * e * (w * t - 1.0)]
    }

    /// (13), as mended: with its sign and + x_d.
    fn overdamped(w: f64, xi: f64, t: f64, x0: f64, xd: f64) -> [f64; 3] {
        let r = (xi * xi - 1.0).sqrt();
        let (slow, fast) = ((-(xi - r) * w * t).exp(), (-(xi + r) * w * t).exp());
        let k = (x0 - xd) / (2.0 * r);
        [
            xd + k * ((xi + r) * slow - (xi - r) * fast),
            k * w * (fast - slow),
            k * w * w * ((xi - r) * slow - (xi + r) * fast),
        ]
    }

    #[test]
    fn equals_the_papers_two_formulas() {
        for i in 0..200 {
            let t = 0.02 * f64::from(i);
            let expected = critically_damped(3.0, t, 0.1, 0.4);
            let motion = Response::at(&Gains { lambda: 3.0, eta: 3.0 }, t).motion(0.1, 0.0, 0.4);
            let gains = Gains::from_damping(3.0, 1.4).unwrap();
            let expected_over = overdamped(3.0, 1.4, t, 0.1, 0.4);
            let motion_over = Response::at(&gains, t).motion(0.1, 0.0, 0.4);
            for k in 0..3 {
                assert!((motion[k] - expected[k]).abs() < 1e-14);
                assert!((motion_over[k] - expected_over[k]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_robot_moves_as_its_coordinates_do_and_turns_the_short_way() {
        let start = Pose(Coordinates::new(0.1, 0.2, 1.0, 0.1, -0.2, 3.1));
        let goal = Pose(Coordinates::new(0.0, -0.1, 1.2, 0.0, 0.3, -3.1));
        let rates = Coordinates::new(0.3, -0.1, 0.2, 0.5, 0.1, -0.4);
        let response = Response::at(&Gains { lambda: 2.0, eta: 3.0 }, 0.4);
        let (pose, velocity, acceleration) = response.motion_of(&start, &rates, &goal);
        for k in 0..6 {
            let from = if k == 5 { 3.1 - std::f64::consts::TAU } else { start.0[k] };
            let expected = response.motion(from, rates[k], goal.0[k]);
            for (found, expected) in [pose.0[k], velocity[k], acceleration[k]].iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{found} is not {expected}");
            }
        }
    }

    #[test]
    fn instants_run_from_the_start_to_the_end() {
        let times: Vec<f64> = instants(4.0, 5).collect();
        assert_eq!(times, [0.0, 0.25, 1.0, 2.25, 4.0]);
    }

    #[test]
    fn nearly_equal_gains_join_the_two_formulas() {
        let equal = Response::at(&Gains { lambda: 3.0, eta: 3.0 }, 0.7);
        let near = Response::at(&Gains { lambda: 3.0, eta: 3.0 + 1e-12 }, 0.7);
        for k in 0..3 {
            assert!((equal.f[k] - near.f[k]).abs() < 1e-10 && (equal.phi[k] - near.phi[k]).abs() < 1e-10);
        }
    }

    #[test]
    fn a_lambda_far_above_eta_does_not_overflow() {
        let response = Response::at(&Gains { lambda: 100.0, eta: 1.0 }, 20.0);
        assert!(response.f.iter().chain(&response.phi).all(|value| value.is_finite() && value.abs() < 1e-6));
    }

    #[test]
    fn initial_velocity_is_followed() {
        // e'' + 5 e' + 6 e = 0 from e = 0, e' = 1: exp(-2t) - exp(-3t).
        let t: f64 = 0.4;
        let [x, v, _] = Response::at(&Gains { lambda: 2.0, eta: 3.0 }, t).motion(0.5, 1.0, 0.5);
        assert!((x - 0.5 - ((-2.0 * t).exp() - (-3.0 * t).exp())).abs() < 1e-15);
        assert!((v - (-2.0 * (-2.0 * t).exp() + 3.0 * (-3.0 * t).exp())).abs() < 1e-15);
    }
}
