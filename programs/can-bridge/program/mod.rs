//! Arguments, exit codes, and which of its tasks the program does.

mod calibration;
mod check;
mod commissioned;
mod controller;
mod data_sheet;
mod entry;
mod fate;
mod goals;
mod journal;
mod keyboard;
mod log;
mod operator;
mod outlet;
mod privileges;
mod prompt;
mod real_time;
mod record;
mod recorder;
mod replay;
mod session;
mod signals;
mod status;
mod status_line;
mod survey;
mod terminal;
#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use cable_robot::robot::PerCable;
use cable_robot_fieldbus::bridge::{Bridge, Identity};
use cable_robot_fieldbus::transport;
use cable_robot_fieldbus::{Config, Files, bus_load, export};
use cable_robot_programs::{errors, output_schema, shell};
use clap::Parser;

use commissioned::Record;
use controller::BridgeController;
use data_sheet::SheetOf;
use journal::Journal;
use session::{End, Session};
use status::Status;
use survey::Survey;
use terminal::say;

const EXIT_CODES: &str = "\
Exit codes: 0 ended as asked, check or replay in order; 1 error; 2 wrong usage; 3 the rate does not fit on the bus;
4 the replay gives other commands than the recording; 5 ended after a fault, or the
drives do not confirm that they are off; 6 the torque was cut off at once (second
signal, or a failure of the program itself); 7 ended as asked, but the recording or the status stream is not whole;
8 commissioning is not whole, or blames the files.
Example: can-bridge rigs/can/akd.toml --bus can0=slcan:/dev/ttyACM0 --record run";

/// The controller against the drives and load cells of a rig on a CAN bus
#[derive(Parser)]
#[command(name = "can-bridge", version, after_help = EXIT_CODES)]
struct Arguments {
    /// The fieldbus file: what is on which bus, how it scales, what is allowed, and which rig file it is for; rigs/can/akd.toml is an example
    #[arg(value_name = "FIELDBUS.toml", required_unless_present = "replay")]
    fieldbus: Option<PathBuf>,
    /// Looks at fieldbus file, rig file, controller and bus load, and opens no bus
    #[arg(long)]
    check: bool,
    /// Looks with --check at the data sheet (EDS or DCF) of the drives, the load cells or a node for what the bridge asks of them
    #[arg(long, value_name = "drives|load-cells|NODE=FILE", value_parser = data_sheet::sheet_of, requires = "check")]
    eds: Vec<SheetOf>,
    /// Takes the controller of this FMU, whose code then runs in this program, instead of the program's own
    #[arg(long, value_name = "FMU")]
    controller: Option<PathBuf>,
    /// Writes the frames of this bus with names, scaling and units to stdout, as a DBC file for bench tools
    #[arg(long, value_name = "BUS", conflicts_with_all = ["check", "dry_run", "scenario", "record", "status", "no_realtime"])]
    export_dbc: Option<String>,
    /// Reads and computes beside another controller, and sends nothing
    #[arg(long, conflicts_with = "check")]
    dry_run: bool,
    /// Measures instead of moving: a person places the platform at poses with errors of these standard deviations (m, rad), and lengths read there say
    /// whether the files are right; with --check only says which poses, and what they tell
    #[arg(long, value_name = "POSITION,ANGLE", value_parser = survey::accuracy, conflicts_with_all = ["dry_run", "scenario"])]
    survey: Option<(f64, f64)>,
    /// Opens this address instead of the bus's name, such as can0=slcan:/dev/ttyACM0; may be given for each bus
    #[arg(long, value_name = "NAME=ADDRESS", value_parser = bus_address)]
    bus: Vec<(String, String)>,
    /// Goals of a scenario file, timed from the first time the controller pulls
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Records every frame, cycle and command, and a run for `cable-robot report`, into this folder, which holds no recording yet
    #[arg(long, value_name = "FOLDER")]
    record: Option<PathBuf>,
    /// Writes the status for machines, a JSON object a line, into this file; - is stdout
    #[arg(long, value_name = "FILE")]
    status: Option<PathBuf>,
    /// Prints the JSON Schema of a line of --status
    #[arg(long, exclusive = true)]
    status_schema: bool,
    /// Moves the rig although its commissioning record is missing or is of other files, and says what was skipped
    #[arg(long, conflicts_with = "survey")]
    uncommissioned: bool,
    /// Leaves scheduling and memory as they are
    #[arg(long)]
    no_realtime: bool,
    /// Gives a recorded folder to bridge and controller once more, and compares what they command
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["fieldbus", "check", "dry_run", "bus", "scenario", "record", "status", "survey"])]
    replay: Option<PathBuf>,
}

