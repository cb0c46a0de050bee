//! The packed controller: an FMU whose variables are looked up once, and which is then stepped without allocating.

use anyhow::{Context, Result, bail, ensure};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::robot::{PerCable, Pose};
use cable_robot_fieldbus::CABLES;
use cable_robot_fieldbus::config::Parameter;
use cable_robot_fieldbus::controller::ControllerFailure;
use cable_robot_fieldbus::{Config, TensionController};
use cable_robot_fmi::models::controller;
use cable_robot_fmi::values::Values;
use cable_robot_fmi::variables::{Causality as Role, Kind};
use cable_robot_fmi::{Interface, Model};
use cable_robot_import::{
    Causality, FmiVersion, Fmu, Instance, LogMessage, Status, Value, Variable, VariableType,
};
use cable_robot_report::run_folder;

/// An instance in Step Mode.
///
/// Its time lags by a cycle: what is read in a cycle was measured at the SYNC of the one before, and the step leads from there to now.
pub struct FmuController {
    instance: Instance,
    path: String,
    parameters: ControllerParameters,
    /// Our value references, and the FMU's variables of the same names.
    inputs: Vec<(u32, Variable)>,
    outputs: Vec<(u32, Variable)>,
    values: Values,
    /// End of the last step, s.
    time: f64,
    /// Of the rig, s.
    period: f64,
    /// A longer time without a step is none: the controller was not asked. s.
    longest_step: f64,
}

impl FmuController {
    /// Opens the FMU of the rig file, sets its parameters and initialises it at rest at the home pose, at time 0.
    pub fn open(config: &Config) -> Result<Self> {
        let path = &config.controller.fmu;
        let fmu = Fmu::open(path)?;
        let instance = fmu.instantiate("controller", Box::new(say))?;
        Self::start(instance, config).with_context(|| path.clone())
    }

    fn start(instance: Instance, config: &Config) -> Result<Self> {
        let interface = Model::Controller.interface();
        let mut values = interface.start().clone();
        for (name, parameter) in &config.controller.parameters {
            let (reference, number) = parameter_value(&interface, name, parameter)?;
            values.put(reference, number);
        }
        for (reference, variable) in shared(&instance, &interface, Role::Parameter)? {
            instance.set(&variable, typed(variable.kind, values.at(reference)))?;
        }
        let period = config.period as f64 * 1e-9;
        let mut this = Self {
            path: config.controller.fmu.clone(),
            parameters: controller::controller_parameters(&interface, &values),
            inputs: shared(&instance, &interface, Role::Input)?,
            outputs: shared(&instance, &interface, Role::Output)?,
            values,
            instance,
            time: 0.0,
            period,
            longest_step: period * f64::from(config.limits.lost_cycles + 1),
        };
        this.require("goalPose.x", &this.inputs)?;
        for i in 1..=CABLES {
            this.require(&format!("motorTension[{i}]"), &this.outputs)?;
            this.require(&format!("cableLength[{i}]"), &this.inputs)?;
        }
        this.instance.enter_initialization(0.0, None)?;
        controller::write_inputs(&at_rest(config), &mut this.values);
        this.give()?;
        this.instance.exit_initialization()?;
        // Its remarks on every set point cost memory; errors are told all the same.
        this.instance.set_logging(false)?;
        Ok(this)
    }

    /// What the FMU was told.
    pub fn parameters(&self) -> ControllerParameters {
        self.parameters
    }

    /// For `run.json`, and for people.
    pub fn info(&self) -> run_folder::Model {
        let description = self.instance.description();
        let fmi_version = match description.version {
            FmiVersion::V2 => "2.0",
            FmiVersion::V3 => "3.0",
        };
        run_folder::Model::Fmu {
            path: self.path.clone().into(),
            name: description.model_name.clone(),
            fmi_version: fmi_version.to_owned(),
        }
    }

    fn require(&self, name: &str, known: &[(u32, Variable)]) -> Result<()> {
        let has = known.iter().any(|(_, variable)| variable.name == name);
        ensure!(has, "this is no controller of a cable robot: it has no variable {name} of the right role");
        Ok(())
    }

    /// Sets the inputs.
    fn give(&self) -> Result<(), cable_robot_import::CosimError> {
        self.inputs.iter().try_for_each(|(reference, variable)| {
            self.instance.set(variable, typed(variable.kind, self.values.at(*reference)))
        })
    }

