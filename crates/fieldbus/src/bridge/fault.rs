//! What can be wrong, as the bridge sees it.

use thiserror::Error;

use super::trial::AfterSilence;
use crate::Nanoseconds;
use crate::canopen::{self, Emergency, NmtState, Node, Object, sdo};
use crate::cia402::{DriveState, status};

/// Why the bridge gave up its controller's tensions, or never took them. Cables count from 1, buses from 0 as in the fieldbus file.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Fault {
    /// A node did not start.
    #[error("node {node} sent no boot-up message: is it powered, and are its address and bit rate right?")]
    NoBoot {
        /// Its address.
        node: Node,
    },
    /// A node does not answer.
    #[error("node {node} did not answer about object {object}, asked three times")]
    NoAnswer {
        /// Its address.
        node: Node,
        /// What was asked for.
        object: Object,
    },
    /// A node refuses a setting.
    #[error("node {node} refused object {object}: 0x{code:08X}, {}", sdo::abort_text(*.code))]
    Refused {
        /// Its address.
        node: Node,
        /// What was asked for.
        object: Object,
        /// Abort code.
        code: u32,
    },
    /// A node's object is longer than what is read of any.
    #[error(
        "node {node} answers for object {object} with {} in segments; of an object that is read here there are at most 4",
        count_in_words(*.bytes)
    )]
    TooLong {
        /// Its address.
        node: Node,
        /// What was asked for.
        object: Object,
        /// How long it is, if the node says so.
        bytes: Option<u32>,
    },
    /// A node's object is not what it should be.
    #[error("object {object} of node {node} is 0x{found:X}, not 0x{expected:X}")]
    Different {
        /// Its address.
        node: Node,
        /// The object.
        object: Object,
        /// What was written, or asked for by the fieldbus file.
        expected: u32,
        /// What was read.
        found: u32,
    },
    /// A drive did not take up its mode.
    #[error("drive {node} stays in mode {found}, cyclic synchronous torque is mode 10")]
    ModeRefused {
        /// Its address.
        node: Node,
        /// 0x6061.
        found: i8,
    },
    /// A drive did not follow its control word.
    #[error("drive {node} stays in \"{state}\"{}", held_by(*.state))]
    DriveStuck {
        /// Its address.
        node: Node,
        /// Where it is.
        state: DriveState,
    },
    /// Another drive than the one that was commissioned.
    #[error(
        "drive {node} is another than was commissioned: vendor, product, revision or serial number (0x1018) differ"
    )]
    AnotherDrive {
        /// Its address.
        node: Node,
    },
    /// A drive goes on when nobody commands it any more.
    #[error(
        "drive {node} goes on after the bridge was silent for twice heartbeat.drive_watchdog ({found}): killed, it would leave a motor \
         that pulls; look at its heartbeat consumer (0x1016), error behaviour (0x1029) and abort connection option (0x6007)"
    )]
    WatchdogIgnored {
        /// Its address.
        node: Node,
        /// What it did meanwhile.
        found: AfterSilence,
    },
    /// A drive reports a fault in its status word.
    #[error("drive {node} is in \"{state}\"")]
    DriveFault {
        /// Its address.
        node: Node,
        /// Where it is.
        state: DriveState,
    },
    /// A drive left Operation enabled unasked.
    #[error("drive {node} left \"Operation enabled\" for \"{state}\"{}", held_by(*.state))]
    DriveLeft {
        /// Its address.
        node: Node,
        /// Where it is.
        state: DriveState,
    },
    /// A motor does not give what was commanded of late.
    #[error(
        "the motor of cable {cable} pulls {actual:.2} N, not {commanded:.2} N: its torque frames do not reach it, or it does not follow them"
    )]
    TorqueNotFollowed {
        /// Its number, from 1.
        cable: usize,
        /// What 0x6077 says, N.
        actual: f64,
        /// What was commanded of late and is nearest to that, N.
        commanded: f64,
    },
    /// A drive shows too late what a control word does.
    #[error(
        "drive {node} shows what a control word does {:.1} ms after it at the soonest, at most {:.1} ms (limits.latency) are allowed: the link is slow, or the drive",
        *.time as f64 * 1e-6, *.most as f64 * 1e-6
    )]
    SlowReaction {
        /// Its address.
        node: Node,
        /// From a control word to the status word that shows its transition.
        time: Nanoseconds,
        /// So long it may take.
        most: Nanoseconds,
    },
    /// A torque comes too late.
    #[error(
        "the motor of cable {cable} says that it pulls {periods:.1} periods after the command, at most {most} are allowed: the link is slow, or the drive"
    )]
    Late {
        /// Its number, from 1.
        cable: usize,
        /// Periods of the cycle.
        periods: f64,
        /// So many are allowed.
        most: f64,
    },
    /// A drive says that it does not do what it is told.
    #[error("drive {node} is enabled and says that {}", disobedience(*.bits))]
    DriveDisobeys {
        /// Its address.
        node: Node,
        /// The bits of its status word that are not as they should be.
        bits: u16,
    },
    /// A drive changed its mode of operation by itself.
    #[error("drive {node} left cyclic synchronous torque (mode 10) for mode {found}")]
    ModeLeft {
        /// Its address.
        node: Node,
        /// 0x6061.
        found: i8,
    },
    /// An emergency message.
    #[error("{0}")]
    Emergency(Emergency),
    /// A node started again.
    #[error("node {node} started again by itself")]
    Rebooted {
        /// Its address.
        node: Node,
    },
    /// A node's heartbeat is missing.
    #[error("node {node} sends no heartbeat")]
    HeartbeatLost {
        /// Its address.
        node: Node,
    },
    /// A node left Operational.
    #[error("node {node} is {state}, not Operational")]
    NotOperational {
        /// Its address.
        node: Node,
        /// What its heartbeat says.
        state: NmtState,
    },
    /// No encoder values.
    #[error("the encoder of cable {cable} is silent")]
    EncoderSilent {
        /// Its number, from 1.
        cable: usize,
    },
    /// The same encoder value again and again while the cable must be moving.
    #[error("the encoder of cable {cable} is frozen")]
    EncoderFrozen {
        /// Its number, from 1.
        cable: usize,
    },
    /// Farther than a cable can have moved.
    #[error("the encoder of cable {cable} jumped: {speed:.2} m/s")]
    EncoderJump {
        /// Its number, from 1.
        cable: usize,
        /// What it would mean.
        speed: f64,
    },
    /// No readings.
    #[error("load cell {cable} is silent")]
    LoadCellSilent {
        /// Its number, from 1.
        cable: usize,
    },
    /// The same reading again and again while the pull changed.
    #[error("load cell {cable} is stuck")]
    LoadCellStuck {
        /// Its number, from 1.
        cable: usize,
    },
    /// No number, or none that the cell can mean.
    #[error("load cell {cable} says {tension} N, which cannot be")]
    LoadCellAbsurd {
        /// Its number, from 1.
        cable: usize,
        /// N.
        tension: f64,
    },
    /// A load cell and its motor do not agree.
    #[error("load cell {cable} says {measured:.2} N while its motor pulls {commanded:.2} N")]
    LoadCellDisagrees {
        /// Its number, from 1.
        cable: usize,
        /// N.
        measured: f64,
        /// N.
        commanded: f64,
    },
    /// More cable came in, or went out, than slack can be.
    #[error(
        "cable {cable} came in by {length:.3} m and is not taut: loose, off its pulley, or (below 0) wound the other way round"
    )]
    LooseCable {
        /// Its number, from 1.
        cable: usize,
        /// m.
        length: f64,
    },
    /// The lengths belong to no pose.
    #[error("the cable lengths belong to no pose near the last one")]
    NoPose,
    /// The platform is turned too far.
    #[error("the platform is turned by {angle:.3} rad")]
    Tilted {
        /// The largest of roll, pitch and yaw, rad.
        angle: f64,
    },
    /// The platform does not come to where the law leads it, or goes away from it.
    #[error(
        "the platform is {distance:.3} m from where it is led, at most {most:.3} m are allowed: another mass than in the rig file, or something is in its way"
    )]
    OffCourse {
        /// m.
        distance: f64,
        /// m.
        most: f64,
    },
    /// The platform is where it must not be.
    #[error("the platform is outside of its box: {axis} = {at:.3} m")]
    OutOfBox {
        /// x, y or z.
        axis: char,
        /// m.
        at: f64,
    },
    /// Let down to where it began, the platform does not stand there.
    #[error(
        "the platform was let down and does not stand at home: cable {cable} is off by {length:.3} m, at most slack.most = {most} m are allowed; it is held, and not let down again by itself"
    )]
    OffStand {
        /// Its number, from 1.
        cable: usize,
        /// More than at home, m.
        length: f64,
        /// m.
        most: f64,
    },
    /// Somebody else sends what only the bridge may.
    #[error(
        "another master is on bus {bus}: it sent 0x{id:03X}, which only this bridge may; end one of them (or the adapter gives back what it is sent)"
    )]
    AnotherMaster {
        /// Its place.
        bus: usize,
        /// SYNC, the bridge's heartbeat, or a torque frame.
        id: u16,
    },
    /// The controller has left the bus.
    #[error("bus {bus} is off: its controller saw too many errors")]
    BusOff {
        /// Its place.
        bus: usize,
    },
    /// The transport cannot send.
    #[error("bus {bus}: {error}")]
    Transport {
        /// Its place.
        bus: usize,
        /// Why.
        error: TransportError,
    },
    /// The controller returned an error.
    #[error("the controller failed, and no reset brings it back: start the program anew")]
    ControllerFailed,
    /// The controller says that its measurements make no sense.
    #[error("the controller reports a sensor fault")]
    ControllerSensorFault,
    /// The controller asks for what is no tension, or is more than allowed.
    #[error("the controller asks for {tension} N in cable {cable}")]
    ControllerOutput {
        /// Its number, from 1.
        cable: usize,
        /// N.
        tension: f64,
    },
    /// A cycle came too late.
    #[error("no cycle for {:.1} ms", *.gap as f64 * 1e-6)]
    Overrun {
        /// Time since the one before.
        gap: Nanoseconds,
    },
    /// Time went backwards.
    #[error("the clock went back by {:.1} ms", *.by as f64 * 1e-6)]
    ClockBackwards {
        /// By so much.
        by: Nanoseconds,
    },
}

