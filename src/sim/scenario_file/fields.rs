//! The fields of a scenario file, with what JSON Schema can say of each.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use serde_json::json;
use toml::Spanned;

use crate::plan::PlannerKind;

/// A scenario for cable-robot: what happens in a simulation. SI units, angles in rad, z down; times from the start, s.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "cable-robot scenario")]
pub struct File {
    /// What the scenario shows, in a line.
    pub title: String,
    /// Path of a rig file, relative to this file; the paper's rig if left out.
    #[schemars(with = "String", default)]
    pub rig: Option<Spanned<String>>,
    /// Pose at which the platform hangs at rest: x, y, z (m), or with roll, pitch, yaw (rad); the rig's home if left out.
    #[schemars(with = "Vec<f64>", default, length(min = 3, max = 6))]
    pub start: Option<Spanned<Vec<f64>>>,
    /// Simulated time, s: greater than 0, a whole number of steps.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub duration: Spanned<f64>,
    /// Time between two steps of the controller, s: greater than 0.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0, "default" = 0.001))]
    pub step: Option<Spanned<f64>>,
    /// Instead of goals: an orbit about the start, which it begins with.
    #[schemars(with = "Orbit", default)]
    pub orbit: Option<Spanned<Orbit>>,
    /// Goals in the order of their times; before the first one the robot holds its start.
    #[serde(default)]
    pub goals: Vec<Goal>,
    /// Forces and torques on the platform; where several act at once they add up.
    #[serde(default)]
    pub disturbances: Vec<Disturbance>,
    /// Imperfections of the plant; each is zero if left out.
    #[serde(default)]
    pub imperfections: Imperfections,
    /// Settings of the controller; what is left out is the rig's (gains, limits) or Table II's.
    #[serde(default)]
    pub controller: Controller,
}

/// An orbit from rest to rest, which may leave the static workspace.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orbit {
    /// What it draws.
    pub shape: Shape,
    /// R, m: of the circle, half the line, of the hypotrochoid's large circle; greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub radius: Spanned<f64>,
    /// Of the end at which a line begins, from the x axis towards y, rad; 0 if left out.
    #[schemars(with = "f64", default)]
    pub direction: Option<Spanned<f64>>,
    /// Radius of a hypotrochoid's small circle, as a share of R: greater than 0; 0.15 if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    pub share: Option<Spanned<f64>>,
    /// Lobes of a hypotrochoid: from 2 to 100; 3 if left out.
    #[schemars(with = "u32", default, range(min = 2, max = 100))]
    pub lobes: Option<Spanned<u32>>,
    /// Ω, rad/s: greater than 0; that of a pendulum as long as the anchors are above the start if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    pub rate: Option<Spanned<f64>>,
    /// Turns at full size: greater than 0; 3 if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    pub turns: Option<Spanned<f64>>,
    /// T₁, how long it grows from the centre, s: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub start: Spanned<f64>,
}

/// What an orbit draws.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// About the start.
    Circle,
    /// To and fro, the start in its middle.
    Line,
    /// A circle and on it a smaller one that turns the other way round.
    Hypotrochoid,
}

/// A goal and when it is given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// When it is given, s: 0 or greater, not after the last step begins.
    #[schemars(with = "f64", extend("minimum" = 0))]
    pub time: Spanned<f64>,
    /// x, y, z (m), or with roll, pitch, yaw (rad).
    #[schemars(with = "Vec<f64>", length(min = 3, max = 6))]
    pub pose: Spanned<Vec<f64>>,
    /// Poses on the way to it, passed without a stop where that is proved: at most seven, and `minimum-time` alone takes them.
    #[serde(default)]
    #[schemars(with = "Vec<Vec<f64>>", length(max = 7))]
    pub through: Vec<Spanned<Vec<f64>>>,
}

/// A force, a torque or both, in the base frame.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// When it begins, s: 0 or greater.
    #[schemars(with = "f64", extend("minimum" = 0))]
    pub from: Spanned<f64>,
    /// When it ends, s: greater than `from`; it lasts if left out.
    #[schemars(with = "f64", default)]
    pub until: Option<Spanned<f64>>,
    /// On the centre of mass, N.
    #[schemars(with = "[f64; 3]", default)]
    pub force: Option<Spanned<[f64; 3]>>,
    /// N m.
    #[schemars(with = "[f64; 3]", default)]
    pub torque: Option<Spanned<[f64; 3]>>,
}

/// Imperfections of the plant; each is zero if left out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Imperfections {
    /// Coulomb friction between motor and platform, N a cable: 0 or greater.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub friction: Option<Spanned<f64>>,
    /// Time constant of the motors' torque, s: 0 or greater.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub motor_lag: Option<Spanned<f64>>,
    /// Smallest change of cable length that the encoders see, m: 0 or greater.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub encoder_resolution: Option<Spanned<f64>>,
    /// Standard deviation of the load cells' noise, N: 0 or greater.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub load_cell_noise: Option<Spanned<f64>>,
    /// Seed of that noise: the same seed, the same noise; 1 if left out.
    #[schemars(with = "i32", default)]
    pub noise_seed: Option<i32>,
}

