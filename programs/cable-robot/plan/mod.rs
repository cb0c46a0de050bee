//! `cable-robot plan`: the set points to a goal, and what stands in the way of one that cannot be reached.

pub mod answer;
mod picture;
mod show;
mod through;

use std::path::{Path, PathBuf};
use std::{fs, iter};

use anyhow::{Context, Result, ensure};
use cable_robot::plan::minimum_time::Course;
use cable_robot::plan::sequence::Sequence;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::reach::certificate::{Margins, Step};
use cable_robot::robot::{Coordinates, Pose, Rig};
use cable_robot_report::files::probe;
use clap::{Args, ValueHint};

use crate::command::arguments::{planner, pose};
use crate::command::figure::draw;
use crate::command::rig::{RigArgument, require_below, require_rest};
use crate::command::{Outcome, print, print_json, proof};
use picture::Shown;

pub const EXAMPLE: &str = "\
Example: cable-robot plan --from 0,0,1 --to 0.15,0.15,1
         cable-robot plan --from 0,0,1 --through 0.1,0,1 --through 0.15,0.05,1 --to 0.15,0.15,1     (in minimum time, without a stop)
         cable-robot plan --from 0,0,1 --to 0.15,0.15,1 --planner minimum-time --proof motion     (why it is so, to be checked: docs/proof.md)
         cable-robot plan --from 0,0,1 --to 0,0.4,1     (exit code 3: it says which cable forbids it, when, and how near one gets)";

#[derive(Args)]
pub struct Plan {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] of the start, at rest, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll)
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Pose,
    /// x,y,z[,roll,pitch,yaw] of the goal, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll)
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Pose,
    /// A way point, a pose as those, passed without a stop; may be given seven times, in their order (planner minimum-time)
    #[arg(long, value_parser = pose, allow_hyphen_values = true, value_name = "POSE", conflicts_with = "lift")]
    through: Vec<Pose>,
    /// Reachable domain to plan with; without it bounded for the paper's rig, exact for others, minimum-time with --through
    #[arg(long, value_parser = planner())]
    planner: Option<PlannerKind>,
    /// By how much the platform may rise above the straight way to be quicker, m (planner minimum-time)
    #[arg(long, default_value_t = 0.0)]
    lift: f64,
    /// Greatest rate of a tension, N/s, 0 for no limit (planner minimum-time)
    #[arg(long, default_value_t = 0.0, value_name = "RATE")]
    max_tension_rate: f64,
    /// Folder, new or empty, for what proves each step from rest at one set point to the next, or the motion of planner minimum-time
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    proof: Option<PathBuf>,
    /// Also draws the plan into this file: base, static workspace, set points and from each where the next may be
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    svg: Option<PathBuf>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

impl Plan {
    pub fn run(&self) -> Result<Outcome> {
        let fastest = Some(PlannerKind::MinimumTime);
        ensure!(
            self.through.is_empty() || self.planner.is_none() || self.planner == fastest,
            "--through is for --planner minimum-time: other planners stop at every set point"
        );
        let planner = if self.through.is_empty() { self.planner } else { fastest };
        let (file, mut parameters) = self.rig.read_with_controller(planner)?;
        (parameters.lift, parameters.max_tension_rate) = (self.lift, self.max_tension_rate);
        parameters.validate()?;
        require_rest(&parameters, "--from", &self.from)?;
        require_below(&parameters.rig, "--to", &self.to)?;
        self.proof.as_deref().map_or(Ok(()), prepare)?;
        self.svg.as_deref().map_or(Ok(()), probe)?;
        if !self.through.is_empty() {
            return through::run(self, &file, &parameters);
        }
        let planned = Sequence::new(&parameters, &self.from, &self.to)?;
        if let Some(folder) = &self.proof {
            match parameters.planner {
                PlannerKind::MinimumTime => {
                    prove_motion(folder, &parameters.rig, self.courses(&planned, &parameters))?
                }
                PlannerKind::Bounded | PlannerKind::Exact => self.prove(folder, &planned, &parameters)?,
            }
        }
        if let Some(path) = &self.svg {
            let said = show::verdict(self, &planned, &parameters);
            draw::write(path, &Shown::of(self, &file, &planned, &parameters, said).chart())?;
        }
        if self.json {
            print_json(&answer::SetPoints::new(self, &planned, &parameters))?;
        } else {
            print(&show::as_text(self, &planned, &parameters))?;
        }
        Ok(if planned.is_complete() { Outcome::Done } else { Outcome::NotReachable })
    }

    fn is_turned(&self) -> bool {
        self.to.0.fixed_rows::<3>(3).amax() > 0.0
    }

    /// The motions from rest at one set point to the next; `None` of a step too short for one.
    fn courses(&self, planned: &Sequence, parameters: &ControllerParameters) -> Vec<Option<Course>> {
        let planner = Planner::from(*parameters);
        let starts = iter::once(&self.from).chain(&planned.set_points);
        starts.zip(&planned.set_points).map(|(from, to)| planner.course_from_rest(from, to)).collect()
    }

    /// Writes what proves each step into `folder`.
    fn prove(&self, folder: &Path, planned: &Sequence, parameters: &ControllerParameters) -> Result<()> {
        let mut start = self.from;
        for (i, set_point) in planned.set_points.iter().copied().enumerate() {
            let step = Step { start, rates: Coordinates::zeros(), set_point, gains: parameters.gains() };
            proof::write(
                &folder.join(format!("step-{}.proof.json", i + 1)),
                &parameters.rig,
                &step,
                &Margins::default(),
            )?;
            start = set_point;
        }
        Ok(())
    }
}

/// Writes what proves motions from rest to rest, one after the other, into `folder`; nothing of steps that are none.
fn prove_motion(folder: &Path, rig: &Rig, courses: Vec<Option<Course>>) -> Result<()> {
    let pieces = |course: Option<Course>| Some(course?.pieces()?.collect::<Vec<_>>());
    let pieces: Option<Vec<_>> = courses.into_iter().map(pieces).collect();
    proof::write_motion(&folder.join("motion.proof.json"), rig, &pieces.unwrap_or_default().concat())
}

/// Makes a folder for proofs. Those of another plan must not be among them.
fn prepare(folder: &Path) -> Result<()> {
    let named = || format!("--proof {}", folder.display());
    fs::create_dir_all(folder).with_context(named)?;
    let is_empty = fs::read_dir(folder).with_context(named)?.next().is_none();
    ensure!(
        is_empty,
        "--proof {}: the folder holds files already: a new or empty one is wanted",
        folder.display()
    );
    Ok(())
}
