//! The library's own controller, in the place of the packed FMU: in tests and in static builds.

use cable_robot::plan::{Controller, ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::sim::{ControllerModel, ModelError};

/// The library's controller, which starts with its first step, whenever that is.
#[derive(Clone, Debug)]
pub struct LibraryController {
    parameters: ControllerParameters,
    controller: Option<Controller>,
}

impl LibraryController {
    /// With these parameters.
    pub fn new(parameters: ControllerParameters) -> Self {
        Self { parameters, controller: None }
    }

    fn start_at(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        let controller = Controller::new(self.parameters, time, inputs)?;
        Ok(*self.controller.insert(controller).outputs())
    }
}

impl ControllerModel for LibraryController {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        self.start_at(0.0, inputs)
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        match &mut self.controller {
            Some(controller) => ControllerModel::step(controller, time, h, inputs),
            None => self.start_at(time, inputs),
        }
    }
}
