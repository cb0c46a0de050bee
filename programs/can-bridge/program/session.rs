//! The loop: waits for the time of a cycle, lets the bridge compute, sends. Nothing here allocates after [`Session::new`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use cable_robot::robot::PerCable;
use cable_robot::sim::{ControllerModel, Goal};
use cable_robot_fieldbus::bridge::{Bridge, CycleReport, Identity, Refusal, TransportError};
use cable_robot_fieldbus::canopen::{TPDO1, sync};
use cable_robot_fieldbus::transport::{LinkError, Received, Transport, now};
use cable_robot_fieldbus::{Frame, FrameQueue, Nanoseconds, OperatorCommand, State};
use rtrb::Consumer;

use super::entry::{Cycle, Entry, Input, OnBus, Teller};
use super::goals::Timetable;
use super::real_time::sleep_until;

/// Frames that are read from a bus in a cycle: more than fit on it.
const MOST_FRAMES: usize = 1024;
/// Errors of links that are told in a cycle.
const MOST_ERRORS: usize = 96;
/// Cycles after the last, in which drives confirm that they are off; and in which the torque is cut off.
const LAST_CYCLES: u32 = 50;
const CUT_OFF_CYCLES: u32 = 3;

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// As asked, in safety.
    Asked,
    /// As asked, but there had been a fault, or the drives do not confirm that they are off.
    Faulted,
    /// With the torque cut off.
    CutOff,
}

/// Bridge, controller and links, and everybody who has a say.
pub struct Session<'a> {
    bridge: Bridge,
    controller: &'a mut dyn ControllerModel,
    links: Vec<Box<dyn Transport>>,
    teller: Teller,
    commands: Consumer<OperatorCommand>,
    /// How often signals asked for the end.
    stop: Arc<AtomicU32>,
    timetable: Timetable,
    /// Whether nothing is ever sent.
    is_dry: bool,
    /// Time 0 of the log, on the clock of [`now`].
    start: Nanoseconds,
    /// What links could not do since the last cycle.
    errors: Vec<(usize, TransportError, Option<Frame>)>,
    out: FrameQueue,
    /// When the first encoder's frame of this cycle came.
    encoder_at: Option<Nanoseconds>,
    /// When the next cycle is due, and how many before it were left out.
    due: Nanoseconds,
    missed: u64,
    /// The last command's.
    refusal: Option<Refusal>,
    is_stopping: bool,
    has_asked_to_end: bool,
    has_failed: bool,
    cycles_off: u32,
}

impl<'a> Session<'a> {
    /// Before its first cycle.
    pub fn new(
        bridge: Bridge,
        controller: &'a mut dyn ControllerModel,
        links: Vec<Box<dyn Transport>>,
        teller: Teller,
        commands: Consumer<OperatorCommand>,
        stop: Arc<AtomicU32>,
        goals: Vec<Goal>,
    ) -> Self {
        let (start, period) = (now(), bridge.config().period);
        Self {
            timetable: Timetable::new(goals, bridge.config()),
            is_dry: bridge.state() == State::Shadow,
            bridge,
            controller,
            links,
            teller,
            commands,
            stop,
            start,
            due: start + period,
            missed: 0,
            errors: Vec::with_capacity(MOST_ERRORS),
            out: FrameQueue::new(),
            encoder_at: None,
            refusal: None,
            is_stopping: false,
            has_asked_to_end: false,
            has_failed: false,
            cycles_off: 0,
        }
    }

    /// Runs until somebody ends it.
    pub fn run(&mut self) -> End {
        loop {
            if let Some(end) = self.once() {
                return end;
            }
        }
    }

    /// Who the drives said they are.
    pub fn drives(&self) -> PerCable<Identity> {
        self.bridge.identities()
    }

    /// Waits for the time of the next cycle, and goes through it. A failure of the program itself leads to the safe output; a second
    /// one, and a second signal, cut the torque off.
    pub fn once(&mut self) -> Option<End> {
        let signals = self.stop.load(Ordering::Relaxed);
        if signals > 1 {
            return Some(self.cut_off("a second signal: the torque is cut off"));
        }
        if signals == 1 && !self.is_stopping {
            self.is_stopping = true;
            self.note(
                "a signal: a platform that hangs is let down, then off; another one, later, cuts the torque off at once",
            );
        }
        let report = catch_unwind(AssertUnwindSafe(|| {
            self.receive_until(self.due);
            self.cycle()
        }));
        // Cycles that are over are left out, not made up for.
        let period = self.bridge.config().period;
        self.missed = now().saturating_sub(self.due) / period;
        self.due += (self.missed + 1) * period;
        match report {
            Ok(report) => self.end(&report),
            Err(_) if self.has_failed => {
                Some(self.cut_off("the program failed again: the torque is cut off"))
            }
            Err(_) => {
                (self.has_failed, self.is_stopping) = (true, true);
                self.note("the program failed: to the safe output, down, then off");
                None
            }
        }
    }

    fn end(&mut self, report: &CycleReport) -> Option<End> {
        if report.state != State::Off {
            return None;
        }
        self.cycles_off += 1;
        // The frames of the first cycle in Off are still to be answered.
        let is_confirmed = self.is_dry || self.cycles_off > CUT_OFF_CYCLES && self.bridge.is_off();
        let has_waited = self.cycles_off > LAST_CYCLES;
        if !is_confirmed && !has_waited {
            return None;
        }
        if !is_confirmed {
            self.note("the drives do not confirm that they are off");
        }
        Some(match (self.has_failed, report.fault) {
            (true, _) => End::CutOff,
            (false, None) if is_confirmed => End::Asked,
            (false, _) => End::Faulted,
        })
    }

