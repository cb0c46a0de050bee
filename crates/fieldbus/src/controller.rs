//! Who computes the tensions: the packed FMU for `can-bridge`, the library's own controller in tests and in static builds.

use thiserror::Error;

use cable_robot::plan::{Controller, ControllerInputs, ControllerOutputs, ControllerParameters};

/// Pose, lengths and measured tensions in, tensions out. What goes in and comes out is what the FMU's variables say.
pub trait TensionController {
    /// Reads `inputs` measured at `time` (s, increasing) and computes what the motors shall pull from now on.
    ///
    /// With `enable` false it only follows the measurements.
    ///
    /// # Errors
    /// [`ControllerFailure`]: there are no outputs, and will not be any more.
    fn step(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ControllerFailure>;
}

/// The controller computed nothing.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the controller failed: {reason}")]
pub struct ControllerFailure {
    /// What it said.
    pub reason: String,
}

/// The library's controller.
#[derive(Clone, Debug)]
pub struct LibraryController {
    parameters: ControllerParameters,
    controller: Option<Controller>,
}

impl LibraryController {
    /// Starts with its first step.
    pub fn new(parameters: ControllerParameters) -> Self {
        Self { parameters, controller: None }
    }
}

impl TensionController for LibraryController {
    fn step(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ControllerFailure> {
        if let Some(controller) = &mut self.controller {
            controller.step(time, inputs);
            return Ok(*controller.outputs());
        }
        let controller = Controller::new(self.parameters, time, inputs)
            .map_err(|error| ControllerFailure { reason: error.to_string() })?;
        Ok(*self.controller.insert(controller).outputs())
    }
}
