//! A controller or plant that is an FMU: in the closed loop of `cable-robot simulate`, and between the motors of `can-bridge`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, PoseSource};
use cable_robot::robot::{RigFile, Shape};
use cable_robot::sim::{ControllerModel, ModelError, PlantInputs, PlantModel, PlantOutputs};
use cable_robot_fmi::models::{controller, plant};
use cable_robot_fmi::values::Values;
use cable_robot_fmi::variables::Causality as Role;
use cable_robot_fmi::{Interface, Model};
use cable_robot_import::{Causality, FmiVersion, Fmu, Instance, LogCallback, Value, Variable, VariableType};
use cable_robot_report::{recording::column, run_folder};

/// An FMU in the place of ours. Its variables are found by the names of ours; what it lacks is left out. After its initialization a step
/// allocates nothing here.
pub struct FmuModel {
    path: PathBuf,
    instance: Instance,
    interface: Interface,
    inputs: Group,
    outputs: Group,
    values: Values,
    phase: Phase,
}

/// Variables that are moved together, and room for their values.
struct Group {
    /// Of ours.
    references: Vec<u32>,
    variables: Vec<Variable>,
    values: Vec<Value>,
}

impl Group {
    fn new(shared: Vec<(u32, Variable)>) -> Self {
        let (references, variables): (Vec<_>, Vec<_>) = shared.into_iter().unzip();
        let values = vec![Value::Bool(false); variables.len()];
        Self { references, variables, values }
    }
}

#[derive(PartialEq)]
enum Phase {
    Instantiated,
    Initialization,
    Stepping,
}

impl FmuModel {
    /// Opens the file, for this rig, and loads it into this process. Which of the two models it stands for its variables tell; what it has to
    /// say goes to `log`.
    ///
    /// # Errors
    /// A file that is no FMU for this machine, is neither model, or has another number of cables than the rig.
    pub fn open(path: &Path, rig: &RigFile, log: LogCallback) -> Result<Self> {
        Self::of(&Fmu::open(path)?, path, rig, log)
    }

    /// The same of a file that is open already, in this process or apart.
    ///
    /// # Errors
    /// As [`FmuModel::open`].
    pub fn of(fmu: &Fmu, path: &Path, rig: &RigFile, log: LogCallback) -> Result<Self> {
        let motor = fmu.description().variable("motorTension[1]").map(|variable| variable.causality);
        let (model, name) = match motor {
            Some(Causality::Output) => (Model::Controller, "controller"),
            Some(Causality::Input) => (Model::Plant, "plant"),
            _ => bail!(
                "{} is neither controller nor plant: a controller has the scalar outputs motorTension[1] to \
                 motorTension[n], a plant has them as inputs",
                path.display()
            ),
        };
        let cables = rig.rig.cables.len();
        let beyond = fmu.description().variable(&format!("motorTension[{}]", cables + 1));
        ensure!(beyond.is_none(), "{} has more cables than the rig, which has {cables}", path.display());
        let instance = fmu.instantiate(name, log)?;
        let interface = interface(model, fmu, rig);
        let values = interface.start().clone();
        let inputs = Group::new(shared(&instance, &interface, Role::Input)?);
        let outputs = Group::new(shared(&instance, &interface, Role::Output)?);
        let path = path.to_owned();
        Ok(Self { path, instance, interface, inputs, outputs, values, phase: Phase::Instantiated })
    }

    /// Sets its parameters to what `write` makes of ours.
    ///
    /// # Errors
    /// Those of `write`, and what the FMU refuses.
    pub fn set_parameters(
        &mut self,
        write: impl FnOnce(&Interface, &mut Values) -> Result<()>,
    ) -> Result<()> {
        write(&self.interface, &mut self.values)?;
        for (reference, variable) in shared(&self.instance, &self.interface, Role::Parameter)? {
            self.instance.set(&variable, typed(variable.kind, self.values.at(reference)))?;
        }
        Ok(())
    }

    /// What our variables of its kind are called, and what they hold.
    pub fn values(&self) -> (&Interface, &Values) {
        (&self.interface, &self.values)
    }

    /// Which of the two it stands for.
    pub fn model(&self) -> Model {
        self.interface.model()
    }

    /// For `run.json`.
    pub fn info(&self) -> run_folder::Model {
        let description = self.instance.description();
        let fmi_version = match description.version {
            FmiVersion::V2 => "2.0",
            FmiVersion::V3 => "3.0",
        };
        run_folder::Model::Fmu {
            path: self.path.clone(),
            name: description.model_name.clone(),
            fmi_version: fmi_version.to_owned(),
        }
    }

    /// Columns of a run that it cannot fill.
    pub fn lacking(&self) -> Vec<String> {
        let own = |reference: u32| self.outputs.references.contains(&reference);
        let missing = scalars(&self.interface, Role::Output).filter(|(_, reference)| !own(*reference));
        missing.map(|(name, _)| column(self.model(), &name)).collect()
    }

