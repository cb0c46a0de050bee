//! `cable-robot simulate`: a scenario, run.

pub mod answer;
mod interruption;
mod record;
pub mod settings;
pub mod source;
mod summary;
mod sweep;

use std::fs;
use std::io::{IsTerminal, Write, stdout};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;

use crate::plain::plain;
use anyhow::{Error, Result, bail, ensure};
use cable_robot::plan::{PlannerKind, Status};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::scenario::count_steps;
use cable_robot::sim::simulation::library_models;
use cable_robot::sim::{BUNDLED, ControllerModel, PlantModel, Scenario, Simulation};
use cable_robot_cosim::FmuModel;
use cable_robot_fmi::Model;
use cable_robot_fmi::models::{controller, plant};
use cable_robot_import::{Fmu, LogMessage, Lost};
use cable_robot_report::run_folder::{self, FORMAT, RunInfo};
use clap::error::ErrorKind;
use clap::{Args, Command, ValueHint};

use self::interruption::Interruption;
use self::record::{Record, Sink};
use self::settings::{Setting, Sweep};
use self::summary::Summary;
use crate::command::arguments::{planner, pose, seconds};
use crate::command::progress::Progress;
use crate::command::rig::{RigArgument, require_below, require_rest};
use crate::command::{Outcome, lost, number, print, print_json, say};
#[cfg(unix)]
use {
    crate::command::{FMU_WORKER, Installation, installation},
    anyhow::Context,
    cable_robot_import::Worker,
};

pub const EXAMPLE: &str = "\
Example: cable-robot simulate paper --output run
         cable-robot simulate paper --set controller.planner=exact --sweep controller.lambda=3,5,8
         cable-robot simulate --from 0,0,1 --to 0.1,0,1 --duration 5
Scenario files: docs/scenarios.md. Exit codes besides those of every command: 3 the controller ended with the status \
GoalUnreachable, SensorFault or WaitingForPose, 4 a cable went slack, 5 an FMU crashed or ended its process, 6 an FMU did not return \
within --fmu-timeout, 130 interrupted. Rows are written as they come: those until then are there.";

#[derive(Args)]
pub struct Simulate {
    /// A bundled scenario by its name, or a scenario file (TOML)
    #[arg(
        value_name = "SCENARIO",
        value_hint = ValueHint::FilePath,
        conflicts_with_all = ["rig", "from", "to", "duration", "step", "planner"]
    )]
    scenario: Option<String>,
    /// Sets a field of the scenario, as its file names it: controller.lambda=8; may be given again
    #[arg(long, value_name = "FIELD=VALUE", requires = "scenario", conflicts_with = "to")]
    set: Vec<Setting>,
    /// Runs the scenario for each of some values of a field, controller.lambda=3,5,8, and prints what each run came to; given again, for every combination
    #[arg(long, value_name = "FIELD=VALUES", requires = "scenario", conflicts_with_all = ["to", "output", "fmu", "every"])]
    sweep: Vec<Sweep>,
    /// Writes a row only each so many steps
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Lists the bundled scenarios
    #[arg(long, exclusive = true)]
    list: bool,
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] of the start, at rest, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll); without it the rig's home
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Option<Pose>,
    /// x,y,z[,roll,pitch,yaw] of the goal, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll): a scenario of one goal, without a file
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Option<Pose>,
    /// Simulated time, s
    #[arg(long, value_parser = seconds, default_value = "12", allow_negative_numbers = true)]
    duration: f64,
    /// Time between two steps of the controller, s
    #[arg(long, value_parser = seconds, default_value = "0.001", allow_negative_numbers = true)]
    step: f64,
    /// Reachable domain to plan with; without it bounded for the paper's rig, exact for others
    #[arg(long, value_parser = planner())]
    planner: Option<PlannerKind>,
    /// A controller or plant (FMI 2.0 or 3.0 co-simulation) in place of ours; may be given twice
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    fmu: Vec<PathBuf>,
    /// Longest time that an FMU may take for a call, s
    #[arg(long, value_name = "S", value_parser = seconds, default_value = "60", requires = "fmu")]
    fmu_timeout: f64,
    /// Runs the FMUs in this process, which ends with them should one crash: faster, for FMUs that are trusted
    #[arg(long, requires = "fmu")]
    in_process: bool,
    /// Writes run.csv and run.json into this folder, instead of the CSV to stdout
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    output: Option<PathBuf>,
    /// Prints the summary for machines to stdout; the CSV is written only with --output
    #[arg(long)]
    json: bool,
}

/// What runs in the loop, and what `run.json` says of it.
struct Models {
    controller: Box<dyn ControllerModel>,
    plant: Box<dyn PlantModel>,
    controller_info: run_folder::Model,
    plant_info: run_folder::Model,
    /// Columns that they cannot fill.
    lacking: Vec<String>,
}

