//! `cable-robot plan`: the set points to a goal, and what stands in the way of one that cannot be had.

mod show;

use anyhow::{Context, Result};
use cable_robot::control;
use cable_robot::plan::extremes::{Extremes, TensionAt, extremes};
use cable_robot::plan::nearest::{nearest_admissible, workspace_facets};
use cable_robot::plan::planner::Planner as SetPoints;
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::rig::SINGULARITY_THRESHOLD;
use cable_robot::robot::{Pose, Rig, Shape};
use clap::Args;
use nalgebra::Vector2;

use crate::arguments::{Planner, pose};
use crate::rig::{RigArgument, require_below, require_rest};
use crate::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot plan --from 0,0,1 --to 0.15,0.15,1
         cable-robot plan --from 0,0,1 --to 0,0.4,1     (exit code 3: it says which cable forbids it, when, and how near one gets)";

/// Set points after which a plan is given up.
const MOST_SET_POINTS: usize = 1000;
/// Halvings of the distance to the border that the nearest point keeps.
const HALVINGS: usize = 20;
/// Nothing new happens farther than this many radii of the rig from it.
const FAR: f64 = 10.0;
/// Points looked at between the nearest point and the goal.
const POINTS: u32 = 2000;

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
    /// Reachable domain to plan with; without it bounded for the paper's rig, exact for others
    #[arg(long, value_enum)]
    planner: Option<Planner>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// A plan, or as much of one as there is.
struct Planned {
    set_points: Vec<Pose>,
    /// The smallest tension predicted, and in which step (from 1); `None` if no step is made.
    smallest: Option<(usize, TensionAt)>,
    /// Whether the goal may be among set points that are no longer looked for.
    given_up: bool,
    /// Why the goal is not among the set points.
    obstacle: Option<Obstacle>,
}

struct Obstacle {
    /// Whether the wrench matrix is singular at the goal.
    singular: bool,
    /// The cable and the moment at which the step from the last set point straight to the goal breaks a limit; `None` if it
    /// breaks none or meets a singular pose.
    broken: Option<Extremes>,
    /// The nearest pose that can be had.
    nearest: Option<Pose>,
    /// What the robot cannot do at rest between there and the goal.
    barrier: Option<Barrier>,
}

/// A tension reaches a limit with the platform at rest.
struct Barrier {
    limit: control::Barrier,
    at: Pose,
}

impl Planned {
    fn is_complete(&self) -> bool {
        !self.given_up && self.obstacle.is_none()
    }
}

impl Plan {
    pub fn run(&self) -> Result<Outcome> {
        let planner = self.planner.map(Planner::kind);
        let (_, parameters) = self.rig.read_with_controller(planner)?;
        require_rest(&parameters, "--from", &self.from)?;
        require_below(&parameters.rig, "--to", &self.to)?;
        let planned = self.plan(&parameters)?;
        if self.json {
            print_json(&show::as_json(self, &planned, &parameters))?;
        } else {
            print(&show::as_text(self, &planned, &parameters))?;
        }
        Ok(if planned.is_complete() { Outcome::Done } else { Outcome::NotReachable })
    }

    fn plan(&self, parameters: &ControllerParameters) -> Result<Planned> {
        let look = |from: &Pose, to: &Pose| extremes(&parameters.rig, &parameters.gains(), from, to);
        // Where the controller would make for.
        let aim = match parameters.planner {
            PlannerKind::Bounded => self.to,
            PlannerKind::Exact => SetPoints::from(*parameters).exact_aim(&self.from, &self.to),
        };
        let set_points = sequence(parameters, &self.from, &aim);
        let (mut at, mut smallest) = (self.from, None::<(usize, TensionAt)>);
        for (i, next) in set_points.iter().enumerate() {
            let step =
                look(&at, next).context("the way to a set point leads through a singular pose")?.smallest;
            at = *next;
            if smallest.is_none_or(|(_, so_far)| step.tension < so_far.tension) {
                smallest = Some((i + 1, step));
            }
        }
        let goal = match parameters.planner {
            PlannerKind::Bounded => self.pose_over(&self.to.position().xy()),
            PlannerKind::Exact => self.to,
        };
        let given_up =
            at != aim && set_points.len() == MOST_SET_POINTS && barrier(parameters, &goal, &goal).is_none();
        let obstacle = if given_up || at == self.to {
            None
        } else {
            let broken = look(&at, &self.to).filter(|direct| direct.first_outside.is_some());
            let regularity = parameters.rig.regularity(&self.to);
            let singular = regularity < SINGULARITY_THRESHOLD;
            let nearest = match parameters.planner {
                PlannerKind::Exact => Some(at),
                PlannerKind::Bounded => self.nearest(parameters)?.or((at != self.from).then_some(at)),
            };
            let barrier = barrier(parameters, &nearest.unwrap_or(at), &goal);
            Some(Obstacle { singular, broken, nearest, barrier })
        };
        Ok(Planned { set_points, smallest, given_up, obstacle })
    }

