//! Controller and plant in closed loop, a rig of your own if you name its file: `cargo run --example closed_loop -- rigs/eight.toml`.
//!
//! Prints the set points as they are given, and where the robot ends.

use std::error::Error;

use cable_robot::plan::{Controller, ControllerInputs, ControllerParameters};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

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

    let inputs = |plant: &PlantOutputs, goal_pose: Pose| ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose,
        enable: true,
    };
    let parameters = ControllerParameters { lambda, eta, ..ControllerParameters::of(&rig) };
    let hanging = PlantParameters { rig, initial_pose: home, ..PlantParameters::default() };
    let mut pull = PlantInputs::none(rig.cables.len());
    let seen = inputs(Plant::new(hanging, &pull)?.outputs(), goal);
    let mut controller = Controller::new(parameters, 0.0, &seen)?;
    pull.motor_tension = controller.outputs().motor_tension;
    let mut plant = Plant::new(hanging, &pull)?;

    let (mut given, mut smallest) = (0, f64::INFINITY);
    for k in 0..20_000 {
        let time = f64::from(k) * STEP;
        controller.step(time, STEP, &inputs(plant.outputs(), goal));
        let outputs = controller.outputs();
        if outputs.set_point_index > given {
            given = outputs.set_point_index;
            println!("set point {given} after {time:.2} s: {:.4?}", outputs.set_point.position().as_slice());
        }
        pull.motor_tension = outputs.motor_tension;
        plant.step(&pull, STEP)?;
        smallest = plant.outputs().measured_tension.iter().copied().fold(smallest, f64::min);
        if outputs.at_goal {
            println!("at the goal after {time:.2} s, smallest tension {smallest:.2} N");
            return Ok(());
        }
    }
    println!(
        "{:?} after 20 s, {:.4} m from the goal",
        controller.outputs().status,
        controller.outputs().goal_distance
    );
    Ok(())
}
