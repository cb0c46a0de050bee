//! An instance of an FMI 3.0 FMU.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::ffi::{CString, c_void};
use std::sync::Arc;

use super::log::{LogSink, log_fmi3};
use super::slave::{Failure, Slave, present, succeed};
use super::{Status, Value, VariableType};
use cable_robot_bindings::fmi3::*;

type GetFn<T> =
    unsafe extern "C" fn(fmi3Instance, *const fmi3ValueReference, usize, *mut T, usize) -> fmi3Status;
type SetFn<T> =
    unsafe extern "C" fn(fmi3Instance, *const fmi3ValueReference, usize, *const T, usize) -> fmi3Status;

/// Owns the instance, and all that the instance points to.
pub(super) struct Slave3 {
    instance: fmi3Instance,
    /// Set when a call was fatal: nothing may be called any more, not even free.
    fatal: Cell<bool>,
    /// The FMU keeps a pointer to it.
    _log: Arc<LogSink>,
    library: Arc<Fmi3Library>,
}

impl Slave3 {
    pub(super) fn new(
        library: Arc<Fmi3Library>,
        name: &CString,
        token: &CString,
        resources: &CString,
        log: Arc<LogSink>,
    ) -> Result<Self, Failure> {
        let instantiate = present(&library.fmi3InstantiateCoSimulation, "fmi3InstantiateCoSimulation")?;
        present(&library.fmi3FreeInstance, "fmi3FreeInstance")?;
        // SAFETY: the strings live during the call; the sink lives, boxed, as long as the instance.
        let instance = unsafe {
            instantiate(
                name.as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false, // visible
                true,  // loggingOn
                false, // eventModeUsed
                false, // earlyReturnAllowed
                std::ptr::null(),
                0,
                log.environment(),
                Some(log_fmi3),
                None,
            )
        };
        if instance.is_null() {
            return Err(Failure::NoInstance);
        }
        Ok(Self { instance, fatal: Cell::new(false), _log: log, library })
    }

    /// Turns the code into a result, and remembers that the instance is lost.
    fn check(&self, function: &'static str, code: fmi3Status) -> Result<(), Failure> {
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
        // SAFETY: the instance is alive; one reference, one value.
        let code = unsafe { function(self.instance, &raw const reference, 1, &raw mut value, 1) };
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
        // SAFETY: the instance is alive; one reference, one value.
        let code = unsafe { function(self.instance, &raw const reference, 1, &raw const value, 1) };
        self.check(name, code)
    }

    fn get_int(&self, kind: VariableType, reference: u32) -> Result<i64, Failure> {
        let library = &self.library;
        Ok(match kind {
            VariableType::Int8 => self.read(&library.fmi3GetInt8, "fmi3GetInt8", reference)?.into(),
            VariableType::UInt8 => self.read(&library.fmi3GetUInt8, "fmi3GetUInt8", reference)?.into(),
            VariableType::Int16 => self.read(&library.fmi3GetInt16, "fmi3GetInt16", reference)?.into(),
            VariableType::UInt16 => self.read(&library.fmi3GetUInt16, "fmi3GetUInt16", reference)?.into(),
            VariableType::Int32 => self.read(&library.fmi3GetInt32, "fmi3GetInt32", reference)?.into(),
            VariableType::UInt32 => self.read(&library.fmi3GetUInt32, "fmi3GetUInt32", reference)?.into(),
            VariableType::Int64 | VariableType::Enumeration => {
                self.read(&library.fmi3GetInt64, "fmi3GetInt64", reference)?
            }
            VariableType::UInt64 => {
                let value = self.read(&library.fmi3GetUInt64, "fmi3GetUInt64", reference)?;
                i64::try_from(value).map_err(|_| Failure::Type)?
            }
            _ => return Err(Failure::Type),
        })
    }

    fn set_int(&self, kind: VariableType, reference: u32, value: i64) -> Result<(), Failure> {
        let library = &self.library;
        match kind {
            VariableType::Int8 => self.write(&library.fmi3SetInt8, "fmi3SetInt8", reference, narrow(value)?),
            VariableType::UInt8 => {
                self.write(&library.fmi3SetUInt8, "fmi3SetUInt8", reference, narrow(value)?)
            }
            VariableType::Int16 => {
                self.write(&library.fmi3SetInt16, "fmi3SetInt16", reference, narrow(value)?)
            }
            VariableType::UInt16 => {
                self.write(&library.fmi3SetUInt16, "fmi3SetUInt16", reference, narrow(value)?)
            }
            VariableType::Int32 => {
                self.write(&library.fmi3SetInt32, "fmi3SetInt32", reference, narrow(value)?)
            }
            VariableType::UInt32 => {
                self.write(&library.fmi3SetUInt32, "fmi3SetUInt32", reference, narrow(value)?)
            }
            VariableType::Int64 | VariableType::Enumeration => {
                self.write(&library.fmi3SetInt64, "fmi3SetInt64", reference, value)
            }
            VariableType::UInt64 => {
                self.write(&library.fmi3SetUInt64, "fmi3SetUInt64", reference, narrow(value)?)
            }
            _ => Err(Failure::Type),
        }
    }

    /// Calls a function that takes nothing but the instance.
    fn plain(
        &self,
        function: &Result<unsafe extern "C" fn(fmi3Instance) -> fmi3Status, libloading::Error>,
        name: &'static str,
    ) -> Result<(), Failure> {
        let function = self.call(function, name)?;
        // SAFETY: the instance is alive.
        self.check(name, unsafe { function(self.instance) })
    }
}

fn narrow<T: TryFrom<i64>>(value: i64) -> Result<T, Failure> {
    T::try_from(value).map_err(|_| Failure::Type)
}

