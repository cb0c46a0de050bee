//! The fieldbus file of `can-bridge`: what is on which bus, how it scales, what is allowed, what to do when it fails. Geometry, mass and
//! limits of the tensions stand in the rig file that it names.

mod file;
#[cfg(test)]
pub(crate) mod tests;
mod values;

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use thiserror::Error;

use super::Nanoseconds;
use super::canopen::{Emergency, Node, Object, Value};
use super::cia402::Winch;
use super::load_cell::LoadCell;
use cable_robot::checked_toml::Refused;
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Pose, Rig, RigFile};

/// Everything `can-bridge` knows of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// What people call it.
    pub name: String,
    /// Geometry, mass and limits of the tensions, from the rig file. Every greatest tension is finite.
    pub rig: Rig,
    /// Between two cycles, and two SYNCs.
    pub period: Nanoseconds,
    /// Share of each bus that the frames of a cycle may take.
    pub largest_load: f64,
    /// The buses; drives and load cells name theirs by its place here.
    pub buses: Vec<Bus>,
    /// The bridge's own address.
    pub node: Node,
    /// Who tells whom that he is alive.
    pub heartbeat: Heartbeat,
    /// How long the bridge waits.
    pub timeouts: Timeouts,
    /// One a cable.
    pub drives: Vec<Drive>,
    /// Written to, or checked in, the drives before they are used.
    pub drive_objects: Vec<Setting>,
    /// One a cable.
    pub load_cells: Vec<Cell>,
    /// The same for the nodes of the load cells.
    pub load_cell_objects: Vec<Setting>,
    /// Emergency messages that end nothing.
    pub ignored_emergencies: Vec<IgnoredEmergency>,
    /// Where the platform stands when the encoders are read for the first time.
    pub home: Pose,
    /// How slack is taken up.
    pub slack: Slack,
    /// What counts as a fault.
    pub limits: Limits,
    /// What to pull when something failed or the operator let go.
    pub safe: Safe,
    /// Who computes the tensions.
    pub controller: ControllerConfig,
}

/// A CAN bus.
#[derive(Clone, Debug, PartialEq)]
pub struct Bus {
    /// Such as `can0`.
    pub name: String,
    /// bit/s.
    pub bit_rate: f64,
}

/// Who tells whom that he is alive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heartbeat {
    /// Of the bridge and of every node (0x1017).
    pub period: Nanoseconds,
    /// A node silent for so long is lost to the bridge.
    pub timeout: Nanoseconds,
    /// The bridge silent for so long is lost to a drive (0x1016): what stops the robot after `kill -9`.
    pub drive_watchdog: Nanoseconds,
}

/// How long the bridge waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timeouts {
    /// From the reset of a node to its boot-up message.
    pub boot: Nanoseconds,
    /// For the answer to a service request; it is asked three times.
    pub service: Nanoseconds,
    /// For a drive to confirm its mode, or to follow its control word.
    pub drive: Nanoseconds,
    /// The operator's enable ends unless it is given again within this time.
    pub enable: Nanoseconds,
}

/// A drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Place of its bus among [`Config::buses`].
    pub bus: usize,
    /// Its address.
    pub node: Node,
    /// The frame that brings its control word and target torque.
    pub torque_frame: TorqueFrame,
    /// Between its cable and its motor.
    pub winch: Winch,
}

/// A frame with a control word and up to three target torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TorqueFrame {
    /// Identifier.
    pub id: u16,
    /// Which of the torques is this drive's, from 0.
    pub slot: usize,
}

/// A load cell and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Place of its bus among [`Config::buses`].
    pub bus: usize,
    /// Address of the node it hangs on; cells of one node share its first transmit PDO.
    pub node: Node,
    /// First byte of its reading there.
    pub byte: usize,
    /// What it says.
    pub cell: LoadCell,
}

/// A value of a node's dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Where.
    pub object: Object,
    /// What.
    pub value: Value,
    /// Whether it is written and read back, or only read and compared.
    pub action: Action,
    /// Of this node alone; of all if none is named.
    pub node: Option<Node>,
}