/// Settings of the controller; what is left out is the rig's (gains, limits) or Table II's.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Which reachable domain the planner uses; if left out `bounded` for the paper's rig, `exact` for others.
    #[serde(default, deserialize_with = "planner")]
    #[schemars(schema_with = "planner_schema", default)]
    pub planner: Option<PlannerKind>,
    /// T_s, s: greater than 0; 0.05 if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    pub planner_period: Option<Spanned<f64>>,
    /// N of the bisection after Eq. (17): from 1 to 52; 8 if left out.
    #[schemars(with = "i32", default, range(min = 1, max = 52))]
    pub bisection_steps: Option<Spanned<i32>>,
    /// λ₀ of Eq. (2), 1/s: greater than 0, at most 1000; the rig's if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0, "maximum" = 1000))]
    pub lambda: Option<Spanned<f64>>,
    /// η₀ of Eq. (4), 1/s: greater than 0, at most 1000; the rig's if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0, "maximum" = 1000))]
    pub eta: Option<Spanned<f64>>,
    /// Least tension of a cable, N: 0 or greater; the rig's if left out.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub min_tension: Option<Spanned<f64>>,
    /// Greatest tension of a cable, N: greater than `min_tension`; the rig's if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    pub max_tension: Option<Spanned<f64>>,
    /// Where the measured pose comes from; `encoder_pose` if left out.
    #[schemars(with = "PoseSource", default)]
    pub pose_source: Option<PoseSource>,
    /// Whether the load cells correct the motors (Section VII); false if left out.
    #[schemars(with = "bool", default)]
    pub force_loop: Option<bool>,
    /// Whether the law is evaluated for the interval in which its command acts, not for the measurement; true if left out.
    #[schemars(with = "bool", default)]
    pub hold_compensation: Option<bool>,
    /// With that: from a measurement to the moment at which its command acts, s: 0 or greater; 0 if left out.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub command_delay: Option<Spanned<f64>>,
    /// Largest constant force that is estimated and made up for, as a share of the weight: 0 (none) to 1; 0.1 if left out. `bounded` has none.
    #[schemars(with = "f64", default, extend("minimum" = 0, "maximum" = 1))]
    pub observer_bound: Option<Spanned<f64>>,
    /// By which share the platform's mass may differ from the rig's: 0 or greater, below 1; 0 if left out. `exact` leaves room for it.
    #[schemars(with = "f64", default, extend("minimum" = 0, "exclusiveMaximum" = 1))]
    pub mass_tolerance: Option<Spanned<f64>>,
    /// Smallest change of cable length that the encoders see, as the controller knows it, m: 0 or greater; 0 if left out. `exact` leaves room for it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub encoder_resolution: Option<Spanned<f64>>,
    /// Largest force on the platform that is not known, N, the largest torque being that at its radius: 0 or greater; 0 if left out. `exact` leaves
    /// room for it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub disturbance_bound: Option<Spanned<f64>>,
    /// Greatest speed of the centre of mass, m/s: 0 (no limit) or greater; 0 if left out. `exact` heeds it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub max_speed: Option<Spanned<f64>>,
    /// Greatest angular velocity of the platform, rad/s: 0 (no limit) or greater; 0 if left out. `exact` heeds it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub max_angular_rate: Option<Spanned<f64>>,
    /// Greatest speed of a cable, m/s: 0 (no limit) or greater; 0 if left out. `exact` heeds it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub max_cable_speed: Option<Spanned<f64>>,
    /// Greatest rate of a cable's commanded tension on the way, N/s: 0 (no limit) or greater; 0 if left out. `minimum-time` alone heeds it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub max_tension_rate: Option<Spanned<f64>>,
    /// By how much the platform may rise above the straight way to be quicker, m: 0 (not at all) or greater; 0 if left out. `minimum-time` alone heeds it.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    pub lift: Option<Spanned<f64>>,
}

fn planner<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<PlannerKind>, D::Error> {
    const KEYS: &[&str] = &PlannerKind::KEYS;
    let key = String::deserialize(deserializer)?;
    PlannerKind::named(&key).map(Some).ok_or_else(|| D::Error::unknown_variant(&key, KEYS))
}

fn planner_schema(_: &mut SchemaGenerator) -> Schema {
    let item = |kind: PlannerKind| json!({ "const": kind.key(), "description": kind.described().1 });
    json_schema!({ "oneOf": PlannerKind::ALL.map(item) })
}

/// Where the measured pose comes from.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PoseSource {
    /// The encoders' pose.
    EncoderPose,
    /// Forward kinematics of the cable lengths.
    CableLengths,
}
