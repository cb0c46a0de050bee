//! Importer of FMI 2.0 and 3.0 co-simulation FMUs, and a small master that steps a set of them.
//!
//! Nothing here knows of cables: an FMU is opened with [`Fmu::open`], instantiated with [`Fmu::instantiate`],
//! and stepped alone through [`Instance`] or with others through [`Master`]. A [`Recorder`] keeps what they show.

mod description;
mod error;
mod fmi2;
mod fmi3;
mod fmu;
mod folder;
mod instance;
mod log;
mod master;
mod recorder;
mod slave;
mod value;

pub use description::{Causality, FmiVersion, ModelDescription, Variable, VariableType};
pub use error::CosimError;
pub use fmu::{Fmu, platform};
pub use instance::{Instance, State};
pub use log::{LogCallback, LogMessage, Status};
pub use master::Master;
pub use recorder::Recorder;
pub use value::Value;
