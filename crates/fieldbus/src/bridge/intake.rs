//! What arrives between two cycles: heartbeats, emergencies, answers, process data, and what a transport could not do.

use super::fault::{Fault, TransportError};
use super::state::Event;
use super::{Bridge, Mode};
use crate::Nanoseconds;
use crate::canopen::{Emergency, NmtState, Node, SdoResponse, TPDO1};
use crate::cia402::DriveState;
use crate::frame::{Frame, FrameKind, error_class};

impl Bridge {
    /// Takes in a frame from a bus, seen at `now`. To be called in the order of arrival, before the cycle that shall know of it.
    pub fn on_frame(&mut self, bus: usize, frame: &Frame, now: Nanoseconds) {
        let now = now + self.offset;
        self.watch_masters(bus, frame);
        if frame.kind() == FrameKind::Error {
            if frame.id() & error_class::BUS_OFF != 0 {
                self.raise(Fault::BusOff { bus });
            }
        } else if let Some((node, state)) = NmtState::parse(frame) {
            self.on_heartbeat(bus, node, state, now);
        } else if let Some(emergency) = Emergency::parse(frame) {
            self.on_emergency(bus, emergency, now);
        } else if let Some((node, response)) = SdoResponse::parse(frame) {
            let timeouts = self.config.timeouts;
            let result = match self.peer(bus, node) {
                Some(peer) => peer.startup.on_response(&response, now, &timeouts),
                None => Ok(()),
            };
            self.expect(result);
            self.on_mode(node, &response);
            self.on_status(bus, node, &response);
        } else {
            self.on_process_data(bus, frame);
        }
    }

    /// Takes in what a transport could not do since the last cycle.
    pub fn on_transport_error(&mut self, bus: usize, error: TransportError) {
        match error {
            TransportError::NoRoom if self.no_room < self.config.limits.lost_cycles => {
                self.had_no_room = true
            }
            _ => self.raise(Fault::Transport { bus, error }),
        }
    }

    fn on_heartbeat(&mut self, bus: usize, node: Node, state: NmtState, now: Nanoseconds) {
        // What nodes were doing before they are reset means nothing.
        if matches!(self.mode, Mode::Shadow { .. } | Mode::Listening { .. } | Mode::Quieting { .. }) {
            return;
        }
        let is_configuring = self.mode == Mode::Configuring;
        if let (NmtState::BootUp, false) = (state, is_configuring) {
            self.forget_reference(bus, node);
        }
        let is_judged_later = self.on_silent_heartbeat(bus, node, state);
        let Some(peer) = self.peer(bus, node) else { return };
        peer.heard = now;
        let result = match state {
            _ if is_judged_later => Ok(()),
            _ if is_configuring => peer.startup.on_heartbeat(state, now),
            NmtState::Operational => Ok(()),
            NmtState::BootUp => Err(Fault::Rebooted { node }),
            state => Err(Fault::NotOperational { node, state }),
        };
        self.expect(result);
    }

    fn on_emergency(&mut self, bus: usize, emergency: Emergency, now: Nanoseconds) {
        if self.peer(bus, emergency.node).is_none() {
            return;
        }
        self.events.push(now, Event::Emergency(emergency));
        self.on_silent_emergency(bus, emergency);
        // With no error in the error register it is a warning.
        let is_error = emergency.code != 0 && emergency.register != 0;
        if is_error && !self.config.ignores(&emergency) && self.is_active() {
            self.raise(Fault::Emergency(emergency));
        }
    }

    fn on_process_data(&mut self, bus: usize, frame: &Frame) {
        let is_from = |at: usize, node: Node| (at, TPDO1 + u16::from(node)) == (bus, frame.id());
        if frame.kind() != FrameKind::Data {
            return;
        }
        for (i, drive) in self.config.drives.iter().enumerate() {
            let fields = (frame.array(0), frame.array(2));
            if let (true, (Some(status), Some(counts))) = (is_from(drive.bus, drive.node), fields) {
                let (monitor, status) = (&mut self.drives[i], u16::from_le_bytes(status));
                // Bits that belong to no state leave the last one standing.
                monitor.state = DriveState::of_status(status).or(monitor.state);
                monitor.encoder.receive(i32::from_le_bytes(counts));
                if let Some(torque) = frame.array(6) {
                    self.followers[i].receive(i16::from_le_bytes(torque), status);
                }
            }
        }
        for (cell, monitor) in self.config.load_cells.iter().zip(&mut self.cells) {
            if is_from(cell.bus, cell.node) {
                monitor.receive(cell.cell.read(frame, cell.byte));
            }
        }
    }

    /// A drive that started again may count from elsewhere.
    fn forget_reference(&mut self, bus: usize, node: Node) {
        let drives = self.config.drives.iter().zip(&mut self.drives);
        for (_, monitor) in drives.filter(|(drive, _)| (drive.bus, drive.node) == (bus, node)) {
            monitor.encoder.has_failed = true;
        }
    }
}
