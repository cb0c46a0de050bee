//! What the programs have in common, and `cable-robot`, which is a module of the Python package, too.

#[path = "cable-robot/mod.rs"]
pub mod command;
pub mod errors;
pub mod plain;
pub mod shell;
