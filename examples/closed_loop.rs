//! Controller and plant in closed loop, a rig of your own if you name its file: `cargo run --example closed_loop -- rigs/eight.toml`.
//!
//! Prints the set points as they are given, and where the robot ends.

use std::error::Error;

use cable_robot::plan::ControllerParameters;
use cable_robot::robot::RigFile;
use cable_robot::sim::{ClosedLoop, Moment, PlantParameters};

/// s.
const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let RigFile { rig, home, lambda, eta, .. } = match std::env::args().nth(1) {
        Some(path) => RigFile::parse(&std::fs::read_to_string(path)?)?,
        None => RigFile::default(),
    };
    // A tenth of the rig's radius aside.
    let mut goal = home;
    goal.0[0] += 0.1 * rig.radius();

    let controller = ControllerParameters { lambda, eta, ..ControllerParameters::of(&rig) };
    let plant = PlantParameters { rig, initial_pose: home, ..PlantParameters::default() };
    let mut closed_loop = ClosedLoop::new(controller, plant, goal)?;

    let (mut given, mut smallest) = (0, f64::INFINITY);
    for _ in 0..20_000 {
        let Moment { time, controller, plant, .. } = *closed_loop.step(STEP)?;
        if controller.set_point_index > given {
            given = controller.set_point_index;
            println!(
                "set point {given} after {time:.2} s: {:.4?}",
                controller.set_point.position().as_slice()
            );
        }
        smallest = plant.measured_tension.iter().copied().fold(smallest, f64::min);
        if controller.at_goal {
            println!("at the goal after {time:.2} s, smallest tension {smallest:.2} N");
            return Ok(());
        }
    }
    let last = closed_loop.moment().controller;
    println!("{:?} after 20 s, {:.4} m from the goal", last.status, last.goal_distance);
    Ok(())
}
