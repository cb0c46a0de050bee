//! CiA 402: the state machine of a drive, seen from the master, and the scaling between a cable and its motor.

use std::f64::consts::TAU;
use std::fmt;

use super::canopen::Object;

/// Control word.
pub const CONTROL_WORD: Object = Object::new(0x6040, 0);
/// Status word.
pub const STATUS_WORD: Object = Object::new(0x6041, 0);
/// Modes of operation: what is asked for.
pub const MODE: Object = Object::new(0x6060, 0);
/// Modes of operation display: what the drive does.
pub const MODE_DISPLAY: Object = Object::new(0x6061, 0);
/// Position actual value, counts.
pub const POSITION: Object = Object::new(0x6064, 0);
/// Target torque, per mille of the rated torque.
pub const TARGET_TORQUE: Object = Object::new(0x6071, 0);
/// Max torque, per mille of the rated torque.
pub const MAX_TORQUE: Object = Object::new(0x6072, 0);
/// Torque actual value, per mille of the rated torque.
pub const TORQUE: Object = Object::new(0x6077, 0);
/// Cyclic synchronous torque.
pub const CYCLIC_TORQUE: u8 = 10;
/// Device type 0x1000 of a drive, lower half.
pub const DRIVE_PROFILE: u16 = 402;

/// State of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveState {
    /// Starting.
    NotReadyToSwitchOn,
    /// No high voltage may be applied.
    SwitchOnDisabled,
    /// High voltage may be applied.
    ReadyToSwitchOn,
    /// High voltage on, no torque.
    SwitchedOn,
    /// Follows its commands.
    OperationEnabled,
    /// Stopping, or stopped, by a quick stop.
    QuickStopActive,
    /// Reacting to a fault.
    FaultReactionActive,
    /// Faulted, no torque.
    Fault,
}

impl DriveState {
    /// From a status word; `None` for bits that belong to no state.
    pub fn of_status(word: u16) -> Option<Self> {
        let state = match (word & 0x4F, word & 0x6F) {
            (0x00, _) => Self::NotReadyToSwitchOn,
            (0x40, _) => Self::SwitchOnDisabled,
            (0x0F, _) => Self::FaultReactionActive,
            (0x08, _) => Self::Fault,
            (_, 0x21) => Self::ReadyToSwitchOn,
            (_, 0x23) => Self::SwitchedOn,
            (_, 0x27) => Self::OperationEnabled,
            (_, 0x07) => Self::QuickStopActive,
            _ => return None,
        };
        Some(state)
    }

    /// The bits of the status word that tell the state.
    pub fn status(self) -> u16 {
        match self {
            Self::NotReadyToSwitchOn => 0x00,
            Self::SwitchOnDisabled => 0x40,
            Self::ReadyToSwitchOn => 0x21,
            Self::SwitchedOn => 0x23,
            Self::OperationEnabled => 0x27,
            Self::QuickStopActive => 0x07,
            Self::FaultReactionActive => 0x0F,
            Self::Fault => 0x08,
        }
    }

    /// Faulted, or on the way to it.
    pub fn is_faulted(self) -> bool {
        matches!(self, Self::Fault | Self::FaultReactionActive)
    }

    /// The control word that leads from here towards what is demanded. A fault is reset on no demand but its own.
    pub fn control_word(self, demand: Demand) -> u16 {
        match (demand, self) {
            (Demand::Enabled, Self::SwitchOnDisabled) => control::SHUTDOWN,
            (Demand::Enabled, Self::ReadyToSwitchOn) => control::SWITCH_ON,
            (Demand::Enabled, Self::SwitchedOn | Self::OperationEnabled) => control::ENABLE_OPERATION,
            (Demand::Keep, Self::OperationEnabled) => control::ENABLE_OPERATION,
            (Demand::QuickStop, Self::OperationEnabled | Self::QuickStopActive) => control::QUICK_STOP,
            (Demand::FaultReset, Self::Fault) => control::FAULT_RESET,
            _ => control::DISABLE_VOLTAGE,
        }
    }