    /// The point nearest to the goal, at the height of the start, to which the paper's planner has a plan: as little inside the facets of
    /// the static workspace as limits of tension and the planner's own allowances need.
    fn nearest(&self, parameters: &ControllerParameters) -> Result<Option<Pose>> {
        let Ok(shape) = Shape::of(&parameters.rig) else { return Ok(None) };
        let facets = workspace_facets(&shape.robot);
        // The solver's precision is relative to the distance.
        let middle = shape.to_rig(&Pose::at(0.0, 0.0, shape.to_paper(&self.to).0[2]));
        let goal = shape.to_paper(&within_reach(&parameters.rig, &middle, &self.to)).position();
        let arrives = |place: &Pose| {
            place == &self.from || sequence(parameters, &self.from, place).last() == Some(place)
        };
        let (mut short, mut enough, mut found) = (0.0, 0.5 * shape.robot.a, None);
        for _ in 0..HALVINGS {
            let margin = 0.5 * (short + enough);
            let nearest = nearest_admissible(&goal.xy(), &facets, margin)?;
            let nearest = nearest.map(|nearest| self.pose_over_paper(&shape, &nearest.point));
            if nearest.as_ref().is_some_and(arrives) {
                (enough, found) = (margin, nearest);
            } else {
                short = margin;
            }
        }
        Ok(found)
    }

    /// At the height of the start, which (15) keeps.
    fn pose_over(&self, point: &Vector2<f64>) -> Pose {
        Pose::at(point.x, point.y, self.from.0[2])
    }

    /// The same over a point of the paper's plane.
    fn pose_over_paper(&self, shape: &Shape, point: &Vector2<f64>) -> Pose {
        let height = shape.to_paper(&self.from).0[2];
        shape.to_rig(&Pose::at(point.x, point.y, height))
    }

    fn is_turned(&self) -> bool {
        self.to.0.fixed_rows::<3>(3).amax() > 0.0
    }
}

/// The set points from rest to rest, as far as there are any.
fn sequence(parameters: &ControllerParameters, from: &Pose, to: &Pose) -> Vec<Pose> {
    let planner = SetPoints::from(*parameters);
    let next = |at: &Pose| planner.next_from_rest(at, to);
    std::iter::successors(next(from), next).take(MOST_SET_POINTS).collect()
}

/// The goal, or if it is far out the point of the way to it from which on nothing new happens.
fn within_reach(rig: &Rig, from: &Pose, goal: &Pose) -> Pose {
    let far = FAR * rig.radius();
    let way = goal.0 - from.0;
    let longest = way.amax();
    if longest <= far { *goal } else { Pose(from.0 + way * (far / longest)) }
}

/// Where, on the line from one pose to another, a tension first is at or beyond a limit at rest.
fn barrier(parameters: &ControllerParameters, from: &Pose, to: &Pose) -> Option<Barrier> {
    let rig = &parameters.rig;
    let to = &within_reach(rig, from, to);
    (0..=POINTS).find_map(|k| {
        let at = Pose(from.0.lerp(&to.0, f64::from(k) / f64::from(POINTS)));
        control::barrier(rig, &at).map(|limit| Barrier { limit, at })
    })
}
