//! The bridge and the simulated rig as nodes of a simulated bus: FMI-LS-BUS 1.0.0, network abstraction, CAN.
//!
//! A node is stepped from one communication point to the next. What it sends within a step leaves at the end of the step, a *bus
//! communication point*, and what arrives there is taken in before the next step (docs/ls-bus.md).

mod controller;
pub mod operation;
mod port;
mod rig;

pub use controller::{ControllerNode, Wishes};
pub use port::{CYCLES, Notice, Port, ROOM, Received};
pub use rig::RigNode;

use crate::Nanoseconds;
use crate::config::Config;

/// What is due within this part of a period after a communication point is due at it: importers round.
const ROUNDING: Nanoseconds = 1_000_000;

/// A port for each bus of the fieldbus file.
fn ports(config: &Config) -> Vec<Port> {
    config.buses.iter().map(|bus| Port::new(bus.bit_rate)).collect()
}

/// The longest step that a node makes, ns: there is room for the frames of so many cycles.
pub fn longest_step(config: &Config) -> Nanoseconds {
    config.period * Nanoseconds::from(CYCLES)
}

#[cfg(test)]
mod tests;
