//! Section IV: where a step may go without slackening a cable. Static workspace (16), bounded reachable domain (15), exact
//! domain; for rigs with any cables the static workspace, and the certificate of a step in all six coordinates.

pub(crate) mod bounded;
pub mod certificate;
pub(crate) mod curve;
pub mod exact;
pub(crate) mod half_plane;
#[cfg(feature = "clarabel")]
pub mod quadratic_program;
pub mod static_region;
pub(crate) mod workspace;

pub use bounded::BoundedDomain;
pub use certificate::{Verdict, certify};
pub use curve::{Curve, Extremes};
pub use exact::ExactDomain;
pub use half_plane::{HalfPlane, polygon};
#[cfg(feature = "clarabel")]
pub use quadratic_program::SolverError;
pub use static_region::Slice;
pub use workspace::{in_static_workspace, static_workspace};
