//! The robot in three dimensions: frames, the outlines of base and platform, cables coloured by their tension.
//!
//! Frame `base` is that of the rig file, `platform` moves with the platform, `world` is `base` turned so that gravity points against z.

use nalgebra::{UnitQuaternion, Vector3};

use super::foxglove::{
    Color, Duration, FrameTransform, LinePrimitive, LineType, Pose, Quaternion, SceneEntity, SceneUpdate,
    Time,
};
use crate::data::colour_top;
use crate::run_folder::RunInfo;
use crate::table::TableError;
use cable_robot::robot::{Pose as RobotPose, Rig};

/// The frame of the rig file.
pub const BASE: &str = "base";
const PLATFORM: &str = "platform";
const WORLD: &str = "world";

/// Pixels.
const THICKNESS: f64 = 3.0;

/// Colours of a cable without tension, of one with half, and of one with the greatest on the scale.
const RAMP: [[f64; 3]; 3] = [[1.0, 0.81, 0.30], [0.25, 0.70, 0.45], [0.25, 0.49, 0.94]];
const SLACK: Color = Color { r: 1.0, g: 0.1, b: 0.2, a: 1.0 };
const FRAME: Color = Color { r: 0.55, g: 0.58, b: 0.62, a: 1.0 };

/// What is drawn of a run, from its rows.
pub struct Scene<'a> {
    rig: &'a Rig,
    pose: [usize; 6],
    tension: Vec<usize>,
    slack: Option<Vec<usize>>,
    colour_top: f64,
}

impl<'a> Scene<'a> {
    /// Of a run with these columns.
    ///
    /// # Errors
    /// [`TableError::Missing`].
    pub fn new(info: &'a RunInfo, names: &[String]) -> Result<Self, TableError> {
        let rig = &info.plant_parameters.rig;
        let cables = |name: &str| {
            let place = |i: usize| place(names, &format!("{name}[{i}]"));
            (1..=rig.cables.len()).map(place).collect::<Result<Vec<_>, _>>()
        };
        Ok(Self {
            rig,
            pose: pose(names, "plant.encoderPose")?,
            // A plant from elsewhere may have no load cells: then what the motors pull.
            tension: cables("plant.measuredTension").or_else(|_| cables("controller.motorTension"))?,
            slack: cables("plant.slack").ok(),
            colour_top: colour_top(rig, info.controller_parameters.rig.common_limits().max),
        })
    }

    /// Where the base stands: z of the world points up.
    pub fn world(&self, timestamp: Time) -> FrameTransform {
        let up = -Vector3::z();
        let half_turn = || UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.0, 1.0, 0.0, 0.0));
        let turn = UnitQuaternion::rotation_between(&self.rig.gravity, &up).unwrap_or_else(half_turn);
        FrameTransform {
            timestamp,
            parent_frame_id: WORLD,
            child_frame_id: BASE,
            translation: Vector3::zeros().into(),
            rotation: turn.into(),
        }
    }

    /// Where the platform is in a row.
    pub fn platform(&self, row: &[f64], timestamp: Time) -> FrameTransform {
        let Pose { position, orientation } = Pose::from(&pose_of(self.pose, row));
        FrameTransform {
            timestamp,
            parent_frame_id: BASE,
            child_frame_id: PLATFORM,
            translation: position,
            rotation: orientation,
        }
    }

    /// The outlines of base and platform, each in its frame.
    pub fn outlines(&self, timestamp: Time) -> SceneUpdate {
        let entity = |frame, points: Vec<Vector3<f64>>| {
            let points = outline(points).into_iter().map(Into::into).collect();
            entity(timestamp, frame, frame, lines(LineType::Loop, points, vec![]))
        };
        let anchors = self.rig.cables.iter().map(|cable| cable.anchor).collect();
        let attachments = self.rig.cables.iter().map(|cable| cable.attachment).collect();
        SceneUpdate { deletions: [], entities: vec![entity(BASE, anchors), entity(PLATFORM, attachments)] }
    }

    /// The cables in a row.
    pub fn cables(&self, row: &[f64], timestamp: Time) -> SceneUpdate {
        let pose = pose_of(self.pose, row);
        let ends = self.rig.cables.iter().flat_map(|cable| {
            [cable.anchor.into(), (pose.position() + pose.rotation() * cable.attachment).into()]
        });
        let colours = (0..self.tension.len()).flat_map(|i| [self.colour(row, i); 2]).collect();
        let drawn = lines(LineType::Pairs, ends.collect(), colours);
        SceneUpdate { deletions: [], entities: vec![entity(timestamp, BASE, "cables", drawn)] }
    }

    /// Red where the cable is slack.
    fn colour(&self, row: &[f64], i: usize) -> Color {
        let tension = row[self.tension[i]];
        let slack = self.slack.as_ref().map_or(tension <= 0.0, |slack| row[slack[i]] != 0.0);
        if slack {
            return SLACK;
        }
        let share = 2.0 * (tension / self.colour_top).clamp(0.0, 1.0);
        let (from, to) = if share < 1.0 { (RAMP[0], RAMP[1]) } else { (RAMP[1], RAMP[2]) };
        let part = if share < 1.0 { share } else { share - 1.0 };
        let [r, g, b] = [0, 1, 2].map(|k| from[k] + part * (to[k] - from[k]));
        Color { r, g, b, a: 1.0 }
    }
}

/// Place of a column among all.
fn place(names: &[String], column: &str) -> Result<usize, TableError> {
    let missing = || TableError::Missing { name: column.to_owned() };
    names.iter().position(|name| name == column).ok_or_else(missing)
}

/// Places of the components of a pose.
///
/// # Errors
/// [`TableError::Missing`].
pub fn pose(names: &[String], name: &str) -> Result<[usize; 6], TableError> {
    let mut places = [0; 6];
    for (to, component) in places.iter_mut().zip(["x", "y", "z", "roll", "pitch", "yaw"]) {
        *to = place(names, &format!("{name}.{component}"))?;
    }
    Ok(places)
}

/// The pose in a row.
pub fn pose_of(places: [usize; 6], row: &[f64]) -> RobotPose {
    RobotPose(places.map(|place| row[place]).into())
}

/// Points without repetitions, in order round their middle.
fn outline(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let size = points.iter().map(|point| (point - middle).norm()).fold(0.0, f64::max);
    let mut apart: Vec<Vector3<f64>> = vec![];
    for point in points {
        if apart.iter().all(|known| (known - point).norm() > 1e-6 * size) {
            apart.push(point);
        }
    }
    let angle = |point: &Vector3<f64>| (point.y - middle.y).atan2(point.x - middle.x);
    apart.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    apart
}

fn lines(line_type: LineType, points: Vec<super::foxglove::Vector3>, colors: Vec<Color>) -> LinePrimitive {
    LinePrimitive {
        line_type: line_type as u32,
        pose: Pose {
            position: Vector3::zeros().into(),
            orientation: Quaternion::from(UnitQuaternion::identity()),
        },
        thickness: THICKNESS,
        scale_invariant: true,
        points,
        color: FRAME,
        colors,
        indices: vec![],
    }
}

/// Stays until another of its name takes its place.
fn entity(timestamp: Time, frame_id: &'static str, id: &'static str, lines: LinePrimitive) -> SceneEntity {
    SceneEntity {
        timestamp,
        frame_id,
        id,
        lifetime: Duration { sec: 0, nsec: 0 },
        frame_locked: true,
        metadata: [],
        arrows: [],
        cubes: [],
        spheres: [],
        cylinders: [],
        lines: vec![lines],
        triangles: [],
        texts: [],
        models: [],
    }
}
