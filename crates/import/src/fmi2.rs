//! An instance of an FMI 2.0 FMU.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::ffi::{CString, c_char, c_int, c_void};
use std::sync::Arc;

use super::log::{LogSink, log_fmi2};
use super::slave::{Failure, Slave, present, succeed};
use super::{Status, Value, VariableType};
use cable_robot_bindings::fmi2::*;

type GetFn<T> = unsafe extern "C" fn(fmi2Component, *const fmi2ValueReference, usize, *mut T) -> fmi2Status;
type SetFn<T> = unsafe extern "C" fn(fmi2Component, *const fmi2ValueReference, usize, *const T) -> fmi2Status;

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

/// Owns the component, and all that the component points to.
pub(super) struct Slave2 {
    component: fmi2Component,
    /// Set when a call was fatal: nothing may be called any more, not even free.
    fatal: Cell<bool>,
    /// The FMU keeps a pointer to it.
    _log: Arc<LogSink>,
    /// FMI 2 keeps a pointer to it for the life of the component.
    _callbacks: Box<fmi2CallbackFunctions>,
    library: Arc<Fmi2Library>,
}

impl Slave2 {
    pub(super) fn new(
        library: Arc<Fmi2Library>,
        name: &CString,
        token: &CString,
        resources: &CString,
        log: Arc<LogSink>,
    ) -> Result<Self, Failure> {
        let instantiate = present(&library.fmi2Instantiate, "fmi2Instantiate")?;
        present(&library.fmi2FreeInstance, "fmi2FreeInstance")?;
        let callbacks = Box::new(fmi2CallbackFunctions {
            // SAFETY: the FMU calls the logger as variadic C. Where this runs (x86-64 and AArch64 Linux), the five named
            // arguments of a variadic call lie in the same registers as those of a plain one; the rest is ignored.
            logger: Some(unsafe { std::mem::transmute::<PlainLogger, VariadicLogger>(log_fmi2) }),
            allocateMemory: Some(calloc),
            freeMemory: Some(free),
            stepFinished: None,
            componentEnvironment: log.environment(),
        });
        // SAFETY: the strings live during the call; callbacks and sink live, boxed, as long as the component.
        let component = unsafe {
            instantiate(
                name.as_ptr(),
                fmi2Type_fmi2CoSimulation,
                token.as_ptr(),
                resources.as_ptr(),
                &raw const *callbacks,
                fmi2False as fmi2Boolean,
                fmi2True as fmi2Boolean,
            )
        };
        if component.is_null() {
            return Err(Failure::NoInstance);
        }
        Ok(Self { component, fatal: Cell::new(false), _log: log, _callbacks: callbacks, library })
    }

    /// Turns the code into a result, and remembers that the component is lost.
    fn check(&self, function: &'static str, code: fmi2Status) -> Result<(), Failure> {
        self.fatal.set(self.fatal.get() || Status::from(code) == Status::Fatal);
        succeed(function, code)
    }

    /// The function, unless an earlier call was fatal.
    fn call<F: Copy>(
        &self,
        function: &Result<F, libloading::Error>,
        name: &'static str,
    ) -> Result<F, Failure> {
        if self.fatal.get() {
            Err(Failure::Status(name.into(), Status::Fatal))
        } else {
            present(function, name)
        }
    }

    fn read<T: Default>(
        &self,
        function: &Result<GetFn<T>, libloading::Error>,
        name: &'static str,
        reference: u32,
    ) -> Result<T, Failure> {
        let function = self.call(function, name)?;
        let mut value = T::default();
        // SAFETY: the component is alive; one reference, one value.
        let code = unsafe { function(self.component, &raw const reference, 1, &raw mut value) };
        self.check(name, code)?;
        Ok(value)
    }

    fn write<T>(
        &self,
        function: &Result<SetFn<T>, libloading::Error>,
        name: &'static str,
        reference: u32,
        value: T,
    ) -> Result<(), Failure> {
        let function = self.call(function, name)?;
        // SAFETY: the component is alive; one reference, one value.
        let code = unsafe { function(self.component, &raw const reference, 1, &raw const value) };
        self.check(name, code)
    }

    /// Calls a function that takes nothing but the component.
    fn plain(
        &self,
        function: &Result<unsafe extern "C" fn(fmi2Component) -> fmi2Status, libloading::Error>,
        name: &'static str,
    ) -> Result<(), Failure> {
        let function = self.call(function, name)?;
        // SAFETY: the component is alive.
        self.check(name, unsafe { function(self.component) })
    }
}

type PlainLogger = unsafe extern "C" fn(*mut c_void, *const c_char, fmi2Status, *const c_char, *const c_char);
type VariadicLogger =
    unsafe extern "C" fn(*mut c_void, *const c_char, fmi2Status, *const c_char, *const c_char, ...);

impl Slave for Slave2 {
    fn get(&self, kind: VariableType, reference: u32) -> Result<Value, Failure> {
        let library = &self.library;
        match kind {
            VariableType::Float64 => {
                self.read(&library.fmi2GetReal, "fmi2GetReal", reference).map(Value::Float)
            }
            VariableType::Int32 | VariableType::Enumeration => self
                .read::<c_int>(&library.fmi2GetInteger, "fmi2GetInteger", reference)
                .map(|v| Value::Int(i64::from(v))),
            VariableType::Boolean => self
                .read::<fmi2Boolean>(&library.fmi2GetBoolean, "fmi2GetBoolean", reference)
                .map(|v| Value::Bool(v != 0)),
            _ => Err(Failure::Type),
        }
    }

