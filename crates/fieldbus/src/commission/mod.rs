//! Commissioning: is the rig what its files say? Six lengths always belong to some pose, so nothing that the bridge computes from them
//! tells a wrong file. Poses measured in the base's frame do (docs/commissioning.md).

mod calibration;
mod doubt;
#[cfg(test)]
mod first_day;
mod fit;
mod gains;
mod mistake;
mod poses;
mod quantity;
mod survey;
#[cfg(test)]
mod tests;
mod verdict;
mod world;

pub use calibration::Calibration;
pub use doubt::Doubt;
pub use fit::Fitted;
pub use gains::{Gains, Weighing};
pub use mistake::{Frame, Mistake};
pub use poses::Plan;
pub use quantity::Quantity;
pub use survey::Accuracy;
pub use verdict::{Explanation, Placement, Verdict};
pub use world::World;

/// Something is blamed from so many standard deviations on. Some eighty things are looked for; chance brings one of them there once in two hundred
/// surveys.
const ALARM: f64 = 4.0;
/// What shows by so many is blamed, but for one time in 740: three standard deviations more than what is blamed.
pub const NEEDED: f64 = ALARM + 3.0;
