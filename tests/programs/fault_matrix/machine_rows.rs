//! The programs on the CAN of a real kernel, in a virtual machine under software emulation: its times say nothing.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use cable_robot_fieldbus::Nanoseconds;

use crate::machine::{Machine, Outcome};
use crate::table::{Row, count};
use crate::{Case, ensure};

const SCRIPTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/programs/fault_matrix/machine");

/// Of the fieldbus file in the machine, and how exactly it can be kept there, ms.
const WATCHDOG: f64 = 2000.0;
const GRAIN: f64 = 200.0;
/// The cycles that the bridge rides through, and the one in which it gives up, ms: on a bus without room heartbeats may get through, and keep
/// the watchdog calm, where torques do not.
const RIDDEN: f64 = 101.0 * 10.0;

type Outcomes = Result<BTreeMap<String, Outcome>, String>;

/// All of them; the first boots the machine for all.
pub fn cases() -> Vec<Case> {
    let outcomes: Arc<OnceLock<Outcomes>> = Arc::default();
    [
        ("ENOBUFS", "enobufs", Some("bus 0: no room to send (ENOBUFS)|the encoder of cable 1 is silent")),
        ("link down", "link_down", Some("bus 0: the link is down")),
        ("link removed", "link_removed", Some("bus 0: the link is")),
        ("bus-off report", "bus_off", Some("bus 0 is off")),
        ("load cell's frames say NaN (cangw)", "nan", Some("load cell 4 says NaN N, which cannot be")),
        ("wall clock set", "clock_set", None),
        ("1 % of the frames lost (netem)", "loss", None),
    ]
    .into_iter()
    .map(|(name, script, cause)| {
        let outcomes = Arc::clone(&outcomes);
        let run = move || {
            let outcomes = outcomes.get_or_init(boot).as_ref().map_err(String::clone)?;
            let outcome = outcomes.get(script).ok_or("the scenario did not run")?;
            judge(name, outcome, cause)
        };
        Case { name, kind: "virtual machine", run: Box::new(run) }
    })
    .collect()
}

fn boot() -> Outcomes {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let scripts = std::fs::read_dir(SCRIPTS).map_err(|error| text(&error))?;
    let scripts = scripts.flatten().map(|entry| entry.path());
    let folder = tempfile::tempdir().map_err(|error| text(&error))?;
    let rig = folder.path().join("rig.toml");
    std::fs::write(&rig, rig_text()?).map_err(|error| text(&error))?;
    let machine = Machine {
        programs: vec![
            (env!("CARGO_BIN_EXE_can-bridge").into(), "can-bridge"),
            (env!("CARGO_BIN_EXE_rig-sim").into(), "rig-sim"),
        ],
        files: vec![
            (rig, "/rig.toml"),
            (concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/lab.toml").into(), "/lab.toml"),
            (PathBuf::from(SCRIPTS).join("lab.inc"), "/lab"),
        ],
        scenarios: scripts
            .filter(|path| path.extension().is_some_and(|extension| extension == "sh"))
            .collect(),
    };
    machine.run().map_err(|error| format!("{error:#}"))
}

/// The example, for a machine that is ten times slower than it seems, and stands still for a second now and then.
fn rig_text() -> Result<String, String> {
    let mut rig = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml"))
        .map_err(|error| error.to_string())?;
    for (from, to) in [
        ("rate = 250.0 ", "rate = 100.0 "),
        ("lost_cycles = 4 ", "lost_cycles = 100 "),
        ("timeout = 0.1 ", "timeout = 5.0 "),
        ("drive_watchdog = 0.1 ", "drive_watchdog = 2.0 "),
        ("enable = 0.5 ", "enable = 5.0 "),
        ("service = 0.5 ", "service = 5.0 "),
        ("ramp = 2.0 ", "ramp = 0.5 "),
        ("cable_speed = 2.0 ", "cable_speed = 20.0 "),
        ("disagreement_time = 0.1 ", "disagreement_time = 1.0 "),
    ] {
        ensure(rig.contains(from), || format!("the example no longer says {from:?}"))?;
        rig = rig.replacen(from, to, 1);
    }
    Ok(rig)
}

/// `cause`: what must have ended the tensions, one of several between bars; nothing may have if there is none.
fn judge(name: &str, outcome: &Outcome, cause: Option<&str>) -> Result<Row, String> {
    let story = || outcome.lines.join("\n");
    ensure(outcome.exit_code == 0, story)?;
    let after = |start: &str| outcome.lines.iter().find_map(|line| line.strip_prefix(start));
    let exit = after("exit: ").and_then(|code| code.parse().ok());
    let said = after("said: ").ok_or_else(story)?;
    let line = said.split_once("FAULT: ").map_or("none", |(_, text)| text);
    let is_expected = cause.unwrap_or("none").split('|').any(|start| line.starts_with(start));
    ensure(is_expected, || format!("said {line:?}:\n{}", story()))?;
    ensure(exit == Some(if cause.is_some() { 5 } else { 0 }), || format!("exit {exit:?}:\n{}", story()))?;
    let mut drives = BTreeMap::new();
    for line in outcome.lines.iter().filter_map(|line| line.split_once(" s  drive ")) {
        line.1.split_once(": ").map(|(drive, state)| drives.insert(drive, state.to_owned()));
    }
    let oldest = after("rig: oldest command that a motor followed: ");
    let oldest: f64 = oldest.and_then(|text| text.strip_suffix(" ms")?.parse().ok()).ok_or_else(story)?;
    ensure(oldest <= WATCHDOG + RIDDEN + GRAIN, || format!("a motor followed a command for {oldest} ms"))?;
    Ok(Row {
        name: name.to_owned(),
        stated: if cause.is_some() { "not asserted" } else { "goes on" }.to_owned(),
        ended: None,
        safe: None,
        oldest: Some((oldest * 1e6) as Nanoseconds),
        drives: count(drives.into_values()),
        down: "-".to_owned(),
        exit,
        line: line.to_owned(),
    })
}
