//! A scenario under way: controller and plant in a closed loop, each the library's own or another that does the same.

use std::error::Error;

use thiserror::Error;

use super::{Plant, PlantInputs, PlantOutputs, Scenario};
use crate::plan::{Controller, ControllerInputs, ControllerOutputs};
use crate::robot::Pose;

/// Why a model stopped, in its own words.
pub type ModelError = Box<dyn Error + Send + Sync>;

/// What the loop needs of a controller.
pub trait ControllerModel {
    /// Starts at time 0; before the first step it may be called again with other inputs.
    ///
    /// # Errors
    /// What the model refuses.
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError>;

    /// Steps from `time` by `h` seconds with inputs measured at `time`.
    ///
    /// # Errors
    /// What the model refuses.
    fn step(&mut self, time: f64, h: f64, inputs: &ControllerInputs)
    -> Result<ControllerOutputs, ModelError>;
}

/// What the loop needs of a plant.
pub trait PlantModel {
    /// Hangs at rest at time 0; before the first step it may be called again with other inputs.
    ///
    /// # Errors
    /// What the model refuses.
    fn start(&mut self, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError>;

    /// Steps from `time` by `h` seconds with `inputs` held.
    ///
    /// # Errors
    /// What the model refuses.
    fn step(&mut self, time: f64, h: f64, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError>;
}

impl ControllerModel for Controller {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        *self = Controller::new(*self.parameters(), 0.0, inputs)?;
        Ok(*self.outputs())
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        Controller::step(self, time, h, inputs);
        Ok(*self.outputs())
    }
}

impl PlantModel for Plant {
    fn start(&mut self, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        *self = Plant::new(*self.parameters(), inputs)?;
        Ok(*self.outputs())
    }

    fn step(&mut self, _time: f64, h: f64, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        Plant::step(self, inputs, h)?;
        Ok(*self.outputs())
    }
}

/// A simulation that cannot go on.
#[derive(Debug, Error)]
#[error("the {model} stopped at {time} s: {cause}")]
pub struct SimulationError {
    /// `controller` or `plant`.
    pub model: &'static str,
    /// Start of the step, s.
    pub time: f64,
    /// Why.
    pub cause: ModelError,
}

/// A scenario under way. The controller steps first and reads the plant of the step's start, as in a real loop.
pub struct ClosedLoop<'a> {
    scenario: &'a Scenario,
    controller: Box<dyn ControllerModel + 'a>,
    plant: Box<dyn PlantModel + 'a>,
    steps_done: u64,
    moment: Moment,
}

/// What controller and plant read and answered in the step that led to this moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// s.
    pub time: f64,
    /// Inputs of the controller at the start of the step.
    pub controller_inputs: ControllerInputs,
    /// Its answer, held over the step.
    pub controller: ControllerOutputs,
    /// Inputs of the plant over the step.
    pub plant_inputs: PlantInputs,
    /// The plant now.
    pub plant: PlantOutputs,
}

impl<'a> ClosedLoop<'a> {
    /// The library's own controller and plant, started.
    ///
    /// # Errors
    /// [`SimulationError`] with the parameter that makes no sense.
    pub fn new(scenario: &'a Scenario) -> Result<Self, SimulationError> {
        let plant = Box::new(library_plant(scenario)?);
        let controller = Box::new(library_controller(scenario)?);
        Self::with_models(scenario, controller, plant)
    }

    /// These models, started: the plant hangs, the controller reads it, the plant's motors pull what the controller says.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn with_models(
        scenario: &'a Scenario,
        mut controller: Box<dyn ControllerModel + 'a>,
        mut plant: Box<dyn PlantModel + 'a>,
    ) -> Result<Self, SimulationError> {
        let hanging = plant
            .start(&PlantInputs::none(scenario.plant.rig.cables.len()))
            .map_err(stopped("plant", 0.0))?;
        let read = inputs(&hanging, scenario.goal_at(0.0));
        let answer = controller.start(&read).map_err(stopped("controller", 0.0))?;
        let pull = pull(scenario, 0.0, &answer);
        let started = plant.start(&pull).map_err(stopped("plant", 0.0))?;
        let moment = Moment {
            time: 0.0,
            controller_inputs: read,
            controller: answer,
            plant_inputs: pull,
            plant: started,
        };
        Ok(Self { scenario, controller, plant, steps_done: 0, moment })
    }

    /// One step of the controller, then one of the plant.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn step(&mut self) -> Result<(), SimulationError> {
        let (time, h) = (self.moment.time, self.scenario.step);
        let read = inputs(&self.moment.plant, self.scenario.goal_at(time));
        let answer = self.controller.step(time, h, &read).map_err(stopped("controller", time))?;
        let pull = pull(self.scenario, time, &answer);
        let plant = self.plant.step(time, h, &pull).map_err(stopped("plant", time))?;
        self.steps_done += 1;
        self.moment = Moment {
            time: self.steps_done as f64 * h,
            controller_inputs: read,
            controller: answer,
            plant_inputs: pull,
            plant,
        };
        Ok(())
    }

    /// Where the simulation is.
    pub fn moment(&self) -> &Moment {
        &self.moment
    }
}

/// The library's plant at the start of a scenario.
///
/// # Errors
/// [`SimulationError`] with the parameter that makes no sense.
pub fn library_plant(scenario: &Scenario) -> Result<Plant, SimulationError> {
    Plant::new(scenario.plant, &PlantInputs::none(scenario.plant.rig.cables.len()))
        .map_err(stopped("plant", 0.0))
}

/// The library's controller at the start of a scenario.
///
/// # Errors
/// [`SimulationError`] with the parameter that makes no sense.
pub fn library_controller(scenario: &Scenario) -> Result<Controller, SimulationError> {
    let hanging = library_plant(scenario)?;
    let read = inputs(hanging.outputs(), scenario.goal_at(0.0));
    Controller::new(scenario.controller, 0.0, &read).map_err(stopped("controller", 0.0))
}

fn stopped<E: Into<ModelError>>(model: &'static str, time: f64) -> impl FnOnce(E) -> SimulationError {
    move |cause| SimulationError { model, time, cause: cause.into() }
}

fn inputs(plant: &PlantOutputs, goal: Pose) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose: goal,
        enable: true,
    }
}

fn pull(scenario: &Scenario, time: f64, controller: &ControllerOutputs) -> PlantInputs {
    let (disturbance_force, disturbance_torque) = scenario.disturbance_at(time);
    PlantInputs { motor_tension: controller.motor_tension, disturbance_force, disturbance_torque }
}
