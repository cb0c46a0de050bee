//! One instance behind the C functions of either version, and what it has said.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use cable_robot_bindings::fmi2::{fmi2CallbackFunctions, fmi2CallbackLogger};
use cable_robot_fmi::abi::{fmi2::*, fmi3::*, fmi3_values::*};
use cable_robot_fmi::{Model, Use};

pub const OK: u32 = 0;
pub const WARNING: u32 = 1;
pub const DISCARD: u32 = 2;
pub const ERROR: u32 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fmi {
    Two,
    Three,
}
pub use Fmi::{Three, Two};

pub const BOTH: [Fmi; 2] = [Two, Three];

/// Status, category, text of each message.
pub type Messages = Mutex<Vec<(u32, String, String)>>;

pub struct Slave {
    pub fmi: Fmi,
    pub model: Model,
    pub instance: *mut c_void,
    pub messages: Box<Messages>,
}

unsafe extern "C" {
    fn snprintf(buffer: *mut c_char, size: usize, format: *const c_char, ...) -> i32;
}

/// The logger of a C importer: the message is a format string, and there are no further arguments.
unsafe extern "C" fn log_2(
    to: *mut c_void,
    _name: *const c_char,
    status: u32,
    category: *const c_char,
    format: *const c_char,
) {
    let mut buffer = [0; 4096];
    unsafe {
        snprintf(buffer.as_mut_ptr(), buffer.len(), format);
        log_3(to, status, category, buffer.as_ptr());
    }
}

pub unsafe extern "C" fn log_3(
    to: *mut c_void,
    status: u32,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned();
    let messages = unsafe { &*to.cast::<Messages>() };
    messages.lock().unwrap().push((status, text(category), text(message)));
}

/// Callbacks that write to `messages`.
pub fn callbacks(messages: &Messages) -> fmi2CallbackFunctions {
    type Fixed = unsafe extern "C" fn(*mut c_void, *const c_char, u32, *const c_char, *const c_char);
    // Rust cannot define variadic functions; one with the fixed arguments only is called the same way.
    let logger = unsafe { std::mem::transmute::<Option<Fixed>, fmi2CallbackLogger>(Some(log_2)) };
    let componentEnvironment = std::ptr::from_ref(messages).cast_mut().cast();
    fmi2CallbackFunctions {
        logger,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment,
    }
}

/// An instance, or NULL, of whatever model has `token`.
pub fn instantiate(fmi: Fmi, usage: Use, token: &str, logging: bool, messages: &Messages) -> *mut c_void {
    let token = CString::new(token).unwrap();
    let (name, place) = (c"test".as_ptr(), c"file:/tmp/with%20space/\xc3\xbc/resources".as_ptr());
    unsafe {
        let to = std::ptr::from_ref(messages).cast_mut().cast();
        match (fmi, usage) {
            (Two, usage) => {
                let kind = u32::from(usage == Use::CoSimulation);
                fmi2Instantiate(
                    name,
                    kind,
                    token.as_ptr(),
                    place,
                    &callbacks(messages),
                    0,
                    i32::from(logging),
                )
            }
            (Three, Use::ModelExchange) => {
                fmi3InstantiateModelExchange(name, token.as_ptr(), place, false, logging, to, Some(log_3))
            }
            (Three, Use::CoSimulation | Use::CoSimulationWithEvents | Use::OnBuses) => {
                fmi3InstantiateCoSimulation(
                    name,
                    token.as_ptr(),
                    place,
                    false,
                    logging,
                    false,
                    false,
                    null(),
                    0,
                    to,
                    Some(log_3),
                    None,
                )
            }
        }
    }
}

impl Slave {
    /// Instantiated, logging off.
    pub fn new(fmi: Fmi, model: Model) -> Self {
        Self::logging(fmi, model, false)
    }

