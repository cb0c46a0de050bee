//! `cable-robot plan`: the set points to a goal, and what stands in the way of one that cannot be had.

use std::fmt::Write;

use anyhow::{Context, Result};
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::extremes::{Extremes, TensionAt, extremes};
use cable_robot::plan::nearest::{Nearest, nearest_admissible, workspace_facets};
use cable_robot::plan::planner::{Situation, next_set_point};
use cable_robot::robot::{Coordinates, Pose, TensionLimits};
use clap::Args;
use serde_json::json;

use crate::arguments::{Planner, pose};
use crate::rig::{RigArgument, require_rest};
use crate::{Outcome, metres, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot plan --from 0,0,1 --to 0.15,0.15,1
         cable-robot plan --from 0,0,1 --to 0,0.4,1     (exit code 3: it says which cable forbids it, when, and how near one gets)";

/// A plan that has so many set points and is not there yet does not get there.
const MOST_SET_POINTS: usize = 1000;
/// Halvings of the distance to the border that the nearest point keeps.
const HALVINGS: usize = 20;

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
    /// The nearest point that can be had.
    nearest: Option<Nearest>,
}

impl Plan {
    pub fn run(&self) -> Result<Outcome> {
        let parameters = self.rig.controller(self.planner.kind())?;
        require_rest(&parameters, &self.from)?;
        let planned = self.plan(&parameters)?;
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
        let set_points = sequence(parameters, &self.from, &self.to);
        let (mut at, mut smallest) = (self.from, None::<(usize, TensionAt)>);
        for (i, next) in set_points.iter().enumerate() {
            let step =
                look(&at, next).context("the way to a set point leads through a singular pose")?.smallest;
            at = *next;
            if smallest.is_none_or(|(_, so_far)| step.tension < so_far.tension) {
                smallest = Some((i + 1, step));
            }
        }
        let obstacle = if at == self.to {
            None
        } else {
            let broken = look(&at, &self.to).filter(|direct| direct.first_outside.is_some());
            Some(Obstacle { broken, nearest: self.nearest(parameters)? })
        };
        Ok(Planned { set_points, smallest, obstacle })
    }

    /// The point nearest to the goal, at a height that the planner can give, to which there is a plan: as little inside the facets of
    /// the static workspace as limits of tension and the planner's own allowances need.
    fn nearest(&self, parameters: &ControllerParameters) -> Result<Option<Nearest>> {
        let (goal, facets) = (self.to.position(), workspace_facets(&parameters.robot));
        let z = self.nearest_height();
        let arrives = |nearest: &Nearest| {
            let place = Pose::at(nearest.point.x, nearest.point.y, z);
            place == self.from || sequence(parameters, &self.from, &place).last() == Some(&place)
        };
        let (mut short, mut enough, mut found) = (0.0, 0.5 * parameters.robot.a, None);
        for _ in 0..HALVINGS {
            let margin = 0.5 * (short + enough);
            let nearest = nearest_admissible(&goal.xy(), &facets, margin)?;
            if nearest.as_ref().is_some_and(arrives) {
                (enough, found) = (margin, nearest);
            } else {
                short = margin;
            }
        }
        Ok(found)
    }

    /// (15) keeps the height.
    fn nearest_height(&self) -> f64 {
        match self.planner {
            Planner::Bounded => self.from.0[2],
            Planner::Exact => self.to.0[2],
        }
    }

    /// From the goal to the nearest point, m.
    fn distance(&self, nearest: &Nearest) -> f64 {
        nearest.distance.hypot(self.to.0[2] - self.nearest_height())
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
                    "  planner {:?} has no step to it: {}",
                    self.planner,
                    match self.planner {
                        Planner::Bounded => "it plans at one height and with zero orientation",
                        Planner::Exact =>
                            "it plans with zero orientation and keeps 0.17 % of the weight of every tension",
                    }
                );
            }
        }
        match &obstacle.nearest {
            Some(nearest) => {
                let place = place(nearest.point.x, nearest.point.y, self.nearest_height());
                let distance = self.distance(nearest);
                let _ = writeln!(text, "  nearest: {place}, {distance:.4} m from the goal");
                if let Some(cable) = nearest.cable {
                    let _ = writeln!(
                        text,
                        "  held back by cable {cable}, which is slack at rest beyond its facet"
                    );
                }
            }
            None => text += "  no other point can be had from there\n",
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
                    "point": [nearest.point.x, nearest.point.y, self.nearest_height()],
                    "distance": self.distance(&nearest),
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

/// The set points from rest to rest, as far as there are any.
fn sequence(parameters: &ControllerParameters, from: &Pose, to: &Pose) -> Vec<Pose> {
    let next = |at: &Pose| {
        let now = Situation { pose: at, rates: &Coordinates::zeros(), set_point: at, hold: 0.0 };
        next_set_point(parameters, &now, to)
    };
    std::iter::successors(next(from), next).take(MOST_SET_POINTS).collect()
}

fn described(u: &TensionAt) -> String {
    let place = place(u.pose.0[0], u.pose.0[1], u.pose.0[2]);
    format!("{:.3} N in cable {} after {:.3} s at {place}", u.tension, u.cable, u.time)
}

fn place(x: f64, y: f64, z: f64) -> String {
    format!("({}, {}, {})", metres(x).trim(), metres(y).trim(), metres(z).trim())
}
