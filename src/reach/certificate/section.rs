//! A piece of a way through the six coordinates, as a polynomial of the way's parameter.

use serde::{Deserialize, Serialize};

use super::taylor::Taylor;
use crate::robot::memory::are_finite;
use crate::robot::{Coordinates, Pose};

/// q(s) = c₀ + c₁ σ + c₂ σ² + c₃ σ³ with σ = s - `begin`, m and rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// s where it begins.
    pub begin: f64,
    /// c₀ to c₃.
    pub coefficients: [Coordinates; 4],
}

impl Section {
    /// From a pose straight on, at s = 0; `way` for each unit of s.
    pub fn straight(from: &Pose, way: &Coordinates) -> Self {
        Self { begin: 0.0, coefficients: [from.0, *way, Coordinates::zeros(), Coordinates::zeros()] }
    }

    /// Whether it is one of numbers.
    pub fn is_sound(&self) -> bool {
        self.begin.is_finite() && self.coefficients.iter().all(are_finite)
    }

    /// q.
    pub fn pose(&self, s: f64) -> Pose {
        let ([a, b, c, d], s) = (self.coefficients, s - self.begin);
        Pose(a + (b + (c + d * s) * s) * s)
    }

    /// dq/ds.
    pub fn slope(&self, s: f64) -> Coordinates {
        let ([_, b, c, d], s) = (self.coefficients, s - self.begin);
        b + (c * 2.0 + d * (3.0 * s)) * s
    }

    /// d²q/ds².
    pub fn bend(&self, s: f64) -> Coordinates {
        let ([_, _, c, d], s) = (self.coefficients, s - self.begin);
        c * 2.0 + d * (6.0 * s)
    }

    /// Slopes in whose convex hull those up to `end` are: of Bézier's polygon.
    pub fn slopes(&self, end: f64) -> [Coordinates; 3] {
        let ([_, b, c, d], length) = (self.coefficients, end - self.begin);
        [b, b + c * length, b + (c * 2.0 + d * (3.0 * length)) * length]
    }

    /// The coordinates, their rates and their accelerations where s, s' and s'' are these.
    pub(super) fn led(&self, s: Taylor, rate: Taylor, acceleration: Taylor) -> [[Taylor; 3]; 6] {
        let from = s - Taylor::constant(self.begin);
        std::array::from_fn(|k| {
            let [a, b, c, d] = self.coefficients.map(|coordinates| coordinates[k]);
            if c == 0.0 && d == 0.0 {
                return [from * b + Taylor::constant(a), rate * b, acceleration * b];
            }
            let constant = Taylor::constant;
            let slope = from * (from * d * 3.0 + constant(2.0 * c)) + constant(b);
            let bend = from * d * 6.0 + constant(2.0 * c);
            [
                from * (from * (from * d + constant(c)) + constant(b)) + constant(a),
                slope * rate,
                slope * acceleration + bend * (rate * rate),
            ]
        })
    }
}
