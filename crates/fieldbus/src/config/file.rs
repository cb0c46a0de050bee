//! The file as it is written, and the way from there to a [`Config`].

mod limits;
mod together;

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::values::{bus, time};
use super::{
    Action, Bus, Cell, Config, ConfigError, ControllerConfig, Drive, Heartbeat, IgnoredEmergency, Parameter,
    Safe, SafeOutput, Setting, Slack, Timeouts, TorqueFrame,
};
use crate::canopen::{self, Node, Object, Value, Width};
use crate::cia402::Winch;
use crate::load_cell::{Encoding, LoadCell};
use cable_robot::checked_toml::{Checked, Refused};
use cable_robot::robot::{Coordinates, Pose, Rig, RigFile};
use limits::{LimitEntry, limits};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    /// See [`super::rig_path`].
    rig: Spanned<String>,
    rate: Spanned<f64>,
    largest_load: Spanned<f64>,
    node: Spanned<u32>,
    home: Spanned<[f64; 6]>,
    buses: Spanned<Vec<BusEntry>>,
    heartbeat: HeartbeatEntry,
    timeouts: TimeoutEntry,
    slack: SlackEntry,
    limits: LimitEntry,
    safe: SafeEntry,
    #[serde(default)]
    controller: ControllerEntry,
    #[serde(default)]
    drive_objects: Vec<ObjectEntry>,
    drives: Spanned<Vec<DriveEntry>>,
    #[serde(default)]
    load_cell_objects: Vec<ObjectEntry>,
    load_cells: Spanned<Vec<CellEntry>>,
    #[serde(default)]
    ignored_emergencies: Vec<EmergencyEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EmergencyEntry {
    code: Spanned<u32>,
    /// None for all of them.
    node: Option<Spanned<u32>>,
    register: Option<Spanned<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BusEntry {
    name: Spanned<String>,
    bit_rate: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HeartbeatEntry {
    period: Spanned<f64>,
    timeout: Spanned<f64>,
    drive_watchdog: Spanned<f64>,
    /// Why it is longer than an operator's hand may be away.
    long_watchdog: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeoutEntry {
    boot: Spanned<f64>,
    service: Spanned<f64>,
    drive: Spanned<f64>,
    enable: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SlackEntry {
    pretension: Spanned<f64>,
    ramp: Spanned<f64>,
    most: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SafeEntry {
    output: SafeOutput,
    ramp: Spanned<f64>,
    stiffness: Spanned<f64>,
    damping: Spanned<f64>,
    hold_time: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ControllerEntry {
    #[serde(default)]
    fmu: Option<String>,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<Parameter>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectEntry {
    index: Spanned<u32>,
    subindex: Spanned<u32>,
    bytes: Spanned<u8>,
    value: Spanned<i64>,
    action: Action,
    /// None for all of them.
    node: Option<Spanned<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DriveEntry {
    bus: Spanned<String>,
    node: Spanned<u32>,
    gear: Spanned<f64>,
    pulley_radius: Spanned<f64>,
    rated_torque: Spanned<f64>,
    torque_limit: Spanned<f64>,
    counts_per_turn: Spanned<f64>,
    direction: Spanned<f64>,
    torque_frame: Option<FrameEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameEntry {
    id: Spanned<u32>,
    slot: Spanned<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CellEntry {
    bus: Spanned<String>,
    node: Spanned<u32>,
    index: Spanned<u32>,
    subindex: Spanned<u32>,
    encoding: Encoding,
    scale: Spanned<f64>,
    offset: Spanned<f64>,
    range: Spanned<[f64; 2]>,
}

/// Lengths and forces from here to there are believable for a rig: wide, but they catch units that were mixed up.
const SMALL: f64 = 1e-6;
const LARGE: f64 = 1e6;

pub(super) fn parse(text: &str, rig: &RigFile) -> Result<Config, ConfigError> {
    let file: File = toml::from_str(text)?;
    let check = Checked { text };
    let rate = check.within(&file.rate, "rate", 1.0..=2000.0, "Hz")?;
    let buses = buses(&check, &file)?;
    let cables = rig.rig.cables.len();
    let controller = controller(&check, &file.controller, rig)?;
    let config = Config {
        period: (1e9 / rate).round() as u64,
        largest_load: check.within(&file.largest_load, "largest_load", 0.01..=1.0, "")?,
        node: check.within(&file.node, "node", 1..=127, "")? as Node,
        heartbeat: heartbeat(&check, &file.heartbeat)?,
        timeouts: timeouts(&check, &file.timeouts)?,
        rig: rig.rig,
        drives: drives(&check, &file, &buses, cables)?,
        drive_objects: settings(&check, &file.drive_objects, "drive_objects")?,
        load_cells: load_cells(&check, &file, &buses, cables)?,
        load_cell_objects: settings(&check, &file.load_cell_objects, "load_cell_objects")?,
        ignored_emergencies: ignored(&check, &file.ignored_emergencies)?,
        home: home(&check, &file.home, &rig.rig)?,
        slack: slack(&check, &file.slack)?,
        limits: limits(&check, &file.limits, &rig.rig, home(&check, &file.home, &rig.rig)?)?,
        safe: safe(&check, &file.safe)?,
        controller,
        name: file.name.clone(),
        buses,
    };
    together::check(&check, &file, &config)?;
    Ok(config)
}

fn buses(check: &Checked, file: &File) -> Result<Vec<Bus>, Refused> {
    let entries = file.buses.get_ref();
    if !(1..=4).contains(&entries.len()) {
        let offset = file.buses.span().start;
        return Err(check.refuse(offset, "number of [[buses]]", entries.len(), "must be from 1 to 4"));
    }
    let bus = |(k, entry): (usize, &BusEntry)| {
        let field = format!("buses[{}].bit_rate", k + 1);
        let bit_rate = check.within(&entry.bit_rate, &field, 1e4..=1e6, "bit/s")?;
        Ok(Bus { name: entry.name.get_ref().clone(), bit_rate })
    };
    entries.iter().enumerate().map(bus).collect()
}

fn heartbeat(check: &Checked, entry: &HeartbeatEntry) -> Result<Heartbeat, Refused> {
    let period = check.within(&entry.period, "heartbeat.period", 0.005..=10.0, "s")?;
    let longer = 2.0 * period..=60.0;
    Ok(Heartbeat {
        period: time(check, &entry.period, "heartbeat.period", 0.005..=10.0)?,
        timeout: time(check, &entry.timeout, "heartbeat.timeout", longer.clone())?,
        drive_watchdog: time(check, &entry.drive_watchdog, "heartbeat.drive_watchdog", longer)?,
    })
}

fn timeouts(check: &Checked, entry: &TimeoutEntry) -> Result<Timeouts, Refused> {
    Ok(Timeouts {
        boot: time(check, &entry.boot, "timeouts.boot", 0.1..=120.0)?,
        service: time(check, &entry.service, "timeouts.service", 0.01..=10.0)?,
        drive: time(check, &entry.drive, "timeouts.drive", 0.1..=60.0)?,
        enable: time(check, &entry.enable, "timeouts.enable", 0.02..=5.0)?,
    })
}

fn slack(check: &Checked, entry: &SlackEntry) -> Result<Slack, Refused> {
    Ok(Slack {
        pretension: check.within(&entry.pretension, "slack.pretension", 0.1..=LARGE, "N")?,
        ramp: time(check, &entry.ramp, "slack.ramp", 0.01..=60.0)?,
        most: check.within(&entry.most, "slack.most", 1e-4..=10.0, "m")?,
    })
}

/// Who let go has so long to enable again, s.
const HOLD_TIME: f64 = 10.0;

fn safe(check: &Checked, entry: &SafeEntry) -> Result<Safe, Refused> {
    // Winches that do not resist neither keep the platform level nor can let it down.
    let least = if entry.output == SafeOutput::TorqueOff { 0.0 } else { SMALL };
    Ok(Safe {
        output: entry.output,
        ramp: time(check, &entry.ramp, "safe.ramp", 0.0..=10.0)?,
        stiffness: check.within(&entry.stiffness, "safe.stiffness", least..=LARGE, "N/m")?,
        damping: check.within(&entry.damping, "safe.damping", 0.0..=LARGE, "N s/m")?,
        hold_time: match &entry.hold_time {
            Some(given) => time(check, given, "safe.hold_time", 0.0..=3600.0)?,
            None => (1e9 * HOLD_TIME) as u64,
        },
    })
}

fn home(check: &Checked, home: &Spanned<[f64; 6]>, rig: &Rig) -> Result<Pose, Refused> {
    let (names, offset) = (["x", "y", "z", "roll", "pitch", "yaw"], home.span().start);
    for (k, value) in home.get_ref().iter().enumerate() {
        if !value.is_finite() {
            let field = format!("home[{}] ({})", k + 1, names[k]);
            return Err(check.refuse(offset, &field, value, "must be finite (m, rad)"));
        }
    }
    let pose = Pose(Coordinates::from(*home.get_ref()));
    if !rig.can_be_at(&pose) {
        let allowed = "must be below an anchor of the rig file, or no cable can pull against gravity (m)";
        return Err(check.refuse(offset, "home[3] (z)", pose.0[2], allowed));
    }
    Ok(pose)
}

/// What the rig file says, and the fieldbus file therefore must not.
const OF_THE_RIG: [&str; 14] = [
    "a",
    "b",
    "m",
    "I1",
    "I2",
    "I3",
    "g",
    "mass",
    "inertia",
    "gravity",
    "anchor",
    "attachment",
    "minTension",
    "maxTension",
];

fn controller(check: &Checked, entry: &ControllerEntry, rig: &RigFile) -> Result<ControllerConfig, Refused> {
    for (name, value) in &entry.parameters {
        let stem = name.split(['.', '[']).next().unwrap_or(name);
        if OF_THE_RIG.contains(&stem) {
            let allowed = "the rig file says it, and nothing else does: remove it here";
            let field = format!("controller.parameters.{name}");
            return Err(check.refuse(value.span().start, &field, value.get_ref(), allowed));
        }
    }
    let parameters =
        entry.parameters.iter().map(|(name, value)| (name.clone(), value.get_ref().clone())).collect();
    Ok(ControllerConfig { fmu: entry.fmu.clone(), lambda: rig.lambda, eta: rig.eta, parameters })
}

fn object(
    check: &Checked,
    field: &str,
    index: &Spanned<u32>,
    subindex: &Spanned<u32>,
) -> Result<Object, Refused> {
    let index = check.within(index, &format!("{field}.index"), 0x1000..=0xFFFF, "(0x1000 to 0xFFFF)")?;
    let subindex = check.within(subindex, &format!("{field}.subindex"), 0..=255, "")?;
    Ok(Object::new(index as u16, subindex as u8))
}

fn settings(check: &Checked, entries: &[ObjectEntry], table: &str) -> Result<Vec<Setting>, Refused> {
    let setting = |(k, entry): (usize, &ObjectEntry)| {
        let field = format!("{table}[{}]", k + 1);
        let bytes = check.within(&entry.bytes, &format!("{field}.bytes"), 1..=4, "")?;
        let width = Width::of_bytes(bytes).unwrap_or(Width::Bits32);
        let end = 1i64 << (8 * bytes);
        let value = check.within(&entry.value, &format!("{field}.value"), -end / 2..=end - 1, "")?;
        let bits = (value & (end - 1)) as u32;
        let object = object(check, &field, &entry.index, &entry.subindex)?;
        let node = node(check, &field, &entry.node)?;
        Ok(Setting { object, value: Value { bits, width }, action: entry.action, node })
    };
    entries.iter().enumerate().map(setting).collect()
}

fn node(check: &Checked, field: &str, named: &Option<Spanned<u32>>) -> Result<Option<Node>, Refused> {
    let node = |named| Ok(check.within(named, &format!("{field}.node"), 1..=127, "")? as Node);
    named.as_ref().map(node).transpose()
}

/// Bits of the error register that an ignored emergency may have without their being named: communication, the device profile's, the
/// maker's. Generic (of every error), current, voltage and temperature are to be named.
const HARMLESS: u8 = 0xB0;

fn ignored(check: &Checked, entries: &[EmergencyEntry]) -> Result<Vec<IgnoredEmergency>, Refused> {
    let one = |(k, entry): (usize, &EmergencyEntry)| {
        let field = format!("ignored_emergencies[{}]", k + 1);
        let code = check.within(&entry.code, &format!("{field}.code"), 1..=0xFFFF, "(0x0001 to 0xFFFF)")?;
        let named = |bits| check.within(bits, &format!("{field}.register"), 0..=0xFF, "");
        let named = entry.register.as_ref().map(named).transpose()?.unwrap_or(0);
        let node = node(check, &field, &entry.node)?;
        Ok(IgnoredEmergency { code: code as u16, node, register: HARMLESS | named as u8 })
    };
    entries.iter().enumerate().map(one).collect()
}

/// An entry for each of so many cables, or an error that says how many there are.
fn one_a_cable<T>(
    check: &Checked,
    entries: &Spanned<Vec<T>>,
    table: &str,
    cables: usize,
) -> Result<(), Refused> {
    let count = entries.get_ref().len();
    let refusal = || {
        let allowed = format!("must be {cables}, one a cable of the rig file, in the order of the cables");
        check.refuse(entries.span().start, &format!("number of [[{table}]]"), count, allowed)
    };
    if count == cables { Ok(()) } else { Err(refusal()) }
}

fn drives(check: &Checked, file: &File, buses: &[Bus], cables: usize) -> Result<Vec<Drive>, Refused> {
    one_a_cable(check, &file.drives, "drives", cables)?;
    let entries = file.drives.get_ref();
    let drives: Vec<_> = entries
        .iter()
        .enumerate()
        .map(|(i, entry)| drive(check, entry, i, buses))
        .collect::<Result<_, _>>()?;
    for i in 0..cables {
        let clash =
            |j: &usize| (drives[*j].bus, drives[*j].torque_frame) == (drives[i].bus, drives[i].torque_frame);
        if let Some(j) = (0..i).find(clash) {
            let offset = entries[i]
                .torque_frame
                .as_ref()
                .map_or(entries[i].node.span().start, |f| f.slot.span().start);
            let field = format!("drives[{}].torque_frame", i + 1);
            let value =
                format!("0x{:03X}, slot {}", drives[i].torque_frame.id, drives[i].torque_frame.slot + 1);
            return Err(check.refuse(
                offset,
                &field,
                value,
                format!("drives[{}] has this place already", j + 1),
            ));
        }
    }
    Ok(drives)
}

fn drive(check: &Checked, entry: &DriveEntry, i: usize, buses: &[Bus]) -> Result<Drive, Refused> {
    let field = |name: &str| format!("drives[{}].{name}", i + 1);
    let number = |value, name: &str, range, unit| check.within(value, &field(name), range, unit);
    let node = check.within(&entry.node, &field("node"), 1..=127, "")? as Node;
    let torque_frame = match &entry.torque_frame {
        None => TorqueFrame { id: canopen::RPDO1 + u16::from(node), slot: 0 },
        Some(frame) => TorqueFrame {
            id: check.within(&frame.id, &field("torque_frame.id"), 0x201..=0x57F, "(0x201 to 0x57F)")? as u16,
            slot: check.within(&frame.slot, &field("torque_frame.slot"), 1..=3, "")? as usize - 1,
        },
    };
    let direction = number(&entry.direction, "direction", -1.0..=1.0, "")?;
    if direction.abs() != 1.0 {
        let allowed = "must be 1 (positive counts haul the cable in) or -1";
        return Err(check.refuse(entry.direction.span().start, &field("direction"), direction, allowed));
    }
    let rated_torque = number(&entry.rated_torque, "rated_torque", SMALL..=LARGE, "N m")?;
    let winch = Winch {
        gear: number(&entry.gear, "gear", 1e-3..=1e4, "")?,
        pulley_radius: number(&entry.pulley_radius, "pulley_radius", 1e-3..=1.0, "m")?,
        rated_torque,
        torque_limit: number(
            &entry.torque_limit,
            "torque_limit",
            0.01 * rated_torque..=30.0 * rated_torque,
            "N m",
        )?,
        counts_per_turn: number(&entry.counts_per_turn, "counts_per_turn", 16.0..=4_294_967_296.0, "")?,
        direction,
    };
    Ok(Drive { bus: bus(check, &entry.bus, &field("bus"), buses)?, node, torque_frame, winch })
}

fn load_cells(check: &Checked, file: &File, buses: &[Bus], cables: usize) -> Result<Vec<Cell>, Refused> {
    one_a_cable(check, &file.load_cells, "load_cells", cables)?;
    let entries = file.load_cells.get_ref();
    let mut cells: Vec<_> = entries
        .iter()
        .enumerate()
        .map(|(i, entry)| load_cell(check, entry, i, buses))
        .collect::<Result<_, _>>()?;
    for i in 0..cables {
        let before = cells[..i].iter().filter(|other| other.node == cells[i].node);
        let byte = before.map(|other| other.cell.encoding.width().bytes()).sum::<usize>();
        if byte + cells[i].cell.encoding.width().bytes() > 8 {
            let field = format!("load_cells[{}].node", i + 1);
            let allowed = "the readings of one node must fit into a frame of 8 bytes";
            return Err(check.refuse(entries[i].node.span().start, &field, cells[i].node, allowed));
        }
        cells[i].byte = byte;
    }
    Ok(cells)
}

fn load_cell(check: &Checked, entry: &CellEntry, i: usize, buses: &[Bus]) -> Result<Cell, Refused> {
    let field = |name: &str| format!("load_cells[{}].{name}", i + 1);
    let (scale, offset) = (*entry.scale.get_ref(), *entry.offset.get_ref());
    if !(scale.is_finite() && scale != 0.0) {
        let allowed = "must be finite and not 0 (N a unit)";
        return Err(check.refuse(entry.scale.span().start, &field("scale"), scale, allowed));
    }
    let [least, greatest] = *entry.range.get_ref();
    if !(least.is_finite() && greatest.is_finite() && least < greatest) {
        let value = format!("[{least}, {greatest}]");
        let allowed = "must be two finite numbers, the least first (N)";
        return Err(check.refuse(entry.range.span().start, &field("range"), value, allowed));
    }
    let cell = LoadCell {
        object: object(check, &format!("load_cells[{}]", i + 1), &entry.index, &entry.subindex)?,
        encoding: entry.encoding,
        scale,
        offset: check.within(&entry.offset, &field("offset"), -LARGE..=LARGE, "N").map(|_| offset)?,
        range: [least, greatest],
    };
    let node = check.within(&entry.node, &field("node"), 1..=127, "")? as Node;
    Ok(Cell { bus: bus(check, &entry.bus, &field("bus"), buses)?, node, byte: 0, cell })
}
