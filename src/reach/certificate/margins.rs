//! What keeps the robot from the closed form, and how far.

use crate::robot::Coordinates;

/// How far coordinates (m, rad), rates (m/s, rad/s) and the accelerations that the law commands (m/s², rad/s²) may be from the closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Of the coordinates.
    pub coordinates: Coordinates,
    /// Of their rates.
    pub rates: Coordinates,
    /// Of the accelerations.
    pub accelerations: Coordinates,
}

impl Tube {
    /// The closed form itself.
    pub fn empty() -> Self {
        let none = Coordinates::zeros();
        Self { coordinates: none, rates: none, accelerations: none }
    }
}
