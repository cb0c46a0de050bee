//! Importer of FMI 2.0 and 3.0 co-simulation FMUs.
//!
//! Nothing here knows of cables: an FMU is opened with [`Fmu::open_apart`], instantiated with [`Fmu::instantiate`] and stepped through
//! [`Instance`]. It runs in a process of its own, a [`Worker`], so that what it does to that process is an error here. [`Fmu::open`] loads it into
//! this process instead: faster, and for FMUs that are trusted.

mod description;
mod error;
mod fmi2;
mod fmi3;
mod fmu;
mod folder;
mod instance;
mod limits;
mod log;
#[cfg(unix)]
mod remote;
#[cfg(unix)]
mod serve;
mod slave;
mod unpack;
mod value;
#[cfg(unix)]
mod wire;
#[cfg(unix)]
mod worker;

pub use description::{Causality, FmiVersion, ModelDescription, Variable, VariableType};
pub use error::{CosimError, Lost};
pub use fmu::{Fmu, platform};
pub use instance::{Instance, State};
pub use log::{LogCallback, LogMessage, Status};
#[cfg(unix)]
pub use serve::serve;
pub use value::Value;
#[cfg(unix)]
pub use worker::Worker;