impl Setting {
    /// Whether it is a node's.
    pub fn is_of(&self, node: Node) -> bool {
        self.node.is_none_or(|named| named == node)
    }
}

/// What is done with a [`Setting`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Write it, read it back.
    Write,
    /// It must already be so.
    Check,
}

/// An emergency message that is logged and ends nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IgnoredEmergency {
    /// Its code, all digits.
    pub code: u16,
    /// Of this node alone; of all if none is named.
    pub node: Option<Node>,
    /// Bits that the error register may have: with others it is no longer this harmless message.
    pub register: u8,
}

impl IgnoredEmergency {
    fn is(&self, emergency: &Emergency) -> bool {
        self.code == emergency.code
            && self.node.is_none_or(|node| node == emergency.node)
            && emergency.register & !self.register == 0
    }
}

/// How slack is taken up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack {
    /// Tension that makes every cable taut while the platform stands on its stand, N. Twice of it tells which load cell is whose.
    pub pretension: f64,
    /// Time of the ramp to it (a quarter for each further step), and then again for the load cells to settle.
    pub ramp: Nanoseconds,
    /// More cable than this is not slack: it is loose, or off its pulley. m.
    pub most: f64,
}

/// What counts as a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Cycles without a frame, an encoder value or a load cell's reading that are bridged; one more is a fault.
    pub lost_cycles: u32,
    /// A cable faster than this is a mistake of its encoder, m/s.
    pub cable_speed: f64,
    /// An encoder that stands still within one cycle from this speed is frozen, m/s.
    pub freeze_speed: f64,
    /// One that does not change by a count while another cable moves so far is frozen, m.
    pub freeze_travel: f64,
    /// Largest roll, pitch or yaw, rad.
    pub tilt: f64,
    /// Largest difference between a load cell and what its motor pulls, N.
    pub disagreement: f64,
    /// How long it may last.
    pub disagreement_time: Nanoseconds,
    /// Largest difference between what a drive says that its motor gives (0x6077) and what was commanded of late, N.
    pub torque_error: f64,
    /// How far the platform may be from what the law follows, beyond what it was from a new set point, m.
    pub following: f64,
    /// Where the platform's centre of mass may be: least and greatest x, y, z, m.
    pub space: [[f64; 2]; 3],
    /// Periods from the command of a torque to the drive's word that its motor gives it, at most.
    pub latency: f64,
    /// A load cell that says the same to the last bit while its motor's pull changed by this is stuck, N.
    pub stuck: f64,
}

/// What to pull when something failed or the operator let go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Safe {
    /// What.
    pub output: SafeOutput,
    /// Time of the way to it, and of the lift off the stand.
    pub ramp: Nanoseconds,
    /// What each winch adds by itself for every metre that its cable is longer than when the way began, N/m.
    pub stiffness: f64,
    /// The same for every m/s that it gets longer, N s/m.
    pub damping: f64,
    /// A platform that hangs is held so long, from when the controller's tensions ended, before it is let down.
    pub hold_time: Nanoseconds,
}

/// What to pull when something failed or the operator let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SafeOutput {
    /// The last tensions that passed every check.
    Hold,
    /// By a ramp to what carries the platform at rest at the last good pose.
    GravityRamp,
    /// Nothing: quick stop, then voltage off. The platform falls unless the drives have brakes.
    TorqueOff,
}

/// Who computes the tensions.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerConfig {
    /// The controller that a file of earlier versions names: nothing is loaded for that.
    pub fmu: Option<String>,
    /// Gains of the rig file, 1/s: those of the controller, unless `parameters` say others.
    pub lambda: f64,
    /// See `lambda`.
    pub eta: f64,
    /// Its other parameters, by their names in the FMU.
    pub parameters: BTreeMap<String, Parameter>,
}

/// A parameter of the FMU.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Parameter {
    /// `true` or `false`.
    Boolean(bool),
    /// A number.
    Number(f64),
    /// An item of an enumeration, by its name.
    Item(String),
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Boolean(flag) => flag.fmt(f),
            Self::Number(number) => number.fmt(f),
            Self::Item(item) => item.fmt(f),
        }
    }
}

