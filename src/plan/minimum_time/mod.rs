//! The fastest motions with every tension within its limits. Derived in docs/minimum-time.md.

mod arc;
mod conditions;
mod course;
mod envelope;
mod holding;
pub mod line;
pub mod path;
mod pieces;
mod planning;
mod polygon;
mod smooth;
mod sum;
mod track;

pub use arc::{Along, Arc, Timing};
pub use course::Course;
pub use line::Line;
pub use track::{MOST_SECTIONS, Track};
