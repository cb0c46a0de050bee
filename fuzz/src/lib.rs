//! What must hold for any bytes at all, for the fuzzers in `fuzz_targets/` and for the test `tests/fuzz_seeded.rs`.

mod bus;

pub use bus::bridge;

use std::fmt::Debug;
use std::io::BufRead;

use cable_robot::plan::ControllerParameters;
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::ScenarioFile;
use cable_robot_fieldbus::candump::Line;
use cable_robot_fieldbus::slcan::{self, Received};
use cable_robot_fieldbus::{Bridge, Config, FrameQueue, LibraryController, bus_load, export};
use cable_robot_report::Table;

/// Lines of a log and commands of an adapter: what is understood is written and read again as the same.
pub fn frames(data: &[u8]) {
    for text in data.lines().map_while(Result::ok) {
        if let Ok(line) = Line::parse(&text) {
            let written = line.to_string();
            let again = Line::parse(&written).expect(&written);
            assert_eq!((again.bus, again.frame), (line.bus, line.frame), "{text}");
            assert_eq!(again.time, line.time / 1000 * 1000, "{text}");
        }
    }
    let mut decoder = slcan::Decoder::default();
    for received in data.iter().filter_map(|byte| decoder.push(*byte)) {
        if let Received::Frame(frame) = received {
            let encoded = slcan::encode(&frame).expect("what came through the protocol can go back");
            let command = encoded.as_bytes().strip_suffix(b"\r").expect("a command ends so");
            assert_eq!(slcan::decode(command), Received::Frame(frame));
        }
    }
}

/// A fieldbus file: refused with a reason, or good for a bridge that starts.
pub fn fieldbus_file(data: &[u8]) {
    let lab = bus::lab();
    let Some(config) = understood(data, |text| Config::parse(text, &lab)) else { return };
    assert!(bus_load::bus_loads(&config).iter().all(|bus| bus.load > 0.0 && bus.load.is_finite()));
    assert!((0..config.buses.len()).all(|bus| export::dbc(&config, bus).is_ascii()));
    let parameters = ControllerParameters { rig: config.rig, ..ControllerParameters::default() };
    let period = config.period;
    let (mut bridge, mut out) = (Bridge::new(config), FrameQueue::new());
    for k in 1..4 {
        bridge.cycle(k * period, &mut LibraryController::new(parameters), &mut out);
    }
}

/// The files of a robot and of a scenario.
pub fn scenario(data: &[u8]) {
    understood(data, RigFile::parse);
    if let Some(file) = understood(data, ScenarioFile::parse) {
        let scenario = file.scenario("any", Pose::at(0.0, 0.0, 1.0), ControllerParameters::default());
        if let Err(error) = scenario {
            assert!(error.to_string().contains("line"), "{error}");
        }
    }
}

/// A recorded run: what is understood is written and read again as the same.
pub fn run_csv(data: &[u8]) {
    let Ok(table) = Table::read_csv(data) else { return };
    let mut written = vec![];
    table.write_csv(&mut written).expect("memory can be written to");
    let again = Table::read_csv(written.as_slice()).expect("what was written can be read");
    assert_eq!((again.names(), again.rows()), (table.names(), table.rows()));
    for name in table.names() {
        assert_eq!(again.get(name), table.get(name), "{name}");
    }
}

/// What a parser makes of the bytes, if they are text and it accepts them.
fn understood<T, E: ToString + Debug>(data: &[u8], parse: impl Fn(&str) -> Result<T, E>) -> Option<T> {
    let text = std::str::from_utf8(data).ok()?;
    parse(text).inspect_err(|error| assert!(!error.to_string().is_empty(), "{error:?}")).ok()
}
