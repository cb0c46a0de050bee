//! How a recorded session is written down: what entered the bridge, so that it can be entered again, and what came out.
//!
//! | file | |
//! |---|---|
//! | `fieldbus.toml`, `rig.toml` | fieldbus file and rig file |
//! | `frames.log` | every frame in the order it entered (R) or left (T), as candump writes it |
//! | `inputs.csv` | what else entered: the cycle it came before, what it was, and why a command was not taken |
//! | `cycles.csv` | a row a cycle |

use cable_robot::robot::PerCable;
use cable_robot_fieldbus::bridge::{CycleReport, Identity, Refusal, TransportError};
use cable_robot_fieldbus::candump::{Line, parse_frame};
use cable_robot_fieldbus::{Config, Nanoseconds};

use super::Purpose;
use super::controller;
use super::entry::{Cycle, Input, OnBus};
use super::operator;

pub const FIELDBUS: &str = "fieldbus.toml";
pub const RIG: &str = "rig.toml";
pub const FRAMES: &str = "frames.log";
pub const INPUTS: &str = "inputs.csv";
pub const CYCLES: &str = "cycles.csv";

const DRY_RUN: &str = "dry-run";
const SURVEY: &str = "survey";
/// And then vendor.product.revision.serial of each drive, - for what it does not say.
const COMMISSIONED: &str = "commissioned";

/// What [`INPUTS`] says of what the session was for; nothing for a run with whatever drives there are.
pub fn purpose_text(purpose: &Purpose) -> Option<String> {
    let number = |part: &Option<u32>| part.map_or("-".to_owned(), |part| part.to_string());
    let identity = |identity: &Identity| identity.each_ref().map(number).join(".");
    match purpose {
        Purpose::Run(None) => None,
        Purpose::Run(Some(drives)) => {
            Some(drives.iter().fold(COMMISSIONED.to_owned(), |text, drive| text + " " + &identity(drive)))
        }
        Purpose::DryRun => Some(DRY_RUN.to_owned()),
        Purpose::Survey => Some(SURVEY.to_owned()),
    }
}

/// Reads what [`purpose_text`] wrote for a rig of so many cables.
pub fn parse_purpose(text: &str, cables: usize) -> Option<Purpose> {
    let number = |part: &str| if part == "-" { Some(None) } else { part.parse().ok().map(Some) };
    let identity = |word: &str| -> Option<Identity> {
        word.split('.').map(number).collect::<Option<Vec<_>>>()?.try_into().ok()
    };
    match text {
        DRY_RUN => Some(Purpose::DryRun),
        SURVEY => Some(Purpose::Survey),
        _ => {
            let drives: Option<Vec<_>> =
                text.strip_prefix(COMMISSIONED)?.split_whitespace().map(identity).collect();
            let drives = drives.filter(|drives| drives.len() == cables)?;
            Some(Purpose::Run(Some(PerCable::from_slice(&drives)?)))
        }
    }
}

/// What [`INPUTS`] says first: which controller it was.
pub fn controller_text(identity: &controller::Identity) -> String {
    format!("{CONTROLLER}{identity}")
}

/// What of [`controller_text`] comes before the identity.
pub const CONTROLLER: &str = "controller ";

/// What [`INPUTS`] says where the queue was full.
pub const GAP: &str = "gap";

/// Columns of [`CYCLES`] that are not what the bridge computed.
pub const OWN_COLUMNS: [&str; 6] = ["time", "received", "sent", "lateness_us", "latency_us", "missed_cycles"];

/// Which way a frame went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    Received,
    Sent,
}

/// A line of [`FRAMES`].
pub fn frame_line(config: &Config, on_bus: &OnBus, direction: Direction) -> String {
    let line = Line { time: on_bus.time, bus: &config.buses[on_bus.bus].name, frame: on_bus.frame };
    format!("{line} {}", if direction == Direction::Received { 'R' } else { 'T' })
}

/// Reads a line of [`FRAMES`].
pub fn parse_frame_line(config: &Config, text: &str) -> Result<(OnBus, Direction), String> {
    let Line { time, bus, frame } = Line::parse(text).map_err(|error| error.to_string())?;
    let bus = place(config, bus)?;
    let direction = match text.split_ascii_whitespace().nth(3) {
        Some("R") => Direction::Received,
        Some("T") => Direction::Sent,
        _ => return Err("expected R or T after the frame".to_owned()),
    };
    Ok((OnBus { bus, time, frame }, direction))
}

