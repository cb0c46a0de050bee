//! The C boundary: one library, two models, FMI 2.0 and 3.0 co-simulation.

pub mod bindings;
