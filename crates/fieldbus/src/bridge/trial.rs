//! Trials on the stand, in a survey only: one motor pulls a little; all drives lose the bridge; the platform is weighed. While nothing hangs on them, what encoders and
//! load cells say is not judged.

use super::weigh::Lift;
use super::{Bridge, Cause, Event, Fault, FrameQueue, Mode, Refusal};
use crate::Nanoseconds;
use crate::canopen::emergency::text;
use crate::canopen::{Emergency, NmtCommand, NmtState, Node, SdoRequest, SdoResponse, SdoResult};
use crate::cia402::{DriveState, STATUS_WORD};
use cable_robot::robot::PerCable;
use std::fmt;

/// A pull ends when a cable has moved by this share of `slack.most`.
const TRAVEL: f64 = 0.1;
/// A platform is weighed at this share of `slack.most` above its stand.
pub(super) const LIFT: f64 = 0.4;
/// Silence lasts so many times as long as the drives' watchdog.
const SILENCE: u64 = 2;
/// A status word is asked for so often, once a `timeouts.service`.
const QUESTIONS: u64 = 3;

/// What is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Trial {
    /// One drive pulls, from nothing to at most the pretension within a quarter of `slack.ramp`; the others are off.
    Pull {
        /// From 0.
        cable: usize,
        /// When the operator asked for it last.
        given: Nanoseconds,
        /// When the drive was led up, and all lengths then, m.
        begun: Option<(Nanoseconds, PerCable<f64>)>,
        since: Nanoseconds,
    },
    /// The mean of what load cells say of slack cables; no drive is on.
    Zero {
        since: Nanoseconds,
        /// N, of so many cycles.
        sum: PerCable<f64>,
        cycles: u32,
    },
    /// From Ready: the platform is lifted a little.
    Weigh {
        given: Nanoseconds,
        /// Of its weight that is carried.
        share: f64,
        lift: Lift,
    },
    /// All drives are led up, without torque.
    WatchdogUp { since: Nanoseconds },
    /// Nothing is sent, as if the bridge had been killed.
    Silence { since: Nanoseconds, found: PerCable<AfterSilence> },
    /// The drives are asked for their status words; nothing else is sent still.
    Asking { since: Nanoseconds, asked: Option<Nanoseconds>, found: PerCable<AfterSilence> },
}

/// What a drive did when the bridge was silent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AfterSilence {
    /// Its status word (0x6041), asked for by SDO.
    pub status: Option<u16>,
    /// Of its last heartbeat since the silence began.
    pub nmt: Option<NmtState>,
    /// The last since then.
    pub emergency: Option<Emergency>,
}

impl AfterSilence {
    /// Whether it would go on pulling: bits that belong to no state say nothing to the contrary.
    fn pulls(&self) -> bool {
        let state = self.status.and_then(DriveState::of_status);
        state.is_none_or(|state| state == DriveState::OperationEnabled)
    }
}

impl fmt::Display for AfterSilence {
    /// State, NMT state and emergency message in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.status.and_then(DriveState::of_status), self.status) {
            (Some(state), _) => write!(f, "\"{state}\""),
            (None, Some(status)) => write!(f, "no state (status word 0x{status:04X})"),
            (None, None) => f.write_str("no state"),
        }?;
        match self.nmt {
            Some(nmt) => write!(f, ", NMT {nmt}"),
            None => f.write_str(", no heartbeat"),
        }?;
        match self.emergency {
            Some(Emergency { code, register, .. }) => {
                write!(f, ", EMCY 0x{code:04X} ({}), error register 0x{register:02X}", text(code))
            }
            None => f.write_str(", no EMCY"),
        }
    }
}

impl Trial {
    /// Whether the bridge is to seem dead.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Silence { .. } | Self::Asking { .. })
    }

    /// Whether the platform may hang on its cables, so that everything is watched as in Ready.
    pub fn is_lift(&self) -> bool {
        matches!(self, Self::Weigh { .. })
    }

    /// Whether drives are to be in Operation enabled, those of these cables among them.
    pub fn leads_up(&self, cables: impl IntoIterator<Item = usize>) -> bool {
        match self {
            Self::Pull { cable, .. } => cables.into_iter().any(|i| i == *cable),
            Self::WatchdogUp { .. } | Self::Weigh { .. } => true,
            Self::Zero { .. } | Self::Silence { .. } | Self::Asking { .. } => false,
        }
    }
}

impl Bridge {
    /// The motor of a cable (from 0) is to pull; asked again and again while it may.
    pub(super) fn pull(&mut self, cable: usize, now: Nanoseconds) -> Result<(), Refusal> {
        match &mut self.mode {
            Mode::Trying(Trial::Pull { cable: pulling, given, .. }) if *pulling == cable => *given = now,
            _ if self.is_home_stale => return Err(Refusal::StillPressed),
            _ => {
                self.may_be_led_up(cable).map_err(Refusal::NotYet)?;
                self.reactions[cable].begin();
                self.enter(Mode::Trying(Trial::Pull { cable, given: now, begun: None, since: now }));
            }
        }
        Ok(())
    }