/// Header of [`INPUTS`].
pub const INPUT_COLUMNS: [&str; 3] = ["cycle", "input", "refused"];

/// The second column of [`INPUTS`].
pub fn input_text(config: &Config, input: &Input) -> String {
    match input {
        Input::Operator(command) => command.to_string(),
        Input::Transport { bus, error, frame } => {
            let name = ERRORS.iter().find(|(known, _)| known == error).map_or("", |(_, name)| name);
            let frame = frame.map_or(String::new(), |frame| format!(" {frame}"));
            format!("error {} {name}{frame}", config.buses[*bus].name)
        }
    }
}

const ERRORS: [(TransportError, &str); 3] =
    [(TransportError::NoRoom, "no-room"), (TransportError::Down, "down"), (TransportError::Gone, "gone")];

/// Reads the second column of [`INPUTS`].
pub fn parse_input(config: &Config, text: &str) -> Result<Input, String> {
    let mut words = text.split_ascii_whitespace();
    if words.next() != Some("error") {
        return operator::command(text)?.map(Input::Operator).ok_or_else(|| "expected a command".to_owned());
    }
    let bus = place(config, words.next().unwrap_or_default())?;
    let kind = words.next().unwrap_or_default();
    let error = ERRORS.iter().find(|(_, name)| *name == kind);
    let (error, _) = error.ok_or_else(|| format!("{kind:?}: expected no-room, down or gone"))?;
    let frame = words.next().map(parse_frame).transpose().map_err(|error| error.to_string())?;
    Ok(Input::Transport { bus, error: *error, frame })
}

fn place(config: &Config, name: &str) -> Result<usize, String> {
    let place = config.buses.iter().position(|bus| bus.name == name);
    place.ok_or_else(|| format!("the fieldbus file has no bus {name:?}"))
}

/// Header of [`CYCLES`] for a rig of so many cables.
pub fn columns(cables: usize) -> Vec<String> {
    let cables = |name: &'static str| (1..=cables).map(move |i| format!("{name}[{i}]"));
    let pose = ["x", "y", "z", "roll", "pitch", "yaw"].map(|axis| format!("pose.{axis}"));
    let mut columns: Vec<_> = OWN_COLUMNS.map(str::to_owned).to_vec();
    columns.extend(["state", "fault"].map(str::to_owned));
    columns.extend(cables("torque"));
    columns.extend(cables("tension"));
    columns.extend(cables("measured"));
    columns.extend(cables("length"));
    columns.extend(pose);
    columns.extend(cables("drive"));
    columns.extend(["status", "setPointIndex", "tensionMargin"].map(str::to_owned));
    columns
}

/// A row of [`CYCLES`] in the order of [`columns`]; `received` and `sent` count the frames so far and of the cycle.
pub fn row(cycle: &Cycle, received: u64, sent: u64) -> Vec<String> {
    let mut row = vec![
        seconds(cycle.report.time),
        received.to_string(),
        sent.to_string(),
        microseconds(cycle.lateness),
        cycle.latency.map_or(String::new(), microseconds),
        cycle.missed.to_string(),
    ];
    row.extend(computed(&cycle.report));
    row
}

/// What the bridge computed, every number in full: equal text is equal bits.
pub fn computed(report: &CycleReport) -> Vec<String> {
    let text = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>();
    let mut row =
        vec![report.state.to_string(), report.fault.map_or(String::new(), |fault| fault.to_string())];
    row.extend(report.target_torque.iter().map(i16::to_string));
    row.extend(text(&report.tension));
    row.extend(text(&report.measured));
    row.extend(text(&report.length));
    row.extend(report.measured_pose.map_or(vec![String::new(); 6], |pose| text(pose.0.as_slice())));
    row.extend(report.drive.iter().map(|state| state.map_or(String::new(), |state| state.to_string())));
    row.extend(match report.controller {
        Some(answer) => {
            [answer.status.to_string(), answer.set_point_index.to_string(), answer.tension_margin.to_string()]
        }
        None => Default::default(),
    });
    row
}

