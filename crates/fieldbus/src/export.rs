//! What is on a bus, as a DBC file: the format in which bench tools (SavvyCAN, BUSMASTER, CANalyzer, cantools) learn names, scaling and
//! units of signals.

use std::fmt::Write;

use super::bus_load::torque_frame_bytes;
use super::canopen::{NmtState, Node, SYNC_ID, TPDO1};
use super::config::{Cell, Config};
use super::load_cell::Encoding;

/// Bits of a status word that a drive of CiA 402 sets, from bit 0; the empty ones are the maker's or the mode's.
const STATUS_BITS: [&str; 12] = [
    "readyToSwitchOn",
    "switchedOn",
    "operationEnabled",
    "fault",
    "voltageEnabled",
    "noQuickStop",
    "switchOnDisabled",
    "warning",
    "",
    "remote",
    "",
    "internalLimit",
];

/// The control words that the bridge sends.
const CONTROL_WORDS: &str = r#"0 "disable voltage" 2 "quick stop" 6 "shutdown" 7 "switch on" 15 "enable operation" 128 "fault reset""#;

/// States of NMT in a heartbeat.
const NMT_STATES: &str = r#"0 "boot-up" 4 "stopped" 5 "operational" 127 "pre-operational""#;

/// A DBC file of the bus at this place of [`Config::buses`]: process data, SYNC, heartbeats and emergency messages.
///
/// Signals are numbered by their cable. Torques are shown as the tensions that they make in the cable, N; positions as metres of cable,
/// getting longer, from the encoder's zero.
pub fn dbc(config: &Config, bus: usize) -> String {
    let mut file = File { messages: String::new(), attributes: String::new() };
    file.message(SYNC_ID, "sync", 0, "bridge");
    let mut nodes = vec![(config.node, "bridge".to_owned())];
    torque_frames(&mut file, config, bus);
    drives(&mut file, &mut nodes, config, bus);
    load_cells(&mut file, &mut nodes, config, bus);
    for (node, name) in &nodes {
        heartbeat_and_emergency(&mut file, *node, name);
    }
    let names: Vec<_> = nodes.iter().map(|(_, name)| name.as_str()).collect();
    let File { messages, attributes } = file;
    format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {}\n\n{messages}\n{attributes}", names.join(" "))
}

struct File {
    messages: String,
    /// Comments, names of values, and kinds of numbers: they stand after all messages.
    attributes: String,
}

/// A number in a frame, little endian.
struct Signal {
    name: String,
    /// First bit, and how many.
    bits: (usize, usize),
    is_signed: bool,
    /// Physical value of one, and of zero.
    scale: f64,
    offset: f64,
    /// Physical; both 0 if nothing is said of it.
    range: [f64; 2],
    unit: &'static str,
}

impl Signal {
    /// A number as it is, without a sign.
    fn plain(name: String, first: usize, count: usize) -> Self {
        let (scale, offset, range) = (1.0, 0.0, [0.0; 2]);
        Self { name, bits: (first, count), is_signed: false, scale, offset, range, unit: "" }
    }
}

// Writing to a String cannot fail.
impl File {
    fn message(&mut self, id: u16, name: &str, bytes: usize, sender: &str) {
        let _ = writeln!(self.messages, "\nBO_ {id} {name}: {bytes} {sender}");
    }

    /// Of the last message.
    fn signal(&mut self, signal: &Signal) {
        let Signal { name, bits: (first, count), is_signed, scale, offset, range: [least, greatest], unit } =
            signal;
        let sign = if *is_signed { '-' } else { '+' };
        let _ = writeln!(
            self.messages,
            " SG_ {name} : {first}|{count}@1{sign} ({scale},{offset}) [{least}|{greatest}] \"{unit}\" Vector__XXX"
        );
    }

    fn comment(&mut self, id: u16, signal: &str, text: &str) {
        let _ = writeln!(self.attributes, "CM_ SG_ {id} {signal} \"{text}\";");
    }

    fn values(&mut self, id: u16, signal: &str, values: &str) {
        let _ = writeln!(self.attributes, "VAL_ {id} {signal} {values} ;");
    }

    /// The signal is an IEEE number of 32 bits.
    fn float(&mut self, id: u16, signal: &str) {
        let _ = writeln!(self.attributes, "SIG_VALTYPE_ {id} {signal} : 1;");
    }
}

fn torque_frames(file: &mut File, config: &Config, bus: usize) {
    for (_, id, slots) in config.torque_frames().iter().filter(|frame| frame.0 == bus) {
        let cables: Vec<_> = slots.iter().flatten().map(|cable| (cable + 1).to_string()).collect();
        let name = cables.join("_");
        file.message(*id, &format!("torque_{name}"), torque_frame_bytes(slots), "bridge");
        let control = format!("controlWord_{name}");
        file.signal(&Signal::plain(control.clone(), 0, 16));
        file.values(*id, &control, CONTROL_WORDS);
        for (slot, cable) in slots.iter().enumerate() {
            let Some(cable) = *cable else { continue };
            let (name, winch) = (format!("targetTension_{}", cable + 1), &config.drives[cable].winch);
            file.signal(&Signal {
                is_signed: true,
                scale: winch.tension(1),
                range: [0.0, f64::from(winch.permille_limit()) * winch.newtons_per_permille()],
                unit: "N",
                ..Signal::plain(name.clone(), 16 * (slot + 1), 16)
            });
            file.comment(*id, &name, "Object 0x6071, per mille of the rated torque, as tension of the cable");
        }
    }
}

