//! Eq. (1), Newton and Euler: which wrench gives which accelerations.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{Coordinates, Pose, Rig};

/// Inertia about the centre of mass in the base frame, kg m².
pub fn inertia(rig: &Rig, pose: &Pose) -> Matrix3<f64> {
    let rotation = pose.rotation();
    rotation.matrix() * rig.inertia * rotation.matrix().transpose()
}

/// The wrench that the cables must give for these rates and accelerations of the coordinates: left side of Eq. (1).
/// (N, N m), base frame.
pub fn required_wrench(
    rig: &Rig,
    pose: &Pose,
    rates: &Coordinates,
    accelerations: &Coordinates,
) -> Vector6<f64> {
    let mut force: Vector3<f64> = accelerations.fixed_rows::<3>(0) * rig.mass;
    force -= rig.gravity * rig.mass;

    let angle_rates = rates.fixed_rows::<3>(3);
    let rate_matrix = pose.rate_matrix();
    let omega = rate_matrix * angle_rates;
    let alpha =
        rate_matrix * accelerations.fixed_rows::<3>(3) + pose.rate_matrix_derivative(rates) * angle_rates;
    let inertia = inertia(rig, pose);
    let torque = inertia * alpha + omega.cross(&(inertia * omega));

    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{RobotParameters, TensionLimits};

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
