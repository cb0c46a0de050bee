//! Eq. (17): the next set point on the way to the goal, from rest at the last one.

use nalgebra::Vector2;

use super::bisection::smallest_admissible;
use super::interface::{ControllerParameters, PlannerKind};
use crate::reach::{BoundedDomain, in_static_workspace};
use crate::robot::{Coordinates, Pose, RobotParameters};

/// The motion counts as at rest below these rates, m/s and rad/s,
const REST_SPEED: f64 = 2e-3;
const REST_ANGULAR_RATE: f64 = 1e-2;
/// and as being at a pose within these distances, m and rad.
const NEAR_POSITION: f64 = 2e-3;
const NEAR_ANGLE: f64 = 1e-2;

/// The steady-state test of Fig. 4: at rest at the set point, so that (15), which assumes x'₀ = 0, may be used again.
pub fn is_steady(pose: &Pose, rates: &Coordinates, set_point: &Pose) -> bool {
    let error = pose.minus(set_point);
    error.fixed_rows::<3>(0).norm() < NEAR_POSITION
        && error.fixed_rows::<3>(3).amax() < NEAR_ANGLE
        && rates.fixed_rows::<3>(0).norm() < REST_SPEED
        && rates.fixed_rows::<3>(3).amax() < REST_ANGULAR_RATE
}

/// Whether every cable would be in tension at rest at the goal and (15) speaks of the motion from `from` to it: a move in x and y
/// at constant height with zero orientation, each to within what counts as being there.
pub fn is_reachable(robot: &RobotParameters, from: &Pose, goal: &Pose) -> bool {
    is_horizontal(from, goal) && in_static_workspace(robot, &horizontal(goal))
}

/// The set point to give at rest at `from`; `None` if the planner cannot get nearer to the goal.
pub fn next_set_point(parameters: &ControllerParameters, from: &Pose, goal: &Pose) -> Option<Pose> {
    if from == goal || !is_horizontal(from, goal) {
        return None;
    }
    let (x_prev, x_f) = (horizontal(from), horizontal(goal));
    let at = |beta: f64| x_f + (x_prev - x_f) * beta; // (17)
    let beta = match parameters.planner {
        PlannerKind::Bounded => {
            let domain = BoundedDomain::new(&parameters.robot, &parameters.gains(), x_prev, goal.0[2]);
            smallest_admissible(parameters.bisection_steps, |beta| domain.contains(&at(beta)))
        }
    };
    let mut set_point = *goal;
    set_point.0.fixed_rows_mut::<2>(0).copy_from(&at(beta));
    (beta < 1.0).then_some(set_point)
}

fn is_horizontal(from: &Pose, goal: &Pose) -> bool {
    let level = |pose: &Pose| pose.0.fixed_rows::<3>(3).amax() < NEAR_ANGLE;
    goal.0[2] > 0.0 && (from.0[2] - goal.0[2]).abs() < NEAR_POSITION && level(from) && level(goal)
}

fn horizontal(pose: &Pose) -> Vector2<f64> {
    Vector2::new(pose.0[0], pose.0[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_sequence_has_four_set_points_on_the_diagonal() {
        let parameters = ControllerParameters::default();
        let goal = Pose::at(0.15, 0.15, 1.0);
        let mut sequence = vec![];
        let mut from = Pose::default();
        while let Some(next) = next_set_point(&parameters, &from, &goal) {
            sequence.push(next.0[0]);
            assert_eq!(next.0[0], next.0[1]);
            from = next;
        }
        let expected = [0.0855, 0.1266, 0.1464, 0.15];
        assert_eq!(sequence.len(), expected.len(), "{sequence:?}");
        for (x, expected) in sequence.iter().zip(expected) {
            assert!((x - expected).abs() < 5e-5, "{sequence:?}");
        }
    }

    #[test]
    fn other_motions_than_horizontal_ones_get_no_set_point() {
        let parameters = ControllerParameters::default();
        for goal in [
            Pose::at(0.1, 0.0, 0.9),
            Pose::at(0.0, 0.0, -1.0),
            Pose(Coordinates::new(0.1, 0.0, 1.0, 0.0, 0.0, 0.2)),
        ] {
            assert_eq!(next_set_point(&parameters, &Pose::default(), &goal), None);
            assert!(!is_reachable(&parameters.robot, &Pose::default(), &goal));
        }
    }

    #[test]
    fn a_goal_outside_is_approached_from_inside() {
        let parameters = ControllerParameters::default();
        let goal = Pose::at(0.0, 0.4, 1.0);
        let mut from = Pose::default();
        while let Some(next) = next_set_point(&parameters, &from, &goal) {
            from = next;
        }
        assert!(from.0[1] > 0.2 && in_static_workspace(&parameters.robot, &horizontal(&from)), "{from:?}");
        assert!(!is_reachable(&parameters.robot, &from, &goal));
    }
}
