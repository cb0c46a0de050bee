//! Controller and plant in a closed loop, each the library's own or another that does the same.

use std::error::Error;

use nalgebra::Vector3;
use thiserror::Error;

use super::{Plant, PlantInputs, PlantOutputs, PlantParameters};
use crate::plan::orbit::Follower;
use crate::plan::{Controller, ControllerInputs, ControllerOutputs, ControllerParameters};
use crate::robot::{Coordinates, Pose};

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

    /// Leads the way to the goal that is given next through these poses ([`Controller::pass_through`]).
    ///
    /// # Errors
    /// Any way points, where the model takes none: an FMU has no input for them.
    fn pass_through(&mut self, way_points: &[Pose]) -> Result<(), ModelError> {
        match way_points {
            [] => Ok(()),
            _ => Err("goals[..].through: the library's controller alone takes way points".into()),
        }
    }
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
    fn pass_through(&mut self, way_points: &[Pose]) -> Result<(), ModelError> {
        Ok(Controller::pass_through(self, way_points)?)
    }

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
        if inputs.enable {
            self.parameters().check_step(h)?;
        }
        Controller::step(self, time, h, inputs);
        Ok(*self.outputs())
    }
}

impl ControllerModel for Follower {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        *self = self.anew(inputs)?;
        Ok(*self.outputs())
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        self.check_step(h)?;
        Follower::step(self, time, h, inputs);
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

impl ControllerModel for Box<dyn ControllerModel + '_> {
    fn pass_through(&mut self, way_points: &[Pose]) -> Result<(), ModelError> {
        (**self).pass_through(way_points)
    }

    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        (**self).start(inputs)
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        (**self).step(time, h, inputs)
    }
}

impl PlantModel for Box<dyn PlantModel + '_> {
    fn start(&mut self, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        (**self).start(inputs)
    }

    fn step(&mut self, time: f64, h: f64, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        (**self).step(time, h, inputs)
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

/// Controller and plant, joined. In each step the controller comes first and reads the plant of the step's start, as in a real loop.
pub struct ClosedLoop<C = Controller, P = Plant> {
    /// The controller.
    pub controller: C,
    /// The plant.
    pub plant: P,
    /// x_f.
    pub goal: Pose,
    /// Whether the controller may pull.
    pub enable: bool,
    /// On the platform's centre of mass, N, base frame.
    pub disturbance_force: Vector3<f64>,
    /// N m, base frame.
    pub disturbance_torque: Vector3<f64>,
    /// Whether the plant gets the tensions of the step before, as from a master that lets both step at once (Jacobi order).
    pub is_late: bool,
    moment: Moment,
    clock: Clock,
}

/// Time as the number of equal steps since the step last changed: a sum of many steps would be less exact.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    /// s.
    since: f64,
    steps: u32,
    step: f64,
}

impl Clock {
    fn time(&self) -> f64 {
        self.since + f64::from(self.steps) * self.step
    }

    fn advance(&mut self, step: f64) {
        if step != self.step {
            *self = Self { since: self.time(), steps: 0, step };
        }
        self.steps += 1;
    }
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

impl ClosedLoop {
    /// The library's own controller and plant, started.
    ///
    /// # Errors
    /// [`SimulationError`] with the parameter that makes no sense.
    pub fn new(
        controller: ControllerParameters,
        plant: PlantParameters,
        goal: Pose,
    ) -> Result<Self, SimulationError> {
        let plant =
            Plant::new(plant, &PlantInputs::none(plant.rig.cables.len())).map_err(stopped("plant", 0.0))?;
        let seen = inputs(plant.outputs(), goal, true);
        let controller = Controller::new(controller, 0.0, &seen).map_err(stopped("controller", 0.0))?;
        let outside = PlantInputs::none(plant.parameters().rig.cables.len());
        Self::with_models(controller, plant, goal, &outside)
    }

    /// The same, the platform moving with these rates of the six coordinates (m/s, rad/s).
    #[must_use]
    pub fn moving(mut self, rates: &Coordinates) -> Self {
        self.plant = self.plant.moving(rates);
        self.moment.plant = *self.plant.outputs();
        self
    }
}

impl<C: ControllerModel, P: PlantModel> ClosedLoop<C, P> {
    /// These models, started with the goal and the disturbances of `outside`: the plant hangs, the controller reads it, the plant's motors pull what the
    /// controller says.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn with_models(
        mut controller: C,
        mut plant: P,
        goal: Pose,
        outside: &PlantInputs,
    ) -> Result<Self, SimulationError> {
        let none = PlantInputs::none(outside.motor_tension.len());
        let hanging = plant.start(&none).map_err(stopped("plant", 0.0))?;
        let seen = inputs(&hanging, goal, true);
        let answer = controller.start(&seen).map_err(stopped("controller", 0.0))?;
        let pull = PlantInputs { motor_tension: answer.motor_tension, ..*outside };
        let started = plant.start(&pull).map_err(stopped("plant", 0.0))?;
        let moment = Moment {
            time: 0.0,
            controller_inputs: seen,
            controller: answer,
            plant_inputs: pull,
            plant: started,
        };
        Ok(Self {
            controller,
            plant,
            goal,
            enable: true,
            disturbance_force: outside.disturbance_force,
            disturbance_torque: outside.disturbance_torque,
            is_late: false,
            moment,
            clock: Clock::default(),
        })
    }

    /// One step of `h` s of the controller, then one of the plant.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn step(&mut self, h: f64) -> Result<&Moment, SimulationError> {
        self.step_seeing(h, |_| ())
    }

    /// The same with what `change` makes of what the controller reads.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn step_seeing(
        &mut self,
        h: f64,
        change: impl FnOnce(&mut ControllerInputs),
    ) -> Result<&Moment, SimulationError> {
        let time = self.moment.time;
        let mut seen = inputs(&self.moment.plant, self.goal, self.enable);
        change(&mut seen);
        let before = self.moment.controller.motor_tension;
        let answer = self.controller.step(time, h, &seen).map_err(stopped("controller", time))?;
        let pull = PlantInputs {
            motor_tension: if self.is_late { before } else { answer.motor_tension },
            disturbance_force: self.disturbance_force,
            disturbance_torque: self.disturbance_torque,
        };
        let plant = self.plant.step(time, h, &pull).map_err(stopped("plant", time))?;
        self.clock.advance(h);
        self.moment = Moment {
            time: self.clock.time(),
            controller_inputs: seen,
            controller: answer,
            plant_inputs: pull,
            plant,
        };
        Ok(&self.moment)
    }

    /// Where they are.
    pub fn moment(&self) -> &Moment {
        &self.moment
    }
}

pub(super) fn stopped<E: Into<ModelError>>(
    model: &'static str,
    time: f64,
) -> impl FnOnce(E) -> SimulationError {
    move |cause| SimulationError { model, time, cause: cause.into() }
}

pub(super) fn inputs(plant: &PlantOutputs, goal: Pose, enable: bool) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose: goal,
        enable,
    }
}
