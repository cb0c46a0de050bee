//! One instance of an FMU, safe to use: variables by name and type, errors with names, freed when dropped.

use std::ffi::c_void;
use std::rc::Rc;
use std::sync::Arc;

use super::log::LogSink;
use super::slave::{Failure, Slave};
use super::{CosimError, Fmu, ModelDescription, Value, Variable, VariableType};

/// A running instance: a handle, as a file is. The order of calls is the standard's: parameters, then
/// [`enter_initialization`](Self::enter_initialization), inputs, [`exit_initialization`](Self::exit_initialization),
/// steps, [`terminate`](Self::terminate). What the FMU refuses comes back as an error with the reason it logged.
pub struct Instance {
    name: String,
    // Freed before the FMU is unloaded.
    slave: Rc<dyn Slave>,
    log: Arc<LogSink>,
    fmu: Fmu,
}

/// A copy of an instance's whole state, which [`Instance::set_state`] puts back.
pub struct State {
    slave: Rc<dyn Slave>,
    raw: *mut c_void,
}

impl Drop for State {
    fn drop(&mut self) {
        self.slave.free_state(self.raw);
    }
}

impl Instance {
    pub(super) fn new(name: &str, fmu: Fmu, slave: Rc<dyn Slave>, log: Arc<LogSink>) -> Self {
        Self { name: name.to_owned(), slave, log, fmu }
    }

    /// The name given when it was instantiated.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What its FMU says of itself.
    pub fn description(&self) -> &ModelDescription {
        self.fmu.description()
    }

    /// The variable of this name, if this importer can move its values.
    ///
    /// # Errors
    /// [`CosimError::UnknownVariable`], [`CosimError::Unsupported`].
    pub fn variable(&self, name: &str) -> Result<&Variable, CosimError> {
        let Some(variable) = self.description().variable(name) else {
            return Err(CosimError::UnknownVariable {
                instance: self.name.clone(),
                variable: name.to_owned(),
            });
        };
        let kind = match variable.kind {
            VariableType::String | VariableType::Binary | VariableType::Clock => {
                format!("a {:?}", variable.kind)
            }
            _ if variable.array => "an array".to_owned(),
            _ => return Ok(variable),
        };
        Err(CosimError::Unsupported { instance: self.name.clone(), variable: name.to_owned(), kind })
    }

    /// Reads a variable.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses.
    pub fn get(&self, variable: &Variable) -> Result<Value, CosimError> {
        self.slave.get(variable.kind, variable.reference).map_err(|failure| self.unread(variable, failure))
    }

