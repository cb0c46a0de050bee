//! The closed loop of controller and plant in the library, as the tests run it.

mod inputs;

pub use inputs::inputs;

use cable_robot::plan::{Controller, ControllerOutputs, ControllerParameters};
use cable_robot::robot::Pose;
use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

/// Controller and plant, each stepped once a call, the controller first.
pub struct ClosedLoop {
    pub controller: Controller,
    pub plant: Plant,
    pub goal: Pose,
    pub enable: bool,
    pub step: f64,
    count: u32,
}

impl ClosedLoop {
    pub fn new(controller: ControllerParameters, plant: PlantParameters, goal: Pose, step: f64) -> Self {
        let none = PlantInputs::none(plant.rig.cables.len());
        let hanging = Plant::new(plant, &none).unwrap();
        let controller = Controller::new(controller, 0.0, &inputs(hanging.outputs(), goal, true)).unwrap();
        let pull = PlantInputs { motor_tension: controller.outputs().motor_tension, ..none };
        let plant = Plant::new(plant, &pull).unwrap();
        Self { controller, plant, goal, enable: true, step, count: 0 }
    }

    pub fn time(&self) -> f64 {
        f64::from(self.count) * self.step
    }

    /// One communication step; what the controller answered and what the plant was then.
    pub fn advance(&mut self) -> (ControllerOutputs, PlantOutputs) {
        self.controller.step(self.time(), self.step, &inputs(self.plant.outputs(), self.goal, self.enable));
        let output = *self.controller.outputs();
        let pull = PlantInputs {
            motor_tension: output.motor_tension,
            ..PlantInputs::none(output.motor_tension.len())
        };
        let before = *self.plant.outputs();
        self.plant.step(&pull, self.step).unwrap();
        self.count += 1;
        (output, before)
    }
}