/// What a transport can say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TransportError {
    /// ENOBUFS, or a queue that is full: this cycle's frames, or some of them, were dropped.
    #[error("no room to send (ENOBUFS)")]
    NoRoom,
    /// ENETDOWN.
    #[error("the link is down")]
    Down,
    /// ENODEV, or the other end closed.
    #[error("the link is gone")]
    Gone,
}

fn count_in_words(bytes: Option<u32>) -> String {
    bytes.map_or("more bytes than it says".to_owned(), |bytes| format!("{bytes} bytes"))
}

/// What keeps a drive from torque without a fault. CiA 402 has no bit and no code for safe torque off: the state is all that is seen of it.
fn held_by(state: DriveState) -> &'static str {
    match state {
        DriveState::SwitchOnDisabled | DriveState::NotReadyToSwitchOn => {
            ": safe torque off (STO, an emergency stop), its enable input or its supply may hold it there"
        }
        _ => "",
    }
}

fn disobedience(bits: u16) -> &'static str {
    if bits & status::REMOTE != 0 {
        "it is commanded by somebody else (status bit 9, remote)"
    } else if bits & status::FOLLOWS != 0 {
        "it does not follow the torques (status bit 12)"
    } else {
        "a limit of its own holds it back (status bit 11)"
    }
}