    fn set(&self, kind: VariableType, reference: u32, value: Value) -> Result<(), Failure> {
        let library = &self.library;
        match (kind, value) {
            (VariableType::Float64, Value::Float(v)) => {
                self.write(&library.fmi2SetReal, "fmi2SetReal", reference, v)
            }
            (VariableType::Int32 | VariableType::Enumeration, Value::Int(v)) => {
                let v = c_int::try_from(v).map_err(|_| Failure::Type)?;
                self.write(&library.fmi2SetInteger, "fmi2SetInteger", reference, v)
            }
            (VariableType::Boolean, Value::Bool(v)) => {
                self.write(&library.fmi2SetBoolean, "fmi2SetBoolean", reference, fmi2Boolean::from(v))
            }
            _ => Err(Failure::Type),
        }
    }

    fn set_logging(&self, on: bool) -> Result<(), Failure> {
        let set = self.call(&self.library.fmi2SetDebugLogging, "fmi2SetDebugLogging")?;
        let on = fmi2Boolean::from(on);
        // SAFETY: the component is alive; no categories are named, which means all.
        self.check("fmi2SetDebugLogging", unsafe { set(self.component, on, 0, std::ptr::null()) })
    }

    fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        let name = "fmi2SetupExperiment";
        let setup = self.call(&self.library.fmi2SetupExperiment, name)?;
        let (defined, stop) = (fmi2Boolean::from(stop.is_some()), stop.unwrap_or(0.0));
        // SAFETY: the component is alive.
        self.check(name, unsafe { setup(self.component, 0, 0.0, start, defined, stop) })?;
        self.plain(&self.library.fmi2EnterInitializationMode, "fmi2EnterInitializationMode")
    }

    fn exit_initialization(&self) -> Result<(), Failure> {
        self.plain(&self.library.fmi2ExitInitializationMode, "fmi2ExitInitializationMode")
    }

    fn do_step(&self, time: f64, step: f64) -> Result<(), Failure> {
        let do_step = self.call(&self.library.fmi2DoStep, "fmi2DoStep")?;
        // States may be put back at any time, hence false for noSetFMUStatePriorToCurrentPoint.
        // SAFETY: the component is alive.
        let code = unsafe { do_step(self.component, time, step, fmi2False as fmi2Boolean) };
        if Status::from(code) == Status::Discard && self.wants_to_end() {
            return Err(Failure::Terminate);
        }
        self.check("fmi2DoStep", code)
    }

    fn terminate(&self) -> Result<(), Failure> {
        self.plain(&self.library.fmi2Terminate, "fmi2Terminate")
    }

    fn get_state(&self) -> Result<*mut c_void, Failure> {
        let get = self.call(&self.library.fmi2GetFMUstate, "fmi2GetFMUstate")?;
        let mut state = std::ptr::null_mut();
        // SAFETY: the component is alive; null asks for a new state.
        self.check("fmi2GetFMUstate", unsafe { get(self.component, &raw mut state) })?;
        Ok(state)
    }

    fn set_state(&self, state: *mut c_void) -> Result<(), Failure> {
        let set = self.call(&self.library.fmi2SetFMUstate, "fmi2SetFMUstate")?;
        // SAFETY: the component is alive, the state is its own.
        self.check("fmi2SetFMUstate", unsafe { set(self.component, state) })
    }

    fn free_state(&self, mut state: *mut c_void) {
        if let Ok(free) = self.call(&self.library.fmi2FreeFMUstate, "fmi2FreeFMUstate") {
            // SAFETY: the component is alive, the state is its own and is not used after.
            let _ = unsafe { free(self.component, &raw mut state) };
        }
    }

    fn serialize(&self, state: *mut c_void) -> Result<Vec<u8>, Failure> {
        let size_of = self.call(&self.library.fmi2SerializedFMUstateSize, "fmi2SerializedFMUstateSize")?;
        let serialize = self.call(&self.library.fmi2SerializeFMUstate, "fmi2SerializeFMUstate")?;
        let mut size = 0;
        // SAFETY: the component is alive, the state is its own.
        self.check("fmi2SerializedFMUstateSize", unsafe { size_of(self.component, state, &raw mut size) })?;
        let mut bytes = vec![0u8; size];
        // SAFETY: as above; the buffer has the size asked for.
        let code = unsafe { serialize(self.component, state, bytes.as_mut_ptr().cast(), size) };
        self.check("fmi2SerializeFMUstate", code)?;
        Ok(bytes)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, Failure> {
        let name = "fmi2DeSerializeFMUstate";
        let deserialize = self.call(&self.library.fmi2DeSerializeFMUstate, name)?;
        let mut state = std::ptr::null_mut();
        // SAFETY: the component is alive; the buffer is as long as said; null asks for a new state.
        let code = unsafe { deserialize(self.component, bytes.as_ptr().cast(), bytes.len(), &raw mut state) };
        self.check(name, code)?;
        Ok(state)
    }
}

impl Slave2 {
    /// Whether a discarded step means that the FMU asks for the end.
    fn wants_to_end(&self) -> bool {
        let Ok(status) = self.call(&self.library.fmi2GetBooleanStatus, "fmi2GetBooleanStatus") else {
            return false;
        };
        let mut terminated = 0;
        // SAFETY: the component is alive.
        let code = unsafe { status(self.component, fmi2StatusKind_fmi2Terminated, &raw mut terminated) };
        Status::from(code) == Status::Ok && terminated != 0
    }
}

impl Drop for Slave2 {
    fn drop(&mut self) {
        if let Ok(free) = self.call(&self.library.fmi2FreeInstance, "fmi2FreeInstance") {
            // SAFETY: the component is alive and is not used after.
            unsafe { free(self.component) };
        }
    }
}
