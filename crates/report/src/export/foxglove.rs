//! Messages that Foxglove draws, as its schemas of these names want them (<https://docs.foxglove.dev/docs/sdk/schemas>): every field that is
//! required is written. Schemas have no `$ref`, which Foxglove does not resolve, and leave out fields that are always empty.

use cable_robot::robot::Pose as RobotPose;
use nalgebra::UnitQuaternion;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;

/// A list that is always empty.
type Empty = [u8; 0];

/// A message with a schema of Foxglove's.
pub trait Schema: Serialize + JsonSchema {
    /// The schema's name.
    const NAME: &'static str;

    /// JSON Schema in which nothing refers to something else.
    fn json_schema_text() -> Vec<u8> {
        let settings = SchemaSettings::draft07().with(|settings| {
            settings.inline_subschemas = true;
            settings.meta_schema = None;
        });
        settings.into_generator().into_root_schema_for::<Self>().as_value().to_string().into_bytes()
    }
}

/// Since the start of the run.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[schemars(title = "time")]
pub struct Time {
    pub sec: u32,
    pub nsec: u32,
}

#[derive(Clone, Copy, Serialize, JsonSchema)]
#[schemars(title = "duration")]
pub struct Duration {
    pub sec: i32,
    pub nsec: u32,
}

/// m
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

#[derive(Clone, Copy, Serialize, JsonSchema)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

#[derive(Clone, Copy, Serialize, JsonSchema)]
pub struct Pose {
    pub position: Vector3,
    pub orientation: Quaternion,
}

/// Shares of red, green, blue and opacity, from 0 to 1
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub struct Color {
    pub r: f64,
    pub g: f64,
    pub b: f64,
    pub a: f64,
}

/// Where a frame is in another
#[derive(Serialize, JsonSchema)]
pub struct FrameTransform {
    pub timestamp: Time,
    pub parent_frame_id: &'static str,
    pub child_frame_id: &'static str,
    pub translation: Vector3,
    pub rotation: Quaternion,
}

/// A pose, m
#[derive(Serialize, JsonSchema)]
pub struct PoseInFrame {
    pub timestamp: Time,
    pub frame_id: &'static str,
    pub pose: Pose,
}

/// How the points of a line are joined.
#[derive(Clone, Copy)]
#[repr(u32)]
pub enum LineType {
    /// Each with the next, the last with the first.
    Loop = 1,
    /// The first with the second, the third with the fourth.
    Pairs = 2,
}

/// Lines through points, m
#[derive(Serialize, JsonSchema)]
pub struct LinePrimitive {
    /// 0 strip, 1 loop, 2 pairs
    #[serde(rename = "type")]
    pub line_type: u32,
    pub pose: Pose,
    /// Pixels
    pub thickness: f64,
    pub scale_invariant: bool,
    pub points: Vec<Vector3>,
    pub color: Color,
    /// One a point, or none
    pub colors: Vec<Color>,
    pub indices: Vec<u32>,
}

#[derive(Serialize, JsonSchema)]
pub struct SceneEntity {
    pub timestamp: Time,
    pub frame_id: &'static str,
    pub id: &'static str,
    pub lifetime: Duration,
    pub frame_locked: bool,
    #[schemars(skip)]
    pub metadata: Empty,
    #[schemars(skip)]
    pub arrows: Empty,
    #[schemars(skip)]
    pub cubes: Empty,
    #[schemars(skip)]
    pub spheres: Empty,
    #[schemars(skip)]
    pub cylinders: Empty,
    pub lines: Vec<LinePrimitive>,
    #[schemars(skip)]
    pub triangles: Empty,
    #[schemars(skip)]
    pub texts: Empty,
    #[schemars(skip)]
    pub models: Empty,
}

/// Lines in three dimensions
#[derive(Serialize, JsonSchema)]
pub struct SceneUpdate {
    #[schemars(skip)]
    pub deletions: Empty,
    pub entities: Vec<SceneEntity>,
}

/// What is said.
#[derive(Clone, Copy)]
#[repr(u32)]
pub enum Level {
    Info = 2,
    Warning = 3,
    Error = 4,
}

/// Something that happened, in words
#[derive(Serialize, JsonSchema)]
pub struct Log {
    pub timestamp: Time,
    /// 2 information, 3 warning, 4 error
    pub level: u32,
    pub message: String,
    pub name: &'static str,
    pub file: &'static str,
    pub line: u32,
}

impl Schema for FrameTransform {
    const NAME: &'static str = "foxglove.FrameTransform";
}

impl Schema for PoseInFrame {
    const NAME: &'static str = "foxglove.PoseInFrame";
}

impl Schema for SceneUpdate {
    const NAME: &'static str = "foxglove.SceneUpdate";
}

impl Schema for Log {
    const NAME: &'static str = "foxglove.Log";
}

impl Time {
    /// Of nanoseconds.
    pub fn of(nanoseconds: u64) -> Self {
        let second = 1_000_000_000;
        Self { sec: (nanoseconds / second) as u32, nsec: (nanoseconds % second) as u32 }
    }
}

impl From<nalgebra::Vector3<f64>> for Vector3 {
    fn from(v: nalgebra::Vector3<f64>) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<UnitQuaternion<f64>> for Quaternion {
    fn from(q: UnitQuaternion<f64>) -> Self {
        Self { x: q.i, y: q.j, z: q.k, w: q.w }
    }
}

impl From<&RobotPose> for Pose {
    fn from(pose: &RobotPose) -> Self {
        let [roll, pitch, yaw] = [3, 4, 5].map(|k| pose.0[k]);
        Self {
            position: pose.position().into(),
            orientation: UnitQuaternion::from_euler_angles(roll, pitch, yaw).into(),
        }
    }
}
