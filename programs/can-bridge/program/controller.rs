//! The packed controller: an FMU whose variables are looked up once, and which is then stepped without allocating.

use anyhow::{Context, Result, anyhow, ensure};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::robot::{PerCable, Pose};
use cable_robot::sim::{ControllerModel, ModelError};
use cable_robot_cosim::FmuModel;
use cable_robot_fieldbus::Config;
use cable_robot_fmi::can::{self, GivenError, rig_file};
use cable_robot_fmi::models::controller;
use cable_robot_fmi::values::Values;
use cable_robot_fmi::variables::Causality as Role;
use cable_robot_fmi::{Interface, Model};
use cable_robot_import::{LogMessage, Status};
use cable_robot_programs::errors::similar;
use cable_robot_report::run_folder;

/// An instance in Step Mode.
///
/// Its time lags by a cycle: what is read in a cycle was measured at the SYNC of the one before, and the step leads from there to now.
pub struct FmuController {
    fmu: FmuModel,
    /// What it was last given.
    inputs: ControllerInputs,
    /// End of the last step, s.
    time: f64,
    /// Of a cycle, s.
    period: f64,
    /// A longer time without a step is none: the controller was not asked. s.
    longest_pause: f64,
    /// The longest step that the FMU takes while it is enabled, s.
    longest_step: f64,
}

impl FmuController {
    /// Opens the FMU of the fieldbus file, gives it rig and parameters, and initialises it at rest at the home pose, at time 0.
    pub fn open(config: &Config) -> Result<Self> {
        let path = &config.controller.fmu;
        let rig = rig_file(config);
        let mut fmu = FmuModel::open(path.as_ref(), &rig, Box::new(say))?;
        ensure!(fmu.model() == Model::Controller, "{path} is a plant, no controller");
        let start = |fmu: &mut FmuModel| -> Result<()> {
            fmu.require(Role::Parameter, &["anchor", "attachment"]).context(
                "it is not made for the rig of the rig file: `cable-robot fmu --rig FILE --output FOLDER` makes one",
            )?;
            fmu.require(Role::Output, &["motorTension"])?;
            fmu.require(Role::Input, &["cableLength", "goalPose"])?;
            fmu.set_parameters(|interface, values| {
                let (lambda, eta) = (rig.lambda, rig.eta);
                let own = controller::controller_parameters(interface, values);
                let base = ControllerParameters { rig: rig.rig, lambda, eta, ..own };
                // The planner may be among what the fieldbus file says.
                controller::write_parameters(interface, &base, values);
                write_given(config, interface, values)?;
                let planned = controller::controller_parameters(interface, values);
                controller::write_parameters(interface, &config.of_drives(planned), values);
                write_given(config, interface, values)
            })?;
            ControllerModel::start(fmu, &at_rest(config))
                .and_then(|_| fmu.begin())
                .map_err(anyhow::Error::from_boxed)
        };
        start(&mut fmu).with_context(|| path.clone())?;
        let period = config.period as f64 * 1e-9;
        let (interface, values) = fmu.values();
        let longest_step = controller::controller_parameters(interface, values).longest_step();
        Ok(Self {
            fmu,
            inputs: at_rest(config),
            time: 0.0,
            period,
            longest_pause: period * f64::from(config.limits.lost_cycles + 1),
            longest_step,
        })
    }

    /// What the FMU was given.
    pub fn parameters(&self) -> ControllerParameters {
        let (interface, values) = self.fmu.values();
        controller::controller_parameters(interface, values)
    }

    /// For `run.json`, and for people.
    pub fn info(&self) -> run_folder::Model {
        self.fmu.info()
    }
}

impl ControllerModel for FmuController {
    /// It was started when it was opened.
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        ControllerModel::start(&mut self.fmu, inputs)
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
            ControllerModel::step(&mut self.fmu, self.time, measured - self.time, &idle)?;
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

impl FmuController {
    /// One step to `time`, s.
    fn go_on(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        let outputs = ControllerModel::step(&mut self.fmu, self.time, time - self.time, inputs)?;
        self.time = time;
        Ok(outputs)
    }
}

/// What the fieldbus file says of the controller.
fn write_given(config: &Config, interface: &Interface, values: &mut Values) -> Result<()> {
    can::write_given(config, interface, values).map_err(|error| {
        let meant = match &error {
            GivenError::Name { name, known } => similar(name, known.iter().copied()),
            _ => None,
        };
        let question = meant.map_or(String::new(), |meant| format!("; did you mean {meant}?"));
        anyhow!("{error}{question}")
    })
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
fn say(message: &LogMessage) {
    if message.status > Status::Ok {
        super::terminal::say(format_args!("can-bridge: {}: {}", message.instance, message.text));
    }
}

#[cfg(test)]
mod tests {
    use cable_robot::plan::{Controller, Status};
    use cable_robot_fieldbus::config::Parameter;

    use super::*;
    use crate::program::tests::config;

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
    fn the_fmu_does_what_the_library_does_a_cycle_before() {
        let config = config();
        let mut fmu = FmuController::open(&config).unwrap();
        let mut library = Controller::new(fmu.parameters(), 0.0, &at_rest(&config)).unwrap();
        // It is asked for the first time after 5 s, then at times that are not quite regular.
        let mut before = 5.0 - fmu.period;
        let h = fmu.period;
        library.step(0.0, before, &at_rest(&config));
        for k in 0..200 {
            let time = 5.0 + f64::from(k) * fmu.period + 1e-4 * f64::from(k % 3);
            let inputs = inputs(1e-5 * f64::from(k % 7));
            library.step(before, time - before, &inputs);
            let (theirs, ours) = (fmu.step(time, h, &inputs).unwrap(), library.outputs());
            assert_eq!(theirs.motor_tension, ours.motor_tension, "cycle {k}");
            assert_eq!((theirs.set_point, theirs.status), (ours.set_point, ours.status), "cycle {k}");
            before = time;
        }
        assert_eq!(library.outputs().status, Status::Moving);
    }

    /// With `Exact` a step may be 0.16 s long at these gains: a first pause of 14 s, and cycles lost, are no failure.
    #[test]
    fn a_pause_longer_than_a_step_may_be_is_no_failure() {
        let mut config = config();
        config.limits.lost_cycles = 100;
        config.controller.parameters.insert("planner".into(), Parameter::Item("Exact".into()));
        let mut fmu = FmuController::open(&config).unwrap();
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
        let mut fmu = FmuController::open(&config()).unwrap();
        let failure = fmu.step(1.0, 4e-3, &inputs(f64::NAN)).unwrap_err().to_string();
        assert!(failure.contains("cableLength[1] = NaN"), "{failure}");
    }
}
