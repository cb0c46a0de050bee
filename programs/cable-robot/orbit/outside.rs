//! Where a path is outside the static workspace.

use cable_robot::control::static_margin;
use cable_robot::plan::orbit::Trajectory;
use cable_robot::robot::{Pose, Rig};
use nalgebra::Vector2;

/// Instants looked at.
const INSTANTS: usize = 2001;

/// A path and the border of the static workspace at its height.
pub struct Outside {
    /// Corners, m.
    pub border: Vec<Vector2<f64>>,
    /// Times (s), places, and whether the robot could rest there.
    pub path: Vec<(f64, Pose, bool)>,
    /// How long it is outside, s.
    pub time: f64,
    /// How far at most, m.
    pub farthest: f64,
    /// The least margin of a tension at rest there, N: less than 0 if it is outside at all.
    pub margin: f64,
}

impl Outside {
    pub fn of(rig: &Rig, trajectory: &Trajectory, border: Vec<Vector2<f64>>) -> Self {
        let interval = trajectory.end() / (INSTANTS - 1) as f64;
        let mut outside = Self { border, path: vec![], time: 0.0, farthest: 0.0, margin: f64::INFINITY };
        for k in 0..INSTANTS {
            let time = interval * k as f64;
            let pose = trajectory.at(time).pose;
            let margin = static_margin(rig, &pose);
            outside.margin = outside.margin.min(margin);
            if margin < 0.0 {
                outside.time += interval;
                outside.farthest = outside.farthest.max(outside.distance(&pose));
            }
            outside.path.push((time, pose, margin >= 0.0));
        }
        outside
    }

    /// To the border, m.
    fn distance(&self, pose: &Pose) -> f64 {
        let point = pose.position().xy();
        let edges = self.border.iter().zip(self.border.iter().cycle().skip(1));
        let to_edge = |(a, b): (&Vector2<f64>, &Vector2<f64>)| {
            let along = b - a;
            let share = ((point - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (point - a - along * share).norm()
        };
        edges.map(to_edge).fold(f64::INFINITY, f64::min)
    }
}
