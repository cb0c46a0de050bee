//! Section V: the planner, and the controller that executes what it plans.

mod aim;
pub mod bisection;
mod bounded;
pub(crate) mod controller;
pub(crate) mod exact;
pub mod extremes;
pub(crate) mod fault;
pub(crate) mod interface;
#[cfg(feature = "clarabel")]
pub mod linear_program;
mod margins;
pub mod minimum_time;
#[cfg(feature = "clarabel")]
pub mod nearest;
pub mod orbit;
pub mod planner;
pub(crate) mod prediction;
#[cfg(feature = "clarabel")]
pub mod sequence;
mod speed;
mod status;
mod stop;
mod tangents;
pub mod through;
mod tuning;

pub use controller::Controller;
pub use fault::{Check, Fault};
pub use interface::{
    ControllerInputs, ControllerOutputs, ControllerParameters, OF_LONGEST_STEP, PlannerKind, PoseSource, Rest,
};
pub use planner::Planner;
pub use status::Status;
pub use tuning::{Pending, Tuning};
