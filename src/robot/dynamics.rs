//! Eq. (1), Newton and Euler: which wrench gives which accelerations.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{Coordinates, Pose, Rig};

/// Inertia about the centre of mass in the base frame, kg m².
pub fn inertia(rig: &Rig, pose: &Pose) -> Matrix3<f64> {
    let rotation = pose.rotation();
    rotation.matrix() * rig.inertia * rotation.matrix().transpose()
}

/// The platform at a pose: what Eq. (1) asks of it at any rates and accelerations.
pub struct Placed<'a> {
    rig: &'a Rig,
    pose: &'a Pose,
    inertia: Matrix3<f64>,
    /// E with ω = E (roll', pitch', yaw')ᵀ.
    rate_matrix: Matrix3<f64>,
}

impl<'a> Placed<'a> {
    /// At a pose.
    pub fn new(rig: &'a Rig, pose: &'a Pose) -> Self {
        Self { rig, pose, inertia: inertia(rig, pose), rate_matrix: pose.rate_matrix() }
    }

    /// As [`required_wrench`].
    pub fn required_wrench(&self, rates: &Coordinates, accelerations: &Coordinates) -> Vector6<f64> {
        let mut force: Vector3<f64> = accelerations.fixed_rows::<3>(0) * self.rig.mass;
        force -= self.rig.gravity * self.rig.mass;

        let angle_rates = rates.fixed_rows::<3>(3);
        let omega = self.rate_matrix * angle_rates;
        let alpha = self.rate_matrix * accelerations.fixed_rows::<3>(3)
            + self.pose.rate_matrix_derivative(rates) * angle_rates;
        let torque = self.inertia * alpha + omega.cross(&(self.inertia * omega));

        Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z) - self.rig.disturbance
    }

    /// As [`wrench_of`].
    pub fn wrench_of(&self, accelerations: &Coordinates) -> Vector6<f64> {
        let force = accelerations.fixed_rows::<3>(0) * self.rig.mass;
        let torque = self.inertia * (self.rate_matrix * accelerations.fixed_rows::<3>(3));
        Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
    }
}

/// The wrench that the cables must give for these rates and accelerations of the coordinates: left side of Eq. (1).
/// (N, N m), base frame.
pub fn required_wrench(
    rig: &Rig,
    pose: &Pose,
    rates: &Coordinates,
    accelerations: &Coordinates,
) -> Vector6<f64> {
    Placed::new(rig, pose).required_wrench(rates, accelerations)
}

/// The accelerations of the coordinates that these tensions (N) give: Eq. (1) solved for x''.
pub fn accelerations(rig: &Rig, pose: &Pose, rates: &Coordinates, tension: &[f64]) -> Coordinates {
    let (force, torque) = rig.cables_at(pose).wrench(tension);
    let wrench = Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z);
    accelerations_of(rig, pose, &(wrench - required_wrench(rig, pose, rates, &Coordinates::zeros())))
}

/// D(x)⁻¹ w: by how much a wrench (N, N m; base frame) accelerates the coordinates.
pub fn accelerations_of(rig: &Rig, pose: &Pose, wrench: &Vector6<f64>) -> Coordinates {
    let force = wrench.fixed_rows::<3>(0) / rig.mass;
    // Both can be inverted: the inertia of a valid rig, and the rates of angles that tell the orientation.
    let angular = inertia(rig, pose).try_inverse().unwrap_or_default() * wrench.fixed_rows::<3>(3);
    let angles = pose.rate_matrix().try_inverse().unwrap_or_default() * angular;
    Coordinates::new(force.x, force.y, force.z, angles.x, angles.y, angles.z)
}

/// D(x) x'': the wrench (N, N m; base frame) that accelerates the coordinates by this.
pub fn wrench_of(rig: &Rig, pose: &Pose, accelerations: &Coordinates) -> Vector6<f64> {
    Placed::new(rig, pose).wrench_of(accelerations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tensions;
    use crate::robot::{RigFile, RobotParameters, TensionLimits};

    #[test]
    fn tensions_give_the_accelerations_that_they_were_computed_for_also_under_a_disturbance() {
        for text in [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")] {
            let RigFile { mut rig, home, .. } = RigFile::parse(text).unwrap();
            (rig.inertia[(0, 1)], rig.inertia[(1, 0)]) = (0.005, 0.005);
            rig.disturbance = Vector6::new(0.3, -0.2, 0.5, 0.01, -0.02, 0.03) * rig.mass;
            let pose = Pose(home.0 + Coordinates::new(0.05, -0.04, 0.1, 0.1, -0.2, 0.3));
            let rates = Coordinates::new(0.1, 0.2, -0.1, 0.3, 0.4, -0.5);
            let wanted = Coordinates::new(0.5, -0.6, 0.7, 0.8, -0.9, 1.0);
            let tension = tensions(&rig, &pose, &rates, &wanted, 0.0).unwrap();
            assert!((accelerations(&rig, &pose, &rates, &tension) - wanted).amax() < 1e-9);
            let wrench = wrench_of(&rig, &pose, &wanted);
            assert!((accelerations_of(&rig, &pose, &wrench) - wanted).amax() < 1e-11);
        }
    }

    #[test]
    fn gyroscopic_torque_is_that_of_a_turning_body() {
        // Angular momentum L = I ω in the base frame; the torque is dL/dt, taken here by differences.
        let mut rig = Rig::paper(&RobotParameters::default(), TensionLimits::default());
        rig.inertia[(0, 1)] = 0.004;
        rig.inertia[(1, 0)] = 0.004;
        let rates = Coordinates::new(0.0, 0.0, 0.0, 0.6, -0.4, 0.8);
        let pose_at = |t: f64| Pose(Coordinates::new(0.0, 0.0, 1.0, 0.2, 0.1, -0.3) + rates * t);
        let momentum = |t: f64| {
            let pose = pose_at(t);
            inertia(&rig, &pose) * pose.rate_matrix() * rates.fixed_rows::<3>(3)
        };
        let by_differences = (momentum(1e-5) - momentum(-1e-5)) / 2e-5;
        let wrench = required_wrench(&rig, &pose_at(0.0), &rates, &Coordinates::zeros());
        assert!((wrench.fixed_rows::<3>(3) - by_differences).norm() < 1e-8);
    }
}
