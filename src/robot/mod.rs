//! Section II: the robot itself. Rigs, kinematics, dynamics.

pub mod dynamics;
pub mod forward;
pub mod kinematics;
pub mod memory;
pub mod parameters;
pub mod per_cable;
pub mod pose;
pub mod pulley;
pub mod rig;
pub mod rig_file;
pub mod shape;
pub mod triangles;

pub use forward::{ForwardError, ForwardSolution, forward_kinematics};
pub use kinematics::Cables;
pub use memory::MemoryError;
pub use parameters::{ParameterError, RobotParameters};
pub use per_cable::{CableSet, MOST_CABLES, PerCable};
pub use pose::{Coordinates, Pose};
pub use pulley::Pulley;
pub use rig::{Cable, DegenerateRig, LEAST_CABLES, Rig, TensionLimits};
pub use rig_file::{RigFile, RigFileError};
pub use shape::Shape;
