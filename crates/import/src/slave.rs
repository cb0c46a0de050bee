//! What FMI 2.0 and 3.0 have in common: the few calls that a co-simulation needs.

use std::borrow::Cow;
use std::ffi::c_void;

use serde::{Deserialize, Serialize};

use super::{Lost, Status, Value, Variable, VariableType};

/// Why a call failed, before the instance adds its name and what it tried.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Failure {
    /// The binary lacks the function.
    Missing(Cow<'static, str>),
    /// The function returned no success.
    Status(Cow<'static, str>, Status),
    /// This importer does not move values of this type, or the value is none of it.
    Type,
    /// The FMU wants the simulation to end.
    Terminate,
    /// The FMU could not be instantiated.
    NoInstance,
    /// The dynamic linker refused the binary.
    Library(String),
    /// Its process is no more.
    #[serde(skip)]
    #[cfg_attr(not(unix), expect(dead_code, reason = "there FMUs run in this process"))]
    Lost(Lost),
}

/// An instance inside a loaded FMU. Its implementations own it and free it when dropped.
pub(super) trait Slave {
    fn get(&self, kind: VariableType, reference: u32) -> Result<Value, Failure>;
    fn set(&self, kind: VariableType, reference: u32, value: Value) -> Result<(), Failure>;
    /// As `get` of one after the other; which of them failed, if one did.
    fn get_all(&self, variables: &[Variable], values: &mut [Value]) -> Result<(), (usize, Failure)> {
        for (k, (variable, value)) in variables.iter().zip(values).enumerate() {
            *value = self.get(variable.kind, variable.reference).map_err(|failure| (k, failure))?;
        }
        Ok(())
    }
    /// As `set` of one after the other; which of them failed, if one did.
    fn set_all(&self, variables: &[Variable], values: &[Value]) -> Result<(), (usize, Failure)> {
        let mut pairs = variables.iter().zip(values).enumerate();
        pairs.try_for_each(|(k, (variable, value))| {
            self.set(variable.kind, variable.reference, *value).map_err(|failure| (k, failure))
        })
    }
    /// Whether it sends remarks; why a call failed is told in any case.
    fn set_logging(&self, on: bool) -> Result<(), Failure>;
    fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Result<(), Failure>;
    fn exit_initialization(&self) -> Result<(), Failure>;
    fn do_step(&self, time: f64, step: f64) -> Result<(), Failure>;
    fn terminate(&self) -> Result<(), Failure>;
    /// A copy of the state, owned by the FMU until `free_state`.
    fn get_state(&self) -> Result<*mut c_void, Failure>;
    fn set_state(&self, state: *mut c_void) -> Result<(), Failure>;
    fn free_state(&self, state: *mut c_void);
    fn serialize(&self, state: *mut c_void) -> Result<Vec<u8>, Failure>;
    fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, Failure>;
}

/// The function, if the binary has it.
pub(super) fn present<F: Copy>(
    function: &Result<F, libloading::Error>,
    name: &'static str,
) -> Result<F, Failure> {
    function.as_ref().copied().map_err(|_| Failure::Missing(name.into()))
}

/// Success if the status is OK or a warning.
pub(super) fn succeed(function: &'static str, code: u32) -> Result<(), Failure> {
    match Status::from(code) {
        Status::Ok | Status::Warning => Ok(()),
        status => Err(Failure::Status(function.into(), status)),
    }
}
