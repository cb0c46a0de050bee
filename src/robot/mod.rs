//! Section II: the robot itself. Parameters, geometry, kinematics, dynamics.

pub mod dynamics;
pub mod forward;
pub mod geometry;
pub mod parameters;
pub mod per_cable;
pub mod pose;
pub mod rig;
pub mod rig_file;

pub use dynamics::{tensions, tensions_for_wrench};
pub use forward::{ForwardError, ForwardSolution, forward_kinematics};
pub use geometry::{Cables, Geometry};
pub use parameters::{ParameterError, RobotParameters};
pub use pose::{Coordinates, Pose};
pub use rig::{DegenerateRig, Rig, TensionLimits};
pub use rig_file::{RigFile, RigFileError};

/// Number of cables.
pub const CABLES: usize = 6;

/// One scalar a cable, in the order of the cable numbers 1 to 6.
pub type PerCable<T> = [T; CABLES];
