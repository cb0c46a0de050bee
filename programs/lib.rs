//! What the programs have in common.

pub mod errors;
pub mod fmu_model;
