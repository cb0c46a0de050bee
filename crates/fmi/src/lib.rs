//! The C boundary: one library; controller and plant for FMI 2.0 and 3.0 Co-Simulation, and the plant for Model Exchange.
//!
//! An FMU is a zip file with a description (XML) and a library. The description lists variables, each with a number, its
//! *value reference*; the library exports C functions to make an instance, to set and get variables by these numbers, and
//! to advance time. Read on in this order:
//!
//! - [`variables`]: what a variable is; `models/` has the tables and the way from values to controller and plant;
//! - [`values`]: one number a value reference;
//! - [`lifecycle`]: which call is allowed when;
//! - `instance`: what the calls do; `state`: what an instance is and how it is saved; [`log`]: what it says;
//! - [`node`]: what an instance on CAN buses is besides; with the feature `can` there are such;
//! - [`abi`]: the C functions, which translate pointers into the above and nothing else;
//! - [`describe`]: the XML and the documentation, rendered from the tables; [`resources`]: the rig that an FMU carries.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod abi;
pub mod archive;
#[cfg(feature = "can")]
pub mod can;
pub mod describe;
pub mod error;
mod instance;
pub mod lifecycle;
pub mod log;
pub mod models;
pub mod node;
pub mod resources;
mod state;
pub mod values;
pub mod variables;

pub use cable_robot_bindings as bindings;
pub use models::{CO_SIMULATION, Interface, MODELS, Model, Use};