/// A fieldbus file that is refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ConfigError {
    /// No TOML, an unknown or missing field, or a value of the wrong kind.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A value that makes no sense.
    #[error(transparent)]
    Value(#[from] Refused),
}

/// The path of the rig file that this fieldbus file names, relative to its own folder.
///
/// # Errors
/// [`ConfigError::Toml`]: no TOML, or no `rig`.
pub fn rig_path(text: &str) -> Result<String, ConfigError> {
    #[derive(Deserialize)]
    struct Named {
        rig: String,
    }
    Ok(toml::from_str::<Named>(text)?.rig)
}

/// Of [`Limits::lost_cycles`].
pub const MOST_LOST_CYCLES: u32 = 100;

/// The fastest that the platform is let down, m/s: half of what it may land with. A small rig goes slower: this share of its shortest cable at home a second.
const LOWERING_SPEED: f64 = 0.05;
const LOWERING_SHARE: f64 = 0.05;

/// How fast cables may become, as a share of the speed that counts as a mistake of an encoder.
const SHARE_OF_CABLE_SPEED: f64 = 0.8;

impl Config {
    /// Reads the text of a fieldbus file. `rig` is the rig file at its [`rig_path`].
    ///
    /// # Errors
    /// [`ConfigError`]: the line, the field, its value and what is allowed.
    pub fn parse(text: &str, rig: &RigFile) -> Result<Self, ConfigError> {
        file::parse(text, rig)
    }

    /// What the controller is to know of drives and encoders, besides the rig: with the planner `Exact` it leaves room for the resolution of the encoders, and keeps
    /// cables below the speed that counts as a mistake of an encoder.
    pub fn of_drives(&self, parameters: ControllerParameters) -> ControllerParameters {
        let of_winches = self.drives.iter().map(|drive| drive.winch.metres_per_count());
        let heeds = parameters.planner != PlannerKind::Bounded;
        let period = self.period as f64 * 1e-9;
        let (encoder_resolution, max_cable_speed) = if heeds {
            (of_winches.fold(0.0, f64::max), SHARE_OF_CABLE_SPEED * self.limits.cable_speed)
        } else {
            (0.0, 0.0)
        };
        ControllerParameters {
            hold_compensation: true,
            // From an encoder's sample to the torque that answers it is one period, for which it then holds.
            command_delay: period,
            encoder_resolution,
            max_cable_speed,
            ..parameters
        }
    }

    /// How fast the platform is let down, m/s.
    pub fn lowering_speed(&self) -> f64 {
        let shortest = self.rig.cables_at(&self.home).length.iter().copied().fold(f64::INFINITY, f64::min);
        LOWERING_SPEED.min(LOWERING_SHARE * shortest)
    }

    /// Whether the fieldbus file says that an emergency message ends nothing.
    pub fn ignores(&self, emergency: &Emergency) -> bool {
        self.ignored_emergencies.iter().any(|ignored| ignored.is(emergency))
    }

    /// Cycles in a time, at least one.
    pub fn cycles(&self, time: Nanoseconds) -> u32 {
        u32::try_from(time.div_ceil(self.period)).unwrap_or(u32::MAX).max(1)
    }

    /// The torque frames, in the order of the cables: bus, identifier, and whose torque each slot is.
    pub fn torque_frames(&self) -> Vec<(usize, u16, [Option<usize>; 3])> {
        let mut frames: Vec<(usize, u16, [Option<usize>; 3])> = vec![];
        for (cable, drive) in self.drives.iter().enumerate() {
            let TorqueFrame { id, slot } = drive.torque_frame;
            match frames.iter_mut().find(|(bus, other, _)| (*bus, *other) == (drive.bus, id)) {
                Some((_, _, slots)) => slots[slot] = Some(cable),
                None => {
                    let mut slots = [None; 3];
                    slots[slot] = Some(cable);
                    frames.push((drive.bus, id, slots));
                }
            }
        }
        frames
    }
}
