//! Section VI in the library: from (0, 0, 1) to (0.15, 0.15, 1), Tables I and II, sampled at 1 kHz.

use crate::common::ClosedLoop;
use cable_robot::plan::{ControllerParameters, PoseSource, Status};
use cable_robot::robot::Pose;
use cable_robot::sim::PlantParameters;

fn paper(parameters: ControllerParameters) -> ClosedLoop {
    ClosedLoop::new(parameters, PlantParameters::default(), Pose::at(0.15, 0.15, 1.0), 1e-3)
}

#[test]
fn four_set_points_positive_tensions_and_cable_5_smallest_at_the_goal() {
    let mut run = paper(ControllerParameters::default());
    let mut set_points = vec![];
    let mut smallest = f64::INFINITY;
    while run.time() < 15.0 {
        let (output, plant) = run.advance();
        if output.set_point_index as usize > set_points.len() {
            set_points.push((run.time(), output.set_point.0[0], output.set_point.0[1]));
        }
        smallest = output.motor_tension.iter().copied().fold(smallest, f64::min);
        assert!(plant.slack == [false; 6], "slack at {}", run.time());
    }
    let expected = [0.0855, 0.1266, 0.1464, 0.15];
    assert_eq!(set_points.len(), 4, "{set_points:?}");
    for ((_, x, y), expected) in set_points.iter().zip(expected) {
        assert!((x - expected).abs() < 5e-5 && x == y, "{set_points:?}");
    }
    let output = run.controller.outputs();
    assert_eq!(output.status, Status::AtGoal);
    let u5 = output.motor_tension[4];
    assert!(output.motor_tension.iter().all(|u| *u >= u5));
    assert!((u5 - 1.05).abs() < 5e-3, "u5 = {u5}");
    assert!(smallest > 1.0 && (output.tension_margin - u5).abs() < 1e-3);
}

#[test]
fn velocity_is_estimated_to_a_millimetre_a_second() {
    let mut run = paper(ControllerParameters::default());
    let mut worst: f64 = 0.0;
    while run.time() < 12.0 {
        let (output, plant) = run.advance();
        worst = worst.max((output.estimated_velocity.fixed_rows::<3>(0) - plant.velocity).norm());
    }
    assert!(worst < 1e-3, "{worst} m/s");
}

#[test]
fn cable_lengths_serve_as_well_as_the_encoder_pose() {
    let by_lengths = ControllerParameters { pose_source: PoseSource::CableLengths, ..Default::default() };
    let (mut a, mut b) = (paper(ControllerParameters::default()), paper(by_lengths));
    for _ in 0..9000 {
        let (a, b) = (a.advance().0, b.advance().0);
        assert!(a.estimated_pose.minus(&b.estimated_pose).norm() < 1e-8);
        assert_eq!(a.set_point_index, b.set_point_index);
    }
}
