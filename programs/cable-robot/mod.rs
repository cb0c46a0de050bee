//! `cable-robot`: workspaces, reachable domains, plans and simulations from the command line.

mod arguments;
mod certify;
mod completions;
mod contours;
#[cfg(feature = "export")]
mod export;
mod figure;
mod fmu;
mod man;
mod modelica;
mod opener;
mod orbit;
mod picture;
mod plan;
mod plane;
mod progress;
mod proof;
mod reach;
mod report;
mod rig;
mod schema;
mod simulate;
mod study;
mod tensions;
mod workspace;

pub use certify::earliest;
pub use rig::{controller, read, require_below, require_rest};
pub use simulate::source::{named, of_goal};
pub use workspace::{Found, find};

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::sync::OnceLock;

use crate::errors;
use crate::plain::plain;
use anyhow::Context;
use cable_robot::sim::SimulationError;
use cable_robot_import::{CosimError, Lost};
use clap::{Parser, Subcommand};

const EXIT_CODES: &str = "\
Frame: that of the rig file; the paper's rig has its origin at the centre of the base plane, z down. Metres, radians, newtons;
orientations are R = Rz(yaw) Ry(pitch) Rx(roll).
Results go to stdout, messages to stderr. Exit codes: 0 done, 1 error, 2 wrong usage, 3 goal not reachable, step or orbit \
not proved or workspace empty, 4 a cable went slack, 5 an FMU crashed or ended its process, 6 an FMU did not return, 130 interrupted.";

/// The subcommand that is a process for an FMU.
#[cfg(unix)]
const FMU_WORKER: &str = "fmu-worker";

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: u8 = 130;

/// Cable robot that never lets a cable go slack: static workspace, reachable domains, plans, simulations
#[derive(Parser)]
#[command(name = "cable-robot", version, about, after_help = EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Static workspace of a rig at one height and orientation
    #[command(after_help = workspace::EXAMPLE)]
    Workspace(workspace::Workspace),
    /// Domain (15) of the set points that may be given at rest at a point
    #[command(after_help = reach::EXAMPLE)]
    Reach(reach::Reach),
    /// Set points from one pose to another, and why a goal cannot be reached
    #[command(after_help = plan::EXAMPLE)]
    Plan(plan::Plan),
    /// A periodic motion that may leave the static workspace, proved with its start and its stops
    #[command(after_help = orbit::EXAMPLE)]
    Orbit(orbit::Orbit),
    /// A scenario: controller and plant in a closed loop, as CSV or as a run folder
    #[command(after_help = simulate::EXAMPLE)]
    Simulate(simulate::Simulate),
    /// One HTML file of a run: robot, positions, tensions, plane, with a time scrubber; of two runs side by side
    #[command(after_help = report::EXAMPLE)]
    Report(report::Report),
    /// A run as MCAP for Foxglove and PlotJuggler, or as Parquet
    #[cfg(feature = "export")]
    #[command(after_help = export::EXAMPLE)]
    Export(export::Export),
    /// A proof that one step, in all six coordinates, keeps every tension within its limits
    #[command(after_help = certify::EXAMPLE)]
    Certify(certify::Certify),
    /// Length and tension of each cable at a pose
    #[command(after_help = tensions::EXAMPLE)]
    Tensions(tensions::Tensions),
    /// Controller and plant of a rig as FMUs
    #[command(after_help = fmu::EXAMPLE)]
    Fmu(fmu::Fmu),
    /// The plant of a rig in plain Modelica
    #[command(after_help = modelica::EXAMPLE)]
    Modelica(modelica::Modelica),
    /// The paper's figures as SVG, PNG and CSV
    #[command(after_help = figure::EXAMPLE)]
    Figure(figure::Figure),
    /// JSON Schema of a file that this program reads, for editors, or of what a command prints with --json
    #[command(after_help = schema::EXAMPLE)]
    Schema(schema::Schema),
    /// Studies that back what is claimed about the reachable domains
    #[command(subcommand)]
    Study(study::Study),
    /// Runs an FMU for the process that starts this one
    #[cfg(unix)]
    #[command(name = FMU_WORKER, hide = true)]
    FmuWorker,
    /// Completions for a shell, to stdout
    #[command(after_help = completions::EXAMPLE)]
    Completions(completions::Completions),
    /// Pages for man, one a command, into a folder
    #[command(after_help = man::EXAMPLE)]
    Man(man::Man),
}

