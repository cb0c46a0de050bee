//! The example that ships: what it means, and what is refused.

use super::*;
use crate::load_cell::Encoding;
use cable_robot::robot::{RobotParameters, TensionLimits};

/// The example that ships.
pub const AKD: &str = include_str!("../../../../rigs/can/akd.toml");
/// The rig file that it names.
pub const LAB: &str = include_str!("../../../../rigs/can/lab.toml");

/// A fieldbus file for the example's rig.
pub fn parse(text: &str) -> Result<Config, ConfigError> {
    Config::parse(text, &RigFile::parse(LAB).unwrap())
}

/// The example with eight cables.
pub fn eight() -> Config {
    let rig = RigFile::parse(include_str!("../../../../rigs/eight.toml")).unwrap();
    Config::parse(include_str!("../../../../rigs/can/eight.toml"), &rig).unwrap()
}

/// What is said of the example with one text replaced by another.
fn refusal(from: &str, to: &str) -> String {
    assert!(AKD.contains(from), "{from}");
    parse(&AKD.replacen(from, to, 1)).expect_err(to).to_string()
}

#[test]
fn the_example_is_right() {
    let config = parse(AKD).unwrap();
    assert_eq!(config.period, 4_000_000);
    assert_eq!(config.drives[1].winch.direction, -1.0);
    assert_eq!(config.drives[2].torque_frame, TorqueFrame { id: 0x203, slot: 0 });
    assert_eq!(config.load_cells[5].cell.encoding, Encoding::F32);
    assert_eq!(config.drive_objects[0].value, Value::u32(1000));
    assert_eq!(config.safe.output, SafeOutput::GravityRamp);
    assert_eq!(config.safe.hold_time, 10_000_000_000);
    let speed = config.lowering_speed();
    assert!(speed == 0.05, "{speed}");
    assert_eq!(config.controller.parameters["forceLoop"], Parameter::Boolean(true));
    assert_eq!(rig_path(AKD).unwrap(), "lab.toml");
    let limits = TensionLimits { min: 0.0, max: 60.0 };
    assert_eq!(config.rig, Rig::paper(&RobotParameters::default(), limits));
}

#[test]
fn an_object_may_be_of_one_node_alone() {
    let config = parse(&AKD.replacen("value = 1000", "node = 2\nvalue = 1000", 1)).unwrap();
    let of = |node| config.drive_objects.iter().filter(|setting| setting.is_of(node)).count();
    assert_eq!((of(1), of(2)), (1, 2));
}