    fn cycle(&mut self) -> CycleReport {
        let (began, missed) = (now(), self.missed);
        let (time, lateness) = (self.time(began), began.saturating_sub(self.due));
        for k in 0..self.errors.len() {
            let (bus, error, frame) = self.errors[k];
            self.teller.tell(Entry::Input(Input::Transport { bus, error, frame }, None));
            self.bridge.on_transport_error(bus, error);
        }
        self.errors.clear();
        if self.is_stopping && !self.has_asked_to_end {
            self.obey(OperatorCommand::Shutdown, time);
            self.has_asked_to_end = true;
        }
        // No more than wait now: who gives them faster is not waited for.
        for _ in 0..self.commands.slots() {
            if let Ok(command) = self.commands.pop() {
                self.obey(command, time);
            }
        }
        if let Some(goal) = self.timetable.due(self.bridge.state(), time) {
            self.obey(OperatorCommand::Goal(goal), time);
        }
        let report = self.bridge.cycle(time, self.controller, &mut self.out);
        let latency = self.send();
        self.teller.tell(Entry::Cycle(Cycle { report, lateness, latency, missed }));
        while let Some((time, event)) = self.bridge.take_event() {
            self.teller.tell(Entry::Event(time, event));
        }
        report
    }

    fn obey(&mut self, command: OperatorCommand, time: Nanoseconds) {
        let refusal = self.bridge.operator(command, time).err();
        self.teller.tell(Entry::Input(Input::Operator(command), refusal));
        // What is asked again and again, as a dead man's button does, is refused once.
        if let Some(refusal) = refusal.filter(|refusal| self.refusal != Some(*refusal)) {
            self.teller.tell(Entry::Refused(time, refusal));
        }
        self.refusal = refusal;
    }

    /// Sends what the bridge put out. The time from the first encoder's frame to the last torque's.
    fn send(&mut self) -> Option<Nanoseconds> {
        if self.is_dry {
            return None;
        }
        let mut has_torque = false;
        for k in 0..self.out.frames().len() {
            let (bus, frame) = self.out.frames()[k];
            match self.links[bus].send(&frame) {
                Ok(()) => {
                    let time = self.time(now());
                    self.teller.tell(Entry::Sent(OnBus { bus, time, frame }));
                    has_torque |=
                        self.bridge.config().drives.iter().any(|drive| drive.torque_frame.id == frame.id());
                }
                Err(error) => self.fail(bus, error, Some(frame)),
            }
        }
        let since = self.encoder_at.take()?;
        has_torque.then(|| now().saturating_sub(since))
    }

    /// Takes in what comes until `due`.
    fn receive_until(&mut self, due: Nanoseconds) {
        for bus in 0..self.links.len() {
            // One bus is waited at, from the others what has come meanwhile is taken.
            let until = if bus == 0 { due } else { 0 };
            for _ in 0..MOST_FRAMES {
                match self.links[bus].receive(until) {
                    Ok(Some(received)) => self.take_in(bus, &received),
                    Ok(None) => break,
                    Err(error) => {
                        self.fail(bus, error, None);
                        break;
                    }
                }
            }
        }
        sleep_until(due);
    }

    fn take_in(&mut self, bus: usize, received: &Received) {
        let (time, frame) = (self.time(received.time), received.frame);
        let is_encoder =
            |id: u16| self.bridge.config().drives.iter().any(|d| id == TPDO1 + u16::from(d.node));
        if self.encoder_at.is_none() && is_encoder(frame.id()) {
            self.encoder_at = Some(received.time);
        }
        self.teller.tell(Entry::Received(OnBus { bus, time, frame }));
        self.bridge.on_frame(bus, &frame, time);
    }

    fn fail(&mut self, bus: usize, error: LinkError, frame: Option<Frame>) {
        let error = match error {
            LinkError::Down => TransportError::Down,
            LinkError::BufferFull | LinkError::ErrorFrame => TransportError::NoRoom,
            LinkError::Removed | LinkError::Other(_) => TransportError::Gone,
        };
        if self.errors.len() < MOST_ERRORS {
            self.errors.push((bus, error, frame));
        }
    }

    /// Voltage off, at once and without the bridge.
    fn cut_off(&mut self, why: &'static str) -> End {
        self.note(why);
        let period = self.bridge.config().period;
        // Before that the drives are somebody else's.
        for _ in 0..if self.bridge.has_spoken() { CUT_OFF_CYCLES } else { 0 } {
            for (bus, id, slots) in self.bridge.config().torque_frames() {
                // A control word of 0 and no torque.
                let bytes = 2 + 2 * slots.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
                let frame = Frame::new(cable_robot_fieldbus::frame::FrameKind::Data, id, &[0; 8][..bytes]);
                frame.into_iter().for_each(|frame| _ = self.links[bus].send(&frame));
            }
            self.links.iter_mut().for_each(|link| _ = link.send(&sync()));
            sleep_until(now() + period);
        }
        End::CutOff
    }

    fn note(&mut self, text: &'static str) {
        let time = self.time(now());
        self.teller.tell(Entry::Note(time, text));
    }

    /// Since the start, in whole microseconds: what candump's format keeps.
    fn time(&self, clock: Nanoseconds) -> Nanoseconds {
        clock.saturating_sub(self.start) / 1000 * 1000
    }
}
