//! Any rig: cables from anchors on a base to attachments on a platform, with limits of tension.

use nalgebra::Vector3;

use super::{Geometry, RobotParameters};

/// Tensions that the drives and cables allow, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionLimits {
    /// Least tension of a cable; at zero it is slack.
    pub min: f64,
    /// Greatest tension of a cable.
    pub max: f64,
}

/// A rig of six or more cables. Cable i runs from `anchors[i]` to `attachments[i]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// What people call it.
    pub name: String,
    /// Anchors in the base frame (z down), m.
    pub anchors: Vec<Vector3<f64>>,
    /// Attachments in the platform's frame, whose origin is the centre of mass, m.
    pub attachments: Vec<Vector3<f64>>,
    /// Mass of the platform, kg.
    pub mass: f64,
    /// Principal moments of inertia about the centre of mass along the platform's axes, kg m².
    pub inertia: Vector3<f64>,
    /// Gravitational acceleration along +z, m/s².
    pub g: f64,
    /// What each cable may pull.
    pub limits: TensionLimits,
}

impl Rig {
    /// The paper's rig with other numbers in Table I, and these limits.
    pub fn triangular(robot: &RobotParameters, limits: TensionLimits) -> Self {
        let geometry = Geometry::new(robot);
        Self {
            name: "Oh and Agrawal".to_owned(),
            anchors: geometry.anchor.to_vec(),
            attachments: geometry.attachment.to_vec(),
            mass: robot.m,
            inertia: Vector3::new(robot.i1, robot.i2, robot.i3),
            g: robot.g,
            limits,
        }
    }
}