    /// The state that a control word leads to from here, in one transition of the standard; `None` if it leaves the drive as it is.
    pub fn after(self, word: u16) -> Option<Self> {
        match (self, word) {
            (Self::SwitchOnDisabled, control::SHUTDOWN) => Some(Self::ReadyToSwitchOn),
            (Self::ReadyToSwitchOn, control::SWITCH_ON) => Some(Self::SwitchedOn),
            (Self::SwitchedOn, control::ENABLE_OPERATION) => Some(Self::OperationEnabled),
            (
                Self::ReadyToSwitchOn | Self::SwitchedOn | Self::OperationEnabled | Self::QuickStopActive,
                control::DISABLE_VOLTAGE,
            ) => Some(Self::SwitchOnDisabled),
            (Self::OperationEnabled, control::QUICK_STOP) => Some(Self::QuickStopActive),
            (Self::Fault, control::FAULT_RESET) => Some(Self::SwitchOnDisabled),
            _ => None,
        }
    }
}

impl fmt::Display for DriveState {
    /// As the standard writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotReadyToSwitchOn => "Not ready to switch on",
            Self::SwitchOnDisabled => "Switch on disabled",
            Self::ReadyToSwitchOn => "Ready to switch on",
            Self::SwitchedOn => "Switched on",
            Self::OperationEnabled => "Operation enabled",
            Self::QuickStopActive => "Quick stop active",
            Self::FaultReactionActive => "Fault reaction active",
            Self::Fault => "Fault",
        })
    }
}

/// What the master wants of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// No torque.
    Off,
    /// Up to Operation enabled.
    Enabled,
    /// To stay in Operation enabled; one that left it is not led up again.
    Keep,
    /// To a stop as object 0x605A says.
    QuickStop,
    /// Out of Fault.
    FaultReset,
}

/// Bits of the status word beside those of the state.
pub mod status {
    /// The control word is obeyed.
    pub const REMOTE: u16 = 1 << 9;
    /// A limit of the drive itself holds back what is commanded.
    pub const INTERNAL_LIMIT: u16 = 1 << 11;
    /// In the cyclic synchronous modes: the drive follows the command.
    pub const FOLLOWS: u16 = 1 << 12;
}

/// Control words.
pub mod control {
    /// To Switch on disabled, from anywhere.
    pub const DISABLE_VOLTAGE: u16 = 0x00;
    /// To Quick stop active.
    pub const QUICK_STOP: u16 = 0x02;
    /// To Ready to switch on.
    pub const SHUTDOWN: u16 = 0x06;
    /// To Switched on.
    pub const SWITCH_ON: u16 = 0x07;
    /// To Operation enabled.
    pub const ENABLE_OPERATION: u16 = 0x0F;
    /// Out of Fault, when this bit rises.
    pub const FAULT_RESET: u16 = 0x80;
}

/// Between a cable and its motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winch {
    /// Motor turns a turn of the pulley.
    pub gear: f64,
    /// Radius at which the cable runs, m.
    pub pulley_radius: f64,
    /// What 1000 ‰ are, N m.
    pub rated_torque: f64,
    /// Encoder counts a turn of the motor.
    pub counts_per_turn: f64,
    /// 1 if positive counts and torques haul the cable in, -1 if they pay it out.
    pub direction: f64,
    /// Largest torque of the motor, N m.
    pub torque_limit: f64,
}

impl Winch {
    /// Tension that 1 ‰ of the rated torque gives, N.
    pub fn newtons_per_permille(&self) -> f64 {
        1e-3 * self.rated_torque * self.gear / self.pulley_radius
    }

    /// Largest target torque, ‰.
    pub fn permille_limit(&self) -> u16 {
        (1e3 * self.torque_limit / self.rated_torque).clamp(0.0, i16::MAX.into()) as u16
    }

    /// Target torque for a tension, ‰ of the rated torque, rounded and saturated; no tension is no torque.
    pub fn target_torque(&self, tension: f64) -> i16 {
        self.torque_either_way(tension.max(0.0))
    }

    /// The same, below 0 N to pay out.
    pub fn torque_either_way(&self, tension: f64) -> i16 {
        let most = f64::from(self.permille_limit());
        let permille = (tension / self.newtons_per_permille()).round();
        (self.direction * permille.clamp(-most, most)) as i16
    }

    /// Tension for a torque, N.
    pub fn tension(&self, permille: i16) -> f64 {
        self.direction * f64::from(permille) * self.newtons_per_permille()
    }

    /// Cable that one count winds, m.
    pub fn metres_per_count(&self) -> f64 {
        TAU * self.pulley_radius / (self.counts_per_turn * self.gear)
    }

