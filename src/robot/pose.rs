//! The six coordinates of the platform.

use nalgebra::{Rotation3, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Generalised coordinates q = (x, y, z, roll, pitch, yaw) or their rates, in m and rad.
pub type Coordinates = Vector6<f64>;

/// Pose of the platform in the base frame (origin at the centre of the base plane, z down).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose(pub Coordinates);

impl Pose {
    /// A pose without rotation.
    pub fn at(x: f64, y: f64, z: f64) -> Self {
        Self(Coordinates::new(x, y, z, 0.0, 0.0, 0.0))
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
}

impl Default for Pose {
    /// One metre below the centre of the base, the paper's start.
    fn default() -> Self {
        Self::at(0.0, 0.0, 1.0)
    }
}
