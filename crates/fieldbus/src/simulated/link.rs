//! The wires between bridge and simulated rig.

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::Nanoseconds;
use crate::frame::Frame;

/// What is wrong with the wires.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkFaults {
    /// Share of the frames that are lost, each way.
    pub loss: f64,
    /// Share of the frames that arrive twice.
    pub duplicates: f64,
    /// Nothing passes.
    pub is_cut: bool,
    /// No frame with this identifier arrives.
    pub lost_id: Option<u16>,
    /// How long a frame takes, each way.
    pub delay: Nanoseconds,
}

/// Frames on their way in one direction: when each arrives, and its bus.
type Way = VecDeque<(Nanoseconds, usize, Frame)>;

/// The wires, with the dice that decide which frame is lost.
#[derive(Clone, Debug)]
pub struct Link {
    /// What is wrong with them.
    pub faults: LinkFaults,
    random: Pcg64,
    to_rig: Way,
    to_bridge: Way,
}

impl Link {
    /// All is well.
    pub fn new(seed: u64) -> Self {
        Self {
            faults: LinkFaults::default(),
            random: Pcg64::seed_from_u64(seed),
            to_rig: Way::new(),
            to_bridge: Way::new(),
        }
    }

    /// The bridge sends a frame at `now`.
    pub fn send_to_rig(&mut self, bus: usize, frame: &Frame, now: Nanoseconds) {
        for _ in 0..self.copies(frame) {
            self.to_rig.push_back((now + self.faults.delay, bus, *frame));
        }
    }

    /// The rig sends a frame at `now`.
    pub fn send_to_bridge(&mut self, bus: usize, frame: &Frame, now: Nanoseconds) {
        for _ in 0..self.copies(frame) {
            self.to_bridge.push_back((now + self.faults.delay, bus, *frame));
        }
    }

    /// The next frame that reaches the rig until `now`: when, on which bus, what.
    pub fn at_rig(&mut self, now: Nanoseconds) -> Option<(Nanoseconds, usize, Frame)> {
        arrived(&mut self.to_rig, now)
    }

    /// The same of the bridge.
    pub fn at_bridge(&mut self, now: Nanoseconds) -> Option<(Nanoseconds, usize, Frame)> {
        arrived(&mut self.to_bridge, now)
    }

    /// How often a frame arrives.
    fn copies(&mut self, frame: &Frame) -> usize {
        let LinkFaults { loss, duplicates, is_cut, lost_id, .. } = self.faults;
        let mut happens = |share: f64| share > 0.0 && self.random.random::<f64>() < share;
        if is_cut || lost_id == Some(frame.id()) || happens(loss) {
            0
        } else if happens(duplicates) {
            2
        } else {
            1
        }
    }
}

fn arrived(way: &mut Way, now: Nanoseconds) -> Option<(Nanoseconds, usize, Frame)> {
    if way.front()?.0 <= now { way.pop_front() } else { None }
}