    /// What load cells say while a person says that every cable is slack.
    pub(super) fn zero(&mut self, now: Nanoseconds) -> Result<(), Refusal> {
        let silent = (0..self.cables()).find(|i| !self.cells[*i].is_alive(&self.config.limits));
        if let Some(i) = silent {
            return Err(Refusal::NotYet(Fault::LoadCellSilent { cable: i + 1 }));
        }
        let sum = PerCable::filled(self.cables(), 0.0);
        self.enter(Mode::Trying(Trial::Zero { since: now, sum, cycles: 0 }));
        Ok(())
    }

    /// Whether the drives stop by themselves when the bridge is gone.
    pub(super) fn try_watchdog(&mut self, now: Nanoseconds) -> Result<(), Refusal> {
        (0..self.cables()).try_for_each(|cable| self.may_be_led_up(cable)).map_err(Refusal::NotYet)?;
        self.enter(Mode::Trying(Trial::WatchdogUp { since: now }));
        Ok(())
    }

    /// Whether this drive has hauled its own cable in, as its encoder says.
    pub(super) fn is_direction_known(&self, cable: usize) -> bool {
        self.proved[cable] == Some(self.peers[cable].startup.identity())
    }

    pub(super) fn may_be_led_up(&self, cable: usize) -> Result<(), Fault> {
        let (drive, node) = (&self.drives[cable], self.config.drives[cable].node);
        match drive.state {
            _ if !drive.encoder.is_alive(&self.config.limits) => {
                Err(Fault::EncoderSilent { cable: cable + 1 })
            }
            Some(state) if state.is_faulted() => Err(Fault::DriveFault { node, state }),
            _ => Ok(()),
        }
    }

    /// What a trial pulls, N.
    pub(super) fn trial_pull(&self, trial: &Trial) -> PerCable<f64> {
        let mut tension = PerCable::filled(self.cables(), 0.0);
        if let Trial::Weigh { share, .. } = *trial {
            return self.weighing_pull(share);
        }
        if let Trial::Pull { cable, begun: Some((begun, _)), .. } = *trial {
            tension[cable] = self.config.slack.pretension * self.share(begun, self.config.slack.ramp / 4);
        }
        tension
    }

    /// The trial of this cycle.
    pub(super) fn try_out(&mut self, trial: Trial, out: &mut FrameQueue) {
        let waits = |since: Nanoseconds| self.time.saturating_sub(since);
        match trial {
            Trial::Pull { given, .. } if waits(given) > self.config.timeouts.enable => {
                self.is_home_stale = true;
                self.switch_off(Cause::EnableExpired);
            }
            Trial::Pull { cable, given, begun: None, since } => {
                if self.drives[cable].state == Some(DriveState::OperationEnabled) {
                    if let Some(fault) = self.slow_drive(cable..=cable) {
                        return self.fail(fault);
                    }
                    let begun = Some((self.time, self.lengths()));
                    self.mode = Mode::Trying(Trial::Pull { cable, given, begun, since });
                } else if waits(since) > self.config.timeouts.drive {
                    self.fail_drive_stuck(cable);
                }
            }
            Trial::Pull { cable, begun: Some((begun, from)), .. } => self.watch_pull(cable, begun, &from),
            Trial::Zero { since, sum, cycles } => {
                let sum = PerCable::from_fn(self.cables(), |i| sum[i] + self.cells[i].tension());
                let cycles = cycles + 1;
                if waits(since) < self.config.slack.ramp / 4 {
                    self.mode = Mode::Trying(Trial::Zero { since, sum, cycles });
                } else {
                    self.events.push(self.time, Event::Zeroed(sum.map(|sum| sum / f64::from(cycles))));
                    self.enter(Mode::Homing { since: self.time });
                }
            }
            Trial::Weigh { given, share, lift } => self.lift(given, share, lift),
            Trial::WatchdogUp { since } => {
                let is_up = |i: &usize| self.drives[*i].state == Some(DriveState::OperationEnabled);
                match (0..self.cables()).find(|i| !is_up(i)) {
                    None => {
                        let found = PerCable::filled(self.cables(), AfterSilence::default());
                        self.mode = Mode::Trying(Trial::Silence { since: self.time, found });
                    }
                    Some(i) if waits(since) > self.config.timeouts.drive => self.fail_drive_stuck(i),
                    Some(_) => {}
                }
            }
            Trial::Silence { since, found } => {
                if waits(since) >= SILENCE * self.config.heartbeat.drive_watchdog {
                    self.mode = Mode::Trying(Trial::Asking { since: self.time, asked: None, found });
                }
            }
            Trial::Asking { since, asked, found } => self.ask_for_status(since, asked, found, out),
        }
    }

