//! Section IV: where a step may go without slackening a cable. Static workspace (16), bounded reachable domain (15), exact
//! domain.

pub mod bounded;
pub mod curve;
pub mod exact;
pub mod half_plane;
pub mod workspace;

pub use bounded::BoundedDomain;
pub use curve::Curve;
pub use exact::ExactDomain;
pub use half_plane::{HalfPlane, polygon};
pub use workspace::{in_static_workspace, static_workspace};
