//! Section II: the robot itself. Parameters, geometry, kinematics, dynamics.

pub mod parameters;
pub mod pose;

pub use parameters::{ParameterError, RobotParameters};
pub use pose::{Coordinates, Pose};

/// Number of cables.
pub const CABLES: usize = 6;

/// One scalar a cable, in the order of the cable numbers 1 to 6.
pub type PerCable<T> = [T; CABLES];
