//! Section VI: the plant, its integrator, scenarios.

pub mod plant;
