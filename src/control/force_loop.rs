//! Section VII: load cells correct what friction in the drive train takes from the motors.

use serde::{Deserialize, Serialize};

use crate::robot::memory::are_of_each_cable;
use crate::robot::{PerCable, Rig};

/// Integral gain, 1/s: an error of tension decays to a third in 0.05 s.
const INTEGRAL_GAIN: f64 = 20.0;
/// Largest part of an error made up for in one step, however long: above 2 the loop would ring.
const LARGEST_SHARE: f64 = 0.5;
/// Largest correction of a cable, as a share of the weight: what a dead load cell can add or take. 10 N with Table I.
const LARGEST_CORRECTION: f64 = 0.17;

/// An integrating tension loop a cable, around the motors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceLoop {
    correction: PerCable<f64>,
    /// Of a correction, N.
    largest: f64,
    last_desired: Option<PerCable<f64>>,
}

impl ForceLoop {
    /// Nothing corrected yet.
    pub fn new(rig: &Rig) -> Self {
        let largest = LARGEST_CORRECTION * rig.weight();
        Self { correction: rig.cables.map(|_| 0.0), largest, last_desired: None }
    }

    /// Whether a run with this rig can have left this.
    pub fn is_sound(&self, rig: &Rig) -> bool {
        let of_the_rig = Self::new(rig);
        let is_of_each_cable = |values: &PerCable<f64>| are_of_each_cable(values, rig.cables.len());
        self.largest == of_the_rig.largest
            && is_of_each_cable(&self.correction)
            && self.correction.iter().all(|correction| correction.abs() <= self.largest)
            && self.last_desired.as_ref().is_none_or(is_of_each_cable)
    }

    /// What the motors shall pull, N, so that the platform feels `desired`; `measured` is the answer to the previous call,
    /// `dt` seconds ago.
    pub fn command(&mut self, desired: &PerCable<f64>, measured: &PerCable<f64>, dt: f64) -> PerCable<f64> {
        if let Some(last) = self.last_desired {
            let share = (INTEGRAL_GAIN * dt).min(LARGEST_SHARE);
            for i in 0..desired.len() {
                let integral = self.correction[i] + share * (last[i] - measured[i]);
                self.correction[i] = integral.clamp(-self.largest, self.largest);
            }
        }
        self.last_desired = Some(*desired);
        PerCable::from_fn(desired.len(), |i| desired[i] + self.correction[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RigFile;

    fn six(tension: f64) -> PerCable<f64> {
        PerCable::filled(6, tension)
    }

    #[test]
    fn friction_is_made_up_for() {
        let mut force_loop = ForceLoop::new(&RigFile::default().rig);
        let mut measured = six(8.0);
        for _ in 0..2000 {
            let command = force_loop.command(&six(10.0), &measured, 1e-3);
            measured = command.map(|u| u - 2.0);
        }
        assert!((measured[0] - 10.0).abs() < 1e-3, "{}", measured[0]);
    }

    #[test]
    fn a_dead_load_cell_adds_no_more_than_the_limit() {
        let mut force_loop = ForceLoop::new(&RigFile::default().rig);
        let mut command = six(0.0);
        for _ in 0..10_000 {
            command = force_loop.command(&six(10.0), &six(0.0), 1e-3);
        }
        assert_eq!(command, six(10.0 + LARGEST_CORRECTION * 6.0 * 9.81));
    }
}