#[test]
fn an_emergency_that_is_ignored_has_no_other_bits_than_those_named() {
    let emergency = |node, code, register| Emergency { node, code, register, maker: [0; 5] };
    let with = |entry: &str| parse(&format!("{AKD}\n[[ignored_emergencies]]\n{entry}\n"));
    let config = with("code = 0x8140").unwrap();
    assert!(config.ignores(&emergency(3, 0x8140, 0x10)) && config.ignores(&emergency(4, 0x8140, 0x80)));
    // Generic, current, voltage, temperature; another code of its class.
    for (code, register) in [(0x8140, 0x11), (0x8140, 0x12), (0x8140, 0x04), (0x8140, 0x08), (0x8141, 0x10)] {
        assert!(!config.ignores(&emergency(3, code, register)), "{code:X} {register:X}");
    }
    let config = with("code = 0x8140\nnode = 3\nregister = 0x01").unwrap();
    assert!(config.ignores(&emergency(3, 0x8140, 0x11)) && !config.ignores(&emergency(4, 0x8140, 0x11)));
    assert!(!config.ignores(&emergency(3, 0x8140, 0x15)));
    for (entry, said) in [
        ("code = 0", "ignored_emergencies[1].code = 0 is not allowed"),
        (
            "code = 1\nnode = 99",
            "ignored_emergencies[1].node = 99 is not allowed: must be of one of the nodes",
        ),
        ("code = 1\nregister = 256", "ignored_emergencies[1].register = 256 is not allowed"),
    ] {
        let error = with(entry).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_long_watchdog_is_taken_with_a_reason() {
    let long = AKD.replacen("drive_watchdog = 0.1 ", "long_watchdog = \"brakes\"\ndrive_watchdog = 60.0 ", 1);
    assert_eq!(parse(&long).unwrap().heartbeat.drive_watchdog, 60_000_000_000);
}

#[test]
fn what_limits_leave_out_follows_from_the_rig() {
    let limits = parse(AKD).unwrap().limits;
    assert!((limits.torque_error - 0.4).abs() < 1e-12 && limits.latency == 5.0, "{limits:?}");
    assert!((limits.following - 0.0212).abs() < 1e-3, "{limits:?}");
    let [x, y, z] = limits.space;
    assert!((x[0] + 0.5196).abs() < 1e-3 && (x[1] - 0.2887).abs() < 1e-3 && y == [-0.45, 0.45], "{limits:?}");
    assert!(z[0] == 0.0 && (z[1] - 1.2887).abs() < 1e-3, "{limits:?}");
}

#[test]
fn bad_values_are_named_with_their_line() {
    let line = AKD.lines().position(|line| line.starts_with("rate")).unwrap() + 1;
    let rate = refusal("rate = 250.0", "rate = 0");
    assert_eq!(rate, format!("line {line}: rate = 0 is not allowed: must be from 1 to 2000 Hz"));
    for (from, to, said) in [
        ("rate = 250.0", "rate = nan", "rate = NaN"),
        (
            "pretension = 3.0",
            "pretension = 70.0",
            "slack.pretension = 70 is not allowed: must be from 0.1 to ",
        ),
        (
            "disagreement = 2.0",
            "disagreement = 3.0",
            "limits.disagreement = 3 is not allowed: must be less than slack.pretension (3 N)",
        ),
        ("direction = 1", "direction = 0.5", "drives[1].direction = 0.5 is not allowed: must be 1"),
        ("node = 2\n", "node = 1\n", "drives[2].torque_frame = 0x201, slot 1"),
        ("node = 127", "node = 3", "drives[3].node = 3 is not allowed: the bridge has"),
        ("node = 16", "node = 6", "load_cells[6].node = 6 is not allowed: drives[6] has"),
        (
            "timeout = 0.1 ",
            "timeout = 0.03 ",
            "heartbeat.timeout = 0.03 is not allowed: must be from 0.04 to 60 s",
        ),
        (
            "bus = \"can0\"\nnode = 3",
            "bus = \"can7\"\nnode = 3",
            "drives[3].bus = can7 is not allowed: must be the name of one of [[buses]]: can0",
        ),
        (
            "stiffness = 60.0",
            "stiffness = 0.0",
            "safe.stiffness = 0 is not allowed: must be from 0.000001 to",
        ),
        ("stiffness = 60.0", "hold_time = -1.0\nstiffness = 60.0", "safe.hold_time = -1 is not allowed"),
        ("scale = 1.0", "scale = 0.0", "load_cells[1].scale = 0"),
        ("range = [-5.0, 150.0]", "range = [5.0, -150.0]", "load_cells[1].range = [5, -150]"),
        ("index = 0x6130", "index = 0x61300", "load_cells[1].index = 398080"),
        ("home = [0.0, 0.0, 1.0", "home = [0.0, 0.0, -1.0", "home[3] (z) = -1"),
        (
            "forceLoop = true",
            "maxTension = 60",
            "controller.parameters.maxTension = 60 is not allowed: the rig file says it",
        ),
        ("forceLoop = true", "\"anchor[2].x\" = 2.0", "controller.parameters.anchor[2].x = 2 is not allowed"),
        ("value = 1000", "value = 4294967296", "drive_objects[1].value = 4294967296"),
        (
            "value = 1000",
            "node = 11\nvalue = 1000",
            "drive_objects[1].node = 11 is not allowed: must be the node of a drive",
        ),
        (
            "torque_limit = 1.6",
            "torque_limit = 1.4",
            "drives[1].torque_limit = 1.4 is not allowed: must be at least 1.5 N m for the greatest tension of the rig file (60 N)",
        ),
        (
            "home = [0.0, 0.0, 1.0",
            "home = [1.5, 0.0, 1.0",
            "home = [1.5, 0, 1, 0, 0, 0] is not allowed: must be a pose that cables hold within the limits of the rig file",
        ),
        (
            "[[buses]]",
            "[[buses]]\nname = \"can0\"\nbit_rate = 1e6\n\n[[buses]]",
            "buses[2].name = can0 is not allowed: buses[1] has this name already",
        ),
        (
            "counts_per_turn = 65536.0",
            "counts_per_turn = 16.0",
            "drives[1].counts_per_turn = 16 is not allowed: must be at least 39",
        ),
        (
            "drive_watchdog = 0.1 ",
            "drive_watchdog = 60.0 ",
            "heartbeat.drive_watchdog = 60 is not allowed: must be at most timeouts.enable (0.5 s)",
        ),
        (
            "tilt = 0.15",
            "space = [[-0.3, 0.3], [0.1, 0.3], [0.8, 1.0]]\ntilt = 0.15",
            "limits.space[2] (y) = [0.1, 0.3] is not allowed: must be two numbers",
        ),
        (
            "index = 0x605A",
            "index = 0x6040",
            "object = 0x6040:0 is not allowed: the bridge sets this object itself",
        ),
        (
            "rate = 250.0",
            "rate = 19.0",
            "heartbeat.drive_watchdog = 0.1 is not allowed: must be longer than 0.26",
        ),
        (
            "lost_cycles = 4",
            "lost_cycles = 24",
            "heartbeat.drive_watchdog = 0.1 is not allowed: must be longer than 0.1 s",
        ),
    ] {
        let refusal = refusal(from, to);
        assert!(refusal.starts_with("line ") && refusal.contains(said), "{refusal}");
    }
}

#[test]
fn unknown_missing_and_mistyped_fields_are_named_with_their_line() {
    for (from, to, said) in [
        ("gear = 1.0", "gears = 1.0", "gears"),
        ("gear = 1.0", "", "gear"),
        ("output = \"gravity-ramp\"", "output = \"pray\"", "pray"),
        ("encoding = \"f32\"", "encoding = \"f64\"", "f64"),
    ] {
        let refusal = refusal(from, to);
        assert!(refusal.contains("line ") && refusal.contains(said), "{refusal}");
    }
    let five = AKD.rsplit_once("[[load_cells]]").unwrap().0;
    let error = parse(five).unwrap_err().to_string();
    assert!(error.contains("number of [[load_cells]] = 5 is not allowed: must be 6"), "{error}");
    let nameless = rig_path(&AKD.replacen("rig = ", "rigs = ", 1)).unwrap_err().to_string();
    assert!(nameless.contains("missing field `rig`"), "{nameless}");
    let unlimited = RigFile::parse(&LAB.replacen("max = 60.0", "", 1)).unwrap();
    let error = Config::parse(AKD, &unlimited).unwrap_err().to_string();
    assert!(error.contains("rig = lab.toml is not allowed: its rig file must say the greatest"), "{error}");
}

#[test]
fn readings_of_one_amplifier_follow_each_other() {
    let text = AKD.replace("node = 12\n", "node = 11\n");
    let same = parse(&text).unwrap_err().to_string();
    assert!(same.contains("load_cells[2].index, subindex = 0x6130:1 is not allowed"), "{same}");
    let text = text.replacen(
        "node = 11\nindex = 0x6130\nsubindex = 1",
        "node = 11\nindex = 0x6130\nsubindex = 2",
        1,
    );
    let config = parse(&text).unwrap();
    assert_eq!((config.load_cells[0].byte, config.load_cells[1].byte), (0, 4));
    let three = text.replace("node = 13\n", "node = 11\n");
    let error = parse(&three).unwrap_err().to_string();
    assert!(error.contains("load_cells[3].node = 11"), "{error}");
}
