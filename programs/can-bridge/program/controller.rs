//! The controller: this program's own, or an FMU that the user names, whose variables are looked up once. It is stepped without allocating.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use cable_robot::plan::{Controller, ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::robot::{PerCable, Pose};
use cable_robot::sim::{ControllerModel, ModelError};
use cable_robot_cosim::FmuModel;
use cable_robot_fieldbus::Config;
use cable_robot_fmi::Model;
use cable_robot_fmi::can::{self, GivenError, rig_file};
use cable_robot_fmi::models::controller;
use cable_robot_fmi::variables::Causality as Role;
use cable_robot_import::{Fmu, LogMessage, Status};
use cable_robot_programs::errors::similar;
use cable_robot_report::run_folder;
use sha2::{Digest, Sha256};

use super::privileges;
use super::terminal::say;

/// Which one it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identity {
    /// The one that is part of this program.
    Own,
    /// Of a packed FMU: SHA-256 of its file.
    Packed(String),
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Own => "own".fmt(f),
            Self::Packed(hash) => write!(f, "sha256:{hash}"),
        }
    }
}

/// The controller that the bridge asks: this program's own, or an FMU in Step Mode.
///
/// Its time lags by a cycle: what is read in a cycle was measured at the SYNC of the one before, and the step leads from there to now.
pub struct BridgeController {
    model: Box<dyn ControllerModel>,
    parameters: ControllerParameters,
    info: run_folder::Model,
    identity: Identity,
    /// What it was last given.
    inputs: ControllerInputs,
    /// End of the last step, s.
    time: f64,
    /// Of a cycle, s.
    period: f64,
    /// A longer time without a step is none: the controller was not asked. s.
    longest_pause: f64,
    /// The longest step that it takes while it is enabled, s.
    longest_step: f64,
}

impl BridgeController {
    /// The FMU that the user names, or this program's own controller; with rig and parameters, initialised at rest at the home pose, at time 0.
    pub fn open(config: &Config, fmu: Option<&Path>) -> Result<Self> {
        match fmu {
            Some(path) => Self::packed(config, path),
            None => Self::own(config),
        }
    }

    fn own(config: &Config) -> Result<Self> {
        let parameters = can::controller_parameters(config).map_err(with_question)?;
        let controller = Controller::new(parameters, 0.0, &at_rest(config))?;
        Ok(Self::new(config, Box::new(controller), parameters, run_folder::Model::Library, Identity::Own))
    }

    /// Runs the code in the file: it is the user's word that this is meant.
    fn packed(config: &Config, path: &Path) -> Result<Self> {
        privileges::refuse_foreign_code()?;
        let bytes = Fmu::read(path)?;
        let identity =
            Identity::Packed(Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect());
        say(format_args!("can-bridge: controller {} ({identity})", path.display()));
        let rig = rig_file(config);
        let mut fmu = FmuModel::of(&Fmu::open_read(path, &bytes)?, path, &rig, Box::new(say_of_fmu))?;
        ensure!(fmu.model() == Model::Controller, "{} is a plant, no controller", path.display());
        let start = |fmu: &mut FmuModel| -> Result<()> {
            fmu.require(Role::Parameter, &["anchor", "attachment"]).context(
                "it is not made for the rig of the rig file: `cable-robot fmu --rig FILE --output FOLDER` makes one",
            )?;
            fmu.require(Role::Output, &["motorTension"])?;
            fmu.require(Role::Input, &["cableLength", "goalPose"])?;
            fmu.set_parameters(|interface, values| {
                let (lambda, eta) = (rig.lambda, rig.eta);
                let own = controller::controller_parameters(interface, values);
                let own = ControllerParameters { rig: rig.rig, lambda, eta, ..own };
                can::write_parameters(config, interface, &own, values).map_err(with_question)
            })?;
            ControllerModel::start(fmu, &at_rest(config))
                .and_then(|_| fmu.begin())
                .map_err(anyhow::Error::from_boxed)
        };
        start(&mut fmu).with_context(|| path.display().to_string())?;
        let (interface, values) = fmu.values();
        let (parameters, info) = (controller::controller_parameters(interface, values), fmu.info());
        Ok(Self::new(config, Box::new(fmu), parameters, info, identity))
    }

    fn new(
        config: &Config,
        model: Box<dyn ControllerModel>,
        parameters: ControllerParameters,
        info: run_folder::Model,
        identity: Identity,
    ) -> Self {
        let period = config.period as f64 * 1e-9;
        Self {
            model,
            longest_step: parameters.longest_step(),
            parameters,
            info,
            identity,
            inputs: at_rest(config),
            time: 0.0,
            period,
            longest_pause: period * f64::from(config.limits.lost_cycles + 1),
        }
    }

    /// What it was given.
    pub fn parameters(&self) -> ControllerParameters {
        self.parameters
    }

    /// For `run.json`, and for people.
    pub fn info(&self) -> &run_folder::Model {
        &self.info
    }

    /// Which one it is.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }
}

