//! What the law follows: a set point at rest, or a motion.

use serde::{Deserialize, Serialize};

use crate::robot::{Coordinates, Pose};

/// Pose, rates and accelerations that the law leads the robot to: r, r', r'' in the six coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// r
    pub pose: Pose,
    /// r', m/s and rad/s.
    pub rates: Coordinates,
    /// r'', m/s² and rad/s².
    pub accelerations: Coordinates,
}

impl Reference {
    /// A set point.
    pub fn resting(pose: &Pose) -> Self {
        Self { pose: *pose, rates: Coordinates::zeros(), accelerations: Coordinates::zeros() }
    }

    /// What a command that acts from `begin` on for `hold` is computed for: a motion at the time `at` (all in s), with the mean of its accelerations while
    /// the command acts.
    pub fn held(motion: impl Fn(f64) -> Self, at: f64, begin: f64, hold: f64) -> Self {
        let mut reference = motion(at);
        if hold > 0.0 {
            let [before, after] = [begin, begin + hold].map(|time| motion(time).rates);
            reference.accelerations = (after - before) / hold;
        }
        reference
    }
}
