//! The six coordinates of the platform.

use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Generalised coordinates q = (x, y, z, roll, pitch, yaw) or their rates, in m and rad.
pub type Coordinates = Vector6<f64>;

/// Where roll and pitch stand among the coordinates.
pub const ROLL: usize = 3;
/// As [`ROLL`].
pub const PITCH: usize = 4;
/// Beyond this pitch, rad, the angles no longer tell the orientation.
pub const LARGEST_PITCH: f64 = 1.4;

/// Pose of the platform in the base frame (origin at the centre of the base plane, z down).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pose(#[schemars(with = "[f64; 6]")] pub Coordinates);

impl Pose {
    /// A pose without rotation.
    pub fn at(x: f64, y: f64, z: f64) -> Self {
        Self(Coordinates::new(x, y, z, 0.0, 0.0, 0.0))
    }

    /// The pose of a body at `position` turned by `rotation`.
    pub fn from_parts(position: &Vector3<f64>, rotation: &Rotation3<f64>) -> Self {
        let (roll, pitch, yaw) = rotation.euler_angles();
        Self(Coordinates::new(position.x, position.y, position.z, roll, pitch, yaw))
    }

    /// Centre of mass, m.
    pub fn position(&self) -> Vector3<f64> {
        self.0.fixed_rows::<3>(0).into_owned()
    }

    /// (roll, pitch, yaw), rad.
    pub fn angles(&self) -> Vector3<f64> {
        self.0.fixed_rows::<3>(3).into_owned()
    }

    /// R = Rz(yaw) Ry(pitch) Rx(roll), from the platform's frame to the base frame.
    pub fn rotation(&self) -> Rotation3<f64> {
        Rotation3::from_euler_angles(self.0[3], self.0[4], self.0[5])
    }

    /// `self - other` in coordinates, the angles brought into (-π, π].
    pub fn minus(&self, other: &Self) -> Coordinates {
        let mut difference = self.0 - other.0;
        for angle in 3..6 {
            difference[angle] = wrap(difference[angle]);
        }
        difference
    }

    /// E with ω = E (roll', pitch', yaw')ᵀ in the base frame.
    pub fn rate_matrix(&self) -> Matrix3<f64> {
        let (sp, cp) = libm::sincos(self.0[4]);
        let (sy, cy) = libm::sincos(self.0[5]);
        Matrix3::new(cy * cp, -sy, 0.0, sy * cp, cy, 0.0, -sp, 0.0, 1.0)
    }

    /// dE/dt at these rates of the coordinates.
    pub fn rate_matrix_derivative(&self, rates: &Coordinates) -> Matrix3<f64> {
        let (sp, cp) = libm::sincos(self.0[4]);
        let (sy, cy) = libm::sincos(self.0[5]);
        let (dp, dy) = (rates[4], rates[5]);
        Matrix3::new(
            -sy * cp * dy - cy * sp * dp,
            -cy * dy,
            0.0,
            cy * cp * dy - sy * sp * dp,
            -sy * dy,
            0.0,
            -cp * dp,
            0.0,
            0.0,
        )
    }
}

impl Default for Pose {
    /// One metre below the centre of the base, the paper's start.
    fn default() -> Self {
        Self::at(0.0, 0.0, 1.0)
    }
}

/// The same angle in [-π, π].
fn wrap(angle: f64) -> f64 {
    if angle.abs() <= std::f64::consts::PI { angle } else { libm::atan2(libm::sin(angle), libm::cos(angle)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_matrix_maps_angle_rates_to_the_angular_velocity() {
        let pose = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.3, -0.4, 0.5));
        let rates = Coordinates::new(0.0, 0.0, 0.0, 0.7, -0.2, 0.9);
        let h = 1e-6;
        let (before, after) = (Pose(pose.0 - rates * h), Pose(pose.0 + rates * h));
        // R' Rᵀ is the matrix of ω×.
        let spin = (after.rotation().matrix() - before.rotation().matrix()) / (2.0 * h)
            * pose.rotation().matrix().transpose();
        let turned = Vector3::new(spin.m32, spin.m13, spin.m21);
        assert!((turned - pose.rate_matrix() * rates.fixed_rows::<3>(3)).norm() < 1e-9);
        let derivative = (after.rate_matrix() - before.rate_matrix()) / (2.0 * h);
        assert!((derivative - pose.rate_matrix_derivative(&rates)).norm() < 1e-9);
    }

    #[test]
    fn difference_of_angles_crosses_the_half_turn_the_short_way() {
        let a = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, 3.1));
        let b = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, -3.1));
        assert!((a.minus(&b)[5] + 0.083_185_307).abs() < 1e-8);
    }
}
