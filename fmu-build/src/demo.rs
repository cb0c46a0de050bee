//! `cargo demo`: the paper's manoeuvre (Section VI) through the packed FMUs.

use std::io::Write;

use anyhow::{Context, Result};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::{ClosedLoop, PlantInputs};
use cable_robot_cosim::FmuModel;
use cable_robot_fmi::Model;
use cable_robot_fmi::describe::Version;
use cable_robot_import::{LogMessage, Status};
use cable_robot_report::facts::slack_in_words;
use cable_robot_report::files::write_whole;
use cable_robot_report::run_folder::{self, FORMAT};
use cable_robot_report::{Digest, Recording, RunFolder, RunInfo, Summary, Table, compare, html};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{pack, project_root};

/// From the plant's initial pose (0, 0, 1) to here, m.
const GOAL: [f64; 3] = [0.15, 0.15, 1.0];
/// Communication step, s.
const STEP: f64 = 1e-3;
/// The run ends after this time, or when the robot has rested at the goal for a while, s.
const STOP: f64 = 12.0;
const REST: f64 = 1.0;

/// What is run: with the paper's planner, and as fast as the tensions allow; each with a folder for its report.
const RUNS: [(PlannerKind, &str, &str); 2] = [
    (PlannerKind::Bounded, "The paper's move, through the FMUs", "target/demo"),
    (
        PlannerKind::MinimumTime,
        "The paper's move in minimum time, through the FMUs",
        "target/demo/minimum-time",
    ),
];

/// Both side by side.
const COMPARISON: &str = "target/demo/comparison.html";

/// Builds and packs the FMUs, runs them, prints what came of it, writes the run folders and the reports.
pub fn run(version: Version) -> Result<()> {
    pack::build()?;
    let (mut rows, mut runs) = (vec![], vec![]);
    for (planner, title, folder) in RUNS {
        let folder = project_root().join(folder);
        run_folder::make(&folder)?;
        let recorded = RunFolder { info: info(version, planner, title), table: simulate(version, planner)? };
        let summary = recorded.run()?.summary();
        println!("planner {}", planner.described().0);
        print(&summary);
        recorded.write(&folder)?;
        let digest = Digest::of(&recorded)?;
        let page = html(&digest)?;
        let path = folder.join("report.html");
        write_whole(&path, |file| file.write_all(page.as_bytes()))?;
        println!("report: {}\n", path.display());
        rows.push((planner, summary));
        runs.push(digest);
    }
    let path = project_root().join(COMPARISON);
    let page = compare([&runs[0], &runs[1]])?;
    write_whole(&path, |file| file.write_all(page.as_bytes()))?;
    print_rows(&rows);
    println!("both in one report: {}", path.display());
    Ok(())
}

/// Side by side.
fn print_rows(rows: &[(PlannerKind, Summary)]) {
    println!(
        "{:<13} {:>15} {:>20} {:>12}",
        "planner", "at the goal (s)", "smallest tension (N)", "slack cables"
    );
    for (planner, summary) in rows {
        let time = summary.time_to_goal.map_or_else(|| "not reached".to_owned(), |time| format!("{time:.3}"));
        let tension =
            summary.smallest_tension.map_or_else(String::new, |smallest| format!("{:.3}", smallest.value));
        let slack = slack_in_words(&summary.slack);
        println!("{:<13} {time:>15} {tension:>20} {slack:>12}", planner.described().0);
    }
}

/// Runs them until the robot has rested at the goal for a while.
fn simulate(version: Version, planner: PlannerKind) -> Result<Table> {
    let rig = RigFile::default();
    let [x, y, z] = GOAL;
    let outside = PlantInputs::none(rig.rig.cables.len());
    let [controller, plant] = [Model::Controller, Model::Plant].map(|model| open(model, version, &rig));
    let mut controller = controller?;
    controller.set_parameters(|interface, values| {
        let number = interface.named("plannerNumber").context("the controller FMU knows no plannerNumber")?;
        values.put(number.reference, f64::from(planner as i32));
        Ok(())
    })?;
    let mut closed_loop = ClosedLoop::with_models(controller, plant?, Pose::at(x, y, z), &outside)?;
    let mut recording = Recording::new(rig.rig.cables.len());
    recording.push(closed_loop.moment())?;
    let bar = ProgressBar::new((STOP / STEP) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:40} {msg}")?);
    let mut end = STOP;
    while closed_loop.moment().time < end {
        let moment = closed_loop.step(STEP)?;
        recording.push(moment)?;
        if end == STOP && moment.controller.at_goal {
            end = STOP.min(moment.time + REST);
        }
        bar.set_position((moment.time / STEP) as u64);
        bar.set_message(format!("{:.1} s", moment.time));
    }
    bar.finish_and_clear();
    Ok(recording.into_table())
}

/// A packed FMU; what it has to say beyond remarks goes to stderr.
fn open(model: Model, version: Version, rig: &RigFile) -> Result<FmuModel> {
    let log = |message: &LogMessage| {
        if message.status > Status::Ok {
            eprintln!("{}: {}", message.instance, message.text);
        }
    };
    FmuModel::open(&pack::path(model, version), rig, Box::new(log))
}

/// What was run: both FMUs with their defaults, Tables I and II, but for the planner.
fn info(version: Version, planner: PlannerKind, title: &str) -> RunInfo {
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
        title: title.to_owned(),
        scenario: None,
        controller: fmu(Model::Controller),
        plant: fmu(Model::Plant),
        rig: "Oh and Agrawal, Table I".to_owned(),
        orbit: None,
        step: STEP,
        controller_parameters: ControllerParameters { planner, ..Default::default() },
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
