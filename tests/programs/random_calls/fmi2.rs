//! The sequences through FMI 2.0.

use std::ffi::{CString, c_char, c_void};
use std::ptr::{null, null_mut};

use cable_robot_bindings::fmi2::*;

use super::{Dice, LENGTH, Packed, SEQUENCES, count_message, explained, night, packed, say_progress};

/// Stands for the standard's variadic function: the FMUs send one preformatted text and nothing after it.
type PlainLogger = unsafe extern "C" fn(*mut c_void, *const c_char, u32, *const c_char, *const c_char);

unsafe extern "C" fn log(_: *mut c_void, _: *const c_char, _: u32, _: *const c_char, message: *const c_char) {
    assert!(!message.is_null());
    count_message();
}

#[test]
fn controller() {
    run(&packed(2, "CableRobotController"), 0, SEQUENCES);
}

#[test]
fn plant() {
    run(&packed(2, "CableRobotPlant"), 0, SEQUENCES);
}

#[test]
#[ignore = "25 million sequences"]
fn night_of_controllers() {
    let (seed, sequences) = night(25_000_000);
    run(&packed(2, "CableRobotController"), seed, sequences);
}

#[test]
#[ignore = "25 million sequences"]
fn night_of_plants() {
    let (seed, sequences) = night(25_000_000);
    run(&packed(2, "CableRobotPlant"), seed, sequences);
}

