//! What a controller reads of a plant.

use cable_robot::plan::ControllerInputs;
use cable_robot::robot::Pose;
use cable_robot::sim::PlantOutputs;

pub fn inputs(plant: &PlantOutputs, goal: Pose, enable: bool) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose: goal,
        enable,
    }
}