    fn advance(
        &mut self,
        time: f64,
        inputs: &ControllerInputs,
    ) -> Result<(), cable_robot_import::CosimError> {
        if time - self.time > self.longest_step {
            let measured = time - self.period;
            self.instance.do_step(self.time, measured - self.time)?;
            self.time = measured;
        }
        controller::write_inputs(inputs, &mut self.values);
        self.give()?;
        self.instance.do_step(self.time, time - self.time)?;
        self.time = time;
        for (reference, variable) in &self.outputs {
            self.values.put(*reference, self.instance.get(variable)?.as_f64());
        }
        Ok(())
    }
}

impl TensionController for FmuController {
    fn step(&mut self, time: f64, inputs: &ControllerInputs) -> Result<ControllerOutputs, ControllerFailure> {
        self.advance(time, inputs).map_err(|error| ControllerFailure { reason: error.to_string() })?;
        Ok(controller::outputs(&self.values))
    }
}

/// At home, not enabled.
fn at_rest(config: &Config) -> ControllerInputs {
    let Config { home, controller, .. } = config;
    ControllerInputs {
        encoder_pose: *home,
        cable_length: controller.rig().cables_at(home).length,
        measured_tension: PerCable::filled(CABLES, 0.0),
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

/// Value reference and number of a parameter of the rig file.
fn parameter_value(interface: &Interface, name: &str, parameter: &Parameter) -> Result<(u32, f64)> {
    let mut rows = interface.rows_with(Role::Parameter);
    let Some(row) = rows.find(|row| row.name == name) else {
        let known: Vec<_> = interface.rows_with(Role::Parameter).map(|row| row.name).collect();
        bail!("controller.parameters.{name}: the controller has {}", known.join(", "));
    };
    let number = match (row.kind, parameter) {
        (Kind::Boolean, Parameter::Boolean(flag)) => f64::from(u8::from(*flag)),
        (Kind::Float64 | Kind::Int32, Parameter::Number(number)) => *number,
        (Kind::Enumeration(kind), Parameter::Item(item)) => {
            let found = kind.numbered().find(|(_, known, _)| known == item);
            let known: Vec<_> = kind.numbered().map(|(_, known, _)| known).collect();
            let (number, ..) = found.with_context(|| {
                format!("controller.parameters.{name} = {item}: it is one of {}", known.join(", "))
            })?;
            f64::from(number)
        }
        _ => bail!("controller.parameters.{name} = {parameter:?}: it is a {}", row.kind.name()),
    };
    Ok((row.first, number))
}

/// Our value references and the FMU's variables, where it has one of the same name and role.
fn shared(instance: &Instance, interface: &Interface, role: Role) -> Result<Vec<(u32, Variable)>> {
    let theirs = match role {
        Role::Parameter => Causality::Parameter,
        Role::Input => Causality::Input,
        Role::Output => Causality::Output,
        Role::Independent => Causality::Independent,
    };
    let has = |name: &str| instance.description().variable(name).is_some_and(|v| v.causality == theirs);
    let ours = interface.scalars().filter(|scalar| scalar.row.causality == role);
    let both = ours.map(|scalar| (scalar.name(), scalar.reference)).filter(|(name, _)| has(name));
    both.map(|(name, reference)| Ok((reference, instance.variable(&name)?.clone()))).collect()
}

/// The number as a value of this type.
fn typed(kind: VariableType, number: f64) -> Value {
    match kind {
        VariableType::Float64 | VariableType::Float32 => Value::Float(number),
        VariableType::Boolean => Value::Bool(number != 0.0),
        _ => Value::Int(number as i64),
    }
}

#[cfg(test)]
mod tests {
    use cable_robot::plan::{Controller, Status};

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
        library.step(0.0, &at_rest(&config));
        for k in 0..200 {
            let time = 5.0 + f64::from(k) * fmu.period + 1e-4 * f64::from(k % 3);
            let inputs = inputs(1e-5 * f64::from(k % 7));
            library.step(before, &inputs);
            let (theirs, ours) = (fmu.step(time, &inputs).unwrap(), library.outputs());
            assert_eq!(theirs.motor_tension, ours.motor_tension, "cycle {k}");
            assert_eq!((theirs.set_point, theirs.status), (ours.set_point, ours.status), "cycle {k}");
            before = time;
        }
        assert_eq!(library.outputs().status, Status::Moving);
    }

    #[test]
    fn what_the_fmu_refuses_is_a_failure_that_says_why() {
        let mut fmu = FmuController::open(&config()).unwrap();
        let failure = fmu.step(1.0, &inputs(f64::NAN)).unwrap_err();
        assert!(failure.reason.contains("cableLength[1] = NaN"), "{failure}");
    }
}