impl ControllerModel for BridgeController {
    /// It was started when it was opened.
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        self.model.start(inputs)
    }

    fn step(
        &mut self,
        time: f64,
        _h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        if time - self.time > self.longest_pause {
            let measured = time - self.period;
            let idle = ControllerInputs { enable: false, ..self.inputs };
            self.model.step(self.time, measured - self.time, &idle)?;
            self.time = measured;
        }
        // Cycles that were lost, and bridged, may be more than one step takes.
        let (from, pause) = (self.time, time - self.time);
        let steps = (pause / self.longest_step).ceil().max(1.0);
        for k in 1..steps as u32 {
            self.go_on(from + pause * f64::from(k) / steps, inputs)?;
        }
        self.inputs = *inputs;
        self.go_on(time, inputs)
    }
}

impl BridgeController {
    /// One step to `time`, s.
    fn go_on(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        let outputs = self.model.step(self.time, time - self.time, inputs)?;
        self.time = time;
        Ok(outputs)
    }
}

/// With the name that may have been meant.
fn with_question(error: GivenError) -> anyhow::Error {
    let meant = match &error {
        GivenError::Name { name, known } => similar(name, known.iter().copied()),
        _ => None,
    };
    let question = meant.map_or(String::new(), |meant| format!("; did you mean {meant}?"));
    anyhow!("{error}{question}")
}

/// At home, not enabled.
fn at_rest(config: &Config) -> ControllerInputs {
    let Config { home, rig, .. } = config;
    ControllerInputs {
        encoder_pose: *home,
        cable_length: rig.cables_at(home).length,
        measured_tension: PerCable::filled(rig.cables.len(), 0.0),
        goal_pose: Pose(home.0),
        enable: false,
    }
}

/// Passes on what the FMU has to say beyond remarks.
fn say_of_fmu(message: &LogMessage) {
    if message.status > Status::Ok {
        say(format_args!("can-bridge: {}: {}", message.instance, message.text));
    }
}

#[cfg(test)]
mod tests {
    use cable_robot::plan::Status;
    use cable_robot_fieldbus::config::Parameter;

    use super::*;
    use crate::program::tests::{config, packed};

    /// At home, pulling the platform to (0.1, 0, 1).
    fn inputs(lengthening: f64) -> ControllerInputs {
        let rest = at_rest(&config());
        ControllerInputs {
            cable_length: rest.cable_length.map(|length| length + lengthening),
            goal_pose: Pose::at(0.1, 0.0, 1.0),
            enable: true,
            ..rest
        }
    }

    #[test]
    fn the_own_and_the_packed_controller_do_what_the_library_does_a_cycle_before() {
        let config = config();
        for fmu in [None, Some(packed())] {
            let mut controller = BridgeController::open(&config, fmu.as_deref()).unwrap();
            let mut library = Controller::new(controller.parameters(), 0.0, &at_rest(&config)).unwrap();
            // It is asked for the first time after 5 s, then at times that are not quite regular.
            let h = controller.period;
            let mut before = 5.0 - h;
            library.step(0.0, before, &at_rest(&config));
            for k in 0..200 {
                let time = 5.0 + f64::from(k) * h + 1e-4 * f64::from(k % 3);
                let inputs = inputs(1e-5 * f64::from(k % 7));
                library.step(before, time - before, &inputs);
                let (theirs, ours) = (controller.step(time, h, &inputs).unwrap(), library.outputs());
                assert_eq!(theirs.motor_tension, ours.motor_tension, "cycle {k}");
                assert_eq!((theirs.set_point, theirs.status), (ours.set_point, ours.status), "cycle {k}");
                before = time;
            }
            assert_eq!(library.outputs().status, Status::Moving);
        }
    }

    /// With `Exact` a step may be 0.16 s long at these gains: a first pause of 14 s, and cycles lost, are no failure.
    #[test]
    fn a_pause_longer_than_a_step_may_be_is_no_failure() {
        let mut config = config();
        config.limits.lost_cycles = 100;
        config.controller.parameters.insert("planner".into(), Parameter::Item("Exact".into()));
        let mut fmu = BridgeController::open(&config, Some(&packed())).unwrap();
        assert!(fmu.longest_step > 0.1 && fmu.longest_step < 0.2, "{}", fmu.longest_step);
        let mut time = 14.0;
        for pause in [fmu.period, 0.15, 0.4, fmu.period, 10.0, fmu.period] {
            let status = fmu.step(time, fmu.period, &inputs(0.0)).unwrap().status;
            assert!(!matches!(status, Status::Disabled | Status::SensorFault), "{status:?} at {time} s");
            time += pause;
        }
    }

    #[test]
    fn what_the_fmu_refuses_is_a_failure_that_says_why() {
        let mut fmu = BridgeController::open(&config(), Some(&packed())).unwrap();
        let failure = fmu.step(1.0, 4e-3, &inputs(f64::NAN)).unwrap_err().to_string();
        assert!(failure.contains("cableLength[1] = NaN"), "{failure}");
    }
}
