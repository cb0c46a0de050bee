//! Pose, velocity and what disturbs the platform, from measured poses and what the commands impose.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::Gains;
use crate::robot::dynamics::{accelerations_of, wrench_of};
use crate::robot::memory::are_finite;
use crate::robot::{Coordinates, Pose, Rig};

/// Decay of an estimation error, 1/s: far above the gains of the law, far below the sampling of a rig.
pub const OBSERVER_POLE: f64 = 100.0;

/// How much the accelerations of the law jump, 1/s², for each unit by which a measured coordinate jumps: λη of the pose, (λ + η) of the rate,
/// which jumps by q/e a second (q the pole), and of the disturbance by p q/e (p its pole).
pub fn jump_of_acceleration(gains: &Gains, disturbance_pole: f64) -> f64 {
    let of_rates = OBSERVER_POLE / std::f64::consts::E;
    gains.omega_n_squared() + of_rates * (gains.lambda + gains.eta + disturbance_pole)
}

/// How a constant disturbance is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisturbanceObserver {
    /// Decay of an error of the estimate, 1/s.
    pub pole: f64,
    /// Largest force estimated, N.
    pub force: f64,
    /// Largest torque, N m.
    pub torque: f64,
}

/// Of a vector that was shortened to a length.
const ROUNDING: f64 = 1e-12;

impl DisturbanceObserver {
    /// Whether it can have estimated this (N, N m).
    pub fn can_find(&self, disturbance: &Vector6<f64>) -> bool {
        let [force, torque] = [0, 3].map(|k| disturbance.fixed_rows::<3>(k).norm());
        force <= self.force * (1.0 + ROUNDING) && torque <= self.torque * (1.0 + ROUNDING)
    }

    /// What a disturbance that begins does through the law before it is found, integrated over all time, in units of its size: s. Derived in
    /// docs/controller.md.
    pub fn time(&self, gains: &Gains) -> f64 {
        let (p, q, sum) = (self.pole, OBSERVER_POLE, gains.lambda + gains.eta);
        1.0 / p + 2.0 / q + sum * (2.0 / (p * q) + 1.0 / (q * q)) + gains.omega_n_squared() / (p * q * q)
    }
}

/// An observer of each coordinate with a double pole. It is told the acceleration that the law imposes, so that it has no lag
/// in the motions that the controller itself makes. With a [`DisturbanceObserver`] a third, slower pole estimates what else accelerates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimator {
    /// Estimated pose.
    pub pose: Pose,
    /// Estimated rates of the coordinates, m/s and rad/s.
    pub rates: Coordinates,
    /// Estimated wrench on the platform besides weight and cables (N, N m), base frame.
    pub disturbance: Vector6<f64>,
    /// What measurements have added to the rates since the start at rest, m/s and rad/s.
    pub unexplained: Coordinates,
}

/// A platform that leaves where it is by itself, x'' = κ x, is followed by the observer up to κ = q², q its pole: an error e of the estimated pose
/// obeys e'' + 2 q e' + (q² - κ) e = 0. Up to this κ, 1/s², it is at most twice what it would be without. See docs/controller.md.
pub const FASTEST_DIVERGENCE: f64 = 0.5 * OBSERVER_POLE * OBSERVER_POLE;

/// After this many seconds from a start at rest the rates are known, whatever they were: five time constants.
pub const SETTLING: f64 = 5.0 / OBSERVER_POLE;

impl Estimator {
    /// At rest at `pose`.
    pub fn at_rest(pose: Pose) -> Self {
        let none = Vector6::zeros();
        Self { pose, rates: none, disturbance: none, unexplained: none }
    }

    /// The pose after `dt` s at the estimated rates.
    pub fn expected(&self, dt: f64) -> Pose {
        Pose(self.pose.0 + self.rates * dt)
    }

    /// What the estimated disturbance accelerates the coordinates by, m/s² and rad/s².
    pub fn disturbing(&self, rig: &Rig) -> Coordinates {
        accelerations_of(rig, &self.pose, &self.disturbance)
    }