fn run(packed: &Packed, seed: u64, sequences: u64) {
    let library = unsafe { Fmi2Library::new(&packed.library) }.unwrap();
    // SAFETY: additional variadic arguments are never sent, and the calling convention passes the first five alike.
    let logger = unsafe { std::mem::transmute::<PlainLogger, fmi2CallbackLogger>(log) };
    let callbacks = fmi2CallbackFunctions {
        logger,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let token = CString::new(packed.token.as_str()).unwrap();
    for k in 0..sequences {
        say_progress(&packed.description.model_identifier, k, sequences);
        let mut dice = Dice::new(seed, k, &packed.references);
        unsafe { sequence(&library, &callbacks, &token, &mut dice) };
    }
}

unsafe fn sequence(l: &Fmi2Library, callbacks: &fmi2CallbackFunctions, token: &CString, dice: &mut Dice) {
    unsafe {
        let wrong = dice.chance(50);
        let given = if wrong { c"{no such token}".as_ptr() } else { dice.pointer(token.as_ptr()) };
        let resource = dice.pointer(c"file:///tmp/Pr%C3%BCfstand%20S%C3%BCd/resources".as_ptr());
        let kind = if dice.chance(30) { 0 } else { fmi2Type_fmi2CoSimulation };
        let on = i32::from(dice.chance(2));
        let c = l.fmi2Instantiate(c"i".as_ptr(), kind, given, resource, callbacks, 0, on);
        if wrong || given.is_null() || kind == 0 {
            assert!(c.is_null());
            return explained("fmi2Instantiate", 3);
        }
        assert!(!c.is_null());
        super::MESSAGES.set(0);

        let mut saved: Vec<fmi2FMUstate> = vec![];
        let mut time = 0.0;
        for _ in 0..dice.below(LENGTH) {
            call(l, c, dice, &mut saved, &mut time);
        }
        for mut state in saved {
            explained("fmi2FreeFMUstate", l.fmi2FreeFMUstate(c, &mut state));
            assert!(state.is_null());
        }
        // Usable again, as the standard says.
        assert_eq!(l.fmi2Reset(c), 0);
        assert_eq!(l.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(l.fmi2EnterInitializationMode(c), 0);
        assert_eq!(l.fmi2ExitInitializationMode(c), 0);
        assert_eq!(l.fmi2DoStep(c, 0.0, 1e-3, 1), 0);
        l.fmi2FreeInstance(c);
        super::MESSAGES.set(0);
    }
}

unsafe fn call(
    l: &Fmi2Library,
    c: *mut c_void,
    dice: &mut Dice,
    saved: &mut Vec<fmi2FMUstate>,
    time: &mut f64,
) {
    let references = dice.references();
    let n = references.len();
    let vr = if n == 0 { null() } else { dice.pointer(references.as_ptr()) };
    let mut reals: [f64; 4] = std::array::from_fn(|_| dice.real());
    let mut integers: [i32; 4] = std::array::from_fn(|_| dice.integer());
    let mut strings = [c"text".as_ptr(); 4];
    unsafe {
        let (name, status) = match dice.below(30) {
            0 => ("SetupExperiment", l.fmi2SetupExperiment(c, 0, 0.0, dice.real(), 1, dice.real())),
            1..=3 => ("EnterInitializationMode", l.fmi2EnterInitializationMode(c)),
            4..=6 => ("ExitInitializationMode", l.fmi2ExitInitializationMode(c)),
            7..=10 => {
                let h = if dice.chance(4) { dice.real() } else { 1e-3 };
                let at = if dice.chance(8) { dice.real() } else { *time };
                let status = l.fmi2DoStep(c, at, h, 1);
                if status == 0 {
                    *time = at + h;
                }
                ("DoStep", status)
            }
            11 => ("Terminate", l.fmi2Terminate(c)),
            12 => {
                *time = 0.0;
                ("Reset", l.fmi2Reset(c))
            }
            13 => ("GetReal", l.fmi2GetReal(c, vr, n, dice.pointer_mut(reals.as_mut_ptr()))),
            14 => ("GetInteger", l.fmi2GetInteger(c, vr, n, dice.pointer_mut(integers.as_mut_ptr()))),
            15 => ("GetBoolean", l.fmi2GetBoolean(c, vr, n, dice.pointer_mut(integers.as_mut_ptr()))),
            16 => ("GetString", l.fmi2GetString(c, vr, n, dice.pointer_mut(strings.as_mut_ptr()))),
            17 => ("SetReal", l.fmi2SetReal(c, vr, n, dice.pointer(reals.as_ptr()))),
            18 => ("SetInteger", l.fmi2SetInteger(c, vr, n, dice.pointer(integers.as_ptr()))),
            19 => ("SetBoolean", l.fmi2SetBoolean(c, vr, n, dice.pointer(integers.as_ptr()))),
            20 => ("SetString", l.fmi2SetString(c, vr, n, dice.pointer(strings.as_ptr()))),
            21 => {
                let mut state = null_mut();
                let status = l.fmi2GetFMUstate(c, dice.pointer_mut(&mut state));
                if !state.is_null() {
                    saved.push(state);
                }
                ("GetFMUstate", status)
            }
            22 => {
                let state = saved.last().copied().unwrap_or(null_mut());
                ("SetFMUstate", l.fmi2SetFMUstate(c, state))
            }
            23 => ("states", serialise(l, c, dice, saved)),
            24 => {
                let mut garbage = dice.bytes();
                let mut state = null_mut();
                let status =
                    l.fmi2DeSerializeFMUstate(c, garbage.as_mut_ptr().cast(), garbage.len(), &mut state);
                assert!(status != 0 && state.is_null());
                ("DeSerializeFMUstate", status)
            }
            25 => {
                let categories = [dice.pointer(c"logEvents".as_ptr()), c"noSuchCategory".as_ptr()];
                let count = dice.below(3);
                ("SetDebugLogging", l.fmi2SetDebugLogging(c, 1, count, dice.pointer(categories.as_ptr())))
            }
            26 => {
                let orders = [1; 4];
                let status = l.fmi2SetRealInputDerivatives(c, vr, n, orders.as_ptr(), reals.as_ptr());
                ("SetRealInputDerivatives", status)
            }
            27 => ("SetTime", l.fmi2SetTime(c, dice.real())),
            28 => {
                let what = dice.below(5) as u32;
                ("GetRealStatus", l.fmi2GetRealStatus(c, what, dice.pointer_mut(reals.as_mut_ptr())))
            }
            _ => {
                // Without an instance there is nobody to tell.
                assert_eq!(l.fmi2DoStep(null_mut(), 0.0, 1e-3, 1), 3);
                ("nothing", 0)
            }
        };
        explained(name, status);
    }
}

/// A state there and back through bytes, spoilt at times.
unsafe fn serialise(l: &Fmi2Library, c: *mut c_void, dice: &mut Dice, saved: &mut Vec<fmi2FMUstate>) -> u32 {
    let Some(&state) = saved.last() else { return 0 };
    unsafe {
        let mut size = 0;
        assert_eq!(l.fmi2SerializedFMUstateSize(c, state, &mut size), 0);
        let mut blob = vec![0u8; size];
        assert_eq!(l.fmi2SerializeFMUstate(c, state, blob.as_mut_ptr().cast(), size), 0);
        let spoilt = dice.chance(2);
        if spoilt {
            let at = dice.below(size);
            blob[at] ^= 1 << dice.below(8);
        }
        let mut copy = null_mut();
        let status = l.fmi2DeSerializeFMUstate(c, blob.as_ptr().cast(), size, &mut copy);
        assert_eq!(status != 0, spoilt);
        if !copy.is_null() {
            saved.push(copy);
        }
        status
    }
}
