//! Where the cables are: anchors, attachments, lengths, directions, the wrench matrix.

use nalgebra::{Matrix6, Rotation3, Vector2, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::{CABLES, PerCable, RobotParameters};

/// sin 60°.
const S60: f64 = 0.866_025_403_784_438_6;

/// Unit vectors (cos, sin) at the azimuths of the base vertices of cables 1 to 6: 300, 300, 60, 60, 180, 180 degrees.
const BASE_AZIMUTH: PerCable<[f64; 2]> =
    [[0.5, -S60], [0.5, -S60], [0.5, S60], [0.5, S60], [-1.0, 0.0], [-1.0, 0.0]];

/// The same for the platform vertices: 240, 0, 0, 120, 120, 240 degrees.
const PLATFORM_AZIMUTH: PerCable<[f64; 2]> =
    [[-0.5, -S60], [1.0, 0.0], [1.0, 0.0], [-0.5, S60], [-0.5, S60], [-0.5, -S60]];

/// Outward normals of the facets of the static workspace: cable i is in tension when nᵢ·p < a/2.
/// Azimuths 150, 90, -90, 210, 30, -30 degrees.
pub const FACET_NORMALS: PerCable<Vector2<f64>> = [
    Vector2::new(-S60, 0.5),
    Vector2::new(0.0, 1.0),
    Vector2::new(0.0, -1.0),
    Vector2::new(-S60, -0.5),
    Vector2::new(S60, 0.5),
    Vector2::new(S60, -0.5),
];

/// Both ends of every cable, each in the frame of the body it is fixed to, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Anchors on the base, base frame.
    pub anchor: PerCable<Vector3<f64>>,
    /// Attachments on the platform, platform frame (origin at the centre of mass).
    pub attachment: PerCable<Vector3<f64>>,
}

impl Geometry {
    /// Two equilateral triangles of sides 2a and 2b, the second turned by 180 degrees.
    pub fn new(robot: &RobotParameters) -> Self {
        let vertex = |half_side: f64, [cos, sin]: [f64; 2]| {
            let radius = 2.0 * half_side / 3f64.sqrt();
            Vector3::new(radius * cos, radius * sin, 0.0)
        };
        Self {
            anchor: BASE_AZIMUTH.map(|direction| vertex(robot.a, direction)),
            attachment: PLATFORM_AZIMUTH.map(|direction| vertex(robot.b, direction)),
        }
    }

    /// Greatest distance of an attachment from the centre of mass, m.
    pub fn platform_radius(&self) -> f64 {
        self.attachment.iter().map(|b| b.norm()).fold(0.0, f64::max)
    }

    /// The cables with the platform's centre at `position` and its orientation `rotation`.
    pub fn cables(&self, position: &Vector3<f64>, rotation: &Rotation3<f64>) -> Cables {
        let mut cables = Cables { arm: self.attachment, direction: self.anchor, length: [0.0; CABLES] };
        for i in 0..CABLES {
            cables.arm[i] = rotation * self.attachment[i];
            let along = self.anchor[i] - position - cables.arm[i];
            cables.length[i] = along.norm();
            cables.direction[i] = along / cables.length[i];
        }
        cables
    }
}

/// The six cables at one pose, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cables {
    /// Attachment relative to the centre of mass, m.
    pub arm: PerCable<Vector3<f64>>,
    /// Unit vector from the attachment to the anchor: where the cable pulls.
    pub direction: PerCable<Vector3<f64>>,
    /// Length, m (inverse kinematics).
    pub length: PerCable<f64>,
}

impl Cables {
    /// The 6x6 wrench matrix -Jᵀ of Eq. (1): tensions to (force, torque about the centre of mass), base frame.
    pub fn wrench_matrix(&self) -> Matrix6<f64> {
        let mut matrix = Matrix6::zeros();
        for i in 0..CABLES {
            matrix.fixed_view_mut::<3, 1>(0, i).copy_from(&self.direction[i]);
            matrix.fixed_view_mut::<3, 1>(3, i).copy_from(&self.arm[i].cross(&self.direction[i]));
        }
        matrix
    }

    /// (force, torque about the centre of mass) of these tensions, N and N m, base frame.
    pub fn wrench(&self, tension: &PerCable<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let mut force = Vector3::zeros();
        let mut torque = Vector3::zeros();
        for i in 0..CABLES {
            let pull = self.direction[i] * tension[i];
            force += pull;
            torque += self.arm[i].cross(&pull);
        }
        (force, torque)
    }

    /// Rates of the lengths, m/s, for the twist (velocity, angular velocity), base frame.
    pub fn length_rates(&self, twist: &Vector6<f64>) -> PerCable<f64> {
        let velocity = twist.fixed_rows::<3>(0).into_owned();
        let omega = twist.fixed_rows::<3>(3).into_owned();
        std::array::from_fn(|i| -self.direction[i].dot(&(velocity + omega.cross(&self.arm[i]))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Pose;

    #[test]
    fn length_rates_are_the_derivative_of_the_lengths() {
        let geometry = Geometry::new(&RobotParameters::default());
        let position = Vector3::new(0.05, -0.1, 0.9);
        let rotation = Pose(Vector6::new(0.0, 0.0, 0.0, 0.1, -0.2, 0.3)).rotation();
        let twist = Vector6::new(0.3, -0.2, 0.1, 0.4, 0.5, -0.6);
        let omega = twist.fixed_rows::<3>(3).into_owned();
        let lengths = |t: f64| {
            let p = position + twist.fixed_rows::<3>(0) * t;
            geometry.cables(&p, &(Rotation3::from_scaled_axis(omega * t) * rotation)).length
        };
        let rates = geometry.cables(&position, &rotation).length_rates(&twist);
        let (before, after) = (lengths(-1e-6), lengths(1e-6));
        for i in 0..CABLES {
            assert!((rates[i] - (after[i] - before[i]) / 2e-6).abs() < 1e-8, "cable {}", i + 1);
        }
    }

    #[test]
    fn wrench_matrix_times_tensions_is_the_wrench() {
        let geometry = Geometry::new(&RobotParameters::default());
        let pose = Pose(Vector6::new(0.05, 0.02, 1.1, 0.1, 0.2, -0.1));
        let cables = geometry.cables(&pose.position(), &pose.rotation());
        let tension = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let (force, torque) = cables.wrench(&tension);
        let product = cables.wrench_matrix() * Vector6::from(tension);
        assert!((product.fixed_rows::<3>(0) - force).norm() < 1e-12);
        assert!((product.fixed_rows::<3>(3) - torque).norm() < 1e-12);
    }
}