impl Simulate {
    pub fn run(&self) -> Result<Outcome> {
        if self.list {
            let list = source::list()?;
            let lines = list.iter().map(|(name, title)| format!("{name:<13}{title}\n"));
            print(&lines.collect::<String>())?;
            return Ok(Outcome::Done);
        }
        if let (Some(name), false) = (&self.scenario, self.sweep.is_empty()) {
            return sweep::run(self, name);
        }
        let scenario = self.scenario()?;
        let interruption = Interruption::listen()?;
        let models = match self.models(&scenario, &interruption) {
            Err(error) if lost(&error) == Some(&Lost::Stopped) => {
                say("interrupted: nothing was simulated");
                return Ok(Outcome::Interrupted);
            }
            models => models?,
        };
        let info = self.info(&scenario, &models);
        let lacking = models.lacking.clone();
        let was_there = self.output.as_ref().is_some_and(|folder| folder.exists());
        self.output.as_deref().map_or(Ok(()), prepare)?;
        let sink = self.sink(&info);
        let mut record = Record::new(&scenario, info, &lacking, sink, self.every);
        let end = match self.simulate(&scenario, models, &mut record, &interruption) {
            Err(error) if lost(&error) == Some(&Lost::Stopped) => Ok(End::Interrupted),
            end => end,
        };

        if record.summary.is_empty() {
            // A folder that was made for nothing; were it no longer empty, it would stay.
            let _ = self.output.as_ref().filter(|_| !was_there).map(fs::remove_dir);
            return end.map(|_| Outcome::Done);
        }
        let (status, is_slack) = self.tell(record.summary)?;
        Ok(match (end?, status) {
            (End::Interrupted, _) => {
                say(format_args!("interrupted: {} s were to be simulated", number(scenario.duration)));
                Outcome::Interrupted
            }
            (End::Whole, _) if is_slack => Outcome::Slack,
            (End::Whole, Some(Status::GoalUnreachable)) => Outcome::NotReachable,
            (End::Whole, Some(status)) if status.lacks_pose() => Outcome::NotReachable,
            (End::Whole, _) => Outcome::Done,
        })
    }

    /// The run folder, or the CSV to stdout.
    fn sink(&self, info: &RunInfo) -> Sink {
        match &self.output {
            Some(folder) => Sink::Folder(folder.clone(), Box::new(info.clone())),
            None if self.json => Sink::Nowhere,
            None => Sink::Stdout,
        }
    }

    /// Runs until the end of the scenario, or until it is to stop.
    fn simulate(
        &self,
        scenario: &Scenario,
        models: Models,
        record: &mut Record,
        interruption: &Interruption,
    ) -> Result<End> {
        let mut simulation = Simulation::with_models(scenario, models.controller, models.plant)?;
        record.push(simulation.moment())?;
        let steps = count_steps(scenario.duration, scenario.step).map_err(Error::msg)?;
        let progress = Progress::new("simulating", steps);
        // A bar among the rows would be in their way.
        let is_seen = !self.sweep.is_empty() || self.output.is_none() && !self.json && stdout().is_terminal();
        for _ in 0..steps {
            if interruption.is_asked() {
                return Ok(End::Interrupted);
            }
            simulation.step()?;
            record.push(simulation.moment())?;
            if !is_seen {
                progress.done(1);
            }
        }
        Ok(End::Whole)
    }

    fn scenario(&self) -> Result<Scenario> {
        match (&self.scenario, self.to) {
            (Some(name), _) => source::named(name, &self.set),
            (None, Some(to)) => self.short_form(to),
            (None, None) => {
                let names = BUNDLED.map(|(name, _)| name).join(", ");
                let wanted = format!("give a scenario ({names}, or a file), or a goal with --to x,y,z");
                let mut command = Self::augment_args(Command::new("cable-robot simulate"));
                Err(command.error(ErrorKind::MissingRequiredArgument, wanted).into())
            }
        }
    }

    /// One goal, an ideal rig.
    fn short_form(&self, to: Pose) -> Result<Scenario> {
        let (file, controller) = self.rig.read_with_controller(self.planner)?;
        let from = self.from.unwrap_or(file.home);
        if let Err(right) = count_steps(self.duration, self.step) {
            bail!("--duration {} s with --step {} s: {right}", number(self.duration), number(self.step));
        }
        let name = if self.from.is_some() { "--from".to_owned() } else { self.rig.name_of_home() };
        require_rest(&controller, &name, &from)?;
        require_below(&file.rig, "--to", &to)?;
        Ok(source::of_goal(&file, controller, (from, to), (self.duration, self.step)))
    }

