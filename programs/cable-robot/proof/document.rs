//! What a proof file holds, version 1: docs/proof.md.

use schemars::JsonSchema;
use serde::Serialize;

use super::number::{Limit, Number};

pub const FORMAT: &str = "cable-robot proof";
pub const VERSION: u32 = 1;
pub const ADMISSIBLE: &str = "admissible";
pub const NOT_ADMISSIBLE: &str = "not admissible";

/// A proof for a step or a motion of a cable-robot, to be checked without that program: docs/proof.md. SI units, angles in rad.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
#[schemars(title = "cable-robot proof", extend("oneOf" = [
    {
        "properties": {"verdict": {"const": "admissible"}, "problem": {"required": ["step"], "properties": {"margins": false}},
            "instant": false, "tube": false, "jump": false},
        "required": ["least", "greatest", "spans"]
    },
    {
        "properties": {"verdict": {"const": "admissible"}, "problem": {"required": ["step", "margins"]}, "instant": false, "jump": false},
        "required": ["least", "greatest", "spans", "tube"]
    },
    {
        "properties": {"verdict": {"const": "admissible"}, "problem": {"required": ["motion"]}, "instant": false, "tube": false},
        "required": ["least", "greatest", "spans", "jump"]
    },
    {
        "properties": {"verdict": {"const": "not admissible"}, "problem": {"required": ["step"]},
            "least": false, "greatest": false, "spans": false, "tube": false, "jump": false},
        "required": ["instant"]
    }
]))]
pub struct Document {
    /// What kind of file this is.
    #[schemars(extend("const" = FORMAT))]
    pub format: &'static str,
    /// Of the format.
    #[schemars(extend("const" = VERSION))]
    pub version: u32,
    /// What is proved of what.
    pub problem: Problem,
    /// SHA-256 of the problem's JSON text without white space, keys sorted.
    #[schemars(extend("pattern" = "^[0-9a-f]{64}$"))]
    pub sha256: String,
    /// `admissible` or `not admissible`.
    pub verdict: &'static str,
    /// Admissible: lower bound of all tensions for all time, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub least: Option<Number>,
    /// Admissible: upper bound of all tensions for all time, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub greatest: Option<Number>,
    /// Admissible: cover all time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<SpanEntry>", length(min = 2))]
    pub spans: Option<Vec<SpanEntry>>,
    /// Admissible, with margins: how far the robot may be from the closed form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "TubeEntry")]
    pub tube: Option<TubeEntry>,
    /// Of a motion: by how much coordinates and rates jump at most where pieces join.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "[Number; 2]")]
    pub jump: Option<[Number; 2]>,
    /// Not admissible: when no tensions within the limits do it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "InstantEntry")]
    pub instant: Option<InstantEntry>,
}

/// A rig, and a step or a motion.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {"required": ["step"], "properties": {"motion": false}},
    {"required": ["motion"], "properties": {"step": false, "margins": false}}
]))]
pub struct Problem {
    /// The robot.
    pub rig: RigEntry,
    /// What it is to do: a step of the law,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "StepEntry")]
    pub step: Option<StepEntry>,
    /// by a robot that differs from the rig by no more than this;
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "MarginsEntry")]
    pub margins: Option<MarginsEntry>,
    /// or a motion from rest to rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "MotionEntry")]
    pub motion: Option<MotionEntry>,
}

/// The robot.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct RigEntry {
    /// kg.
    pub mass: Number,
    /// About the centre of mass, platform's frame, kg m².
    pub inertia: [[Number; 3]; 3],
    /// Base frame, m/s².
    pub gravity: [Number; 3],
    /// Force (N) and torque about the centre of mass (N m), base frame, that act besides cables and weight.
    pub disturbance: [Number; 6],
    /// In the order of the cable numbers.
    #[schemars(length(min = 6, max = 16))]
    pub cables: Vec<CableEntry>,
}

/// A cable.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct CableEntry {
    /// Base frame, m.
    pub anchor: [Number; 3],
    /// Platform's frame, whose origin is the centre of mass, m.
    pub attachment: [Number; 3],
    /// Least tension, N.
    pub least: Number,
    /// Greatest tension, N.
    #[schemars(with = "Limit")]
    pub greatest: Number,
    /// The swivelling pulley at the anchor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "PulleyEntry")]
    pub pulley: Option<PulleyEntry>,
}

/// A pulley.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PulleyEntry {
    /// m.
    pub radius: Number,
    /// Unit vector, base frame.
    pub axis: [Number; 3],
}

/// A set point given to the law at some state.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct StepEntry {
    /// x, y, z, roll, pitch, yaw at first.
    pub start: [Number; 6],
    /// Their rates then.
    pub rates: [Number; 6],
    /// The set point.
    pub set_point: [Number; 6],
    /// 1/s.
    pub lambda: Number,
    /// 1/s.
    pub eta: Number,
}