/// The third column of [`INPUTS`]; empty if the command was taken.
pub fn refusal_text(refusal: Option<Refusal>) -> String {
    refusal.map_or(String::new(), |refusal| refusal.to_string())
}

/// As a number that may have a fraction.
fn microseconds(time: Nanoseconds) -> String {
    format!("{}", time as f64 / 1e3)
}

/// Reads what [`microseconds`] wrote.
pub fn parse_microseconds(text: &str) -> Result<Nanoseconds, String> {
    let parsed = text.parse().ok().filter(|time: &f64| (0.0..1e15).contains(time));
    parsed
        .map(|time| (time * 1e3).round() as Nanoseconds)
        .ok_or_else(|| format!("{text:?}: expected a time in us"))
}

/// Whole microseconds as seconds, as candump has them.
pub fn seconds(time: Nanoseconds) -> String {
    format!("{}.{:06}", time / 1_000_000_000, time / 1000 % 1_000_000)
}

/// Reads what [`seconds`] wrote.
pub fn parse_seconds(text: &str) -> Result<Nanoseconds, String> {
    let parsed = text.split_once('.').and_then(|(seconds, fraction)| {
        let (seconds, microseconds) = (seconds.parse::<u64>().ok()?, fraction.parse::<u64>().ok()?);
        (fraction.len() == 6).then_some(())?;
        seconds.checked_mul(1_000_000_000)?.checked_add(microseconds * 1000)
    });
    parsed.ok_or_else(|| format!("{text:?}: expected a time like 12.345678"))
}

#[cfg(test)]
mod tests {
    use cable_robot::robot::Pose;
    use cable_robot_fieldbus::{Frame, OperatorCommand};

    use super::*;
    use crate::program::tests::config;

    #[test]
    fn what_enters_comes_back_as_it_was_written() {
        let config = config();
        let frame = Frame::data(0x181, [1, 2, 3]);
        let on_bus = OnBus { bus: 0, time: 12_345_678_000, frame };
        for direction in [Direction::Received, Direction::Sent] {
            let line = frame_line(&config, &on_bus, direction);
            assert_eq!(parse_frame_line(&config, &line), Ok((on_bus, direction)), "{line}");
        }
        for input in [
            Input::Operator(OperatorCommand::Goal(Pose::at(0.1, 0.2, 1.0))),
            Input::Transport { bus: 0, error: TransportError::NoRoom, frame: Some(frame) },
            Input::Transport { bus: 0, error: TransportError::Gone, frame: None },
        ] {
            let text = input_text(&config, &input);
            assert_eq!(parse_input(&config, &text), Ok(input), "{text}");
        }
        for time in [0, 1, 1_000, 123_456_789] {
            assert_eq!(parse_microseconds(&microseconds(time)), Ok(time));
        }
        for time in [0, 1_000, 999_999_000, 12_345_678_000] {
            assert_eq!(parse_seconds(&seconds(time)), Ok(time));
        }
    }

    #[test]
    fn what_a_session_was_for_comes_back_as_it_was_written() {
        let drives = PerCable::from_fn(6, |i| [Some(1), None, Some(u32::MAX), Some(i as u32)]);
        for purpose in [Purpose::DryRun, Purpose::Survey, Purpose::Run(Some(drives))] {
            let text = purpose_text(&purpose).unwrap();
            assert_eq!(parse_purpose(&text, 6), Some(purpose), "{text}");
        }
        assert_eq!(purpose_text(&Purpose::Run(None)), None);
        for text in ["home", "commissioned", "commissioned 1.2.3.4", "commissioned 1.2.3 1.2.3 1 1 1 1"] {
            assert_eq!(parse_purpose(text, 6), None, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let config = config();
        let error = |text: &str| parse_frame_line(&config, text).unwrap_err();
        assert!(error("(1.0) can0 181#00").contains("R or T"));
        assert!(error("(1.0) can9 181#00 R").contains("no bus \"can9\""));
        assert!(error("(1.0) can0 181#0 R").contains("expected a frame"));
        assert!(parse_input(&config, "error can0 tired").unwrap_err().contains("no-room, down or gone"));
        assert!(parse_input(&config, "").is_err() && parse_input(&config, "fly").is_err());
        assert!(parse_seconds("1.5").is_err() && parse_seconds("-1.000000").is_err());
    }
}
