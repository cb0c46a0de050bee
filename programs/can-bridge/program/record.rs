//! A session on disk: the log (see [`log`]), and from the first time the controller pulls a run folder for the report.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, Status};
use cable_robot::robot::Pose;
use cable_robot::sim::{Moment, PlantInputs, PlantOutputs, PlantParameters};
use cable_robot_fieldbus::bridge::{CycleReport, Event};
use cable_robot_fieldbus::{Config, Files, Nanoseconds, OperatorCommand, State};
use cable_robot_report::RunFolderError;
use cable_robot_report::events::{self, EVENT_COLUMNS, EVENTS_CSV, Kind};
use cable_robot_report::facts::pose_in_words;
use cable_robot_report::files::{begin, write_whole};
use cable_robot_report::recording::{Recording as Rows, columns};
use cable_robot_report::run_folder::{self, FORMAT, RUN_CSV, RUN_JSON, RunInfo};
use nalgebra::Vector3;

use super::Purpose;
use super::controller::BridgeController;
use super::entry::{Cycle, Entry, Input};
use super::fate::Goals;
use super::log::{self, Direction};

/// What an encoder and a load cell do not tell.
const NOT_MEASURED: [&str; 3] = ["plant.velocity", "plant.angularVelocity", "plant.disturbance"];

/// Files that are there once something was recorded.
const SIGNS: [&str; 7] = [log::FIELDBUS, log::RIG, log::INPUTS, log::CYCLES, RUN_CSV, RUN_JSON, EVENTS_CSV];

/// Refuses a folder with a recording in it.
pub fn refuse_to_overwrite(folder: &Path) -> Result<()> {
    if let Some(name) = SIGNS.iter().find(|name| folder.join(name).exists()) {
        bail!("{} already holds a recording ({name}): name another folder, or remove it", folder.display());
    }
    Ok(())
}

/// A file to which only whole rows are handed, all together when it is flushed: after `kill -9` none is cut.
struct RowFile {
    file: File,
    rows: Vec<u8>,
}

impl RowFile {
    /// In place of what stands there.
    fn create(path: &Path) -> Result<Self, RunFolderError> {
        Ok(Self { file: begin(path)?, rows: vec![] })
    }
}

impl Write for RowFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.rows.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.write_all(&self.rows)?;
        self.rows.clear();
        Ok(())
    }
}

/// The files of a session, being written.
pub struct Recording {
    config: Config,
    frames: RowFile,
    inputs: csv::Writer<RowFile>,
    cycles: csv::Writer<RowFile>,
    run: Run,
    received: u64,
    sent: u64,
    cycle: u64,
}

