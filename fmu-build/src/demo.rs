//! `cargo demo`: the paper's manoeuvre (Section VI) through the packed FMUs.

use std::fs;

use anyhow::Result;
use cable_robot::cosim::{Fmu, Instance, LogMessage, Status};
use cable_robot::fmi::Model;
use cable_robot::fmi::describe::Version;
use cable_robot::plan::ControllerParameters;
use cable_robot::reach::{BoundedDomain, HalfPlane, polygon, static_workspace};
use cable_robot::report::{ClosedLoop, Report, Summary};
use cable_robot::robot::RobotParameters;
use indicatif::{ProgressBar, ProgressStyle};

use crate::{pack, project_root};

/// From the plant's initial pose (0, 0, 1) to here, m.
const GOAL: [f64; 3] = [0.15, 0.15, 1.0];
/// Communication step, s.
const STEP: f64 = 1e-3;
/// The run ends after this time, or when the robot has rested at the goal for a while, s.
const STOP: f64 = 12.0;
const REST: f64 = 1.0;

/// Builds and packs the FMUs, runs them, prints what came of it, writes the CSV file and the report.
pub fn run(version: Version) -> Result<()> {
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
    let run = closed_loop.recorded_run()?;
    let summary = run.summary();
    print(&summary);

    let folder = project_root().join("target/demo");
    fs::create_dir_all(&folder)?;
    closed_loop.recorder().write_csv(&folder.join("run.csv"))?;
    let workspace = vertices(&static_workspace(&RobotParameters::default()));
    let domains = reachable_domains(&summary);
    let title = "Cable robot: from (0, 0, 1) to (0.15, 0.15, 1)";
    let report =
        Report { title, settings: &settings(version), run: &run, workspace: &workspace, domains: &domains };
    let path = folder.join("report.html");
    fs::write(&path, report.html())?;
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

fn print(summary: &Summary) {
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
        None => println!("at the goal: not within {STOP} s"),
    }
    match summary.slack {
        Some((cable, time)) => println!("slack cables: cable {cable}, first at {time:.3} s"),
        None => println!("slack cables: none"),
    }
}

/// The first lines of the report's table.
fn settings(version: Version) -> Vec<(String, String)> {
    let ControllerParameters { robot, lambda, eta, planner_period, bisection_steps, .. } = Default::default();
    [
        (
            "Models",
            format!(
                "CableRobotController and CableRobotPlant of target/fmu/{}, step {} ms",
                version.name(),
                STEP * 1e3
            ),
        ),
        (
            "Robot (Table I)",
            format!("a = {} m, b = {} m, m = {} kg, g = {} m/s²", robot.a, robot.b, robot.m, robot.g),
        ),
        ("Law (Table I)", format!("λ = {lambda} 1/s, η = {eta} 1/s")),
        ("Planner (Table II)", format!("Eq. (15), T_s = {} ms, N = {bisection_steps}", planner_period * 1e3)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

/// The domain of Eq. (15) at each point from which a next one was chosen.
fn reachable_domains(summary: &Summary) -> Vec<Vec<[f64; 2]>> {
    let parameters = ControllerParameters::default();
    let points = summary.set_points.iter().take(summary.set_points.len().saturating_sub(1));
    let domain =
        |[x, y, z]: [f64; 3]| BoundedDomain::new(&parameters.robot, &parameters.gains(), [x, y].into(), z);
    points.map(|point| vertices(&domain(point.position).half_planes())).collect()
}

fn vertices(half_planes: &[HalfPlane]) -> Vec<[f64; 2]> {
    polygon(half_planes, 1.0).iter().map(|vertex| [vertex.x, vertex.y]).collect()
}