    /// Reads as many variables as there are `values`: with an FMU in a process of its own, one exchange instead of one each.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub fn get_all(&self, variables: &[Variable], values: &mut [Value]) -> Result<(), CosimError> {
        assert_eq!(variables.len(), values.len(), "a value for each variable");
        if variables.is_empty() {
            return Ok(());
        }
        self.slave.get_all(variables, values).map_err(|(k, failure)| self.unread(&variables[k], failure))
    }

    fn unread(&self, variable: &Variable, failure: Failure) -> CosimError {
        self.error(failure, || format!("reading {}", variable.name))
    }

    /// Writes a variable.
    ///
    /// # Errors
    /// [`CosimError::WrongType`]; [`CosimError::Call`] if the FMU refuses.
    pub fn set(&self, variable: &Variable, value: impl Into<Value>) -> Result<(), CosimError> {
        let value = value.into();
        let set = self.slave.set(variable.kind, variable.reference, value);
        set.map_err(|failure| self.unset(variable, value, failure))
    }

    /// Writes variables in the order given: with an FMU in a process of its own, one exchange instead of one each.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn set_all(&self, variables: &[Variable], values: &[Value]) -> Result<(), CosimError> {
        assert_eq!(variables.len(), values.len(), "a value for each variable");
        if variables.is_empty() {
            return Ok(());
        }
        let set = self.slave.set_all(variables, values);
        set.map_err(|(k, failure)| self.unset(&variables[k], values[k], failure))
    }

    fn unset(&self, variable: &Variable, value: Value, failure: Failure) -> CosimError {
        match failure {
            Failure::Type => CosimError::WrongType {
                instance: self.name.clone(),
                variable: variable.name.clone(),
                kind: variable.kind,
                value,
            },
            other => self.error(other, || format!("setting {} = {value}", variable.name)),
        }
    }

    /// Writes variables by name, in the order given; before initialisation that sets parameters and start values.
    ///
    /// # Errors
    /// As [`variable`](Self::variable) and [`set`](Self::set).
    pub fn set_parameters(&self, values: &[(&str, Value)]) -> Result<(), CosimError> {
        values.iter().try_for_each(|(name, value)| self.set(self.variable(name)?, *value))
    }

    /// Whether the FMU sends remarks, as it does from the start; why a call failed it tells in any case.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses.
    pub fn set_logging(&self, on: bool) -> Result<(), CosimError> {
        self.slave.set_logging(on).map_err(|f| self.error(f, || "setting what is logged".to_owned()))
    }

    /// Starts initialisation at time `start` (s), with or without a known end.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses.
    pub fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Result<(), CosimError> {
        self.slave
            .enter_initialization(start, stop)
            .map_err(|failure| self.error(failure, || format!("entering initialisation at {start} s")))
    }

    /// Ends initialisation.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses, for instance because of a parameter.
    pub fn exit_initialization(&self) -> Result<(), CosimError> {
        self.slave
            .exit_initialization()
            .map_err(|failure| self.error(failure, || "ending initialisation".to_owned()))
    }

    /// Steps from `time` by `step`, both in s.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses, [`CosimError::Terminated`] if it asks for the end.
    pub fn do_step(&self, time: f64, step: f64) -> Result<(), CosimError> {
        self.slave.do_step(time, step).map_err(|failure| match failure {
            Failure::Terminate => CosimError::Terminated { instance: self.name.clone(), time },
            other => self.error(other, || format!("the step from {time} s by {step} s")),
        })
    }

    /// Ends the simulation; outputs can still be read.
    ///
    /// # Errors
    /// [`CosimError::Call`] if the FMU refuses.
    pub fn terminate(&self) -> Result<(), CosimError> {
        self.slave.terminate().map_err(|failure| self.error(failure, || "terminating".to_owned()))
    }

    /// Copies the whole state.
    ///
    /// # Errors
    /// [`CosimError::NotOffered`]; [`CosimError::Call`] if the FMU refuses.
    pub fn state(&self) -> Result<State, CosimError> {
        self.offers(self.description().can_get_and_set_state, "canGetAndSetFMUState")?;
        let raw = self.slave.get_state().map_err(|f| self.error(f, || "copying the state".to_owned()))?;
        Ok(State { slave: Rc::clone(&self.slave), raw })
    }

    /// Puts a state back.
    ///
    /// # Errors
    /// [`CosimError::ForeignState`]; [`CosimError::Call`] if the FMU refuses.
    pub fn set_state(&self, state: &State) -> Result<(), CosimError> {
        self.owns(state)?;
        self.slave.set_state(state.raw).map_err(|f| self.error(f, || "putting a state back".to_owned()))
    }

    /// The state as bytes, which an instance of the same FMU in another process understands.
    ///
    /// # Errors
    /// [`CosimError::NotOffered`], [`CosimError::ForeignState`]; [`CosimError::Call`] if the FMU refuses.
    pub fn serialize(&self, state: &State) -> Result<Vec<u8>, CosimError> {
        self.offers(self.description().can_serialize_state, "canSerializeFMUState")?;
        self.owns(state)?;
        self.slave.serialize(state.raw).map_err(|f| self.error(f, || "serialising a state".to_owned()))
    }

    /// The state that these bytes stand for.
    ///
    /// # Errors
    /// [`CosimError::NotOffered`]; [`CosimError::Call`] if the FMU refuses the bytes.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<State, CosimError> {
        self.offers(self.description().can_serialize_state, "canSerializeFMUState")?;
        let raw = self
            .slave
            .deserialize(bytes)
            .map_err(|f| self.error(f, || format!("deserialising {} bytes of state", bytes.len())))?;
        Ok(State { slave: Rc::clone(&self.slave), raw })
    }

    fn offers(&self, offered: bool, capability: &'static str) -> Result<(), CosimError> {
        if offered { Ok(()) } else { Err(CosimError::NotOffered { instance: self.name.clone(), capability }) }
    }

    fn owns(&self, state: &State) -> Result<(), CosimError> {
        let own = Rc::ptr_eq(&self.slave, &state.slave);
        if own { Ok(()) } else { Err(CosimError::ForeignState { instance: self.name.clone() }) }
    }

    /// Adds the names, and what the FMU said.
    fn error(&self, failure: Failure, action: impl Fn() -> String) -> CosimError {
        let instance = self.name.clone();
        let said = self.log.take_complaints();
        match failure {
            Failure::Missing(function) => CosimError::MissingFunction { instance, function },
            Failure::Status(function, status) => {
                CosimError::Call { instance, action: action(), function, status, said }
            }
            // An FMI 2 `Float32`, say, which only a wrong description can bring about.
            Failure::Type => CosimError::Unsupported {
                instance,
                variable: action(),
                kind: "of a type that this version of FMI does not have".to_owned(),
            },
            Failure::Lost(how) => CosimError::Lost { instance, action: action(), how, said },
            Failure::Terminate | Failure::NoInstance | Failure::Library(_) => {
                CosimError::Instantiation { instance, said }
            }
        }
    }
}