    /// Moves `dt` seconds on under `acceleration` (m/s², rad/s²), the disturbance's included, and takes in the pose measured then. The
    /// disturbance is estimated if there is an `observer`.
    pub fn update(
        &mut self,
        measured: &Pose,
        acceleration: &Coordinates,
        dt: f64,
        observer: Option<(&Rig, &DisturbanceObserver)>,
    ) {
        if dt <= 0.0 {
            self.pose = *measured;
            return;
        }
        let predicted = Pose(self.pose.0 + self.rates * dt + acceleration * (0.5 * dt * dt));
        let innovation = measured.minus(&predicted);
        // The double pole exp(-100 t) sampled: any step is stable, and a long one makes it a plain difference.
        let keep = libm::exp(-OBSERVER_POLE * dt);
        // The share of an error of the disturbance that goes in this step. The gains place the poles keep, keep and 1 - share.
        let share = observer.map_or(0.0, |(_, observer)| -libm::expm1(-observer.pole * dt));
        let square = (1.0 - keep) * (1.0 - keep);
        // The prediction counts its angles in the measurement's turn.
        self.pose = Pose(measured.0 - innovation * (keep * keep * (1.0 - share)));
        let gain = square + share * (1.0 - keep * keep - 0.5 * square);
        self.rates += acceleration * dt + innovation * (gain / dt);
        self.unexplained += innovation * (gain / dt);
        if let Some((rig, observer)) = observer {
            self.disturbance += wrench_of(rig, &self.pose, &(innovation * (share * square / (dt * dt))));
            self.limit(observer);
        }
    }

    /// Whether a run can have left this.
    pub fn is_sound(&self) -> bool {
        [&self.pose.0, &self.rates, &self.disturbance, &self.unexplained].into_iter().all(are_finite)
    }

    fn limit(&mut self, observer: &DisturbanceObserver) {
        for (k, most) in [(0, observer.force), (3, observer.torque)] {
            let mut part = self.disturbance.fixed_rows_mut::<3>(k);
            let size = part.norm();
            if size > most {
                part *= most / size;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RigFile;

    #[test]
    fn an_unknown_constant_velocity_is_found() {
        let mut estimator = Estimator::at_rest(Pose::default());
        for k in 1..=300 {
            let measured = Pose::at(0.2 * 1e-3 * f64::from(k), 0.0, 1.0);
            estimator.update(&measured, &Coordinates::zeros(), 1e-3, None);
        }
        assert!((estimator.rates[0] - 0.2).abs() < 1e-9, "{}", estimator.rates[0]);
    }

    /// A body that falls freely under a constant force and torque, told that nothing accelerates it.
    fn observed(observer: &DisturbanceObserver, duration: f64) -> Estimator {
        let rig = RigFile::default().rig;
        let wrench = Vector6::new(1.0, -2.0, 0.5, 0.02, 0.03, -0.01);
        let acceleration = accelerations_of(&rig, &Pose::default(), &wrench);
        let mut estimator = Estimator::at_rest(Pose::default());
        for k in 1..=(duration * 1e3) as u32 {
            let time = 1e-3 * f64::from(k);
            let mut measured = Pose::default();
            measured.0 += acceleration * (0.5 * time * time);
            let disturbing = estimator.disturbing(&rig);
            estimator.update(&measured, &disturbing, 1e-3, Some((&rig, observer)));
        }
        estimator.disturbance -= wrench;
        estimator
    }

    #[test]
    fn a_constant_wrench_is_found_at_the_speed_of_the_pole() {
        let observer = DisturbanceObserver { pole: 10.0, force: 5.0, torque: 1.0 };
        // Read as accelerations, for small turns.
        let error = |duration| observed(&observer, duration).disturbance.fixed_rows::<3>(0).norm();
        assert!(error(0.8) < 1e-2 && (error(0.4) / error(0.6) - 2f64.exp()).abs() < 0.5, "{}", error(0.8));
    }

    #[test]
    fn no_more_is_estimated_than_the_bound() {
        let observer = DisturbanceObserver { pole: 10.0, force: 1.0, torque: 0.01 };
        let wrench = Vector6::new(1.0, -2.0, 0.5, 0.02, 0.03, -0.01);
        let found = observed(&observer, 1.0).disturbance + wrench;
        assert!((found.fixed_rows::<3>(0).norm() - 1.0).abs() < 1e-9, "{found}");
        assert!((found.fixed_rows::<3>(3).norm() - 0.01).abs() < 1e-9, "{found}");
    }

    #[test]
    fn yaw_across_the_half_turn_is_not_a_jump() {
        let mut estimator = Estimator::at_rest(Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, 3.1)));
        for k in 1..=1000 {
            let yaw: f64 = 3.1 + 1e-4 * f64::from(k);
            let measured = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, yaw.sin().atan2(yaw.cos())));
            estimator.update(&measured, &Coordinates::zeros(), 1e-3, None);
            assert!(estimator.rates[5].abs() < 0.11);
        }
        assert!((estimator.rates[5] - 0.1).abs() < 1e-9);
    }
}
