//! Section VI: the plant and its integrator.

pub mod body;
pub mod integrator;
pub mod plant;

pub use plant::{Plant, PlantError, PlantInputs, PlantOutputs, PlantParameters};
