//! The wires between bridge and simulated rig.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// What is wrong with the wires.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkFaults {
    /// Share of the frames that are lost, each way.
    pub loss: f64,
    /// Share of the frames that arrive twice.
    pub duplicates: f64,
    /// Nothing passes.
    pub is_cut: bool,
}

/// The wires, with the dice that decide which frame is lost.
#[derive(Clone, Debug)]
pub struct Link {
    /// What is wrong with them.
    pub faults: LinkFaults,
    random: Pcg64,
}

impl Link {
    /// All is well.
    pub fn new(seed: u64) -> Self {
        Self { faults: LinkFaults::default(), random: Pcg64::seed_from_u64(seed) }
    }

    /// How often the next frame arrives.
    pub fn copies(&mut self) -> usize {
        let LinkFaults { loss, duplicates, is_cut } = self.faults;
        let mut happens = |share: f64| share > 0.0 && self.random.random::<f64>() < share;
        if is_cut || happens(loss) {
            0
        } else if happens(duplicates) {
            2
        } else {
            1
        }
    }
}
