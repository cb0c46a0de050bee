//! Eqs. (7) to (11) and (14): the gains λ₀ and η₀, the second order system they make, and its extremes.

use serde::{Deserialize, Serialize};

/// The gains λ = λ₀ diag(1, …, 1) of (2) and η = η₀ diag(1, …, 1) of (4), six ones each; both 1/s and positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// λ₀, 1/s.
    pub lambda: f64,
    /// η₀, 1/s.
    pub eta: f64,
}

impl Gains {
    /// Eqs. (8) to (11) solved for the gains: natural frequency ω_n > 0 in 1/s, damping ratio ξ ≥ 1, λ₀ ≤ η₀ (the upper sign
    /// of Eq. (10); the lower one swaps the two). `None` for any other ω_n or ξ, Eq. (11).
    pub fn from_damping(omega_n: f64, xi: f64) -> Option<Self> {
        if !(omega_n > 0.0 && omega_n.is_finite() && xi >= 1.0 && xi.is_finite()) {
            return None;
        }
        let q = 2.0 * xi * xi - 1.0;
        let ratio = q + (q * q - 1.0).sqrt(); // (10): η₀ = ratio λ₀
        let lambda = omega_n / ratio.sqrt(); // (9)
        Some(Self { lambda, eta: ratio * lambda })
    }

    /// Damping ratio ξ, Eq. (8).
    pub fn xi(&self) -> f64 {
        (self.eta + self.lambda) / (2.0 * self.omega_n())
    }

    /// Natural frequency ω_n, Eq. (9), 1/s.
    pub fn omega_n(&self) -> f64 {
        self.omega_n_squared().sqrt()
    }

    /// ω_n² = η₀ λ₀.
    pub fn omega_n_squared(&self) -> f64 {
        self.eta * self.lambda
    }

    /// Greatest value of φ of [`Response`](super::Response), s: e^(-μt)/M at t = ln(M/μ)/(M - μ), μ the smaller gain, M the larger.
    pub fn largest_phi(&self) -> f64 {
        let (slow, fast) = (self.lambda.min(self.eta), self.lambda.max(self.eta));
        let peak = if slow == fast { 1.0 / slow } else { libm::log1p((fast - slow) / slow) / (fast - slow) };
        libm::exp(-slow * peak) / fast
    }

    /// Z_M of Eq. (14): the largest value of x_s = x''/(ω_n² (x₀ - x_d)), which starts at -1.
    ///
    /// With θ = acosh ξ = |ln(η₀/λ₀)|/2 the maximum at ω_n t = 2θ/sinh θ is exp(-2 θ coth θ).
    pub fn z_m(&self) -> f64 {
        let theta = 0.5 * libm::log(self.eta / self.lambda).abs();
        let theta_coth = if theta < 1e-4 { 1.0 + theta * theta / 3.0 } else { theta / libm::tanh(theta) };
        libm::exp(-2.0 * theta_coth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_m_is_that_of_the_notes() {
        for (xi, z_m) in [(1.0, 0.13534), (1.2, 0.10521), (1.5, 0.07559), (2.0, 0.04777)] {
            let gains = Gains::from_damping(3.0, xi).unwrap();
            assert!((gains.z_m() - z_m).abs() < 5e-6, "Z_M({xi}) = {}", gains.z_m());
        }
    }

    #[test]
    fn gains_and_damping_are_inverse() {
        let gains = Gains::from_damping(4.0, 1.3).unwrap();
        assert!((gains.omega_n() - 4.0).abs() < 1e-12 && (gains.xi() - 1.3).abs() < 1e-12);
        assert_eq!(Gains::from_damping(4.0, 0.99), None);
    }
}