/// What an exit code tells apart.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Done,
    NotReachable,
    Slack,
    Interrupted,
}

/// How this program was started, and what came with it.
#[derive(Clone, Debug, Default)]
pub struct Installation {
    /// Starts the program again, with `arguments` before those of a command; `None`: the file of this process.
    pub program: Option<PathBuf>,
    /// Such as those that make an interpreter run it.
    pub arguments: Vec<String>,
    /// Folder of the FMUs of the paper's rig, with fmi2 and fmi3 in it; `None`: looked for beside the program and where the project packs them.
    pub fmus: Option<PathBuf>,
}

static INSTALLATION: OnceLock<Installation> = OnceLock::new();

/// Runs a command line, its first word the program's name, and returns the exit code. What the first call says of the installation holds for all.
pub fn run(arguments: impl IntoIterator<Item = OsString>, installation: Installation) -> u8 {
    let _ = INSTALLATION.set(installation);
    let parsed = Arguments::try_parse_from(arguments);
    exit_code(parsed.map_err(anyhow::Error::from).and_then(|arguments| execute(arguments.task)))
}

fn installation() -> &'static Installation {
    INSTALLATION.get_or_init(Installation::default)
}

fn execute(task: Task) -> anyhow::Result<Outcome> {
    match task {
        Task::Workspace(task) => task.run(),
        Task::Reach(task) => task.run(),
        Task::Plan(task) => task.run(),
        Task::Orbit(task) => task.run(),
        Task::Simulate(task) => task.run(),
        Task::Report(task) => task.run(),
        #[cfg(feature = "export")]
        Task::Export(task) => task.run(),
        Task::Certify(task) => task.run(),
        Task::Tensions(task) => task.run(),
        Task::Fmu(task) => task.run(),
        Task::Modelica(task) => task.run(),
        Task::Figure(task) => task.run(),
        Task::Schema(task) => task.run(),
        Task::Study(task) => task.run(),
        #[cfg(unix)]
        Task::FmuWorker => {
            cable_robot_import::serve().map(|()| Outcome::Done).with_context(|| FMU_WORKER.to_owned())
        }
        Task::Completions(task) => task.run(),
        Task::Man(task) => task.run(),
    }
}

fn exit_code(result: anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::NotReachable) => 3,
        Ok(Outcome::Slack) => 4,
        Ok(Outcome::Interrupted) => INTERRUPTED,
        Err(error) if is_closed_pipe(&error) => 0,
        Err(error) => {
            if let Some(usage) = error.downcast_ref::<clap::Error>() {
                // Help goes to stdout; nothing depends on whether anybody reads it.
                let _ = usage.print();
                return u8::try_from(usage.exit_code()).unwrap_or(2);
            }
            say(errors::in_words("cable-robot", &error));
            match lost(&error) {
                Some(Lost::Silent(_)) => 6,
                Some(Lost::Ended(_) | Lost::Garbled) => 5,
                _ => 1,
            }
        }
    }
}

/// How the process of an FMU was lost, if that is the error.
fn lost(error: &anyhow::Error) -> Option<&Lost> {
    error.chain().find_map(|cause| {
        let stopped = cause.downcast_ref::<SimulationError>();
        let inner = stopped.map_or_else(|| cause.downcast_ref(), |stopped| stopped.cause.downcast_ref());
        match inner {
            Some(CosimError::Lost { how, .. }) => Some(how),
            _ => None,
        }
    })
}

/// Whoever reads has seen enough.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let io = match cause.downcast_ref::<csv::Error>().map(csv::Error::kind) {
            Some(csv::ErrorKind::Io(io)) => Some(io),
            _ => cause.downcast_ref::<std::io::Error>(),
        };
        io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
    })
}

/// A line for whoever reads stderr, if anybody still does.
fn say(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{}", plain(&text.to_string()));
}

/// Writes a result to stdout. That nobody reads it to the end changes nothing of what the exit code says.
fn print(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout(), "{}", plain(text.trim_end())) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to stdout"),
    }
}

/// A coordinate to a tenth of a millimetre, never -0.
fn metres(value: f64) -> String {
    if value.abs() < 1e6 {
        format!("{:9.4}", (value * 1e4).round() / 1e4 + 0.0)
    } else {
        format!("{value:9.3e}")
    }
}

/// A number as it was given, in a few characters.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-6..1e9).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

/// Writes a result for machines to stdout, fields in alphabetical order.
fn print_json(result: &impl serde::Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(&serde_json::to_value(result)?)?)
}
