//! A simulated CiA 402 drive in cyclic synchronous torque mode.

use super::node::{SimulatedNode, Task};
use crate::Nanoseconds;
use crate::canopen::{NmtState, Object, Value};
use crate::cia402::{
    CONTROL_WORD, CYCLIC_TORQUE, DRIVE_PROFILE, DriveState, MAX_TORQUE, MODE, MODE_DISPLAY, POSITION,
    STATUS_WORD, TARGET_TORQUE, TORQUE, Winch, control, status,
};
use crate::config::{Action, Config};
use crate::frame::Frame;

/// Emergency code when the master's heartbeat is missing.
const HEARTBEAT_ERROR: u16 = 0x8130;
/// Emergency code when it is stopped while it pulls.
const COMMUNICATION_ERROR: u16 = 0x8100;
/// Emergency code when its torque frames are missing.
const RECEIVE_ERROR: u16 = 0x8250;
/// How long a quick stop takes.
const QUICK_STOP_TIME: Nanoseconds = 50_000_000;
/// Voltage bit of the status word.
const VOLTAGE: u16 = 0x0010;

/// What may be wrong with a drive, beside its node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveFaults {
    /// 0x6061 never shows what 0x6060 asks for.
    pub refuses_mode: bool,
    /// 0x6061 shows 0 until the drive is in Operation enabled.
    pub hides_mode: bool,
    /// The encoder's value stays what it is.
    pub is_encoder_frozen: bool,
    /// The encoder's value is off by so many counts.
    pub encoder_error: i32,
    /// The encoder counts against the torque.
    pub counts_backwards: bool,
    /// No process data.
    pub is_silent: bool,
    /// The torque stays what it is, whatever is commanded.
    pub ignores_torque: bool,
    /// An internal limit holds back half of the torque.
    pub is_limited: bool,
    /// Somebody else commands it.
    pub is_local: bool,
    /// It goes on when its master and its torque frames are missing.
    pub ignores_watchdog: bool,
    /// Its power stage takes so long to switch on, and as long to enable, in ns.
    pub slow_stage: Nanoseconds,
    /// It boots anew when its master is missing.
    pub boots_without_master: bool,
    /// Its hardware enable is taken away: no higher than Switched on.
    pub is_blocked: bool,
}

/// A drive and the motor on it.
#[derive(Clone, Debug)]
pub struct SimulatedDrive {
    /// Its communication.
    pub node: SimulatedNode,
    /// What is wrong with it.
    pub faults: DriveFaults,
    winch: Winch,
    state: DriveState,
    word: u16,
    target: i16,
    /// Received, to be used at the next SYNC.
    waiting: Option<(u16, i16)>,
    /// When the target was taken over.
    commanded: Nanoseconds,
    stopping_since: Nanoseconds,
    /// Since when its power stage is on its way up.
    rising_since: Option<Nanoseconds>,
    counts: i32,
    /// What its motor gives, behind what it is to give by the motors' lag, ‰ of the rated torque.
    actual: f64,
}

impl SimulatedDrive {
    /// The drive of a cable, as the fieldbus file describes it.
    pub(super) fn new(config: &Config, cable: usize) -> Self {
        let drive = &config.drives[cable];
        let mut objects = vec![
            (Object::new(0x1000, 0), Value::u32(0x0002_0000 | u32::from(DRIVE_PROFILE)), false),
            // Vendor (none of those that are assigned), product, revision, serial number.
            (Object::new(0x1018, 1), Value::u32(0), false),
            (Object::new(0x1018, 2), Value::u32(402), false),
            (Object::new(0x1018, 3), Value::u32(1), false),
            (Object::new(0x1018, 4), Value::u32(1000 + u32::from(drive.node)), false),
            (CONTROL_WORD, Value::u16(0), true),
            (STATUS_WORD, Value::u16(0), false),
            (MODE, Value::u8(0), true),
            (MODE_DISPLAY, Value::u8(0), false),
            (POSITION, Value::u32(0), false),
            (TARGET_TORQUE, Value::u16(0), true),
            (MAX_TORQUE, Value::u16(1000), true),
            (TORQUE, Value::u16(0), false),
        ];
        for setting in config.drive_objects.iter().filter(|setting| setting.is_of(drive.node)) {
            let is_writable = setting.action == Action::Write;
            let bits = if is_writable { 0 } else { setting.value.bits };
            objects.push((setting.object, Value { bits, ..setting.value }, is_writable));
        }
        Self {
            node: SimulatedNode::new(drive.node, &objects),
            faults: DriveFaults::default(),
            winch: drive.winch,
            state: DriveState::SwitchOnDisabled,
            word: 0,
            target: 0,
            waiting: None,
            commanded: 0,
            stopping_since: 0,
            rising_since: None,
            counts: 0,
            actual: 0.0,
        }
    }

