//! Section II: the robot itself. Rigs, kinematics, dynamics.

pub mod dynamics;
pub(crate) mod forward;
pub(crate) mod kinematics;
pub(crate) mod memory;
pub mod parameters;
pub(crate) mod per_cable;
pub mod pose;
pub(crate) mod pulley;
pub mod rig;
pub mod rig_file;
pub(crate) mod shape;
pub mod triangles;

pub use forward::{ForwardError, ForwardSolution, forward_kinematics};
pub use kinematics::Cables;
pub use memory::MemoryError;
pub use parameters::{ParameterError, RobotParameters};
pub use per_cable::{CableSet, MOST_CABLES, PerCable};
pub use pose::{Coordinates, Pose};
pub use pulley::{Pulley, Run};
pub use rig::{Cable, DegenerateRig, LEAST_CABLES, Rig, TensionLimits};
pub use rig_file::{RigFile, RigFileError};
pub use shape::{OtherShape, Shape};
