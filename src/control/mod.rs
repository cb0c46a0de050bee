//! Section III: the Lyapunov law, its gains, the closed-form response, the tension distribution, and what the law needs to know of the motion.

pub(crate) mod active_set;
pub(crate) mod commands;
pub(crate) mod delay;
pub mod distribution;
pub(crate) mod estimator;
pub(crate) mod force_loop;
pub(crate) mod gains;
pub(crate) mod held_tensions;
pub mod lyapunov;
pub(crate) mod reference;
pub mod response;
pub(crate) mod sensitivity;
pub mod tensions;

pub use commands::Commands;
pub use delay::DelayWatch;
pub use estimator::{DisturbanceObserver, Estimator};
pub use force_loop::ForceLoop;
pub use gains::Gains;
pub use held_tensions::swing;
pub use reference::Reference;
pub use response::Response;
pub use sensitivity::Sensitivity;
pub use tensions::{Barrier, barrier, static_margin, static_tensions, tensions};