impl Recording {
    /// Makes the folder and its files.
    pub fn create(
        folder: &Path,
        files: &Files,
        controller: &BridgeController,
        purpose: Purpose,
    ) -> Result<Self> {
        run_folder::make(folder)?;
        let create = |name: &str| RowFile::create(&folder.join(name));
        for (name, text) in [(log::FIELDBUS, &files.fieldbus), (log::RIG, &files.rig)] {
            write_whole(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
        }
        let config = &files.config;
        let mut inputs = csv::Writer::from_writer(create(log::INPUTS)?);
        inputs.write_record(log::INPUT_COLUMNS)?;
        inputs.write_record(["0", &log::controller_text(controller.identity()), ""])?;
        if let Some(text) = log::purpose_text(&purpose) {
            inputs.write_record(["0", &text, ""])?;
        }
        let mut cycles = csv::Writer::from_writer(create(log::CYCLES)?);
        cycles.write_record(log::columns(config.rig.cables.len()))?;
        Ok(Self {
            frames: create(log::FRAMES)?,
            inputs,
            cycles,
            run: Run::new(folder, config, controller),
            config: config.clone(),
            received: 0,
            sent: 0,
            cycle: 0,
        })
    }

    /// Writes down what happened.
    pub fn take(&mut self, entry: &Entry) -> io::Result<()> {
        self.run.tell(entry)?;
        match entry {
            Entry::Received(on_bus) => {
                self.received += 1;
                writeln!(self.frames, "{}", log::frame_line(&self.config, on_bus, Direction::Received))?;
            }
            Entry::Sent(on_bus) => {
                self.sent += 1;
                writeln!(self.frames, "{}", log::frame_line(&self.config, on_bus, Direction::Sent))?;
            }
            Entry::Input(input, refusal) => {
                if let (Input::Operator(OperatorCommand::Goal(goal)), None) = (input, refusal) {
                    self.run.goal = *goal;
                }
                self.input(&log::input_text(&self.config, input), &log::refusal_text(*refusal))?;
            }
            Entry::Lost(_) => self.input(log::GAP, "")?,
            Entry::Event(_, Event::Entered(State::Enabled)) => self.run.is_enabled_anew = true,
            Entry::Cycle(cycle) => self.take_cycle(cycle)?,
            Entry::Event(..) | Entry::Refused(..) | Entry::Note(..) => {}
        }
        Ok(())
    }

    fn input(&mut self, text: &str, refused: &str) -> io::Result<()> {
        self.inputs.write_record([&self.cycle.to_string(), text, refused])?;
        // Never behind the cycles, even if the program is killed.
        self.inputs.flush()
    }

    fn take_cycle(&mut self, cycle: &Cycle) -> io::Result<()> {
        self.cycles.write_record(log::row(cycle, self.received, self.sent))?;
        self.sent = 0;
        self.cycle += 1;
        self.run.take(&cycle.report)
    }

    /// Hands everything to the system: frames first, so that no row of the cycles tells of frames that are not there.
    pub fn flush(&mut self) -> io::Result<()> {
        self.frames.flush()?;
        self.inputs.flush()?;
        self.cycles.flush()?;
        [&mut self.run.events, &mut self.run.csv].into_iter().flatten().try_for_each(csv::Writer::flush)
    }
}

/// The run folder in it: rows from the first cycle in which the controller may pull.
struct Run {
    folder: PathBuf,
    info: RunInfo,
    rows: Rows,
    csv: Option<csv::Writer<RowFile>>,
    events: Option<csv::Writer<RowFile>>,
    /// The last in `events`.
    state: Option<State>,
    goals: Goals,
    /// The goal that was refused last: it may be given again and again.
    refused: Option<Pose>,
    begun: Nanoseconds,
    /// Of the last cycle.
    now: Nanoseconds,
    answer: Option<ControllerOutputs>,
    goal: Pose,
    is_enabled_anew: bool,
}

impl Run {
    fn new(folder: &Path, config: &Config, controller: &BridgeController) -> Self {
        let info = RunInfo {
            format: FORMAT,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            title: config.name.clone(),
            scenario: None,
            controller: controller.info().clone(),
            plant: run_folder::Model::Rig,
            rig: config.name.clone(),
            orbit: None,
            step: config.period as f64 * 1e-9,
            controller_parameters: controller.parameters(),
            plant_parameters: PlantParameters {
                rig: config.rig,
                initial_pose: config.home,
                ..PlantParameters::default()
            },
        };
        Self {
            folder: folder.to_owned(),
            info,
            rows: Rows::new(config.rig.cables.len()),
            csv: None,
            events: None,
            state: None,
            goals: Goals::new(controller.parameters()),
            refused: None,
            begun: 0,
            now: 0,
            answer: None,
            goal: config.home,
            is_enabled_anew: false,
        }
    }

