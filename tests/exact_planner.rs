//! The planner with the exact domain, in closed loop at 1 kHz.

mod common;

use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Pose, RobotParameters};
use cable_robot::sim::PlantParameters;
use common::ClosedLoop;
use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn exact(lambda: f64, eta: f64) -> ControllerParameters {
    ControllerParameters { planner: PlannerKind::Exact, lambda, eta, ..Default::default() }
}

fn time_to_goal(parameters: ControllerParameters, goal: Pose) -> f64 {
    let mut run = ClosedLoop::new(parameters, PlantParameters::default(), goal, 1e-3);
    while !run.controller.outputs().at_goal {
        let (_, plant) = run.advance();
        assert!(plant.slack == [false; 6] && run.time() < 60.0);
    }
    run.time()
}

#[test]
fn the_papers_move_takes_one_set_point_and_a_third_of_the_time() {
    let goal = Pose::at(0.15, 0.15, 1.0);
    let (bounded, exact) =
        (time_to_goal(ControllerParameters::default(), goal), time_to_goal(exact(3.0, 3.0), goal));
    println!("time to goal: Bounded {bounded:.3} s, Exact {exact:.3} s");
    assert!(exact < 0.4 * bounded);
}

/// A goal at least `margin` m inside the static workspace, at a height around `z`.
fn random_goal(rng: &mut Pcg64, z: f64, margin: f64) -> Pose {
    loop {
        let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        let facets = cable_robot::reach::static_workspace(&Default::default());
        if facets.iter().all(|facet| facet.slack(&point) > margin) {
            return Pose::at(point.x, point.y, z * rng.random_range(0.9..1.1));
        }
    }
}

/// The goal changes in mid-motion, in all three coordinates and at gains at which the exact domain does bind.
#[test]
fn goals_that_change_in_mid_motion_slacken_no_cable() {
    let mut rng = Pcg64::seed_from_u64(40);
    let mut smallest = f64::INFINITY;
    for _ in 0..60 {
        let (z, lambda, eta) =
            (rng.random_range(0.5..2.0), rng.random_range(2.0..8.0), rng.random_range(2.0..8.0));
        let start = PlantParameters { initial_pose: random_goal(&mut rng, z, 0.01), ..Default::default() };
        let mut run = ClosedLoop::new(exact(lambda, eta), start, random_goal(&mut rng, z, 0.01), 1e-3);
        for _ in 0..8 {
            run.goal = random_goal(&mut rng, z, 0.01);
            for _ in 0..rng.random_range(50..800) {
                let (output, plant) = run.advance();
                assert_eq!(plant.slack, [false; 6], "gains {lambda}, {eta}, z = {z}, at {}", run.time());
                smallest = output.motor_tension.iter().copied().fold(smallest, f64::min);
            }
        }
        for _ in 0..(20_000.0 / lambda.min(eta)) as u32 {
            run.advance();
        }
        assert_eq!(run.controller.outputs().status, Status::AtGoal, "gains {lambda}, {eta}, z = {z}");
    }
    println!("smallest tension {smallest:.3} N");
}

#[test]
fn a_goal_outside_is_approached_to_the_margin_and_left_again() {
    let mut run = ClosedLoop::new(exact(5.0, 5.0), PlantParameters::default(), Pose::at(0.0, 0.5, 1.2), 1e-3);
    for _ in 0..10_000 {
        assert_eq!(run.advance().1.slack, [false; 6]);
    }
    let output = *run.controller.outputs();
    assert_eq!(output.status, Status::GoalUnreachable);
    // It rests with twice the 0.1 N that it keeps on the way.
    assert!((0.2..0.25).contains(&output.tension_margin), "{output:?}");
    run.goal = Pose::at(-0.1, -0.1, 0.9);
    for _ in 0..10_000 {
        assert_eq!(run.advance().1.slack, [false; 6]);
    }
    assert_eq!(run.controller.outputs().status, Status::AtGoal);
}

#[test]
fn a_goal_that_cannot_be_had_is_neared_as_far_as_can_be() {
    let goal = Pose::at(0.3, 0.1, 0.9);
    let mut run = ClosedLoop::new(exact(4.0, 4.0), PlantParameters::default(), goal, 1e-3);
    for _ in 0..8000 {
        assert_eq!(run.advance().1.slack, [false; 6]);
    }
    let output = *run.controller.outputs();
    assert_eq!(output.status, Status::GoalUnreachable);
    // Straight across the facet of cable 5, whose normal has azimuth 30 degrees, and not where the line to the goal meets it.
    let back = output.set_point.position() - goal.position();
    assert!((back.y / back.x - 30f64.to_radians().tan()).abs() < 1e-4, "{back}");
    assert!((output.goal_distance - back.norm()).abs() < 1e-4);
    assert!(output.goal_distance < 0.1);
}

#[test]
fn goals_beyond_all_measure_are_a_status() {
    for goal in [Pose::at(1e300, -1e300, 1e300), Pose::at(1e155, 0.0, 1.0), Pose::at(0.0, 0.0, 1e308)] {
        let mut run = ClosedLoop::new(exact(5.0, 3.0), PlantParameters::default(), goal, 1e-3);
        for _ in 0..3000 {
            let (output, plant) = run.advance();
            assert_eq!(plant.slack, [false; 6]);
            assert!(output.set_point.0.norm() < 10.0 && output.goal_distance.is_finite());
        }
        assert_eq!(run.controller.outputs().status, Status::GoalUnreachable);
    }
}

/// At rest on the very edge of what is admissible no rise was: the robot stayed there for good.
#[test]
fn a_robot_on_the_edge_still_rises() {
    let mut run = ClosedLoop::new(exact(3.0, 3.0), PlantParameters::default(), Pose::at(0.4, 0.0, 1.0), 1e-3);
    for goal in [Pose::at(0.4, 0.0, 1.0), Pose::at(0.4, 0.0, 1.5), Pose::at(0.4, 0.0, 0.7)] {
        run.goal = goal;
        for _ in 0..12_000 {
            assert_eq!(run.advance().1.slack, [false; 6]);
        }
        let output = run.controller.outputs();
        assert!((output.set_point.0[2] - goal.0[2]).abs() < 1e-9, "{:?}", output.set_point);
        assert!((output.goal_distance - 0.144).abs() < 3e-3, "{}", output.goal_distance);
    }
}

/// What holding the tensions costs grows with the mass; a margin that does not was used up.
#[test]
fn a_heavy_robot_with_high_gains_slackens_no_cable() {
    let mut rng = Pcg64::seed_from_u64(41);
    for case in 0..24 {
        let m = [12.0, 20.0, 50.0][case % 3];
        let scale = m / 6.0;
        let robot = RobotParameters {
            m,
            i1: 0.018 * scale,
            i2: 0.018 * scale,
            i3: 0.075 * scale,
            ..Default::default()
        };
        let gain = if case % 2 == 0 { 8.0 } else { 10.0 };
        let parameters = ControllerParameters { robot, max_tension: 1000.0, ..exact(gain, gain) };
        let rig = PlantParameters { robot, initial_pose: Pose::at(0.0, 0.0, 2.0), ..Default::default() };
        let mut run = ClosedLoop::new(parameters, rig, Pose::at(0.15, 0.15, 1.0), 1e-3);
        for _ in 0..6 {
            for _ in 0..1500 {
                assert_eq!(
                    run.advance().1.slack,
                    [false; 6],
                    "m = {m}, gain {gain}, case {case}, at {}",
                    run.time()
                );
            }
            run.goal = random_goal(&mut rng, 1.2, 0.0);
        }
    }
}
