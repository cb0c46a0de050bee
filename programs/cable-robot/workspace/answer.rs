//! What `workspace --json` prints.

use cable_robot::reach::Slice;
use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::Serialize;

use super::Found;

/// Either of the two.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "names both for the schema")]
pub enum Answer {
    One(Workspace),
    Several(Stack),
}

/// The static workspace at one height and orientation, in the base frame.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Workspace {
    /// The rig's name.
    rig: String,
    #[serde(flatten)]
    level: Level,
}

/// The static workspace at several heights or orientations, in the base frame.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Stack {
    /// The rig's name.
    rig: String,
    /// Every height with every orientation.
    slices: Vec<Level>,
}

/// Where the cables can hold the platform at rest within their limits, at one height and orientation.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Level {
    /// z of the centre of mass, m.
    height: f64,
    /// Roll, pitch, yaw, rad; R = Rz(yaw) Ry(pitch) Rx(roll).
    orientation: [f64; 3],
    /// Whether the cables hold the platform at no point that was looked at.
    empty: bool,
    /// Within the border, m².
    area: f64,
    /// x, y of the border's corners in order, m.
    vertices: Vec<[f64; 2]>,
    /// Where the margin is greatest; null where it is empty.
    deepest: Option<Deepest>,
    /// Share of the workspace that cannot be seen from there and lies outside the border, 0 to 1.
    unseen: f64,
}

/// Where the margin is greatest.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Deepest {
    /// x, y, m.
    point: [f64; 2],
    /// The least distance of a tension to a limit there, N.
    margin: f64,
}

impl Workspace {
    pub fn new(rig: &str, slice: &Slice, found: Option<&Found>) -> Self {
        Self { rig: rig.to_owned(), level: Level::new(slice, found) }
    }
}

impl Stack {
    pub fn new(rig: &str, slices: &[(Slice, Option<Found>)]) -> Self {
        let level = |(slice, found): &(Slice, Option<Found>)| Level::new(slice, found.as_ref());
        Self { rig: rig.to_owned(), slices: slices.iter().map(level).collect() }
    }
}

impl Level {
    fn new(slice: &Slice, found: Option<&Found>) -> Self {
        let point = |p: &Vector2<f64>| [p.x, p.y];
        Self {
            height: slice.height,
            orientation: slice.angles.into(),
            empty: found.is_none(),
            area: found.map_or(0.0, |found| found.area),
            vertices: found.map_or(vec![], |found| found.corners.iter().map(point).collect()),
            deepest: found.map(|found| Deepest { point: point(&found.deepest.0), margin: found.deepest.1 }),
            unseen: found.map_or(0.0, |found| found.unseen),
        }
    }
}