    /// Ends a pull that has moved something, or cannot.
    fn watch_pull(&mut self, cable: usize, begun: Nanoseconds, from: &PerCable<f64>) {
        let lengths = self.lengths();
        let came_in = PerCable::from_fn(self.cables(), |i| from[i] - lengths[i]);
        let has_moved = came_in.iter().any(|way| way.abs() >= TRAVEL * self.config.slack.most);
        let is_fast = self.drives[cable].encoder.rate.abs() > self.config.limits.cable_speed;
        if has_moved || is_fast || self.time.saturating_sub(begun) > self.config.slack.ramp / 4 {
            let is_own = has_moved && came_in.iter().all(|way| way.abs() <= came_in[cable]);
            self.proved[cable] = is_own.then(|| self.peers[cable].startup.identity());
            self.events.push(self.time, Event::Pulled { cable, tension: self.commanded[cable], came_in });
            self.is_home_stale = true;
            self.enter(Mode::Homing { since: self.time });
        }
    }

    fn ask_for_status(
        &mut self,
        since: Nanoseconds,
        asked: Option<Nanoseconds>,
        found: PerCable<AfterSilence>,
        out: &mut FrameQueue,
    ) {
        let service = self.config.timeouts.service;
        let Some(missing) = (0..self.cables()).find(|i| found[*i].status.is_none()) else {
            return self.judge_watchdog(found);
        };
        if self.time.saturating_sub(since) > QUESTIONS * service {
            let node = self.config.drives[missing].node;
            return self.fail(Fault::NoAnswer { node, object: STATUS_WORD });
        }
        if asked.is_none_or(|asked| self.time.saturating_sub(asked) > service) {
            for i in (0..self.cables()).filter(|i| found[*i].status.is_none()) {
                let drive = &self.config.drives[i];
                // Who stopped itself (0x1029) answers no question.
                if found[i].nmt == Some(NmtState::Stopped) {
                    out.push(drive.bus, NmtCommand::EnterPreOperational.frame(Some(drive.node)));
                }
                out.push(drive.bus, SdoRequest::Read(STATUS_WORD).frame(drive.node));
            }
            self.mode = Mode::Trying(Trial::Asking { since, asked: Some(self.time), found });
        }
    }

    /// A drive that still is in Operation enabled would go on pulling. The others have faulted, and are set up anew.
    fn judge_watchdog(&mut self, found: PerCable<AfterSilence>) {
        self.events.push(self.time, Event::WatchdogTried(found));
        match (0..self.cables()).find(|i| found[*i].pulls()) {
            Some(i) => {
                self.fail(Fault::WatchdogIgnored { node: self.config.drives[i].node, found: found[i] })
            }
            None => {
                self.events.push(self.time, Event::WatchdogProved);
                self.reset();
            }
        }
    }

    /// What is known of a drive while the bridge is silent.
    fn after_silence(&mut self, bus: usize, node: Node) -> Option<&mut AfterSilence> {
        let i = self.config.drives.iter().position(|drive| (drive.bus, drive.node) == (bus, node))?;
        match &mut self.mode {
            Mode::Trying(Trial::Silence { found, .. } | Trial::Asking { found, .. }) => Some(&mut found[i]),
            _ => None,
        }
    }

    /// Takes in a heartbeat. Whether that is all: a drive may leave Operational, or start again, when nobody commands it.
    pub(super) fn on_silent_heartbeat(&mut self, bus: usize, node: Node, state: NmtState) -> bool {
        let Some(found) = self.after_silence(bus, node) else { return false };
        // Who stopped itself and is then told to answer does the rest as it is told.
        if found.nmt != Some(NmtState::Stopped) || state == NmtState::BootUp {
            found.nmt = Some(state);
        }
        true
    }

    /// Takes in an emergency message.
    pub(super) fn on_silent_emergency(&mut self, bus: usize, emergency: Emergency) {
        let found = self.after_silence(bus, emergency.node);
        found.into_iter().for_each(|found| found.emergency = Some(emergency));
    }

    /// Takes in a status word that was asked for.
    pub(super) fn on_status(&mut self, bus: usize, node: Node, response: &SdoResponse) {
        let status = match response.result {
            SdoResult::Value(value) => value.bits as u16,
            SdoResult::Unsized([low, high, ..]) => u16::from_le_bytes([low, high]),
            SdoResult::Written | SdoResult::Segmented(_) | SdoResult::Aborted(_) => return,
        };
        let is_asking = matches!(self.mode, Mode::Trying(Trial::Asking { .. }));
        if response.object == STATUS_WORD && is_asking {
            self.after_silence(bus, node).into_iter().for_each(|found| found.status = Some(status));
        }
    }
}
