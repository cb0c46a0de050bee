//! `cable-robot simulate`: controller and plant in a closed loop.

use std::io::{Write, stdout};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use cable_robot::plan::{Controller, ControllerInputs, ControllerOutputs, Status};
use cable_robot::report::{Run, Summary};
use cable_robot::robot::{CABLES, Pose};
use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};
use clap::Args;
use indicatif::ProgressBar;
use serde_json::json;

use crate::arguments::{Planner, create, pose, seconds};
use crate::rig::{RigArgument, require_rest};
use crate::{Outcome, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot simulate --to 0.15,0.15,1 --output run.csv
Exit code 3: the controller ended with the status GoalUnreachable.";

/// Steps that are recorded at most.
const MOST_STEPS: f64 = 1e6;

#[derive(Args)]
pub struct Simulate {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] of the start, at rest, m and rad; without it the rig's home
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Option<Pose>,
    /// x,y,z[,roll,pitch,yaw] of the goal, m and rad
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Pose,
    /// Simulated time, s
    #[arg(long, value_parser = seconds, default_value = "12")]
    duration: f64,
    /// Time between two steps of the controller, s
    #[arg(long, value_parser = seconds, default_value = "0.001")]
    step: f64,
    /// Reachable domain to plan with
    #[arg(long, value_enum, default_value_t = Planner::Bounded)]
    planner: Planner,
    /// Writes the CSV into this file instead of stdout
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Prints the summary for machines to stdout; the CSV is written only with --output
    #[arg(long)]
    json: bool,
}

impl Simulate {
    pub fn run(&self) -> Result<Outcome> {
        let parameters = self.rig.controller(self.planner.kind())?;
        let from = self.from.map_or_else(|| self.rig.read().map(|file| file.home), Ok)?;
        require_rest(&parameters, &from)?;
        let steps = (self.duration / self.step).round();
        ensure!(
            (1.0..=MOST_STEPS).contains(&steps),
            "--duration {:?} s in steps of {:?} s makes {steps:?} steps: 1 to {MOST_STEPS} are allowed",
            self.duration,
            self.step
        );
        let sink: Box<dyn Write> = match &self.output {
            Some(path) => Box::new(create(path)?),
            None if self.json => Box::new(std::io::sink()),
            None => Box::new(stdout().lock()),
        };
        let mut csv = csv::Writer::from_writer(sink);
        csv.write_record(header())?;

        let plant = PlantParameters { robot: parameters.robot, initial_pose: from, ..Default::default() };
        let hanging = Plant::new(plant, &PlantInputs::default())?;
        let mut controller = Controller::new(parameters, 0.0, &inputs(hanging.outputs(), self.to))?;
        let mut plant = Plant::new(plant, &pull(controller.outputs()))?;
        let mut run = Run::default();
        record(&mut run, &mut csv, 0.0, controller.outputs(), plant.outputs())?;
        // Shown on a terminal only.
        let bar = ProgressBar::new(steps as u64);
        for k in 0..steps as u64 {
            let time = k as f64 * self.step;
            controller.step(time, &inputs(plant.outputs(), self.to));
            plant.step(&pull(controller.outputs()), self.step).with_context(|| format!("at {time} s"))?;
            let after = (k + 1) as f64 * self.step;
            record(&mut run, &mut csv, after, controller.outputs(), plant.outputs())?;
            bar.inc(1);
        }
        csv.flush()?;
        bar.finish_and_clear();

        let (summary, status) = (run.summary(), controller.outputs().status);
        eprint!("{}", as_text(&summary, status, self.duration));
        if self.json {
            print_json(&as_json(&summary, status))?;
        }
        Ok(if status == Status::GoalUnreachable { Outcome::NotReachable } else { Outcome::Done })
    }
}

fn inputs(plant: &PlantOutputs, goal: Pose) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose: goal,
        enable: true,
    }
}

/// Columns of the CSV, as the FMUs call the quantities.
fn header() -> Vec<String> {
    let pose =
        |name: &'static str| ["x", "y", "z", "roll", "pitch", "yaw"].map(|axis| format!("{name}.{axis}"));
    let tensions = (1..=CABLES).map(|i| format!("measuredTension[{i}]"));
    let single = ["setPointIndex", "tensionMargin", "steady", "atGoal", "status"].map(str::to_owned);
    let time = std::iter::once("time".to_owned());
    time.chain(pose("encoderPose")).chain(pose("setPoint")).chain(tensions).chain(single).collect()
}

fn pull(output: &ControllerOutputs) -> PlantInputs {
    PlantInputs { motor_tension: output.motor_tension, ..PlantInputs::default() }
}

/// Takes down the plant at `time` and what the controller said for the step that led there.
fn record(
    run: &mut Run,
    csv: &mut csv::Writer<Box<dyn Write>>,
    time: f64,
    output: &ControllerOutputs,
    plant: &PlantOutputs,
) -> csv::Result<()> {
    let (pose, set_point) = (plant.encoder_pose.0, output.set_point.0);
    run.times.push(time);
    for k in 0..3 {
        run.position[k].push(pose[k]);
        run.set_point[k].push(set_point[k]);
    }
    run.set_point_index.push(output.set_point_index.into());
    for i in 0..CABLES {
        run.tension[i].push(plant.measured_tension[i]);
        run.slack[i].push(plant.slack[i].into());
    }
    run.tension_margin.push(output.tension_margin);
    run.at_goal.push(output.at_goal.into());

    let mut row = vec![time];
    row.extend(pose.iter().chain(set_point.iter()).chain(&plant.measured_tension));
    row.extend([output.set_point_index.into(), output.tension_margin]);
    row.extend([output.steady.into(), output.at_goal.into(), f64::from(output.status as i32)]);
    csv.serialize(row)
}

fn as_text(summary: &Summary, status: Status, duration: f64) -> String {
    let mut text = String::from("set points\n  i   from (s)    x (m)    y (m)    z (m)\n");
    for (i, point) in summary.set_points.iter().enumerate() {
        let [x, y, z] = point.position;
        text += &format!("  {i}   {:8.3} {x:8.4} {y:8.4} {z:8.4}\n", point.time);
    }
    if let Some(smallest) = summary.smallest_tension {
        text += &format!("smallest tension: {smallest}\n");
    }
    text += &match summary.time_to_goal {
        Some(time) => format!("at the goal: after {time:.3} s\n"),
        None => format!("at the goal: not within {duration} s, status {status:?}\n"),
    };
    text += &match summary.slack {
        Some((cable, time)) => format!("slack cables: cable {cable}, first at {time:.3} s\n"),
        None => "slack cables: none\n".to_owned(),
    };
    text
}

fn as_json(summary: &Summary, status: Status) -> serde_json::Value {
    let set_points = summary.set_points.iter().map(|p| json!({ "time": p.time, "position": p.position }));
    json!({
        "setPoints": set_points.collect::<Vec<_>>(),
        "smallestTension": summary.smallest_tension.map(|u| {
            json!({ "cable": u.cable, "tension": u.value, "time": u.time })
        }),
        "timeToGoal": summary.time_to_goal,
        "slack": summary.slack.map(|(cable, time)| json!({ "cable": cable, "time": time })),
        "status": format!("{status:?}"),
    })
}
