//! Eq. (1), Newton and Euler: which tensions give which accelerations.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{Cables, Coordinates, Geometry, PerCable, Pose, RobotParameters};

/// Inertia about the centre of mass in the base frame, kg m².
pub fn inertia(robot: &RobotParameters, pose: &Pose) -> Matrix3<f64> {
    let rotation = pose.rotation();
    let body = Matrix3::from_diagonal(&Vector3::new(robot.i1, robot.i2, robot.i3));
    rotation.matrix() * body * rotation.matrix().transpose()
}

/// The wrench that the cables must give for these rates and accelerations of the coordinates: left side of Eq. (1).
/// (N, N m), base frame.
pub fn required_wrench(
    robot: &RobotParameters,
    pose: &Pose,
    rates: &Coordinates,
    accelerations: &Coordinates,
) -> Vector6<f64> {
    let mut force: Vector3<f64> = accelerations.fixed_rows::<3>(0) * robot.m;
    force.z -= robot.m * robot.g;

    let angle_rates = rates.fixed_rows::<3>(3);
    let rate_matrix = pose.rate_matrix();
    let omega = rate_matrix * angle_rates;
    let alpha =
        rate_matrix * accelerations.fixed_rows::<3>(3) + pose.rate_matrix_derivative(rates) * angle_rates;
    let inertia = inertia(robot, pose);
    let torque = inertia * alpha + omega.cross(&(inertia * omega));

    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

/// The tensions that give `wrench`, N; `None` where the wrench matrix is singular.
pub fn tensions_for_wrench(cables: &Cables, wrench: &Vector6<f64>) -> Option<PerCable<f64>> {
    let tension = cables.wrench_matrix().lu().solve(wrench)?;
    tension.iter().all(|u| u.is_finite()).then(|| tension.into())
}

/// The tensions u of Eq. (1) at this motion, N: negative where a cable would have to push.
/// `None` where the wrench matrix is singular.
pub fn tensions(
    robot: &RobotParameters,
    geometry: &Geometry,
    pose: &Pose,
    rates: &Coordinates,
    accelerations: &Coordinates,
) -> Option<PerCable<f64>> {
    let cables = geometry.cables(&pose.position(), &pose.rotation());
    tensions_for_wrench(&cables, &required_wrench(robot, pose, rates, accelerations))
}

/// The tensions at rest, N; `None` where the wrench matrix is singular.
pub fn static_tensions(robot: &RobotParameters, geometry: &Geometry, pose: &Pose) -> Option<PerCable<f64>> {
    tensions(robot, geometry, pose, &Coordinates::zeros(), &Coordinates::zeros())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_rest(x: f64, y: f64) -> PerCable<f64> {
        let robot = RobotParameters::default();
        static_tensions(&robot, &Geometry::new(&robot), &Pose::at(x, y, 1.0)).unwrap()
    }

    #[test]
    fn tensions_at_rest_are_those_of_the_notes() {
        for u in at_rest(0.0, 0.0) {
            assert!((u - 10.7612).abs() < 5e-5, "{u}");
        }
        let expected = [13.296, 3.858, 17.319, 19.362, 1.050, 8.410];
        for (u, expected) in at_rest(0.15, 0.15).iter().zip(expected) {
            assert!((u - expected).abs() < 5e-4, "{u} is not {expected}");
        }
    }

    #[test]
    fn gyroscopic_torque_is_that_of_a_turning_body() {
        // Angular momentum L = I ω in the base frame; the torque is dL/dt, taken here by differences.
        let robot = RobotParameters::default();
        let rates = Coordinates::new(0.0, 0.0, 0.0, 0.6, -0.4, 0.8);
        let pose_at = |t: f64| Pose(Coordinates::new(0.0, 0.0, 1.0, 0.2, 0.1, -0.3) + rates * t);
        let momentum = |t: f64| {
            let pose = pose_at(t);
            inertia(&robot, &pose) * pose.rate_matrix() * rates.fixed_rows::<3>(3)
        };
        let by_differences = (momentum(1e-5) - momentum(-1e-5)) / 2e-5;
        let wrench = required_wrench(&robot, &pose_at(0.0), &rates, &Coordinates::zeros());
        assert!((wrench.fixed_rows::<3>(3) - by_differences).norm() < 1e-8);
    }
}