impl Fault {
    /// Whether it is the same kind of fault of the same cable, node or bus.
    fn is_again(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.place() == other.place()
    }

    /// Whether a drive may not pull what it is told.
    pub(super) fn is_of_drive(&self) -> bool {
        use Fault::*;
        matches!(
            self,
            DriveFault { .. }
                | DriveLeft { .. }
                | DriveDisobeys { .. }
                | ModeLeft { .. }
                | TorqueNotFollowed { .. }
                | Emergency(_)
                | Rebooted { .. }
                | HeartbeatLost { .. }
                | NotOperational { .. }
        )
    }

    /// Cable, node or bus, if it has one.
    fn place(&self) -> usize {
        use Fault::*;
        match *self {
            NoBoot { node }
            | NoAnswer { node, .. }
            | Refused { node, .. }
            | TooLong { node, .. }
            | Different { node, .. }
            | ModeRefused { node, .. }
            | DriveStuck { node, .. }
            | WatchdogIgnored { node, .. }
            | AnotherDrive { node }
            | SlowReaction { node, .. }
            | DriveFault { node, .. }
            | DriveLeft { node, .. }
            | DriveDisobeys { node, .. }
            | ModeLeft { node, .. }
            | Emergency(canopen::Emergency { node, .. })
            | Rebooted { node }
            | HeartbeatLost { node }
            | NotOperational { node, .. } => node.into(),
            EncoderSilent { cable }
            | EncoderFrozen { cable }
            | EncoderJump { cable, .. }
            | LoadCellSilent { cable }
            | LoadCellStuck { cable }
            | LoadCellAbsurd { cable, .. }
            | LoadCellDisagrees { cable, .. }
            | LooseCable { cable, .. }
            | TorqueNotFollowed { cable, .. }
            | Late { cable, .. }
            | ControllerOutput { cable, .. } => cable,
            AnotherMaster { bus, .. } | BusOff { bus } | Transport { bus, .. } => bus,
            NoPose
            | Tilted { .. }
            | OffCourse { .. }
            | OutOfBox { .. }
            | OffStand { .. }
            | ControllerFailed
            | ControllerSensorFault
            | Overrun { .. }
            | ClockBackwards { .. } => 0,
        }
    }
}

/// Faults, each once, in the order in which they came; of more than there is room for the last are left out.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultList {
    faults: [Option<Fault>; 32],
}

impl FaultList {
    pub fn is_empty(&self) -> bool {
        self.faults[0].is_none()
    }

    /// Whether it was not there yet, and is now.
    pub fn insert(&mut self, fault: Fault) -> bool {
        let is_its = |place: &&mut Option<Fault>| place.is_none_or(|known| known.is_again(&fault));
        match self.faults.iter_mut().find(is_its) {
            Some(place @ None) => {
                *place = Some(fault);
                true
            }
            Some(Some(_)) | None => false,
        }
    }

    /// The same, before all others: they may follow from it.
    pub fn insert_first(&mut self, fault: Fault) {
        let others = std::mem::take(self);
        self.insert(fault);
        others.iter().for_each(|other| _ = self.insert(other));
    }

    pub fn iter(&self) -> impl Iterator<Item = Fault> + '_ {
        self.faults.iter().map_while(|fault| *fault)
    }
}
