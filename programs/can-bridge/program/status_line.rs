//! What `--status` writes: a JSON object a line.

use schemars::JsonSchema;
use serde::Serialize;

/// A line of `can-bridge --status`: the session as of its last cycle, ten times a second, or a message. Poses are x, y, z (m), roll, pitch, yaw (rad) in
/// the base frame; R = Rz(yaw) Ry(pitch) Rx(roll). Lists of cables begin with cable 1.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Line {
    Session(Box<SessionStatus>),
    Message(Message),
}

/// The session as of its last cycle.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct SessionStatus {
    /// When the cycle began, after the program's start, s.
    pub time: f64,
    /// Of the bridge: `Homing`, `Ready`, `Enabled`, ...
    pub state: String,
    /// The first fault since the last reset, in words; null if there was none.
    pub fault: Option<String>,
    /// Of the platform; null while it is not measured.
    pub pose: Option<[f64; 6]>,
    /// The last goal; null if there was none.
    pub goal: Option<GoalStatus>,
    /// Of each cable, m.
    pub length: Vec<f64>,
    /// By each load cell, N.
    pub measured: Vec<f64>,
    /// Commanded, N.
    pub tension: Vec<f64>,
    /// From each measured tension to its nearer limit, N; below 0 outside.
    pub margin: Vec<f64>,
    /// The smallest tension that the controller predicts from now on, N; null while it is not asked.
    pub predicted_margin: Option<f64>,
    /// Status of the controller; null while it is not asked.
    pub controller: Option<String>,
    /// Cycles so far.
    pub cycles: u64,
    /// Cycles left out so far, since the program came too late.
    pub missed_cycles: u64,
    /// What the recording lacks, frames and cycles.
    pub lost_entries: u64,
    /// By how much cycles began too late, us.
    pub lateness_microseconds: Times,
    /// From a cycle's first encoder frame to its last torque, us.
    pub latency_microseconds: Times,
    /// Frames received and sent so far.
    pub frames: u64,
    /// Share of each bus that the frames of the last second took, with as many stuff bits as there can be.
    pub bus_load: Vec<f64>,
}

/// A goal and what became of it.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct GoalStatus {
    /// Where the platform shall go.
    pub pose: [f64; 6],
    /// `given`, `waits`, `reached`, `unreachable`, `refused` or `given up`.
    pub fate: String,
    /// Why, or after how long; null while it is given only.
    pub reason: Option<String>,
}

/// Of all cycles so far.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Times {
    /// Not more in half of them.
    pub p50: f64,
    /// Not more in 99 of 100.
    pub p99: f64,
    /// The greatest.
    pub max: f64,
}

/// What the log says, too.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Message {
    /// After the program's start, s; 0 of what belongs to no cycle.
    pub time: f64,
    /// In words.
    pub message: String,
}
