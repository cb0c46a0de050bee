//! `cargo demo`: the paper's manoeuvre (Section VI) through the packed FMUs.

use std::io::Write;

use anyhow::Result;
use cable_robot_fmi::Model;
use cable_robot_fmi::describe::Version;
use cable_robot_import::{Fmu, Instance, LogMessage, Status};
use cable_robot_report::facts::slack_in_words;
use cable_robot_report::files::write_whole;
use cable_robot_report::run_folder::{self, FORMAT};
use cable_robot_report::{ClosedLoop, RunFolder, RunInfo, Summary, html};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{pack, project_root};

/// From the plant's initial pose (0, 0, 1) to here, m.
const GOAL: [f64; 3] = [0.15, 0.15, 1.0];
/// Communication step, s.
const STEP: f64 = 1e-3;
/// The run ends after this time, or when the robot has rested at the goal for a while, s.
const STOP: f64 = 12.0;
const REST: f64 = 1.0;

/// Builds and packs the FMUs, runs them, prints what came of it, writes the run folder and the report.
pub fn run(version: Version) -> Result<()> {
    let folder = project_root().join("target/demo");
    run_folder::make(&folder)?;
    pack::build()?;
    let mut closed_loop =
        ClosedLoop::new(open(Model::Controller, version)?, open(Model::Plant, version)?, GOAL, STEP)?;
    let bar = ProgressBar::new((STOP / STEP) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:40} {msg}")?);
    closed_loop.run(STOP, REST, |time| {
        bar.set_position((time / STEP) as u64);
        bar.set_message(format!("{time:.1} s"));
    })?;
    bar.finish_and_clear();

    let recorded = RunFolder { info: info(version), table: closed_loop.table()? };
    print(&recorded.run()?.summary());
    recorded.write(&folder)?;
    let page = html(&recorded)?;
    let path = folder.join("report.html");
    write_whole(&path, |file| file.write_all(page.as_bytes()))?;
    println!("report: {}", path.display());
    Ok(())
}

/// An instance of a packed FMU; what it has to say beyond remarks goes to stderr.
fn open(model: Model, version: Version) -> Result<Instance> {
    let name = match model {
        Model::Controller => "controller",
        Model::Plant => "plant",
    };
    let log = |message: &LogMessage| {
        if message.status > Status::Ok {
            eprintln!("{}: {}", message.instance, message.text);
        }
    };
    Ok(Fmu::open(pack::path(model, version))?.instantiate(name, Box::new(log))?)
}

/// What was run: both FMUs with their defaults, Tables I and II.
fn info(version: Version) -> RunInfo {
    let fmu = |model: Model| run_folder::Model::Fmu {
        path: format!("target/fmu/{}/{}.fmu", version.name(), model.identifier()).into(),
        name: model.identifier().to_owned(),
        fmi_version: match version {
            Version::Fmi2 => "2.0".to_owned(),
            Version::Fmi3 => "3.0".to_owned(),
        },
    };
    RunInfo {
        format: FORMAT,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        title: "The paper's move, through the FMUs".to_owned(),
        scenario: None,
        controller: fmu(Model::Controller),
        plant: fmu(Model::Plant),
        rig: "Oh and Agrawal, Table I".to_owned(),
        step: STEP,
        controller_parameters: Default::default(),
        plant_parameters: Default::default(),
    }
}

/// Set points, smallest tension, time to the goal, slack cables.
pub fn print(summary: &Summary) {
    println!("set points");
    println!("  i   from (s)    x (m)    y (m)    z (m)");
    for (i, point) in summary.set_points.iter().enumerate() {
        let [x, y, z] = point.position;
        println!("  {i}   {:8.3} {x:8.4} {y:8.4} {z:8.4}", point.time);
    }
    if let Some(smallest) = summary.smallest_tension {
        println!("smallest tension: {smallest}");
    }
    match summary.time_to_goal {
        Some(time) => println!("at the goal: after {time:.3} s"),
        None => println!("at the goal: not within the run"),
    }
    println!("slack cables: {}", slack_in_words(&summary.slack));
}
