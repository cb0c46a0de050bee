//! What `simulate --json` prints.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

/// With and without `--sweep`.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "names both for the schema")]
pub enum OneOrSeveral {
    One(Answer),
    Several(Vec<AnswerCase>),
}

/// What a simulation came to. Positions in the base frame, times from the start of the simulation.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct Answer {
    /// Of the scenario.
    pub title: String,
    /// Time of the last row, s.
    pub end_time: f64,
    /// In their order; null if the controller has none.
    pub set_points: Option<Vec<AnswerSetPoint>>,
    /// In their order.
    pub goals: Vec<AnswerGoal>,
    /// The smallest tension of the run; null if none was recorded.
    pub smallest_tension: Option<AnswerTension>,
    /// The cables that went slack.
    pub slack: Vec<AnswerSlack>,
    /// From the last goal at the end, m; null without a goal.
    pub goal_distance: Option<f64>,
    /// How much the platform is turned from the last goal at the end, rad; null without a goal.
    pub goal_turn: Option<f64>,
    /// What the controller said last; null if it says nothing.
    pub status: Option<String>,
}

/// A set point.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerSetPoint {
    /// When it was given, s.
    pub time: f64,
    /// x, y, z, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub angles: [f64; 3],
}

/// A goal.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerGoal {
    /// When it was given, s.
    pub time: f64,
    /// x, y, z, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub angles: [f64; 3],
    /// When the robot first rested there, s; null if it never did.
    pub reached: Option<f64>,
}

/// A tension at an instant.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerTension {
    /// The cable, from 1.
    pub cable: usize,
    /// N.
    pub tension: f64,
    /// s.
    pub time: f64,
}

/// A cable that went slack.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerSlack {
    /// The cable, from 1.
    pub cable: usize,
    /// When it first did, s.
    pub first: f64,
    /// For how long in all, s.
    pub duration: f64,
}

/// One run of a sweep.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerCase {
    /// The fields of the scenario that were set, by name, in the units of the scenario file.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, toml::Value>,
    /// What it came to.
    pub summary: Answer,
}
