//! Pose and velocity from measured poses alone.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use crate::robot::{Coordinates, Pose};

/// Decay of an estimation error, 1/s: far above the gains of the law, far below the sampling of a rig.
const OBSERVER_POLE: f64 = 100.0;

/// An observer of each coordinate with a double pole. It is told the acceleration that the law imposes, so that it has no lag
/// in the motions that the controller itself makes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimator {
    /// Estimated pose.
    pub pose: Pose,
    /// Estimated rates of the coordinates, m/s and rad/s.
    pub rates: Coordinates,
}

impl Estimator {
    /// At rest at `pose`.
    pub fn at_rest(pose: Pose) -> Self {
        Self { pose, rates: Vector6::zeros() }
    }

    /// The pose after `dt` s at the estimated rates.
    pub fn expected(&self, dt: f64) -> Pose {
        Pose(self.pose.0 + self.rates * dt)
    }

    /// Moves `dt` seconds on under `acceleration` (m/s², rad/s²) and takes in the pose measured then.
    pub fn update(&mut self, measured: &Pose, acceleration: &Coordinates, dt: f64) {
        if dt <= 0.0 {
            self.pose = *measured;
            return;
        }
        let predicted = Pose(self.pose.0 + self.rates * dt + acceleration * (0.5 * dt * dt));
        let innovation = measured.minus(&predicted);
        // The double pole exp(-100 t) sampled: any step is stable, and a long one makes it a plain difference.
        let keep = (-OBSERVER_POLE * dt).exp();
        // The prediction counts its angles in the measurement's turn.
        self.pose = Pose(measured.0 - innovation * (keep * keep));
        self.rates += acceleration * dt + innovation * ((1.0 - keep).powi(2) / dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_constant_velocity_is_found() {
        let mut estimator = Estimator::at_rest(Pose::default());
        for k in 1..=300 {
            let measured = Pose::at(0.2 * 1e-3 * f64::from(k), 0.0, 1.0);
            estimator.update(&measured, &Coordinates::zeros(), 1e-3);
        }
        assert!((estimator.rates[0] - 0.2).abs() < 1e-9, "{}", estimator.rates[0]);
    }

    #[test]
    fn yaw_across_the_half_turn_is_not_a_jump() {
        let mut estimator = Estimator::at_rest(Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, 3.1)));
        for k in 1..=1000 {
            let yaw: f64 = 3.1 + 1e-4 * f64::from(k);
            let measured = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, yaw.sin().atan2(yaw.cos())));
            estimator.update(&measured, &Coordinates::zeros(), 1e-3);
            assert!(estimator.rates[5].abs() < 0.11);
        }
        assert!((estimator.rates[5] - 0.1).abs() < 1e-9);
    }
}
