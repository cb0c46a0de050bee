//! The paper's rig as a file may have it: turned, shifted, renumbered, rounded. The planner `Bounded` takes it, in the frame recognised.

use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RobotParameters, TensionLimits};
use nalgebra::{Rotation3, Vector3};

/// Two moves at a height of 1 m; on the second, frames turned by 120 degrees disagree.
const MOVES: [([f64; 2], [f64; 2]); 2] =
    [([0.0, 0.0], [0.15, 0.15]), ([0.03994, 0.19393], [0.08252, -0.12090])];

fn paper() -> Rig {
    Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 })
}

/// The set points that `Bounded` gives on the way.
fn set_points(rig: &Rig, from: &Pose, goal: &Pose) -> Vec<Pose> {
    let planner = Planner::from(ControllerParameters {
        planner: PlannerKind::Bounded,
        ..ControllerParameters::of(rig)
    });
    let mut points = vec![*from];
    while let Some(next) = planner.next_from_rest(&points[points.len() - 1], goal) {
        points.push(next);
        assert!(points.len() < 50, "{points:?}");
    }
    points
}

/// Turned about z, then shifted.
struct Moved {
    turn: f64,
    shift: Vector3<f64>,
}

impl Moved {
    fn pose(&self, pose: &Pose) -> Pose {
        let position =
            Rotation3::from_axis_angle(&Vector3::z_axis(), self.turn) * pose.position() + self.shift;
        Pose(Coordinates::new(position.x, position.y, position.z, 0.0, 0.0, 0.0))
    }

    fn anchors(&self, mut rig: Rig) -> Rig {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.turn);
        for cable in rig.cables.iter_mut() {
            cable.anchor = turn * cable.anchor + self.shift;
            cable.attachment = turn * cable.attachment;
        }
        rig
    }
}

/// The set points in a rig are the paper's, moved as `to_rig` moves the paper's frame.
fn agrees(rig: &Rig, to_rig: &Moved, tolerance: f64) {
    for (from, goal) in MOVES {
        let [from, goal] = [from, goal].map(|[x, y]| Pose::at(x, y, 1.0));
        let expected = set_points(&paper(), &from, &goal);
        assert!(expected.len() > 2, "{expected:?}");
        let found = set_points(rig, &to_rig.pose(&from), &to_rig.pose(&goal));
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(&expected) {
            let off = found.minus(&to_rig.pose(expected)).amax();
            assert!(off <= tolerance, "{off:e} off {expected:?}");
        }
    }
}

const HERE: Moved = Moved { turn: 0.0, shift: Vector3::new(0.0, 0.0, 0.0) };

#[test]
fn the_papers_rig_is_its_own_bit_for_bit() {
    agrees(&HERE.anchors(paper()), &HERE, 0.0);
    assert_eq!(ControllerParameters::default().rig, paper());
}

#[test]
fn a_shifted_or_raised_rig_has_shifted_set_points() {
    for shift in [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.5), Vector3::new(-3.0, 2.0, -4.0)] {
        let moved = Moved { turn: 0.0, shift };
        agrees(&moved.anchors(paper()), &moved, 1e-9);
    }
}

#[test]
fn a_rig_turned_by_a_quarter_has_turned_set_points() {
    let quarter = Moved { turn: std::f64::consts::FRAC_PI_2, ..HERE };
    agrees(&quarter.anchors(paper()), &quarter, 1e-9);
}

/// The shape has a symmetry of 120 degrees, Eq. (15) has not: identity comes first.
#[test]
fn a_rig_turned_by_120_degrees_is_the_paper_renumbered() {
    let third = Moved { turn: 2.0 * std::f64::consts::FRAC_PI_3, ..HERE };
    agrees(&third.anchors(paper()), &HERE, 1e-9);
}

#[test]
fn exchanged_cables_change_nothing() {
    let mut rig = paper();
    let swapped = [1, 0, 2, 3, 4, 5];
    rig.cables = PerCable::from_fn(6, |i| paper().cables[swapped[i]]);
    agrees(&rig, &HERE, 1e-9);
}

/// The paper's own coordinates with six decimals were refused.
#[test]
fn six_decimals_are_enough() {
    let mut rig = paper();
    for cable in rig.cables.iter_mut() {
        cable.anchor = cable.anchor.map(|x| (x * 1e6).round() / 1e6);
        cable.attachment = cable.attachment.map(|x| (x * 1e6).round() / 1e6);
    }
    assert_ne!(rig, paper());
    agrees(&rig, &HERE, 1e-6);
}
