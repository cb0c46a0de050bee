//! The bridge with its controller as a node: its cycles run at the period of the fieldbus file.

use super::{Notice, Port, ROUNDING, Received, ports};
use crate::bridge::{CycleReport, Event, TransportError};
use crate::config::Config;
use crate::frame::{FrameKind, error_class};
use crate::{Bridge, Frame, FrameQueue, LibraryController, Nanoseconds, OperatorCommand, State};
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::Pose;

/// What the operator holds pressed, and where the platform shall go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// The controller may pull.
    pub enable: bool,
    /// The platform stands at the home pose: asked again until the bridge takes it.
    pub home: bool,
    /// Set up everything anew, when it is pressed.
    pub reset: bool,
    /// A change while the bridge is enabled sends the platform there; what is enabled anew stays where it is.
    pub goal: Pose,
}

/// Bridge, controller and buses.
#[derive(Debug)]
pub struct ControllerNode {
    bridge: Bridge,
    controller: LibraryController,
    ports: Vec<Port>,
    out: FrameQueue,
    /// Of the last cycle.
    last: Wishes,
    next_cycle: Nanoseconds,
    report: Option<CycleReport>,
}

impl ControllerNode {
    /// Switched on at time 0; its first cycle is a period later.
    pub fn new(config: Config, parameters: ControllerParameters) -> Self {
        let nothing = Wishes { enable: false, home: false, reset: false, goal: config.home };
        Self {
            controller: LibraryController::new(parameters),
            ports: ports(&config),
            out: FrameQueue::new(),
            last: nothing,
            next_cycle: config.period,
            report: None,
            bridge: Bridge::new(config),
        }
    }

    /// What it was made from.
    pub fn config(&self) -> &Config {
        self.bridge.config()
    }

    /// What it is doing.
    pub fn state(&self) -> State {
        self.bridge.state()
    }

    /// Of the last cycle; `None` before the first.
    pub fn report(&self) -> Option<&CycleReport> {
        self.report.as_ref()
    }

    /// The next thing to log, with its time.
    pub fn take_event(&mut self) -> Option<(Nanoseconds, Event)> {
        self.bridge.take_event()
    }

    /// Its buses, in the order of the fieldbus file.
    pub fn ports(&mut self) -> &mut [Port] {
        &mut self.ports
    }

    /// Takes in the operations that a bus brings at `now`, and tells of what is odd.
    pub fn receive(&mut self, bus: usize, bytes: &[u8], now: Nanoseconds, tell: &mut dyn FnMut(Notice)) {
        let bridge = &mut self.bridge;
        self.ports[bus].receive(bytes, &mut |received| match received {
            Received::Frame(frame) => bridge.on_frame(bus, &frame, now),
            Received::BusOff => {
                let off = Frame::new(FrameKind::Error, error_class::BUS_OFF, &[0; 8]);
                off.iter().for_each(|frame| bridge.on_frame(bus, frame, now));
            }
            Received::Notice(notice) => tell(notice),
        });
    }

    /// The cycles that are due until `until`, with what was received before.
    pub fn step(&mut self, until: Nanoseconds, wishes: &Wishes) {
        let period = self.bridge.config().period;
        while self.next_cycle <= until + period / ROUNDING {
            self.cycle(self.next_cycle, wishes);
            self.next_cycle += period;
        }
    }

    fn cycle(&mut self, now: Nanoseconds, wishes: &Wishes) {
        self.obey(now, wishes);
        self.report = Some(self.bridge.cycle(now, &mut self.controller, &mut self.out));
        for &(bus, frame) in self.out.frames() {
            match self.ports[bus].send(frame) {
                // The bridge knows already that it is off.
                Ok(()) | Err(TransportError::Down) => {}
                Err(error) => self.bridge.on_transport_error(bus, error),
            }
        }
    }

    /// What the bridge refuses now is asked again in the next cycle, or has no effect, as at the rig.
    fn obey(&mut self, now: Nanoseconds, wishes: &Wishes) {
        let last = std::mem::replace(&mut self.last, *wishes);
        let mut ask = |command| _ = self.bridge.operator(command, now);
        if wishes.reset && !last.reset {
            ask(OperatorCommand::Reset);
        }
        if wishes.home {
            ask(OperatorCommand::Home);
        }
        match (wishes.enable, last.enable) {
            (true, _) => ask(OperatorCommand::Enable),
            (false, true) => ask(OperatorCommand::Release),
            (false, false) => {}
        }
        if wishes.goal != last.goal {
            ask(OperatorCommand::Goal(wishes.goal));
        }
    }
}
