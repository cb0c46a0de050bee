//! An instance of a packed FMU, called as an importer calls it.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use cable_robot_bindings::fmi3::*;
use cable_robot_import::VariableType;

use crate::Packed;

pub const STEP: f64 = 1e-3;
/// Of the plant for Model Exchange.
const STATES: usize = 13;
const CABLES: usize = 6;

thread_local! {
    /// What the library said of a failure of its own.
    pub static DEFECT: RefCell<Option<String>> = const { RefCell::new(None) };
}

unsafe extern "C" fn log(_: *mut c_void, _: u32, _: *const c_char, message: *const c_char) {
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    if text.contains("internal reason") {
        DEFECT.set(Some(text.into_owned()));
    }
}

/// An instance of a packed FMU.
pub struct Host<'a> {
    library: &'a Fmi3Library,
    packed: &'a Packed,
    instance: *mut c_void,
    /// For Model Exchange.
    exchange: bool,
}

impl<'a> Host<'a> {
    pub fn new(library: &'a Fmi3Library, packed: &'a Packed) -> Self {
        let token = CString::new(packed.token.as_str()).unwrap();
        let (name, token, no) = (c"mutated".as_ptr(), token.as_ptr(), false);
        let exchange = packed.description.model_identifier.ends_with("ME");
        let (l, none, env) = (library, null(), null_mut());
        let instance = unsafe {
            if exchange {
                l.fmi3InstantiateModelExchange(name, token, none, no, no, env, Some(log))
            } else {
                let (no_one, count) = (null(), 0);
                l.fmi3InstantiateCoSimulation(
                    name,
                    token,
                    none,
                    no,
                    no,
                    no,
                    no,
                    no_one,
                    count,
                    env,
                    Some(log),
                    None,
                )
            }
        };
        assert!(!instance.is_null());
        Self { library, packed, instance, exchange }
    }

    pub fn set(&self, name: &str, value: f64) {
        let variable = self.packed.description.variable(name).unwrap();
        let (l, c, vr) = (self.library, self.instance, &raw const variable.reference);
        let status = unsafe {
            match variable.kind {
                VariableType::Boolean => l.fmi3SetBoolean(c, vr, 1, &(value != 0.0), 1),
                VariableType::Int32 => l.fmi3SetInt32(c, vr, 1, &(value as i32), 1),
                _ => l.fmi3SetFloat64(c, vr, 1, &value, 1),
            }
        };
        assert_eq!(status, 0, "{name}");
    }

    pub fn get(&self, name: &str) -> f64 {
        let reference = self.packed.description.variable(name).unwrap().reference;
        let mut value = f64::NAN;
        assert_eq!(
            unsafe { self.library.fmi3GetFloat64(self.instance, &reference, 1, &mut value, 1) },
            0,
            "{name}"
        );
        value
    }

    pub fn integer(&self, name: &str) -> i32 {
        let reference = self.packed.description.variable(name).unwrap().reference;
        let mut value = 0;
        assert_eq!(
            unsafe { self.library.fmi3GetInt32(self.instance, &reference, 1, &mut value, 1) },
            0,
            "{name}"
        );
        value
    }

    pub fn start(&self) {
        let (l, c) = (self.library, self.instance);
        unsafe {
            assert_eq!(l.fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0), 0);
            assert_eq!(l.fmi3ExitInitializationMode(c), 0);
        }
        if self.exchange {
            assert_eq!((self.settle(), unsafe { l.fmi3EnterContinuousTimeMode(c) }), (0, 0));
        }
    }

    /// The status of an event's end.
    fn settle(&self) -> u32 {
        let ([mut a, mut b, mut c, mut d, mut e], mut time) = ([false; 5], 0.0);
        unsafe {
            self.library.fmi3UpdateDiscreteStates(
                self.instance,
                &mut a,
                &mut b,
                &mut c,
                &mut d,
                &mut e,
                &mut time,
            )
        }
    }

    /// The status of a step from where it is.
    pub fn step(&self) -> u32 {
        if self.exchange { self.integrate() } else { self.do_step() }
    }

    /// A step of Euler's, as an integrator makes it, and an event after it.
    fn integrate(&self) -> u32 {
        let (l, c, time) = (self.library, self.instance, self.get("time"));
        let ([mut x, mut rates], mut pull) = ([[0.0; STATES]; 2], [0.0; CABLES]);
        let (mut event, mut terminate) = (false, false);
        let mut done = |x: &mut [f64; STATES]| unsafe {
            let read = l.fmi3GetContinuousStates(c, x.as_mut_ptr(), STATES);
            let rate = l.fmi3GetContinuousStateDerivatives(c, rates.as_mut_ptr(), STATES);
            if read.max(rate) > 1 {
                return read.max(rate);
            }
            assert!(x.iter().chain(&rates).all(|number| number.is_finite()), "{x:?} {rates:?}");
            x.iter_mut().zip(rates).for_each(|(x, rate)| *x += STEP * rate);
            [
                l.fmi3SetTime(c, time + STEP),
                l.fmi3SetContinuousStates(c, x.as_ptr(), STATES),
                l.fmi3GetEventIndicators(c, pull.as_mut_ptr(), CABLES),
                l.fmi3CompletedIntegratorStep(c, true, &mut event, &mut terminate),
                l.fmi3EnterEventMode(c),
                self.settle(),
                l.fmi3EnterContinuousTimeMode(c),
            ]
            .into_iter()
            .max()
            .unwrap()
        };
        done(&mut x)
    }

    fn do_step(&self) -> u32 {
        let (mut event, mut terminate, mut early, mut last) = (false, false, false, 0.0);
        let (l, c, time) = (self.library, self.instance, self.get("time"));
        unsafe { l.fmi3DoStep(c, time, STEP, true, &mut event, &mut terminate, &mut early, &mut last) }
    }

    pub fn saved(&self) -> Vec<u8> {
        let (l, c) = (self.library, self.instance);
        let (mut state, mut size) = (null_mut(), 0);
        unsafe {
            assert_eq!(l.fmi3GetFMUState(c, &mut state), 0);
            assert_eq!(l.fmi3SerializedFMUStateSize(c, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(l.fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size), 0);
            assert_eq!(l.fmi3FreeFMUState(c, &mut state), 0);
            bytes
        }
    }

    /// Whether it takes the state up.
    pub fn takes(&self, bytes: &[u8]) -> bool {
        let (l, c, mut state) = (self.library, self.instance, null_mut());
        unsafe {
            if l.fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), &mut state) != 0 {
                assert!(state.is_null());
                return false;
            }
            let status = l.fmi3SetFMUState(c, state);
            assert_eq!(l.fmi3FreeFMUState(c, &mut state), 0);
            status == 0
        }
    }
}

impl Drop for Host<'_> {
    fn drop(&mut self) {
        unsafe { self.library.fmi3FreeInstance(self.instance) };
    }
}
