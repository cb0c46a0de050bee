//! What the programs have in common.

pub mod fmu_model;
