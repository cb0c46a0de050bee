//! What must hold everywhere, on seeded random cases.

use crate::common::ClosedLoop;
use cable_robot::control::{Gains, Reference, lyapunov};
use cable_robot::plan::ControllerParameters;
use cable_robot::reach::in_static_workspace;
use cable_robot::robot::{
    Coordinates, PerCable, Pose, Rig, RobotParameters, TensionLimits, forward_kinematics,
};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use nalgebra::{Rotation3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A pose in the static workspace, 0.4 m to 2.5 m below the base, each angle up to `angle` rad.
fn random_pose(rng: &mut Pcg64, angle: f64) -> Pose {
    let robot = RobotParameters::default();
    loop {
        let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        if in_static_workspace(&robot, &point) {
            let mut turn = || rng.random_range(-1.0..=1.0) * angle;
            let (roll, pitch, yaw) = (turn(), turn(), turn());
            let z = rng.random_range(0.4..2.5);
            return Pose(Coordinates::new(point.x, point.y, z, roll, pitch, yaw));
        }
    }
}

fn random_direction(rng: &mut Pcg64) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

#[test]
fn forward_kinematics_finds_every_move_of_50_mm_and_5_degrees() {
    let rig = ControllerParameters::default().rig;
    let mut rng = Pcg64::seed_from_u64(1);
    for case in 0..100_000 {
        let from = random_pose(&mut rng, 0.0);
        let position = from.position() + random_direction(&mut rng) * 0.05;
        let turn = Rotation3::from_scaled_axis(random_direction(&mut rng) * 5f64.to_radians());
        let to = Pose::from_parts(&position, &(turn * from.rotation()));
        let lengths = rig.cables_at(&to).length;
        let found = forward_kinematics(&rig, &lengths, &from).unwrap_or_else(|e| panic!("case {case}: {e}"));
        let error = found.pose.minus(&to).norm();
        assert!(error < 1e-7 && found.error_bound < 1e-8, "case {case}: {error} m, {found:?}");
    }
}

/// s of Eq. (2) of a simulated body.
fn sliding(gains: &Gains, plant: &Plant, set_point: &Pose) -> Coordinates {
    let output = plant.outputs();
    let pose = output.encoder_pose;
    let angle_rates = pose.rate_matrix().try_inverse().unwrap() * output.angular_velocity;
    let (v, w) = (output.velocity, angle_rates);
    let rates = Coordinates::new(v.x, v.y, v.z, w.x, w.y, w.z);
    lyapunov::sliding_variable(gains, &pose, &rates, &Reference::resting(set_point))
}

/// V's fall over a step of `h` seconds with the tensions held, in units of what (6) says at its start: from 1,000 random states in
/// which every tension is positive.
fn fall_in_units_of_6(h: f64) -> Vec<f64> {
    let rig = ControllerParameters::default().rig;
    let mut rng = Pcg64::seed_from_u64(6);
    let mut falls = vec![];
    while falls.len() < 1000 {
        let gains = Gains { lambda: rng.random_range(1.0..5.0), eta: rng.random_range(1.0..5.0) };
        let (pose, offset) = (random_pose(&mut rng, 0.1), random_direction(&mut rng) * 0.05);
        let rates = Coordinates::from_fn(|_, _| rng.random_range(-0.1..0.1));
        let mut set_point = pose;
        set_point.0.fixed_rows_mut::<3>(0).copy_from(&(pose.position() + offset));
        let tension =
            lyapunov::tension_command(&rig, &gains, &pose, &rates, &Reference::resting(&set_point), 0.0)
                .unwrap();
        if tension.iter().any(|u| *u <= 0.0) {
            continue;
        }
        let parameters = PlantParameters { initial_pose: pose, ..Default::default() };
        let mut plant = Plant::new(parameters, &PlantInputs::none(6)).unwrap().moving(&rates);
        let before = sliding(&gains, &plant, &set_point);
        plant.step(&PlantInputs { motor_tension: tension, ..PlantInputs::none(6) }, h).unwrap();
        let after = sliding(&gains, &plant, &set_point);
        let fall = lyapunov::lyapunov_function(&after) - lyapunov::lyapunov_function(&before);
        falls.push(fall / (-gains.eta * before.norm_squared() * h)); // (6)
    }
    falls
}

/// Sampled, V does not fall at exactly the rate of (6): the tensions of the start of a step are held while pose and rates move on, and
/// s itself decays. Both are errors of first order in h: the deviation shrinks with h, and extrapolated to h = 0 nothing is left.
#[test]
fn v_falls_at_the_rate_of_equation_6() {
    let (coarse, fine) = (fall_in_units_of_6(1e-3), fall_in_units_of_6(1e-4));
    let worst = |falls: &[f64]| falls.iter().map(|fall| (fall - 1.0).abs()).fold(0.0, f64::max);
    let at_zero: Vec<f64> =
        coarse.iter().zip(&fine).map(|(coarse, fine)| (10.0 * fine - coarse) / 9.0).collect();
    let (coarse, fine, at_zero) = (worst(&coarse), worst(&fine), worst(&at_zero));
    println!(
        "largest deviation from (6): {coarse:.1e} at 1 ms, {fine:.1e} at 0.1 ms, {at_zero:.1e} extrapolated to 0"
    );
    assert!(fine < 0.01, "{fine} at 0.1 ms");
    assert!(at_zero < 1e-4, "{at_zero} is not first order");
}

#[test]
fn plant_does_not_depend_on_the_communication_step() {
    let mut rng = Pcg64::seed_from_u64(50);
    for _ in 0..50 {
        let parameters = PlantParameters {
            friction: rng.random_range(0.0..0.5),
            motor_lag: rng.random_range(0.0..0.05),
            initial_pose: random_pose(&mut rng, 0.1),
            ..Default::default()
        };
        let inputs = PlantInputs {
            motor_tension: PerCable::from_fn(6, |_| rng.random_range(5.0..15.0)),
            disturbance_force: random_direction(&mut rng),
            disturbance_torque: random_direction(&mut rng) * 0.01,
        };
        let end_with = |steps: u32| {
            let mut plant = Plant::new(parameters, &PlantInputs::none(6)).unwrap();
            for _ in 0..steps {
                plant.step(&inputs, 0.5 / f64::from(steps)).unwrap();
            }
            *plant.outputs()
        };
        let (fine, coarse) = (end_with(500), end_with(10));
        let apart = (fine.encoder_pose.position() - coarse.encoder_pose.position()).norm();
        assert!(apart < 1e-6, "{apart} m between 1 ms and 50 ms steps: {parameters:?}");
    }
}

#[test]
fn equal_runs_are_equal_bit_for_bit() {
    let rig = PlantParameters {
        friction: 0.3,
        motor_lag: 0.01,
        encoder_resolution: 1e-5,
        load_cell_noise: 0.2,
        noise_seed: 7,
        ..Default::default()
    };
    let run = || ClosedLoop::new(ControllerParameters::default(), rig, Pose::at(0.1, -0.1, 1.0), 1e-3);
    let (mut a, mut b) = (run(), run());
    for _ in 0..500 {
        assert_eq!(a.advance(), b.advance());
    }
}

#[test]
fn integrator_keeps_a_free_body_turning_as_euler_says() {
    // Without cables, gravity aside, angular momentum in the base frame and kinetic energy are kept.
    let robot = RobotParameters { i1: 0.02, i2: 0.03, i3: 0.04, ..Default::default() };
    let rig = Rig::paper(&robot, TensionLimits::default());
    let parameters = PlantParameters { rig, ..Default::default() };
    let rates = Coordinates::new(0.0, 0.0, 0.0, 1.0, 2.0, -1.5);
    let mut plant = Plant::new(parameters, &PlantInputs::none(6)).unwrap().moving(&rates);
    let energy = |plant: &Plant| {
        let output = plant.outputs();
        let omega = output.encoder_pose.rotation().inverse() * output.angular_velocity;
        0.5 * omega.dot(&Vector3::new(robot.i1, robot.i2, robot.i3).component_mul(&omega))
    };
    let before = energy(&plant);
    for _ in 0..100 {
        plant.step(&PlantInputs::none(6), 0.01).unwrap();
    }
    assert!((energy(&plant) / before - 1.0).abs() < 1e-8);
    let fallen = plant.outputs().encoder_pose.0[2] - 1.0;
    assert!((fallen - 0.5 * 9.81).abs() < 1e-8, "{fallen} m in a second of free fall");
}
