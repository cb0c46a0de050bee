//! Limits of speeds: kept on the way, and every goal reached all the same.

use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, RigFile};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// What the closed form does not know: holding a command, the observers.
const MORE: f64 = 1.02;

/// Greatest speed (m/s), angular velocity (rad/s) and cable speed (m/s) on the way to the goals, one every `every` s; at the end where the robot is.
fn fastest(
    parameters: ControllerParameters,
    plant: PlantParameters,
    goals: &[Pose],
    every: f64,
) -> ([f64; 3], Status) {
    let mut run = ClosedLoop::new(parameters, plant, goals[0]).unwrap();
    let mut fastest = [0.0_f64; 3];
    for goal in goals {
        run.goal = *goal;
        for _ in 0..(every / 1e-3) as u32 {
            let before = run.moment().plant;
            let now = run.step(1e-3).unwrap().plant;
            assert!(!now.slack.contains(&true));
            let cables = before.cable_length.iter().zip(&now.cable_length).map(|(a, b)| (b - a).abs() / 1e-3);
            let speeds = [now.velocity.norm(), now.angular_velocity.norm(), cables.fold(0.0, f64::max)];
            (0..3).for_each(|k| fastest[k] = fastest[k].max(speeds[k]));
        }
    }
    (fastest, run.controller.outputs().status)
}

/// At 7 m/s no winch follows: Exact knew no limit, and the fieldbus's watchdog called the robot's own motion a mistake of the encoder.
#[test]
fn a_long_way_down_keeps_the_speed_of_the_winch() {
    let goal = Pose::at(0.0, 0.0, 10.0);
    let with = |max_cable_speed| ControllerParameters {
        planner: PlannerKind::Exact,
        max_cable_speed,
        ..Default::default()
    };
    let (free, _) = fastest(with(0.0), PlantParameters::default(), &[goal], 5.0);
    let (limited, status) = fastest(with(1.0), PlantParameters::default(), &[goal], 14.0);
    println!("cables at most {:.2} m/s, with a limit of 1 m/s {:.3} m/s", free[2], limited[2]);
    assert!(free[2] > 3.0 && limited[2] <= MORE && limited[2] > 0.9, "{free:?} {limited:?}");
    assert_eq!(status, Status::AtGoal);
}

#[test]
fn random_goals_changed_on_the_way_keep_all_three_limits_and_the_last_is_reached() {
    let mut rng = Pcg64::seed_from_u64(41);
    for text in [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")] {
        let RigFile { rig, home, .. } = RigFile::parse(text).unwrap();
        let size = rig.radius();
        let (speed, spin) = (0.15 * size, 0.2);
        let cable = 0.7 * speed;
        for _ in 0..10 {
            let gain = rng.random_range(2.0..8.0);
            let parameters = ControllerParameters {
                planner: PlannerKind::Exact,
                lambda: gain,
                eta: gain,
                max_speed: speed,
                max_angular_rate: spin,
                max_cable_speed: cable,
                ..ControllerParameters::of(&rig)
            };
            let mut goals: Vec<_> = (0..4)
                .map(|_| {
                    let wide = Coordinates::new(0.2, 0.2, 0.2, 0.0, 0.0, 0.0) * size
                        + Coordinates::new(0.0, 0.0, 0.0, 0.1, 0.1, 0.3);
                    Pose(home.0 + wide.map(|most| rng.random_range(-most..=most)))
                })
                .collect();
            goals.push(home);
            let plant = PlantParameters { rig, initial_pose: home, ..Default::default() };
            let (found, status) = fastest(parameters, plant, &goals, 8.0);
            println!(
                "gains {gain:.1}: {:.2}, {:.2} and {:.2} of the limits",
                found[0] / speed,
                found[1] / spin,
                found[2] / cable
            );
            assert!(found[0] <= MORE * speed && found[1] <= MORE * spin && found[2] <= MORE * cable);
            assert_eq!(status, Status::AtGoal);
        }
    }
}

#[test]
fn bounded_refuses_limits_that_it_does_not_heed() {
    let parameters = ControllerParameters { max_speed: 1.0, ..Default::default() };
    let refused = parameters.validate().unwrap_err().to_string();
    assert!(refused.contains("maxSpeed = 1") && refused.contains("choose Exact"), "{refused}");
}
