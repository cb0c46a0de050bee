//! What must hold everywhere: random rigs, gains, limits, planners and goals, in closed loop.

use crate::common::ClosedLoop;
use cable_robot::control::static_tensions;
use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::PlantParameters;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const RUNS: usize = 60;

fn random_robot(rng: &mut Pcg64) -> RobotParameters {
    let (a, m) = (rng.random_range(0.3..1.0), rng.random_range(2.0..30.0));
    let b = rng.random_range(0.3..0.8) * a;
    let i1 = m * b * b * rng.random_range(0.03..0.3);
    RobotParameters { a, b, m, i1, i2: i1, i3: i1 * rng.random_range(1.0..2.0), ..Default::default() }
}

/// At most `aside` (m) from the middle, around a height of `z`, turned by `tilt` and twice that in yaw.
fn random_pose(rng: &mut Pcg64, aside: f64, z: f64, tilt: f64) -> Pose {
    let mut within = |most: f64| if most > 0.0 { rng.random_range(-most..most) } else { 0.0 };
    let (x, y, up) = (within(aside), within(aside), within(0.4 * z));
    Pose(Coordinates::new(x, y, z + up, within(tilt), within(tilt), within(2.0 * tilt)))
}

/// Many of the goals cannot be reached, and most of them change before they are reached.
#[test]
fn no_cable_goes_slack_whatever_the_rig_and_the_goals() {
    let mut rng = Pcg64::seed_from_u64(47);
    let (mut least, mut runs) = (f64::INFINITY, 0);
    while runs < RUNS {
        let robot = random_robot(&mut rng);
        let weight = robot.m * robot.g;
        let planner = if rng.random_bool(0.7) { PlannerKind::Exact } else { PlannerKind::Bounded };
        let (lambda, eta) = (rng.random_range(1.0..9.0), rng.random_range(1.0..9.0));
        let max = weight * rng.random_range(0.5..3.0);
        let rig = Rig::paper(&robot, TensionLimits { min: 0.0, max });
        let parameters = ControllerParameters { rig, planner, lambda, eta, ..Default::default() };
        let tilt = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..0.6) };
        let z = rng.random_range(0.5..3.0) * robot.a;
        let initial_pose = random_pose(&mut rng, 0.3 * robot.a, z, tilt);
        let most = max - 1e-3 * weight;
        let rests = static_tensions(&rig, &initial_pose, 0.0)
            .is_some_and(|tension| tension.iter().all(|u| (1e-3 * weight..most).contains(u)));
        if !rests {
            continue;
        }
        let plant = PlantParameters { rig, initial_pose, ..Default::default() };
        let step = [1e-3, 2e-3][runs % 2];
        let mut run = ClosedLoop::new(parameters, plant, initial_pose, step);
        for _ in 0..4 {
            run.goal = random_pose(&mut rng, 0.8 * robot.a, z, tilt);
            for _ in 0..[200, 800, 3000][runs % 3] {
                let (output, plant) = run.advance();
                let what = || {
                    format!("run {runs} at {} s: {parameters:?} to {:?}: {output:?}", run.time(), run.goal)
                };
                assert!(plant.slack == [false; 6] && output.status != Status::SensorFault, "{}", what());
                least = output.motor_tension.iter().fold(least, |least, u| least.min(u / weight));
            }
        }
        runs += 1;
    }
    println!("{RUNS} runs, smallest tension {least:.5} of the weight");
    assert!(least > 0.0);
}