    /// Writes down what happened beside the rows.
    fn tell(&mut self, entry: &Entry) -> io::Result<()> {
        if let Some(text) = self.goals.take(entry) {
            self.event(self.now, Kind::Goal, text)?;
        }
        match entry {
            Entry::Cycle(cycle) => self.now = cycle.report.time,
            Entry::Event(time, Event::Entered(state)) => self.enter(*time, *state)?,
            Entry::Event(time, Event::Fault(fault)) => self.event(*time, Kind::Fault, fault.to_string())?,
            Entry::Input(Input::Operator(OperatorCommand::Goal(goal)), refusal) => {
                let is_new = self.refused != Some(*goal);
                self.refused = refusal.map(|_| *goal);
                if let Some(refusal) = refusal.filter(|_| is_new) {
                    let text = format!("goal {}: {refusal}", pose_in_words(goal));
                    self.event(self.now, Kind::Refused, text)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn enter(&mut self, time: Nanoseconds, state: State) -> io::Result<()> {
        if self.events.is_none() || self.state.replace(state) == Some(state) {
            return Ok(());
        }
        self.event(time, Kind::State, state.to_string())
    }

    /// Once there are rows.
    fn event(&mut self, time: Nanoseconds, kind: Kind, text: String) -> io::Result<()> {
        let Some(events) = &mut self.events else { return Ok(()) };
        let time = time.saturating_sub(self.begun) as f64 * 1e-9;
        events.serialize(events::Event { time, kind, text }).map_err(io::Error::from)
    }

    fn take(&mut self, report: &CycleReport) -> io::Result<()> {
        self.answer = report.controller.or(self.answer);
        let is_shown = match report.state {
            State::Enabled | State::Shadow => true,
            State::Stopping | State::Safe | State::Fault | State::Lowering => self.csv.is_some(),
            State::Configuring
            | State::Homing
            | State::Trying
            | State::Jogging
            | State::TakingUpSlack
            | State::Ready
            | State::Off => false,
        };
        let Some(answer) = self.answer.filter(|_| is_shown) else { return Ok(()) };
        // Where the platform was then, nobody knows.
        let Some(pose) = report.measured_pose else { return Ok(()) };
        if self.is_enabled_anew && report.state == State::Enabled {
            let at = report.pose.position();
            (self.is_enabled_anew, self.goal) = (false, Pose::at(at.x, at.y, at.z));
        }
        if self.csv.is_none() {
            self.begin(report.time)?;
            self.enter(report.time, report.state)?;
        }
        let moment = moment(report, &pose, &answer, self.goal, (report.time - self.begun) as f64 * 1e-9);
        let row = self.rows.row(&moment);
        let kept = columns(report.length.len())
            .into_iter()
            .zip(row)
            .filter(|(name, _)| is_measured(name))
            .map(|(_, value)| value);
        let row: Vec<f64> = std::iter::once(moment.time).chain(kept).collect();
        self.csv.as_mut().map_or(Ok(()), |csv| csv.serialize(row).map_err(io::Error::from))
    }

    fn begin(&mut self, time: Nanoseconds) -> io::Result<()> {
        let create = |name: &str| RowFile::create(&self.folder.join(name)).map_err(io::Error::other);
        let mut csv = csv::Writer::from_writer(create(RUN_CSV)?);
        let events = csv::WriterBuilder::new().has_headers(false).from_writer(create(EVENTS_CSV)?);
        let events = self.events.insert(events);
        events.write_record(EVENT_COLUMNS)?;
        let kept =
            columns(self.info.plant_parameters.rig.cables.len()).into_iter().filter(|name| is_measured(name));
        csv.write_record(std::iter::once("time".to_owned()).chain(kept))?;
        let info = serde_json::to_string_pretty(&self.info)? + "\n";
        write_whole(&self.folder.join(RUN_JSON), |file| file.write_all(info.as_bytes()))
            .map_err(io::Error::other)?;
        (self.csv, self.begun) = (Some(csv), time);
        Ok(())
    }
}

fn is_measured(column: &str) -> bool {
    !NOT_MEASURED.iter().any(|name| column.starts_with(name))
}

/// The rig as a plant: what its encoders and load cells say.
fn moment(report: &CycleReport, pose: &Pose, answer: &ControllerOutputs, goal: Pose, time: f64) -> Moment {
    // What the controller said last is not what it says now.
    let answer = match report.controller {
        Some(answer) => answer,
        None => ControllerOutputs { status: Status::Disabled, steady: false, at_goal: false, ..*answer },
    };
    Moment {
        time,
        controller_inputs: ControllerInputs {
            encoder_pose: *pose,
            cable_length: report.length,
            measured_tension: report.measured,
            goal_pose: goal,
            enable: report.state == State::Enabled,
        },
        controller: ControllerOutputs { motor_tension: report.tension, ..answer },
        plant_inputs: PlantInputs {
            motor_tension: report.tension,
            ..PlantInputs::none(report.tension.len())
        },
        plant: PlantOutputs {
            encoder_pose: *pose,
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            cable_length: report.length,
            measured_tension: report.measured,
            slack: report.measured.map(|tension| tension <= 0.0),
        },
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use cable_robot_fieldbus::simulated::Bench;
    use cable_robot_report::{Digest, html};

    use super::*;
    use crate::program::tests::files;

    /// The simulated rig, recorded from the controller's tensions on.
    struct Recorded {
        bench: Bench,
        recording: Recording,
        told: usize,
    }

    impl Recorded {
        fn give(&mut self, x: f64, y: f64, z: f64) {
            let command = OperatorCommand::Goal(Pose::at(x, y, z));
            let refusal = self.bench.bridge.operator(command, self.bench.now).err();
            self.recording.take(&Entry::Input(Input::Operator(command), refusal)).unwrap();
        }

        fn run(&mut self, seconds: f64) {
            for report in self.bench.run(seconds) {
                let cycle = Cycle { report, lateness: 0, latency: None, missed: 0 };
                self.recording.take(&Entry::Cycle(cycle)).unwrap();
            }
            for (time, event) in &self.bench.events[self.told..] {
                self.recording.take(&Entry::Event(*time, *event)).unwrap();
            }
            self.told = self.bench.events.len();
        }
    }

    /// The platform was shown at rest at its goal, with neither state nor fault, and goals as given that were refused.
    #[test]
    fn after_a_fault_the_report_says_so_and_no_pose_is_made_up() {
        let (folder, files) = (tempfile::tempdir().unwrap(), files());
        let controller = BridgeController::open(&files.config, None).unwrap();
        let recording = Recording::create(folder.path(), &files, &controller, Purpose::Run(None)).unwrap();
        let mut bench = Bench::new(files.config, PlantParameters::default()).unwrap();
        assert!(bench.start(), "{:?}", bench.events.last());
        let told = bench.events.len();
        let mut recorded = Recorded { bench, recording, told };
        recorded.run(1.5);
        recorded.give(0.1, 0.0, 1.0);
        recorded.give(9.0, 0.0, 1.0);
        recorded.run(0.5);
        recorded.bench.rig.drives[0].faults.is_silent = true;
        recorded.run(1.0);
        recorded.recording.flush().unwrap();

        let events = fs::read_to_string(folder.path().join(EVENTS_CSV)).unwrap();
        let page = html(&Digest::read(folder.path(), |file| file).unwrap()).unwrap();
        for said in [
            "<li class=\"bad\">fault at 2.0",
            "<b>the encoder of cable 1 is silent</b>",
            "<td>goal (0.1, 0, 1) m given</td>",
            "<td>goal (9, 0, 1) m: the goal is outside of limits.space: x = 9 m</td>",
            "<td>goal (0.1, 0, 1) m given up: after 0.5 s, the bridge is in Stopping</td>",
            "<td>Stopping</td>",
            "<td>Fault</td>",
            "\"unmeasuredSpans\":[[",
            "<th scope=\"row\">Disturbance</th><td>not measured</td>",
            "<th scope=\"row\">Imperfections</th><td>not measured</td>",
        ] {
            assert!(page.contains(said), "{said} is not there\n{events}");
        }
        let inputs = fs::read_to_string(folder.path().join(log::INPUTS)).unwrap();
        assert!(inputs.contains("goal 9 0 1 0 0 0,the goal is outside of limits.space: x = 9 m"), "{inputs}");
        assert!(inputs.contains("goal 0.1 0 1 0 0 0,\n"), "{inputs}");
    }
}
