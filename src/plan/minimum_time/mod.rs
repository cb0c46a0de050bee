//! The fastest motions with every tension within its limits. Derived in docs/minimum-time.md.

mod arc;
mod envelope;
pub mod line;

pub use arc::{Along, Arc, Timing};
pub use line::Line;