    /// Without these there is no loop: motors and pose, and what the controller's settings say it reads besides.
    ///
    /// # Errors
    /// The first that it lacks.
    pub fn require_essentials(&self, controller: &ControllerParameters) -> Result<()> {
        if self.model() == Model::Controller {
            return self.require(Role::Output, &["motorTension"]);
        }
        self.require(Role::Input, &["motorTension"])?;
        let mut outputs = vec!["encoderPose"];
        outputs.extend((controller.pose_source == PoseSource::CableLengths).then_some("cableLength"));
        outputs.extend(controller.force_loop.then_some("measuredTension"));
        self.require(Role::Output, &outputs)
    }

    /// Whether it has all our variables in this role that begin with one of these names.
    ///
    /// # Errors
    /// The first that it lacks.
    pub fn require(&self, role: Role, names: &[&str]) -> Result<()> {
        let have = shared(&self.instance, &self.interface, role)?;
        let needed = scalars(&self.interface, role)
            .filter(|(name, _)| names.iter().any(|start| name.starts_with(start)));
        for (name, reference) in needed {
            let has = have.iter().any(|(known, _)| *known == reference);
            let (path, model) = (self.path.display(), self.instance.name());
            ensure!(has, "{path}: a {model} needs the {} {name}", role.name());
        }
        Ok(())
    }

    /// Sets the inputs.
    fn give(&mut self) -> Result<(), ModelError> {
        let Group { references, variables, values } = &mut self.inputs;
        for ((value, reference), variable) in values.iter_mut().zip(&*references).zip(&*variables) {
            *value = typed(variable.kind, self.values.at(*reference));
        }
        Ok(self.instance.set_all(variables, values)?)
    }

    /// Reads the outputs.
    fn take(&mut self) -> Result<(), ModelError> {
        let Group { references, variables, values } = &mut self.outputs;
        self.instance.get_all(variables, values)?;
        for (reference, value) in references.iter().zip(&*values) {
            self.values.put(*reference, value.as_f64());
        }
        Ok(())
    }

    /// Its initialization ends; from now on it only steps, and logs no remarks any more: they cost memory, and errors are told all the same.
    ///
    /// # Errors
    /// What the FMU refuses.
    pub fn begin(&mut self) -> Result<(), ModelError> {
        self.instance.exit_initialization()?;
        self.instance.set_logging(false)?;
        self.phase = Phase::Stepping;
        Ok(())
    }

    fn start(&mut self) -> Result<(), ModelError> {
        if self.phase == Phase::Instantiated {
            self.instance.enter_initialization(0.0, None)?;
            self.phase = Phase::Initialization;
        }
        self.give()?;
        self.take()
    }

    fn step(&mut self, time: f64, h: f64) -> Result<(), ModelError> {
        if self.phase == Phase::Initialization {
            self.instance.exit_initialization()?;
            self.phase = Phase::Stepping;
        }
        self.give()?;
        self.instance.do_step(time, h)?;
        self.take()
    }
}

impl ControllerModel for FmuModel {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        controller::write_inputs(inputs, &mut self.values);
        self.start()?;
        Ok(controller::outputs(&self.values))
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        controller::write_inputs(inputs, &mut self.values);
        self.step(time, h)?;
        Ok(controller::outputs(&self.values))
    }
}

impl PlantModel for FmuModel {
    fn start(&mut self, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        plant::write_inputs(inputs, &mut self.values);
        self.start()?;
        Ok(plant::outputs(&self.values))
    }

    fn step(&mut self, time: f64, h: f64, inputs: &PlantInputs) -> Result<PlantOutputs, ModelError> {
        plant::write_inputs(inputs, &mut self.values);
        self.step(time, h)?;
        Ok(plant::outputs(&self.values))
    }
}

impl Drop for FmuModel {
    fn drop(&mut self) {
        if self.phase == Phase::Stepping {
            // An FMU that does not end in order is freed all the same.
            let _ = self.instance.terminate();
        }
    }
}

/// Names and value references of our variables in a role.
fn scalars(interface: &Interface, role: Role) -> impl Iterator<Item = (String, u32)> {
    let in_role = interface.scalars().filter(move |scalar| scalar.row.causality == role);
    in_role.map(|scalar| (scalar.name(), scalar.reference))
}

/// Which names to look for: those of the paper's rig, where it is that and the FMU does not have the cables one by one.
fn interface(model: Model, fmu: &Fmu, rig: &RigFile) -> Interface {
    let is_paper = Shape::of(&rig.rig).is_ok_and(|shape| shape.is_in_place());
    if is_paper && fmu.description().variable("anchor[1].x").is_none() {
        return model.interface();
    }
    Interface::of_rig(model, rig)
}

/// Our value references and the FMU's variables, where it has one of the same name and role.
fn shared(instance: &Instance, interface: &Interface, role: Role) -> Result<Vec<(u32, Variable)>> {
    let theirs = match role {
        Role::Parameter => Causality::Parameter,
        Role::Structural => Causality::StructuralParameter,
        Role::Input => Causality::Input,
        Role::Output => Causality::Output,
        Role::Local => Causality::Local,
        Role::Independent => Causality::Independent,
    };
    let has = |name: &str| instance.description().variable(name).is_some_and(|v| v.causality == theirs);
    let both = scalars(interface, role).filter(|(name, _)| has(name));
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