    /// State of its power section.
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// What its motor is to pull, N; below 0 it pays out.
    pub fn tension(&self) -> f64 {
        self.winch.tension(self.torque())
    }

    /// Lets the motor follow for `h` seconds, behind by this time constant (s).
    pub(super) fn turn(&mut self, h: f64, lag: f64) {
        if h > 0.0 {
            self.actual += h / (h + lag) * (f64::from(self.torque()) - self.actual);
        }
    }

    /// Shows another mode of operation than the one asked for.
    pub(super) fn leave_mode(&mut self, mode: i8) {
        self.node.set(MODE_DISPLAY, u32::from(mode as u8));
    }

    fn torque(&self) -> i16 {
        let follows = self.state == DriveState::OperationEnabled
            && self.node.get(MODE_DISPLAY) == u32::from(CYCLIC_TORQUE)
            && !self.node.faults.is_dead;
        let most = i16::try_from(self.node.get(MAX_TORQUE)).unwrap_or(i16::MAX);
        let most = if self.faults.is_limited { self.target.abs() / 2 } else { most };
        if follows { self.target.clamp(-most, most) } else { 0 }
    }

    fn status(&self) -> u16 {
        let is_enabled = self.state == DriveState::OperationEnabled;
        let follows = is_enabled && self.node.get(MODE_DISPLAY) == u32::from(CYCLIC_TORQUE);
        let bit = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
        self.state.status()
            | VOLTAGE
            | bit(!self.faults.is_local, status::REMOTE)
            | bit(is_enabled && self.faults.is_limited, status::INTERNAL_LIMIT)
            | bit(follows && !self.faults.ignores_torque, status::FOLLOWS)
    }

    /// For how long its motor has pulled what it pulls without a newer command; 0 if it does not pull.
    pub(super) fn command_age(&self, now: Nanoseconds) -> Nanoseconds {
        if self.torque() == 0 { 0 } else { now.saturating_sub(self.commanded) }
    }

    /// Fails with an emergency message.
    pub fn fail(&mut self, code: u16, out: &mut Vec<Frame>) {
        if self.state != DriveState::Fault {
            self.state = DriveState::Fault;
            self.node.emergency(code, out);
        }
    }

    /// Starts again, as after a dip of its supply.
    pub fn reboot(&mut self, now: Nanoseconds) {
        self.node.reboot(now);
        self.forget();
    }

    fn forget(&mut self) {
        (self.word, self.target, self.waiting) = (0, 0, None);
        if self.state != DriveState::Fault {
            self.state = DriveState::SwitchOnDisabled;
        }
    }

    /// Where the motor is.
    pub(super) fn turn_to(&mut self, counts: i32) {
        if !self.faults.is_encoder_frozen {
            let counts = if self.faults.counts_backwards { counts.wrapping_neg() } else { counts };
            self.counts = counts.wrapping_add(self.faults.encoder_error);
        }
    }

    pub(super) fn on_frame(&mut self, frame: &Frame, now: Nanoseconds, out: &mut Vec<Frame>) {
        // Whoever asks reads it as it is now; process data have that of the last SYNC.
        self.node.set(STATUS_WORD, self.status().into());
        match self.node.on_frame(frame, now, out) {
            Some(Task::Receive(frame)) => self.receive(&frame),
            Some(Task::Sync) => self.synchronise(now, out),
            Some(Task::Written(MODE, mode)) if !self.faults.refuses_mode && !self.faults.hides_mode => {
                self.node.set(MODE_DISPLAY, mode.bits)
            }
            Some(Task::Reset) => self.forget(),
            Some(Task::Written(..)) | None => {}
        }
    }

    fn receive(&mut self, frame: &Frame) {
        let Some(objects) = self.node.received(frame) else { return };
        let (mut word, mut target) = self.waiting.unwrap_or((self.word, self.target));
        for (object, bits) in objects {
            match object {
                CONTROL_WORD => word = bits as u16,
                TARGET_TORQUE => target = bits as u16 as i16,
                _ => {}
            }
        }
        self.waiting = Some((word, target));
    }

