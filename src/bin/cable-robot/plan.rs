//! `cable-robot plan`: the set points to a goal, and what stands in the way of one that cannot be had.

use std::fmt::Write;

use anyhow::{Context, Result};
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::extremes::{Extremes, TensionAt, extremes};
use cable_robot::plan::nearest::{Nearest, nearest_admissible, workspace_facets};
use cable_robot::plan::planner::next_set_point;
use cable_robot::robot::{Pose, TensionLimits};
use clap::Args;
use serde_json::json;

use crate::arguments::{Planner, pose};
use crate::rig::{RigArgument, require_rest};
use crate::{Outcome, metres, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot plan --from 0,0,1 --to 0.15,0.15,1
         cable-robot plan --from 0,0,1 --to 0,0.4,1     (exit code 3: it says which cable forbids it, when, and how near one gets)";

/// The nearest point is this far inside the static workspace, m.
const NEAREST_MARGIN: f64 = 1e-3;

#[derive(Args)]
pub struct Plan {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] of the start, at rest, m and rad
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Pose,
    /// x,y,z[,roll,pitch,yaw] of the goal, m and rad
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Pose,
    /// Reachable domain to plan with
    #[arg(long, value_enum, default_value_t = Planner::Bounded)]
    planner: Planner,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// A plan, or as much of one as there is.
struct Planned {
    set_points: Vec<Pose>,
    /// The smallest tension predicted, and in which step (from 1); `None` if no step is made.
    smallest: Option<(usize, TensionAt)>,
    /// Why the goal is not among the set points.
    obstacle: Option<Obstacle>,
}

struct Obstacle {
    /// The cable and the moment at which the step from the last set point straight to the goal breaks a limit; `None` if it
    /// breaks none or meets a singular pose.
    broken: Option<Extremes>,
    nearest: Option<Nearest>,
    /// Distance from the goal to the nearest admissible pose's position, m.
    distance: Option<f64>,
}

impl Plan {
    pub fn run(&self) -> Result<Outcome> {
        let parameters = self.rig.controller(self.planner.kind())?;
        require_rest(&parameters, &self.from)?;
        let planned = self.plan(&parameters)?;
        if let Some((step, smallest)) = planned.smallest.filter(|(_, u)| u.tension <= parameters.min_tension)
        {
            eprintln!(
                "cable-robot: cable {} falls to {:.3} N in step {step}, below the rig's least tension of {} N, which planner {:?} \
                 does not look at",
                smallest.cable, smallest.tension, parameters.min_tension, self.planner
            );
        }
        if self.json {
            print_json(&self.as_json(&planned))?;
        } else {
            print(&self.as_text(&planned, &parameters))?;
        }
        Ok(if planned.obstacle.is_some() { Outcome::NotReachable } else { Outcome::Done })
    }

    fn plan(&self, parameters: &ControllerParameters) -> Result<Planned> {
        let limits = TensionLimits { min: parameters.min_tension, max: parameters.max_tension };
        let look =
            |from: &Pose, to: &Pose| extremes(&parameters.robot, &parameters.gains(), &limits, from, to);
        let (mut at, mut set_points, mut smallest) = (self.from, vec![], None::<(usize, TensionAt)>);
        while let Some(next) = next_set_point(parameters, &at, &self.to) {
            let step =
                look(&at, &next).context("the way to a set point leads through a singular pose")?.smallest;
            set_points.push(next);
            at = next;
            if smallest.is_none_or(|(_, so_far)| step.tension < so_far.tension) {
                smallest = Some((set_points.len(), step));
            }
        }
        let obstacle =
            if at == self.to { None } else { Some(self.obstacle(parameters, look(&at, &self.to))?) };
        Ok(Planned { set_points, smallest, obstacle })
    }

    fn obstacle(&self, parameters: &ControllerParameters, direct: Option<Extremes>) -> Result<Obstacle> {
        let goal = self.to.position();
        let nearest = nearest_admissible(&goal.xy(), &workspace_facets(&parameters.robot), NEAREST_MARGIN)?;
        // (15) keeps the height.
        let distance = nearest.map(|nearest| nearest.distance.hypot(goal.z - self.from.0[2]));
        Ok(Obstacle { broken: direct.filter(|direct| direct.first_outside.is_some()), nearest, distance })
    }

    fn as_text(&self, planned: &Planned, parameters: &ControllerParameters) -> String {
        let mut text = String::from("set points\n  i      x (m)     y (m)     z (m)\n");
        for (i, point) in std::iter::once(&self.from).chain(&planned.set_points).enumerate() {
            let _ = writeln!(
                text,
                "  {i:<3} {} {} {}",
                metres(point.0[0]),
                metres(point.0[1]),
                metres(point.0[2])
            );
        }
        if let Some((step, u)) = planned.smallest {
            let _ = writeln!(text, "smallest tension: {} in step {step}", described(&u));
        }
        let Some(obstacle) = &planned.obstacle else {
            text += "the goal is reached\n";
            return text;
        };
        text += "the goal cannot be had\n";
        match &obstacle.broken {
            Some(Extremes { first_outside: Some(first), smallest, greatest }) => {
                let _ = writeln!(
                    text,
                    "  the step from the last set point straight to it breaks the limits ({} to {} N): {}",
                    parameters.min_tension,
                    parameters.max_tension,
                    described(first)
                );
                let worst = if first.tension > parameters.max_tension { greatest } else { smallest };
                let _ = writeln!(text, "  and is worst with {}", described(worst));
            }
            _ => {
                let _ = writeln!(
                    text,
                    "  planner {:?} has no step to it; it plans at one height and with zero orientation",
                    self.planner
                );
            }
        }
        if let Some(Nearest { point, cable, .. }) = obstacle.nearest {
            let place = place(point.x, point.y, self.from.0[2]);
            let distance = obstacle.distance.unwrap_or_default();
            let _ = writeln!(text, "  nearest: {place}, {distance:.4} m from the goal");
            if let Some(cable) = cable {
                let _ = writeln!(text, "  beyond it cable {cable} is slack at rest");
            }
        }
        text
    }

    fn as_json(&self, planned: &Planned) -> serde_json::Value {
        let pose = |pose: &Pose| pose.0.as_slice().to_vec();
        let tension = |u: &TensionAt| json!({ "cable": u.cable, "tension": u.tension, "time": u.time, "pose": pose(&u.pose) });
        let smallest = planned.smallest.map(|(step, u)| json!({ "step": step, "at": tension(&u) }));
        let obstacle = planned.obstacle.as_ref().map(|obstacle| {
            json!({
                "firstOutside": obstacle.broken.and_then(|broken| broken.first_outside).map(|u| tension(&u)),
                "smallest": obstacle.broken.map(|broken| tension(&broken.smallest)),
                "greatest": obstacle.broken.map(|broken| tension(&broken.greatest)),
                "nearest": obstacle.nearest.map(|nearest| json!({
                    "point": [nearest.point.x, nearest.point.y, self.from.0[2]],
                    "distance": obstacle.distance,
                    "forbiddenBy": nearest.cable,
                })),
            })
        });
        json!({
            "from": pose(&self.from),
            "to": pose(&self.to),
            "reachable": planned.obstacle.is_none(),
            "setPoints": planned.set_points.iter().map(pose).collect::<Vec<_>>(),
            "smallestTension": smallest,
            "obstacle": obstacle,
        })
    }
}

fn described(u: &TensionAt) -> String {
    let place = place(u.pose.0[0], u.pose.0[1], u.pose.0[2]);
    format!("{:.3} N in cable {} after {:.3} s at {place}", u.tension, u.cable, u.time)
}

fn place(x: f64, y: f64, z: f64) -> String {
    format!("({}, {}, {})", metres(x).trim(), metres(y).trim(), metres(z).trim())
}