impl Slave for Slave3 {
    fn get(&self, kind: VariableType, reference: u32) -> Result<Value, Failure> {
        let library = &self.library;
        match kind {
            VariableType::Float64 => {
                self.read(&library.fmi3GetFloat64, "fmi3GetFloat64", reference).map(Value::Float)
            }
            VariableType::Float32 => self
                .read::<f32>(&library.fmi3GetFloat32, "fmi3GetFloat32", reference)
                .map(|v| Value::Float(v.into())),
            VariableType::Boolean => {
                self.read(&library.fmi3GetBoolean, "fmi3GetBoolean", reference).map(Value::Bool)
            }
            _ => self.get_int(kind, reference).map(Value::Int),
        }
    }

    fn set(&self, kind: VariableType, reference: u32, value: Value) -> Result<(), Failure> {
        let library = &self.library;
        match (kind, value) {
            (VariableType::Float64, Value::Float(v)) => {
                self.write(&library.fmi3SetFloat64, "fmi3SetFloat64", reference, v)
            }
            (VariableType::Float32, Value::Float(v)) => {
                self.write(&library.fmi3SetFloat32, "fmi3SetFloat32", reference, v as f32)
            }
            (VariableType::Boolean, Value::Bool(v)) => {
                self.write(&library.fmi3SetBoolean, "fmi3SetBoolean", reference, v)
            }
            (_, Value::Int(v)) => self.set_int(kind, reference, v),
            _ => Err(Failure::Type),
        }
    }

    fn set_logging(&self, on: bool) -> Result<(), Failure> {
        let set = self.call(&self.library.fmi3SetDebugLogging, "fmi3SetDebugLogging")?;
        // SAFETY: the instance is alive; no categories are named, which means all.
        self.check("fmi3SetDebugLogging", unsafe { set(self.instance, on, 0, std::ptr::null()) })
    }

    fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        let name = "fmi3EnterInitializationMode";
        let enter = self.call(&self.library.fmi3EnterInitializationMode, name)?;
        // SAFETY: the instance is alive.
        let code = unsafe { enter(self.instance, false, 0.0, start, stop.is_some(), stop.unwrap_or(0.0)) };
        self.check(name, code)
    }

    fn exit_initialization(&self) -> Result<(), Failure> {
        self.plain(&self.library.fmi3ExitInitializationMode, "fmi3ExitInitializationMode")
    }

    fn do_step(&self, time: f64, step: f64) -> Result<(), Failure> {
        let do_step = self.call(&self.library.fmi3DoStep, "fmi3DoStep")?;
        let (mut event, mut terminate, mut early, mut last) = (false, false, false, time);
        // States may be put back at any time, hence false for noSetFMUStatePriorToCurrentPoint.
        // SAFETY: the instance is alive; the four results are valid.
        let code = unsafe {
            do_step(
                self.instance,
                time,
                step,
                false,
                &raw mut event,
                &raw mut terminate,
                &raw mut early,
                &raw mut last,
            )
        };
        self.check("fmi3DoStep", code)?;
        if terminate { Err(Failure::Terminate) } else { Ok(()) }
    }

    fn terminate(&self) -> Result<(), Failure> {
        self.plain(&self.library.fmi3Terminate, "fmi3Terminate")
    }

    fn get_state(&self) -> Result<*mut c_void, Failure> {
        let get = self.call(&self.library.fmi3GetFMUState, "fmi3GetFMUState")?;
        let mut state = std::ptr::null_mut();
        // SAFETY: the instance is alive; null asks for a new state.
        self.check("fmi3GetFMUState", unsafe { get(self.instance, &raw mut state) })?;
        Ok(state)
    }

    fn set_state(&self, state: *mut c_void) -> Result<(), Failure> {
        let set = self.call(&self.library.fmi3SetFMUState, "fmi3SetFMUState")?;
        // SAFETY: the instance is alive, the state is its own.
        self.check("fmi3SetFMUState", unsafe { set(self.instance, state) })
    }

    fn free_state(&self, mut state: *mut c_void) {
        if let Ok(free) = self.call(&self.library.fmi3FreeFMUState, "fmi3FreeFMUState") {
            // SAFETY: the instance is alive, the state is its own and is not used after.
            let _ = unsafe { free(self.instance, &raw mut state) };
        }
    }

    fn serialize(&self, state: *mut c_void) -> Result<Vec<u8>, Failure> {
        let size_of = self.call(&self.library.fmi3SerializedFMUStateSize, "fmi3SerializedFMUStateSize")?;
        let serialize = self.call(&self.library.fmi3SerializeFMUState, "fmi3SerializeFMUState")?;
        let mut size = 0;
        // SAFETY: the instance is alive, the state is its own.
        self.check("fmi3SerializedFMUStateSize", unsafe { size_of(self.instance, state, &raw mut size) })?;
        let mut bytes = vec![0u8; size];
        // SAFETY: as above; the buffer has the size asked for.
        let code = unsafe { serialize(self.instance, state, bytes.as_mut_ptr(), size) };
        self.check("fmi3SerializeFMUState", code)?;
        Ok(bytes)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, Failure> {
        let name = "fmi3DeserializeFMUState";
        let deserialize = self.call(&self.library.fmi3DeserializeFMUState, name)?;
        let mut state = std::ptr::null_mut();
        // SAFETY: the instance is alive; the buffer is as long as said; null asks for a new state.
        let code = unsafe { deserialize(self.instance, bytes.as_ptr(), bytes.len(), &raw mut state) };
        self.check(name, code)?;
        Ok(state)
    }
}

impl Drop for Slave3 {
    fn drop(&mut self) {
        if let Ok(free) = self.call(&self.library.fmi3FreeInstance, "fmi3FreeInstance") {
            // SAFETY: the instance is alive and is not used after.
            unsafe { free(self.instance) };
        }
    }
}
