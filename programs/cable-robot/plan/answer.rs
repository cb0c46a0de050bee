//! What `plan --json` prints.

use cable_robot::plan::ControllerParameters;
use cable_robot::plan::extremes::TensionAt;
use cable_robot::plan::planner::Planner;
use cable_robot::plan::sequence::Sequence;
use cable_robot::robot::Pose;
use schemars::JsonSchema;
use serde::Serialize;

use super::Plan;

/// With and without `--through`.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "names both for the schema")]
pub enum Answer {
    SetPoints(Box<SetPoints>),
    Through(Through),
}

/// The set points from rest at a pose to a goal, or as far as there are any. Poses are x, y, z (m), roll, pitch, yaw (rad) in the base frame; R = Rz(yaw) Ry(pitch) Rx(roll).
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct SetPoints {
    /// The start, at rest: m, rad.
    from: [f64; 6],
    /// The goal: m, rad.
    to: [f64; 6],
    /// Whether the last set point is the goal; null if that is not known.
    reachable: Option<bool>,
    /// In their order, without the start: m, rad.
    set_points: Vec<[f64; 6]>,
    /// The smallest tension on the way; null if there is no set point.
    smallest_tension: Option<Smallest>,
    /// How long it takes, s; null of planners that do not say so.
    duration: Option<f64>,
    /// What stands between the last set point and the goal; null if nothing does.
    obstacle: Option<Obstacle>,
}

/// The smallest tension of a plan.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Smallest {
    /// The step in which it is, from 1.
    step: usize,
    /// Where and when.
    at: Tension,
}

/// A tension at an instant.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Tension {
    /// The cable, from 1.
    cable: usize,
    /// N.
    tension: f64,
    /// After the step began, s.
    time: f64,
    /// Of the platform: m, rad.
    pose: [f64; 6],
}

/// Why a goal cannot be reached, and what can.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct Obstacle {
    /// Whether the wrench matrix is singular at the goal.
    goal_singular: bool,
    /// Whether `--max-tension-rate` is too small for a motion on from the last set point.
    kept_by_max_tension_rate: bool,
    /// The first tension beyond its limits on the step from the last set point straight to the goal; null if there is none.
    first_outside: Option<Tension>,
    /// The smallest tension on that step; null if no limit is broken on it.
    smallest: Option<Tension>,
    /// The greatest.
    greatest: Option<Tension>,
    /// The nearest pose that can be reached; null if there is none.
    nearest: Option<Nearest>,
    /// What first reaches a limit at rest on the way from there to the goal; null if nothing does.
    barrier: Option<Barrier>,
}

/// The nearest pose that can be reached.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Nearest {
    /// m, rad.
    pose: [f64; 6],
    /// From there to the goal, m: the root mean square of the ways of the attachments.
    distance: f64,
}

/// A tension that reaches a limit with the platform at rest.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Barrier {
    /// The cable, from 1.
    cable: usize,
    /// Its limit, N.
    limit: f64,
    /// Where it is reached: m, rad.
    pose: [f64; 6],
}

/// A motion from rest to rest by way of other poses, without a stop.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct Through {
    /// Whether there is one.
    pub reachable: bool,
    /// Start, way points and goal; null if it is not reachable.
    pub passes: Option<Vec<Pass>>,
    /// From rest to rest, s.
    pub duration: Option<f64>,
    /// The smallest tension on the way.
    pub smallest_tension: Option<Tension>,
    /// Why it is not reachable, in words.
    pub obstacle: Option<String>,
}

/// When a pose is passed.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Pass {
    /// m, rad.
    pub pose: [f64; 6],
    /// After the start, s.
    pub time: f64,
}

impl SetPoints {
    pub fn new(plan: &Plan, planned: &Sequence, parameters: &ControllerParameters) -> Self {
        let obstacle = planned.obstacle.as_ref();
        Self {
            from: pose(&plan.from),
            to: pose(&plan.to),
            reachable: (!planned.given_up).then_some(planned.is_complete()),
            set_points: planned.set_points.iter().map(pose).collect(),
            smallest_tension: planned.smallest.map(|(step, at)| Smallest { step, at: Tension::new(&at) }),
            duration: planned.duration,
            obstacle: obstacle.map(|obstacle| Obstacle {
                goal_singular: obstacle.singular,
                kept_by_max_tension_rate: obstacle.is_kept_by_rate,
                first_outside: obstacle
                    .broken
                    .and_then(|broken| broken.first_outside)
                    .map(|u| Tension::new(&u)),
                smallest: obstacle.broken.map(|broken| Tension::new(&broken.smallest)),
                greatest: obstacle.broken.map(|broken| Tension::new(&broken.greatest)),
                nearest: obstacle.nearest.map(|nearest| Nearest {
                    pose: pose(&nearest),
                    distance: Planner::from(*parameters).distance(&nearest, &plan.to),
                }),
                barrier: obstacle.barrier.map(|(limit, at)| Barrier {
                    cable: limit.cable,
                    limit: limit.limit,
                    pose: pose(&at),
                }),
            }),
        }
    }
}

impl Tension {
    pub fn new(u: &TensionAt) -> Self {
        Self { cable: u.cable, tension: u.tension, time: u.time, pose: pose(&u.pose) }
    }
}

pub fn pose(pose: &Pose) -> [f64; 6] {
    pose.0.into()
}
