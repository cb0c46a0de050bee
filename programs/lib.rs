//! What the programs have in common.

pub mod errors;
pub mod plain;