/// Bounds of what the controller does not know or cannot do.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct MarginsEntry {
    /// Relative error of the mass and of each component of the inertia.
    pub mass: Number,
    /// Distance of the centre of mass from where the rig has it, m.
    pub centre_of_mass: Number,
    /// On the centre of mass, N.
    pub force: Number,
    /// About it, N m.
    pub torque: Number,
    /// Difference of what each cable pulls from what is commanded, N.
    pub friction: Number,
    /// Distance of anchors and attachments from where the rig has them, m.
    pub accuracy: Number,
    /// Longest time for which a command is held, s.
    pub sample_period: Number,
    /// Age of the state that it is computed from, s.
    pub delay: Number,
    /// More than six cables: what the law keeps from the limits, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub law_margin: Option<Number>,
}

/// Pieces, one after the other.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct MotionEntry {
    /// From rest to rest.
    #[schemars(length(min = 1))]
    pub pieces: Vec<PieceEntry>,
}

/// A sum of motions along ways.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PieceEntry {
    /// s.
    pub duration: Number,
    /// Added to the sum, m and rad.
    pub offset: [Number; 6],
    /// Summands.
    #[schemars(length(min = 1, max = 4))]
    pub parts: Vec<PartEntry>,
}

/// A motion along a way.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PartEntry {
    /// Coefficients of the powers of s - `begin`; those left out are 0.
    #[schemars(length(min = 1, max = 4))]
    pub way: Vec<[Number; 6]>,
    /// See `way`.
    pub begin: Number,
    /// Where the piece begins,
    pub s: Number,
    /// its derivative there, 1/s,
    pub rate: Number,
    /// and its second, 1/s².
    pub acceleration: Number,
    /// By how much that grows with s, 1/s²,
    pub beta: Number,
    /// or with time, 1/s³: one of the two is 0.
    pub jerk: Number,
}

/// What bounds how far the robot may be from the closed form.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct TubeEntry {
    /// Bounds of the accelerations that the model does not know, m/s² and rad/s².
    pub disturbance: [Number; 6],
    /// Of the sum of the tensions, N.
    pub pull: Number,
    /// Of the lengths of the cables' straight parts, m.
    pub shortest: Number,
    /// Of the distances of attachments from the axes of their pulleys, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub sideways: Option<Number>,
    /// Of what the cables' torque changes by with the pose, N m per m and rad.
    pub stiffness: [[Number; 6]; 3],
    /// More than six cables: by how much the law may intrude on its margin, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub intrusion: Option<Number>,
}

/// A span of time in which the tensions are within the limits.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SpanEntry {
    /// Of a motion: number of the piece, from 1, whose time `from` and `to` count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "usize", range(min = 1))]
    pub piece: Option<usize>,
    /// s; not of the last span of a motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub from: Option<Number>,
    /// s; not of the last span, which has no end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub to: Option<Number>,
    /// More than six cables: σ, N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<Number>")]
    pub base: Option<Vec<Number>>,
    /// More than six cables: B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<[Number; 6]>")]
    pub basis: Option<Vec<[Number; 6]>>,
    /// More than six cables with margins: z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "[Number; 6]")]
    pub multipliers: Option<[Number; 6]>,
    /// More than six cables with margins: how far the law's tensions are from those of the unknowns, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Number")]
    pub distance: Option<Number>,
    /// C.
    pub inverse: [[Number; 6]; 6],
    /// Coefficients of a polynomial for each unknown.
    pub solution: [Polynomial; 6],
    /// How far the unknowns are from that at most.
    pub error: [Number; 6],
    /// Of each cable, N.
    pub least: Vec<Number>,
    /// Of each cable, N.
    pub greatest: Vec<Number>,
}

/// c₀, c₁, … of the powers of τ; those left out are 0.
#[derive(Serialize, JsonSchema)]
pub struct Polynomial(#[schemars(length(min = 1, max = 6))] pub Vec<Number>);

/// When no tensions within the limits do it.
#[derive(Serialize, JsonSchema)]
#[serde(untagged, deny_unknown_fields)]
pub enum InstantEntry {
    /// Six cables: one is at or beyond a limit.
    OfCable {
        /// s.
        time: Number,
        /// From 1.
        #[schemars(range(min = 1, max = 6))]
        cable: usize,
        /// C.
        inverse: Box<[[Number; 6]; 6]>,
        /// Tensions over lengths, N/m.
        solution: [[Number; 1]; 6],
        /// How far they are from that at most.
        error: [Number; 6],
        /// Of this cable, N.
        least: Number,
        /// Of this cable, N.
        greatest: Number,
    },
    /// More than six cables.
    OfAll {
        /// s.
        time: Number,
        /// A vector as in Farkas' lemma.
        multipliers: [Number; 6],
        /// By how much some limit is broken at least, N.
        shortfall: Number,
    },
}
