//! Before anything is set up: listening whether another master is on a bus, then zero torque, so that no reset finds a motor that pulls.

use super::{Bridge, Fault, Mode};
use crate::Nanoseconds;
use crate::canopen::{NmtState, SYNC_ID};
use crate::frame::{Frame, FrameKind};

/// A bridge that runs is heard within two of its heartbeats; nobody listens for less than this.
const LEAST_LISTENING: Nanoseconds = 250_000_000;
/// Cycles of zero torque and voltage off.
const QUIET_CYCLES: u64 = 5;

impl Bridge {
    /// Whether it has put a frame on a bus, or may at any moment: it has listened, and was alone.
    pub fn has_spoken(&self) -> bool {
        self.has_spoken
    }

    pub(super) fn listen(&mut self, since: Nanoseconds) {
        let enough = (2 * self.config.heartbeat.period).max(LEAST_LISTENING);
        if self.time.saturating_sub(since) >= enough {
            self.has_spoken = true;
            self.mode = Mode::Quieting { since: self.time };
        }
    }

    pub(super) fn quiet(&mut self, since: Nanoseconds) {
        let time = self.time;
        if time.saturating_sub(since) > QUIET_CYCLES * self.config.period {
            self.peers.iter_mut().for_each(|peer| peer.startup.restart(time));
            self.mode = Mode::Configuring;
        }
    }

    /// What only this bridge sends: SYNC, its heartbeat, and torques. No transport gives back what was sent by itself.
    pub(super) fn watch_masters(&mut self, bus: usize, frame: &Frame) {
        let (id, own) = (frame.id(), NmtState::Operational.heartbeat(self.config.node));
        let is_torque = self.torque_frames.iter().any(|(on, torque, _)| (*on, *torque) == (bus, id));
        let is_ours = frame.kind() == FrameKind::Data && (id == SYNC_ID || id == own.id() || is_torque);
        if is_ours && !matches!(self.mode, Mode::Shadow { .. }) {
            self.raise(Fault::AnotherMaster { bus, id });
        }
    }
}