    /// Ours, but for what an FMU replaces.
    fn models(&self, scenario: &Scenario, interruption: &Interruption) -> Result<Models> {
        let (controller, plant) = library_models(scenario)?;
        let mut models = Models {
            controller,
            plant: Box::new(plant),
            controller_info: run_folder::Model::Library,
            plant_info: run_folder::Model::Library,
            lacking: vec![],
        };
        for path in &self.fmu {
            let fmu = fmu_model(&self.open(path, interruption)?, path, scenario)?;
            let (info, lacking) = (fmu.info(), fmu.lacking());
            ensure!(
                fmu.model() != Model::Controller || scenario.orbit.is_none(),
                "--fmu {}: a controller that is an FMU follows no orbit; a plant may be one",
                path.display()
            );
            let replaced = match fmu.model() {
                Model::Controller => {
                    models.controller = Box::new(fmu);
                    std::mem::replace(&mut models.controller_info, info)
                }
                Model::Plant | Model::PlantExchange | Model::Node(_) => {
                    models.plant = Box::new(fmu);
                    std::mem::replace(&mut models.plant_info, info)
                }
            };
            if let run_folder::Model::Fmu { path: earlier, .. } = replaced {
                bail!("{} and {} stand for the same model", earlier.display(), path.display());
            }
            if !lacking.is_empty() {
                let mut names: Vec<_> =
                    lacking.iter().filter_map(|name| name.split(['.', '[']).nth(1)).collect();
                names.dedup();
                say(format_args!(
                    "{} lacks outputs, which are not recorded: {}",
                    path.display(),
                    names.join(", ")
                ));
            }
            models.lacking.extend(lacking);
        }
        Ok(models)
    }

    /// In a process of its own, where there are such.
    #[cfg(unix)]
    fn open(&self, path: &Path, interruption: &Interruption) -> Result<Fmu> {
        if self.in_process {
            return Ok(Fmu::open(path)?);
        }
        let Installation { program, arguments, .. } = installation();
        let own = || std::env::current_exe().context("cannot find this program to run the FMU in");
        let program = program.clone().map_or_else(own, Ok)?;
        let arguments: Vec<_> = arguments.iter().map(String::as_str).chain([FMU_WORKER]).collect();
        let limit = Duration::try_from_secs_f64(self.fmu_timeout).unwrap_or(Duration::MAX);
        let interruption = interruption.clone();
        // Nothing depends on whether stderr is read.
        let show = |text: &str| drop(write!(std::io::stderr(), "{}", plain(text)));
        let worker = Worker::new(program, &arguments).with_limit(limit).with_prints(show);
        Ok(Fmu::open_apart(path, &worker.until(move || interruption.is_asked()))?)
    }

    #[cfg(not(unix))]
    fn open(&self, path: &Path, _interruption: &Interruption) -> Result<Fmu> {
        Ok(Fmu::open(path)?)
    }

    fn info(&self, scenario: &Scenario, models: &Models) -> RunInfo {
        RunInfo {
            format: FORMAT,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            title: scenario.title.clone(),
            scenario: self.scenario.clone(),
            controller: models.controller_info.clone(),
            plant: models.plant_info.clone(),
            rig: scenario.rig.clone(),
            orbit: scenario.orbit,
            step: scenario.step,
            controller_parameters: scenario.controller,
            plant_parameters: scenario.plant,
        }
    }

    /// The summary: to stderr for people, to stdout for machines. What the controller said last, and whether a cable went slack.
    fn tell(&self, mut summary: Summary) -> Result<(Option<Status>, bool)> {
        summary.finish()?;
        // Nothing depends on whether stderr is read.
        let _ = write!(std::io::stderr(), "{}", plain(&summary.as_text()));
        if self.json {
            print_json(&summary.answer())?;
        }
        Ok((summary.status(), summary.is_slack()))
    }
}

/// The folder exists and can be written into, before the work begins.
fn prepare(folder: &Path) -> Result<()> {
    ensure!(
        (folder.is_dir() || !folder.exists())
            && folder.extension().is_none_or(|extension| extension != "csv"),
        "--output {}: a folder is wanted, into which run.csv and run.json are written",
        folder.display()
    );
    Ok(run_folder::make(folder)?)
}

/// How a simulation came to its end.
enum End {
    Whole,
    Interrupted,
}

/// The FMU in this file, with the scenario's parameters.
fn fmu_model(fmu: &Fmu, path: &Path, scenario: &Scenario) -> Result<FmuModel> {
    let (lambda, eta) = (scenario.controller.lambda, scenario.controller.eta);
    let (rig, home) = (scenario.plant.rig, scenario.plant.initial_pose);
    let rig = RigFile { name: scenario.rig.clone(), rig, home, lambda, eta };
    let mut fmu = FmuModel::of(fmu, path, &rig, Box::new(say_of_fmu))?;
    let model = fmu.model();
    fmu.set_parameters(|interface, values| {
        match model {
            Model::Controller => controller::write_parameters(interface, &scenario.controller, values),
            Model::Plant | Model::PlantExchange | Model::Node(_) => {
                plant::write_parameters(interface, &scenario.plant, values)
            }
        }
        Ok(())
    })?;
    fmu.require_essentials(&scenario.controller)?;
    Ok(fmu)
}

/// Passes on what the FMU has to say beyond remarks.
fn say_of_fmu(message: &LogMessage) {
    if message.status > cable_robot_import::Status::Ok {
        say(format_args!("{}: {}", message.instance, message.text));
    }
}