    pub fn logging(fmi: Fmi, model: Model, on: bool) -> Self {
        let messages = Box::new(Messages::default());
        let instance = instantiate(fmi, model.usage(), model.interface().token(), on, &messages);
        assert!(!instance.is_null());
        Self { fmi, model, instance, messages }
    }

    /// In Step Mode at time 0.
    pub fn running(fmi: Fmi, model: Model) -> Self {
        let slave = Self::new(fmi, model);
        assert_eq!((slave.enter(0.0, None), slave.exit()), (OK, OK));
        slave
    }

    pub fn enter(&self, start: f64, stop: Option<f64>) -> u32 {
        let (defined, stop) = (stop.is_some(), stop.unwrap_or(0.0));
        unsafe {
            match self.fmi {
                Two => match fmi2SetupExperiment(self.instance, 0, 0.0, start, i32::from(defined), stop) {
                    OK => fmi2EnterInitializationMode(self.instance),
                    status => status,
                },
                Three => fmi3EnterInitializationMode(self.instance, false, 0.0, start, defined, stop),
            }
        }
    }

    pub fn exit(&self) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2ExitInitializationMode(self.instance),
                Three => fmi3ExitInitializationMode(self.instance),
            }
        }
    }

    pub fn step(&self, point: f64, h: f64) -> u32 {
        let (mut event, mut terminate, mut early, mut last) = (true, true, true, 0.0);
        unsafe {
            match self.fmi {
                Two => fmi2DoStep(self.instance, point, h, 1),
                Three => fmi3DoStep(
                    self.instance,
                    point,
                    h,
                    true,
                    &mut event,
                    &mut terminate,
                    &mut early,
                    &mut last,
                ),
            }
        }
    }

    pub fn terminate(&self) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2Terminate(self.instance),
                Three => fmi3Terminate(self.instance),
            }
        }
    }

    pub fn reset(&self) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2Reset(self.instance),
                Three => fmi3Reset(self.instance),
            }
        }
    }

    /// The value reference of a scalar.
    pub fn reference(&self, name: &str) -> u32 {
        let interface = self.model.interface();
        interface.named(name).unwrap_or_else(|| panic!("no variable {name}")).reference
    }

    pub fn set_reals(&self, references: &[u32], values: &[f64]) -> u32 {
        let (r, n, v) = (references.as_ptr(), references.len(), values.as_ptr());
        unsafe {
            match self.fmi {
                Two => fmi2SetReal(self.instance, r, n, v),
                Three => fmi3SetFloat64(self.instance, r, n, v, values.len()),
            }
        }
    }

    pub fn set(&self, name: &str, value: f64) -> u32 {
        self.set_reals(&[self.reference(name)], &[value])
    }

    pub fn get_reals(&self, references: &[u32]) -> (u32, Vec<f64>) {
        let mut values = vec![f64::NAN; references.len()];
        let (r, n, v) = (references.as_ptr(), references.len(), values.as_mut_ptr());
        let status = unsafe {
            match self.fmi {
                Two => fmi2GetReal(self.instance, r, n, v),
                Three => fmi3GetFloat64(self.instance, r, n, v, n),
            }
        };
        (status, values)
    }

    pub fn get(&self, name: &str) -> f64 {
        let (status, values) = self.get_reals(&[self.reference(name)]);
        assert_eq!(status, OK, "{name}: {}", self.last_message());
        values[0]
    }

    /// Enumerations travel as int in FMI 2 and as 64 bits in FMI 3.
    pub fn set_enumeration(&self, name: &str, value: i64) -> u32 {
        let reference = self.reference(name);
        unsafe {
            match self.fmi {
                Two => fmi2SetInteger(self.instance, &reference, 1, &(value as i32)),
                Three => fmi3SetInt64(self.instance, &reference, 1, &value, 1),
            }
        }
    }

    /// Of an integer or an enumeration.
    pub fn get_number(&self, name: &str) -> i32 {
        let (reference, mut value) = (self.reference(name), 0);
        let status = unsafe {
            match self.fmi {
                Two => fmi2GetInteger(self.instance, &reference, 1, &mut value),
                Three => fmi3GetInt32(self.instance, &reference, 1, &mut value, 1),
            }
        };
        assert_eq!(status, OK, "{}", self.last_message());
        value
    }

    pub fn get_enumeration(&self, name: &str) -> i64 {
        let (reference, mut int, mut long) = (self.reference(name), 0, 0);
        let status = unsafe {
            match self.fmi {
                Two => fmi2GetInteger(self.instance, &reference, 1, &mut int),
                Three => fmi3GetInt64(self.instance, &reference, 1, &mut long, 1),
            }
        };
        assert_eq!(status, OK, "{}", self.last_message());
        i64::from(int) + long
    }

    /// A saved state; must be freed.
    pub fn state(&self) -> *mut c_void {
        let mut state = null_mut();
        let status = unsafe {
            match self.fmi {
                Two => fmi2GetFMUstate(self.instance, &mut state),
                Three => fmi3GetFMUState(self.instance, &mut state),
            }
        };
        assert!(status == OK && !state.is_null());
        state
    }

    pub fn set_state(&self, state: *mut c_void) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2SetFMUstate(self.instance, state),
                Three => fmi3SetFMUState(self.instance, state),
            }
        }
    }

    pub fn free_state(&self, mut state: *mut c_void) {
        let status = unsafe {
            match self.fmi {
                Two => fmi2FreeFMUstate(self.instance, &mut state),
                Three => fmi3FreeFMUState(self.instance, &mut state),
            }
        };
        assert!(status == OK && state.is_null());
    }

    pub fn serialize(&self, state: *mut c_void, room: Option<usize>) -> (u32, Vec<u8>) {
        let mut size = 0;
        unsafe {
            let status = match self.fmi {
                Two => fmi2SerializedFMUstateSize(self.instance, state, &mut size),
                Three => fmi3SerializedFMUStateSize(self.instance, state, &mut size),
            };
            assert_eq!(status, OK);
            let mut bytes = vec![0u8; size];
            let room = room.unwrap_or(size);
            let status = match self.fmi {
                Two => fmi2SerializeFMUstate(self.instance, state, bytes.as_mut_ptr().cast(), room),
                Three => fmi3SerializeFMUState(self.instance, state, bytes.as_mut_ptr(), room),
            };
            (status, bytes)
        }
    }

    pub fn save(&self) -> Vec<u8> {
        let state = self.state();
        let (status, bytes) = self.serialize(state, None);
        self.free_state(state);
        assert_eq!(status, OK);
        bytes
    }

    pub fn restore(&self, bytes: &[u8]) -> u32 {
        let mut state = null_mut();
        let status = unsafe {
            match self.fmi {
                Two => fmi2DeSerializeFMUstate(self.instance, bytes.as_ptr().cast(), bytes.len(), &mut state),
                Three => fmi3DeserializeFMUState(self.instance, bytes.as_ptr(), bytes.len(), &mut state),
            }
        };
        if status != OK {
            assert!(state.is_null());
            return status;
        }
        let status = self.set_state(state);
        self.free_state(state);
        status
    }

    pub fn set_debug_logging(&self, on: bool, categories: &[*const c_char]) -> u32 {
        unsafe {
            match self.fmi {
                Two => {
                    fmi2SetDebugLogging(self.instance, i32::from(on), categories.len(), categories.as_ptr())
                }
                Three => fmi3SetDebugLogging(self.instance, on, categories.len(), categories.as_ptr()),
            }
        }
    }

    pub fn last_message(&self) -> String {
        self.messages.lock().unwrap().last().map(|message| message.2.clone()).unwrap_or_default()
    }

    pub fn take_messages(&self) -> Vec<(u32, String, String)> {
        std::mem::take(&mut self.messages.lock().unwrap())
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        unsafe {
            match self.fmi {
                Two => fmi2FreeInstance(self.instance),
                Three => fmi3FreeInstance(self.instance),
            }
        }
    }
}
