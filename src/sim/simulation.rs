//! A scenario under way.

use super::closed_loop::{inputs, stopped};
use super::{ClosedLoop, ControllerModel, Moment, Plant, PlantInputs, PlantModel, Scenario, SimulationError};
use crate::plan::orbit::Follower;

/// A scenario and the closed loop that runs it.
pub struct Simulation<'a> {
    scenario: &'a Scenario,
    /// How many goals were.
    given: usize,
    closed_loop: ClosedLoop<Box<dyn ControllerModel + 'a>, Box<dyn PlantModel + 'a>>,
}

impl<'a> Simulation<'a> {
    /// With the library's own controller and plant, started.
    ///
    /// # Errors
    /// [`SimulationError`] with the parameter that makes no sense.
    pub fn new(scenario: &'a Scenario) -> Result<Self, SimulationError> {
        let (controller, plant) = library_models(scenario)?;
        Self::with_models(scenario, controller, Box::new(plant))
    }

    /// With these models, started.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn with_models(
        scenario: &'a Scenario,
        controller: Box<dyn ControllerModel + 'a>,
        plant: Box<dyn PlantModel + 'a>,
    ) -> Result<Self, SimulationError> {
        let (disturbance_force, disturbance_torque) = scenario.disturbance_at(0.0);
        let none = PlantInputs::none(scenario.plant.rig.cables.len());
        let outside = PlantInputs { disturbance_force, disturbance_torque, ..none };
        let closed_loop = ClosedLoop::with_models(controller, plant, scenario.goal_at(0.0), &outside)?;
        Ok(Self { scenario, given: 0, closed_loop })
    }

    /// One step of the controller, then one of the plant.
    ///
    /// # Errors
    /// [`SimulationError`]: what a model refuses.
    pub fn step(&mut self) -> Result<(), SimulationError> {
        let time = self.closed_loop.moment().time;
        let given = self.scenario.given_at(time);
        if let Some(goal) = given.last().filter(|_| given.len() > self.given) {
            let taken = self.closed_loop.controller.pass_through(&goal.through);
            taken.map_err(stopped("controller", time))?;
            self.given = given.len();
        }
        self.closed_loop.goal = self.scenario.goal_at(time);
        (self.closed_loop.disturbance_force, self.closed_loop.disturbance_torque) =
            self.scenario.disturbance_at(time);
        self.closed_loop.step(self.scenario.step)?;
        Ok(())
    }

    /// Where it is.
    pub fn moment(&self) -> &Moment {
        self.closed_loop.moment()
    }
}

/// The library's controller and plant at the start of a scenario.
///
/// # Errors
/// [`SimulationError`] with the parameter that makes no sense, or why the orbit is not proved.
pub fn library_models(scenario: &Scenario) -> Result<(Box<dyn ControllerModel>, Plant), SimulationError> {
    let parameters = scenario.controller;
    let ClosedLoop { controller, plant, .. } =
        ClosedLoop::new(parameters, scenario.plant, scenario.goal_at(0.0))?;
    let Some(orbit) = &scenario.orbit else { return Ok((Box::new(controller), plant)) };
    let seen = inputs(plant.outputs(), orbit.centre, true);
    let follower = Follower::new(orbit, &parameters, (0.0, scenario.step), &seen);
    Ok((Box::new(follower.map_err(stopped("controller", 0.0))?), plant))
}
