//! Sections of the static workspace, for the pictures.

use serde::Serialize;

use super::history::History;
use super::thinning::rounded;
use cable_robot::reach::{Slice, polygon, static_workspace};
use cable_robot::robot::{Rig, RobotParameters};

/// Points of an outline that is no polygon known beforehand: of the one in the plane, and of those in space.
const FINE_OUTLINE: usize = 180;
const OUTLINE: usize = 60;
/// Sections in space.
const SECTIONS: usize = 5;
/// Steps to a metre.
const STEPS: f64 = 1e4;

/// Where the platform can be held at one height, m.
#[derive(Debug, Serialize)]
pub struct Section {
    /// z of the centre of mass, but for the hexagon in the base plane.
    pub height: f64,
    /// In order round it; nothing if the platform cannot be held over the last set point.
    pub outline: Vec<[f64; 2]>,
}

/// What the plane shows: of the paper's rig the hexagon (16), in the base plane, where p is; of others the border round the last set point, at
/// its height and orientation.
pub fn workspace(history: &History, rig: &Rig) -> Section {
    match &history.paper {
        Some(robot) => hexagon(robot, 0.0),
        None => section(history, rig, history.set_point[history.len() - 1].0[2], FINE_OUTLINE),
    }
}

/// Sections in the orientation of the last set point, at even heights from the platform's radius above where the platform went to as much
/// below; none where it cannot be held over the last set point.
pub fn sections(history: &History, rig: &Rig) -> Vec<Section> {
    let heights = history.pose.iter().map(|pose| pose.0[2]);
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    let (low, high) = (low - rig.platform_radius(), high + rig.platform_radius());
    let height = |k: usize| low + (high - low) * k as f64 / (SECTIONS - 1) as f64;
    let at = |k: usize| match &history.paper {
        // The base plane is at 0, and the hexagon the same below it.
        Some(_) if height(k) <= 0.0 => Section { height: height(k), outline: vec![] },
        Some(robot) => hexagon(robot, height(k)),
        None => section(history, rig, height(k), OUTLINE),
    };
    (0..SECTIONS).map(at).filter(|section| !section.outline.is_empty()).collect()
}

fn hexagon(robot: &RobotParameters, height: f64) -> Section {
    let outline = polygon(&static_workspace(robot), 2.0 * robot.a);
    Section { height, outline: outline.iter().map(|vertex| (*vertex).into()).collect() }
}

fn section(history: &History, rig: &Rig, height: f64, points: usize) -> Section {
    let last = &history.set_point[history.len() - 1];
    let (slice, middle) = (Slice { rig, height, angles: last.angles() }, last.position().xy());
    let outline = if slice.margin(&middle) < 0.0 { vec![] } else { slice.boundary(&middle, points) };
    Section {
        height,
        outline: outline.iter().map(|point| [point.x, point.y].map(|x| rounded(x, STEPS))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{record, run};
    use cable_robot::control::static_margin;
    use cable_robot::plan::{ControllerParameters, PlannerKind};
    use cable_robot::robot::{Pose, RigFile};
    use cable_robot::sim::{Goal, PlantParameters, Scenario};

    #[test]
    fn of_the_papers_rig_they_are_hexagons_round_where_it_went() {
        let folder = run(PlannerKind::Bounded, 1.0, 0.0);
        let history = History::new(&folder).unwrap();
        let sections = sections(&history, &folder.info.plant_parameters.rig);
        let heights: Vec<f64> = sections.iter().map(|section| section.height).collect();
        let radius = folder.info.plant_parameters.rig.platform_radius();
        assert_eq!(heights.len(), SECTIONS);
        assert!(
            (heights[0] - (1.0 - radius)).abs() < 1e-3 && (heights[4] - (1.0 + radius)).abs() < 1e-3,
            "{heights:?}"
        );
        for corner in sections.iter().flat_map(|section| &section.outline) {
            assert!((corner[0].hypot(corner[1]) - 0.45 / 3f64.sqrt()).abs() < 1e-9, "{corner:?}");
        }
    }

    #[test]
    fn of_another_rig_they_lie_where_the_tensions_reach_a_limit() {
        let rig = RigFile::parse(include_str!("../../../rigs/eight.toml")).unwrap().rig;
        let start = Pose::at(0.0, 0.0, 2.0);
        let folder = record(&Scenario {
            title: String::new(),
            rig: String::new(),
            controller: ControllerParameters {
                planner: PlannerKind::Exact,
                ..ControllerParameters::of(&rig)
            },
            plant: PlantParameters { rig, initial_pose: start, ..Default::default() },
            orbit: None,
            goals: vec![Goal::new(0.0, start)],
            disturbances: vec![],
            duration: 0.01,
            step: 1e-3,
        });
        let history = History::new(&folder).unwrap();
        let sections = sections(&history, &rig);
        assert_eq!(sections.len(), SECTIONS);
        for section in &sections {
            assert_eq!(section.outline.len(), OUTLINE);
            for [x, y] in &section.outline {
                let margin = static_margin(&rig, &Pose::at(*x, *y, section.height));
                assert!(margin.abs() < 0.01 * rig.weight(), "{margin} N at ({x}, {y}, {})", section.height);
            }
        }
    }
}
