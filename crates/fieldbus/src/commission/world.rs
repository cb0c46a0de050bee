//! What a rig may be in truth, beside the files that the bridge goes by.

use cable_robot::robot::{PerCable, Pose, Rig};

use crate::config::Config;

/// A rig, where its platform stands at home, and what its winches make of it. The files describe one; the truth may be another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct World {
    /// Geometry.
    pub rig: Rig,
    /// Where the platform stands when the encoders are read for the first time.
    pub home: Pose,
    /// For each winch of the files, which cable of [`Self::rig`] it winds, from 0.
    pub cable: PerCable<usize>,
    /// For each winch, metres that the bridge reads for a true metre.
    pub scale: PerCable<f64>,
}

impl World {
    /// What the files say.
    pub fn of(config: &Config) -> Self {
        let cables = config.rig.cables.len();
        Self {
            rig: config.rig,
            home: config.home,
            cable: PerCable::from_fn(cables, |i| i),
            scale: PerCable::filled(cables, 1.0),
        }
    }

    /// How much longer the bridge reads each cable with the platform at `pose` than at home, m.
    pub fn lengthening(&self, pose: &Pose) -> PerCable<f64> {
        let (here, home) = (self.rig.cables_at(pose).length, self.rig.cables_at(&self.home).length);
        PerCable::from_fn(self.scale.len(), |i| {
            let cable = self.cable[i];
            self.scale[i] * (here[cable] - home[cable])
        })
    }

    /// By how much more the bridge reads each cable at a pose for each unit of what makes a world another one.
    pub(super) fn slope(of: impl Fn(f64) -> Self, pose: &Pose) -> PerCable<f64> {
        // A central difference: what it leaves out is of the order of its square.
        const STEP: f64 = 1e-5;
        let [more, less] = [STEP, -STEP].map(|step| of(step).lengthening(pose));
        PerCable::from_fn(more.len(), |i| (more[i] - less[i]) / (2.0 * STEP))
    }

    /// How much longer the bridge reads each cable at `pose` than it would if `file` were the truth, m.
    pub fn deviation(&self, file: &Self, pose: &Pose) -> PerCable<f64> {
        let (read, expected) = (self.lengthening(pose), file.lengthening(pose));
        PerCable::from_fn(read.len(), |i| read[i] - expected[i])
    }
}