/// What the bridge is run for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of it")]
enum Purpose {
    /// With these drives, if they were commissioned.
    Run(Option<PerCable<Identity>>),
    DryRun,
    Survey,
}

impl Purpose {
    fn bridge(self, config: &Config) -> Bridge {
        match self {
            Self::Run(None) => Bridge::new(config.clone()),
            Self::Run(Some(drives)) => Bridge::new(config.clone()).expecting(drives),
            Self::DryRun => Bridge::shadow(config.clone()),
            Self::Survey => Bridge::survey(config.clone()),
        }
    }
}

/// What an exit code tells apart.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Done,
    DoesNotFit,
    Differs,
    Faulted,
    CutOff,
    Incomplete,
    Blamed,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(match outcome {
            Outcome::Done => 0,
            Outcome::DoesNotFit => 3,
            Outcome::Differs => 4,
            Outcome::Faulted => 5,
            Outcome::CutOff => 6,
            Outcome::Incomplete => 7,
            Outcome::Blamed => 8,
        })
    }
}

/// The program.
pub fn main() -> ExitCode {
    let arguments: Arguments = shell::parse();
    let code = match terminal::start().and_then(|()| run(&arguments)) {
        Ok(outcome) => outcome.into(),
        Err(error) => {
            say(format_args!("{}", errors::in_words("can-bridge", &error)));
            ExitCode::FAILURE
        }
    };
    terminal::finish();
    code
}

/// To stdout.
fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).context("cannot write to stdout")
}

fn run(arguments: &Arguments) -> Result<Outcome> {
    if arguments.status_schema {
        let schema = output_schema::<status_line::Line>();
        print(&format!("{schema:#}\n"))?;
        return Ok(Outcome::Done);
    }
    if let Some(folder) = &arguments.replay {
        return replay::run(folder, arguments.controller.as_deref());
    }
    let files = Files::read(fieldbus(arguments))?;
    let config = &files.config;
    for (name, _) in &arguments.bus {
        let known: Vec<_> = config.buses.iter().map(|bus| bus.name.as_str()).collect();
        ensure!(known.contains(&name.as_str()), "--bus {name}: the fieldbus file knows {}", known.join(", "));
    }
    if let Some(name) = &arguments.export_dbc {
        let bus = config.buses.iter().position(|bus| bus.name == *name);
        let known = || config.buses.iter().map(|bus| bus.name.as_str()).collect::<Vec<_>>().join(", ");
        let bus = bus.with_context(|| format!("--export-dbc {name}: the fieldbus file knows {}", known()))?;
        print(&export::dbc(config, bus))?;
        return Ok(Outcome::Done);
    }
    if let Some(named) = &config.controller.fmu {
        say(format_args!(
            "can-bridge: controller.fmu = {named:?} of the fieldbus file is not loaded: a file runs no code. --controller FMU takes another controller than the own"
        ));
    }
    let controller = BridgeController::open(config, arguments.controller.as_deref())?;
    if arguments.check {
        let (sheets, lacking) = data_sheet::text(config, &arguments.eds)?;
        let survey = arguments.survey.map_or(String::new(), |accuracy| Survey::new(config, accuracy).text());
        print(&(check::text(config, &controller) + &sheets + &survey))?;
        ensure!(lacking == 0, "of {} data sheets {lacking} lack what the bridge uses", arguments.eds.len());
    }
    if let Err(reason) = bus_load::check(config) {
        say(format_args!("can-bridge: {reason}"));
        return Ok(Outcome::DoesNotFit);
    }
    if arguments.check { Ok(Outcome::Done) } else { drive(arguments, &files, controller) }
}