fn drives(file: &mut File, nodes: &mut Vec<(Node, String)>, config: &Config, bus: usize) {
    for (i, drive) in config.drives.iter().enumerate().filter(|(_, drive)| drive.bus == bus) {
        let (cable, winch, id) = (i + 1, &drive.winch, TPDO1 + u16::from(drive.node));
        let node = format!("drive_{cable}");
        file.message(id, &node, 8, &node);
        for (bit, name) in STATUS_BITS.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            file.signal(&Signal::plain(format!("{name}_{cable}"), bit, 1));
        }
        let (length, tension) = (format!("cableLength_{cable}"), format!("motorTension_{cable}"));
        let scale = winch.lengthening(1, 0);
        file.signal(&Signal { is_signed: true, scale, unit: "m", ..Signal::plain(length.clone(), 16, 32) });
        file.comment(id, &length, "Object 0x6064, counts, as length of the cable from the encoder's zero");
        let scale = winch.tension(1);
        file.signal(&Signal { is_signed: true, scale, unit: "N", ..Signal::plain(tension.clone(), 48, 16) });
        file.comment(id, &tension, "Object 0x6077, per mille of the rated torque, as tension of the cable");
        nodes.push((drive.node, node));
    }
}

fn load_cells(file: &mut File, nodes: &mut Vec<(Node, String)>, config: &Config, bus: usize) {
    let mut cells: Vec<_> =
        config.load_cells.iter().enumerate().filter(|(_, cell)| cell.bus == bus).collect();
    // Cells of a node share its frame, the last one comes last in it.
    cells.sort_by_key(|(_, cell)| (cell.node, cell.byte));
    for of_node in cells.chunk_by(|(_, a), (_, b)| a.node == b.node) {
        let Some((_, last)) = of_node.last() else { continue };
        let (id, node) = (TPDO1 + u16::from(last.node), format!("loadCell_{}", last.node));
        file.message(id, &node, last.byte + last.cell.encoding.width().bytes(), &node);
        for (i, Cell { byte, cell, .. }) in of_node {
            let name = format!("measuredTension_{}", i + 1);
            file.signal(&Signal {
                is_signed: true,
                scale: cell.scale,
                offset: cell.offset,
                range: cell.range,
                unit: "N",
                ..Signal::plain(name.clone(), 8 * byte, 8 * cell.encoding.width().bytes())
            });
            if cell.encoding == Encoding::F32 {
                file.float(id, &name);
            }
        }
        nodes.push((last.node, node));
    }
}

fn heartbeat_and_emergency(file: &mut File, node: Node, name: &str) {
    let id = NmtState::Operational.heartbeat(node).id();
    let state = format!("nmtState_{name}");
    file.message(id, &format!("heartbeat_{name}"), 1, name);
    file.signal(&Signal::plain(state.clone(), 0, 7));
    file.values(id, &state, NMT_STATES);
    if name != "bridge" {
        file.message(SYNC_ID + u16::from(node), &format!("emergency_{name}"), 8, name);
        file.signal(&Signal::plain(format!("errorCode_{name}"), 0, 16));
        file.signal(&Signal::plain(format!("errorRegister_{name}"), 16, 8));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::{AKD, parse};

    /// The line of a signal, from its bits on.
    fn signal<'a>(dbc: &'a str, name: &str) -> &'a str {
        let line = dbc.lines().find_map(|line| line.strip_prefix(&format!(" SG_ {name} : ")));
        line.unwrap_or_else(|| panic!("no {name} in\n{dbc}"))
    }

    #[test]
    fn signals_have_their_places_and_scales() {
        let dbc = dbc(&parse(AKD).unwrap(), 0);
        // 1 ‰ of 1 N m at 0.025 m; drive 2 turns the other way.
        assert_eq!(signal(&dbc, "targetTension_1"), r#"16|16@1- (0.04,0) [0|64] "N" Vector__XXX"#);
        assert_eq!(signal(&dbc, "targetTension_2"), r#"16|16@1- (-0.04,0) [0|64] "N" Vector__XXX"#);
        assert!(signal(&dbc, "cableLength_2").starts_with("16|32@1- (0.0000023968"), "{dbc}");
        assert_eq!(signal(&dbc, "measuredTension_6"), r#"0|32@1- (1,0) [-5|150] "N" Vector__XXX"#);
        assert!(dbc.contains("\nBO_ 513 torque_1: 4 bridge\n"), "{dbc}");
        assert!(dbc.contains("\nSIG_VALTYPE_ 400 measuredTension_6 : 1;\n"), "{dbc}");
    }

    #[test]
    fn what_shares_a_frame_stands_in_one_message_and_buses_are_apart() {
        let shared = AKD
            .replace("node = 12\nindex = 0x6130\nsubindex = 1", "node = 11\nindex = 0x6130\nsubindex = 2")
            .replacen("node = 2\n", "node = 2\ntorque_frame = { id = 0x201, slot = 2 }\n", 1)
            .replacen("[heartbeat]", "[[buses]]\nname = \"can1\"\nbit_rate = 1e6\n\n[heartbeat]", 1)
            .replacen("bus = \"can0\"\nnode = 16", "bus = \"can1\"\nnode = 16", 1);
        let config = parse(&shared).unwrap();
        let [first, second] = [dbc(&config, 0), dbc(&config, 1)];
        assert!(first.contains("\nBO_ 513 torque_1_2: 6 bridge\n"), "{first}");
        assert!(first.contains("\nBO_ 395 loadCell_11: 8 loadCell_11\n"), "{first}");
        assert!(signal(&first, "targetTension_2").starts_with("32|16"));
        assert!(signal(&first, "measuredTension_2").starts_with("32|32"));
        assert!(!first.contains("measuredTension_6") && second.contains("measuredTension_6"));
        assert!(!second.contains("targetTension"));
    }
}