    fn synchronise(&mut self, now: Nanoseconds, out: &mut Vec<Frame>) {
        if let Some((word, target)) = self.waiting.take() {
            if !self.faults.is_local {
                self.obey(word, now);
            }
            if !self.faults.ignores_torque && !self.faults.is_local {
                self.target = target;
            }
            self.commanded = now;
        }
        if self.faults.hides_mode {
            let is_enabled = self.state == DriveState::OperationEnabled;
            self.node.set(MODE_DISPLAY, if is_enabled { self.node.get(MODE) } else { 0 });
        }
        self.node.set(STATUS_WORD, self.status().into());
        self.node.set(POSITION, self.counts as u32);
        self.node.set(TORQUE, self.actual.round() as i16 as u16 as u32);
        if !self.faults.is_silent {
            out.extend(self.node.transmit());
        }
    }

    /// The transitions of CiA 402.
    fn obey(&mut self, word: u16, now: Nanoseconds) {
        use DriveState::*;
        let reset_rises = word & !self.word & control::FAULT_RESET != 0;
        self.word = word;
        let (voltage, quick_stop) = (word & 0b0010 != 0, word & 0b0100 == 0);
        let next = match (self.state, word & 0b1111) {
            (Fault, _) if reset_rises => SwitchOnDisabled,
            (Fault | FaultReactionActive | NotReadyToSwitchOn, _) => self.state,
            (_, _) if !voltage => SwitchOnDisabled,
            (OperationEnabled, _) if quick_stop => {
                self.stopping_since = now;
                QuickStopActive
            }
            (QuickStopActive, _) => QuickStopActive,
            (_, _) if quick_stop => SwitchOnDisabled,
            (SwitchOnDisabled | SwitchedOn | OperationEnabled, 0b0110) => ReadyToSwitchOn,
            (ReadyToSwitchOn | OperationEnabled, 0b0111) => SwitchedOn,
            (SwitchedOn | OperationEnabled, 0b1111) if self.faults.is_blocked => SwitchedOn,
            (SwitchedOn, 0b1111) => OperationEnabled,
            (state, _) => state,
        };
        let rises =
            matches!((self.state, next), (ReadyToSwitchOn, SwitchedOn) | (SwitchedOn, OperationEnabled));
        let begun = *self.rising_since.get_or_insert(now);
        if rises && now.saturating_sub(begun) < self.faults.slow_stage {
            return;
        }
        (self.state, self.rising_since) = (next, None);
    }

    pub(super) fn tick(&mut self, now: Nanoseconds, out: &mut Vec<Frame>) {
        self.node.tick(now, out);
        let misses_frames = self.node.misses_frames(now);
        let has_lost_master = self.node.has_lost_master(now);
        if has_lost_master {
            self.node.miss_master();
        }
        if self.faults.boots_without_master && has_lost_master && self.state == DriveState::OperationEnabled {
            return self.reboot(now);
        }
        if self.state == DriveState::OperationEnabled {
            if self.faults.ignores_watchdog {
                return;
            }
            if misses_frames {
                self.fail(RECEIVE_ERROR, out);
            }
            if has_lost_master {
                self.fail(HEARTBEAT_ERROR, out);
            } else if self.node.state() == NmtState::Stopped {
                self.fail(COMMUNICATION_ERROR, out);
            }
        }
        let has_stopped = now.saturating_sub(self.stopping_since) > QUICK_STOP_TIME;
        if self.state == DriveState::QuickStopActive && has_stopped {
            self.state = DriveState::SwitchOnDisabled;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::{AKD, parse};
    use DriveState::*;

    #[test]
    fn states_follow_the_control_word() {
        let mut drive = SimulatedDrive::new(&parse(AKD).unwrap(), 0);
        let mut after = |word| {
            drive.obey(word, 0);
            drive.state
        };
        assert_eq!(
            [0x0F, 0x07, 0x06, 0x0F].map(&mut after),
            [SwitchOnDisabled, SwitchOnDisabled, ReadyToSwitchOn, ReadyToSwitchOn]
        );
        assert_eq!(
            [0x07, 0x0F, 0x0F, 0x06].map(&mut after),
            [SwitchedOn, OperationEnabled, OperationEnabled, ReadyToSwitchOn]
        );
        assert_eq!(
            [0x07, 0x0F, 0x02, 0x0F, 0x00].map(&mut after),
            [SwitchedOn, OperationEnabled, QuickStopActive, QuickStopActive, SwitchOnDisabled]
        );
        drive.state = Fault;
        let mut after = |word| {
            drive.obey(word, 0);
            drive.state
        };
        assert_eq!(
            [0x06, 0x0F, 0x80, 0x80].map(&mut after),
            [Fault, Fault, SwitchOnDisabled, SwitchOnDisabled]
        );
    }
}
