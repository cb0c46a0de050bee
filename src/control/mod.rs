//! Section III: the Lyapunov law, its gains, the closed-form response, and what it needs to be told of the motion.

pub mod estimator;
pub mod force_loop;
pub mod gains;
pub mod lyapunov;
pub mod response;

pub use estimator::Estimator;
pub use force_loop::ForceLoop;
pub use gains::Gains;
pub use response::Response;
