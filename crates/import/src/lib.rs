//! Importer of FMI 2.0 and 3.0 co-simulation FMUs.
//!
//! Nothing here knows of cables: an FMU is opened with [`Fmu::open`], instantiated with [`Fmu::instantiate`] and stepped through [`Instance`].

mod description;
mod error;
mod fmi2;
mod fmi3;
mod fmu;
mod folder;
mod instance;
mod log;
mod slave;
mod value;

pub use description::{Causality, FmiVersion, ModelDescription, Variable, VariableType};
pub use error::CosimError;
pub use fmu::{Fmu, platform};
pub use instance::{Instance, State};
pub use log::{LogCallback, LogMessage, Status};
pub use value::Value;