fn drive(arguments: &Arguments, files: &Files, mut controller: BridgeController) -> Result<Outcome> {
    let config = &files.config;
    arguments.record.as_deref().map_or(Ok(()), record::refuse_to_overwrite)?;
    let goals = arguments
        .scenario
        .as_deref()
        .map_or(Ok(vec![]), |path| goals::read(path, config, &controller.parameters()))?;
    let purpose = match arguments.survey {
        _ if arguments.dry_run => Purpose::DryRun,
        Some(_) => Purpose::Survey,
        None => Purpose::Run(commissioned_drives(arguments, config)?),
    };
    let survey = arguments.survey.map(|accuracy| Arc::new(Survey::new(config, accuracy)));
    let mut links = vec![];
    for bus in &config.buses {
        let replaced = arguments.bus.iter().find(|(name, _)| *name == bus.name);
        let address = replaced.map_or(bus.name.as_str(), |(_, address)| address);
        links.push(transport::open(address, bus.bit_rate as u32, &[])?);
    }
    let recording = match &arguments.record {
        Some(folder) => Some(record::Recording::create(folder, files, &controller, purpose)?),
        None => None,
    };
    let stream = arguments.status.as_deref().map(status::Stream::create).transpose()?;
    let stop = signals::listen()?;
    let (commands, terminal) = operator::listen(config, survey.clone())?;
    let shown = Status::new(config, controller.parameters())?;
    let (teller, journal) = Journal::start(recording, stream, shown, terminal.is_some(), survey.clone())?;
    real_time::say_panics_briefly();
    if !arguments.no_realtime {
        real_time::prepare().iter().for_each(|warning| say(format_args!("can-bridge: {warning}")));
    }
    let mut session =
        Session::new(purpose.bridge(config), &mut controller, links, teller, commands, stop, goals);
    let end = session.run();
    let drives = session.drives();
    drop(session);
    let whole = journal.join();
    let is_commissioned = match &survey {
        Some(survey) => survey.conclude(fieldbus(arguments), config, &drives)?,
        None => true,
    };
    Ok(match end {
        End::CutOff => Outcome::CutOff,
        End::Faulted => Outcome::Faulted,
        End::Asked if !whole => Outcome::Incomplete,
        End::Asked if !is_commissioned => Outcome::Blamed,
        End::Asked => Outcome::Done,
    })
}

fn fieldbus(arguments: &Arguments) -> &Path {
    arguments.fieldbus.as_deref().unwrap_or(Path::new(""))
}

/// The drives that were commissioned; nothing if the rig was not, and somebody takes that on himself.
fn commissioned_drives(arguments: &Arguments, config: &Config) -> Result<Option<PerCable<Identity>>> {
    if arguments.uncommissioned {
        let missing = Record::read(fieldbus(arguments)).map(|record| record.missing(config).join(", "));
        let missing = missing.unwrap_or_else(|error| format!("{error:#}"));
        if !missing.is_empty() {
            say(format_args!("can-bridge: NOT COMMISSIONED, skipped: {missing}"));
        }
        return Ok(None);
    }
    let record = Record::read(fieldbus(arguments))?;
    let missing = record.missing(config);
    ensure!(
        missing.is_empty(),
        "the rig is not commissioned: {} missing: {}; --survey goes through it (docs/commissioning.md), --uncommissioned goes on without",
        if missing.len() == 1 { "a step is" } else { "steps are" },
        missing.join(", ")
    );
    Ok(record.drives())
}

fn bus_address(text: &str) -> Result<(String, String), String> {
    let (name, address) = text.split_once('=').ok_or("expected like can0=slcan:/dev/ttyACM0")?;
    Ok((name.to_owned(), address.to_owned()))
}
