//! Section IV: where a step may go without slackening a cable. Static workspace (16), bounded reachable domain (15), and a
//! certificate for any rig and any step.

pub mod bounded;
pub mod certificate;
pub mod half_plane;
pub mod workspace;

pub use bounded::BoundedDomain;
pub use certificate::{Verdict, certify};
pub use half_plane::{HalfPlane, polygon};
pub use workspace::{in_static_workspace, static_workspace};
