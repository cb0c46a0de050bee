//! What is done to set up a node: one object after the other.

use crate::Nanoseconds;
use crate::canopen::eds::Use;
use crate::canopen::{Direction, Node, Object, TPDO1, Value, Width, object};
use crate::cia402::{
    CONTROL_WORD, CYCLIC_TORQUE, DRIVE_PROFILE, MAX_TORQUE, MODE, MODE_DISPLAY, POSITION, STATUS_WORD,
    TARGET_TORQUE, TORQUE,
};
use crate::config::{Action, Config, Drive, Setting};

pub const DEVICE_TYPE: Object = Object::new(0x1000, 0);
/// Index of vendor, product, revision and serial number (sub-indices 1 to 4).
pub const IDENTITY: u16 = 0x1018;

/// What is done with one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    pub object: Object,
    pub value: Value,
    /// Bits that must agree when it is read.
    pub mask: u32,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Write,
    Check,
    /// The same, but a node that has no such object goes without.
    Offer,
    /// Read until it is so.
    Await,
    /// Read and noted, whatever it is, if there is such an object.
    Note,
}

/// For the drive of a cable.
pub fn of_drive(config: &Config, cable: usize) -> Vec<Step> {
    let drive = &config.drives[cable];
    let watchdog = milliseconds(config.heartbeat.drive_watchdog);
    let mut script = vec![Step { mask: 0xFFFF, ..check(DEVICE_TYPE, Value::u32(DRIVE_PROFILE.into())) }];
    let identity = (1..=4).map(|part| check(Object::new(IDENTITY, part), Value::u32(0)));
    script.extend(identity.map(|step| Step { kind: Kind::Note, ..step }));
    script.push(write(object::consume_heartbeat(config.node, watchdog)));
    script.push(write(object::produce_heartbeat(milliseconds(config.heartbeat.period))));
    let receive = torque_mapping(config, cable);
    let transmit = [(STATUS_WORD, Width::Bits16), (POSITION, Width::Bits32), (TORQUE, Width::Bits16)];
    let receive = object::map_pdo(Direction::Receive, drive.torque_frame.id, &receive);
    script.extend(receive.into_iter().map(write));
    // The last step puts the PDO on.
    let deadline = write(object::receive_deadline(watchdog));
    script.insert(script.len() - 1, Step { kind: Kind::Offer, ..deadline });
    let id = TPDO1 + u16::from(drive.node);
    script.extend(object::map_pdo(Direction::Transmit, id, &transmit).into_iter().map(write));
    script.push(write((MAX_TORQUE, Value::u16(drive.winch.permille_limit()))));
    let own = config.drive_objects.iter().filter(|setting| setting.is_of(drive.node));
    script.extend(own.map(setting));
    script.push(write((MODE, Value::u8(CYCLIC_TORQUE))));
    script.push(Step { kind: Kind::Await, ..check(MODE_DISPLAY, Value::u8(CYCLIC_TORQUE)) });
    script
}

/// For the node of a load cell, with all of its cells.
pub fn of_load_cell(config: &Config, node: Node) -> Vec<Step> {
    let cells = config.load_cells.iter().filter(|cell| cell.node == node);
    let entries: Vec<_> = cells.map(|cell| (cell.cell.object, cell.cell.encoding.width())).collect();
    let mut script = vec![write(object::produce_heartbeat(milliseconds(config.heartbeat.period)))];
    let id = TPDO1 + u16::from(node);
    script.extend(object::map_pdo(Direction::Transmit, id, &entries).into_iter().map(write));
    let own = config.load_cell_objects.iter().filter(|setting| setting.is_of(node));
    script.extend(own.map(setting));
    script
}

/// What a script asks of the node's objects. What it may go without is not.
pub fn needs(script: &[Step]) -> Vec<(Object, Use)> {
    let of_step = |step: &Step| {
        let Step { object, value, kind, .. } = *step;
        let what = match kind {
            Kind::Write => Use::Write(value),
            Kind::Check | Kind::Await => Use::Read(value.width),
            Kind::Offer | Kind::Note => return [None, None],
        };
        [Some((object, what)), mapped(object, value).filter(|_| kind == Kind::Write)]
    };
    script.iter().flat_map(of_step).flatten().collect()
}

/// Control word, then a torque for each slot: this drive's, or a dummy for another's.
fn torque_mapping(config: &Config, cable: usize) -> Vec<(Object, Width)> {
    let drive = &config.drives[cable];
    let shared = |other: &&Drive| other.bus == drive.bus && other.torque_frame.id == drive.torque_frame.id;
    let last = config.drives.iter().filter(shared).map(|other| other.torque_frame.slot).max().unwrap_or(0);
    let mut entries = vec![(CONTROL_WORD, Width::Bits16)];
    for slot in 0..=last {
        let is_ours = slot == drive.torque_frame.slot;
        entries.push(if is_ours { (TARGET_TORQUE, Width::Bits16) } else { object::DUMMY_16 });
    }
    entries
}

/// What a write to a PDO's mapping maps.
fn mapped(object: Object, value: Value) -> Option<(Object, Use)> {
    let direction = Direction::of_mapping(object)?;
    let [index, rest] = [value.bits >> 16, value.bits & 0xFFFF];
    let width = Width::of_bytes((rest & 0xFF) as u8 / 8)?;
    Some((Object::new(index as u16, (rest >> 8) as u8), Use::Map(direction, width)))
}

fn milliseconds(time: Nanoseconds) -> u16 {
    u16::try_from(time / 1_000_000).unwrap_or(u16::MAX)
}

fn write((object, value): (Object, Value)) -> Step {
    Step { object, value, mask: object::read_back_mask(object), kind: Kind::Write }
}

fn check(object: Object, value: Value) -> Step {
    Step { object, value, mask: u32::MAX, kind: Kind::Check }
}

fn setting(setting: &Setting) -> Step {
    match setting.action {
        Action::Write => write((setting.object, setting.value)),
        Action::Check => check(setting.object, setting.value),
    }
}