    /// By how much the cable is longer at `counts` than at `from`, m. Counts may overflow.
    pub fn lengthening(&self, counts: i32, from: i32) -> f64 {
        -self.direction * f64::from(counts.wrapping_sub(from)) * self.metres_per_count()
    }

    /// The counts at which the cable is `lengthening` (m) longer than at `from`.
    pub fn counts(&self, lengthening: f64, from: i32) -> i32 {
        from.wrapping_add((-self.direction * lengthening / self.metres_per_count()).round() as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use DriveState::*;

    #[test]
    fn every_state_is_read_whatever_the_other_bits_are() {
        for state in [
            NotReadyToSwitchOn,
            SwitchOnDisabled,
            ReadyToSwitchOn,
            SwitchedOn,
            OperationEnabled,
            QuickStopActive,
            FaultReactionActive,
            Fault,
        ] {
            assert_eq!(DriveState::of_status(state.status() | 0xFF90), Some(state));
        }
        // As drives send them: voltage and remote bits set; quick stop bit free where the standard says so.
        assert_eq!(DriveState::of_status(0x0250), Some(SwitchOnDisabled));
        assert_eq!(DriveState::of_status(0x0270), Some(SwitchOnDisabled));
        assert_eq!(DriveState::of_status(0x1637), Some(OperationEnabled));
        assert_eq!(DriveState::of_status(0x0638), Some(Fault));
        assert_eq!(DriveState::of_status(0x0001), None);
    }

    #[test]
    fn a_drive_is_led_up_step_by_step_and_never_out_of_a_fault_unasked() {
        let word = |state: DriveState| state.control_word(Demand::Enabled);
        assert_eq!(
            [SwitchOnDisabled, ReadyToSwitchOn, SwitchedOn, OperationEnabled].map(word),
            [0x06, 0x07, 0x0F, 0x0F]
        );
        for demand in [Demand::Off, Demand::Enabled, Demand::Keep, Demand::QuickStop] {
            assert_eq!(Fault.control_word(demand) & control::FAULT_RESET, 0, "{demand:?}");
        }
        assert_eq!(Fault.control_word(Demand::FaultReset), 0x80);
        assert_eq!(OperationEnabled.control_word(Demand::FaultReset), 0x00);
        assert_eq!(OperationEnabled.control_word(Demand::QuickStop), 0x02);
        assert_eq!(QuickStopActive.control_word(Demand::Enabled), 0x00);
        assert_eq!(OperationEnabled.control_word(Demand::Keep), 0x0F);
        assert_eq!(SwitchOnDisabled.control_word(Demand::Keep), 0x00);
    }

    fn winch(direction: f64) -> Winch {
        Winch {
            gear: 5.0,
            pulley_radius: 0.025,
            rated_torque: 0.5,
            counts_per_turn: 65536.0,
            direction,
            torque_limit: 0.4,
        }
    }

    #[test]
    fn torques_are_per_mille_of_the_rated_one() {
        // 10 N at 25 mm are 0.25 N m at the pulley, 0.05 N m at the motor, a tenth of the rated torque.
        assert_eq!(winch(1.0).target_torque(10.0), 100);
        assert_eq!(winch(-1.0).target_torque(10.0), -100);
        assert!((winch(-1.0).tension(-100) - 10.0).abs() < 1e-12);
        assert_eq!(winch(-1.0).target_torque(1000.0), -800);
        assert_eq!(winch(1.0).target_torque(-3.0), 0);
        assert_eq!(winch(1.0).target_torque(f64::NAN), 0);
    }

    #[test]
    fn counts_are_cable_also_across_their_overflow() {
        let turn = 65536 * 5;
        let circumference = TAU * 0.025;
        assert!((winch(1.0).lengthening(turn, 0) + circumference).abs() < 1e-12, "hauled in");
        assert!((winch(-1.0).lengthening(turn, 0) - circumference).abs() < 1e-12, "paid out");
        let (before, after) = (i32::MAX - 10, i32::MIN + 10);
        assert!(
            (winch(-1.0).lengthening(after, before) - 21.0 * winch(1.0).metres_per_count()).abs() < 1e-15
        );
        assert_eq!(winch(1.0).counts(winch(1.0).lengthening(12345, -77), -77), 12345);
    }
}
