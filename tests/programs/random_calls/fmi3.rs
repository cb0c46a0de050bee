//! The sequences through FMI 3.0.

use std::ffi::{CString, c_char, c_void};
use std::ptr::{null, null_mut};

use cable_robot_bindings::fmi3::*;

use super::{Dice, LENGTH, Packed, SEQUENCES, count_message, explained, night, packed, say_progress};

unsafe extern "C" fn log(_: *mut c_void, _: u32, _: *const c_char, message: *const c_char) {
    assert!(!message.is_null());
    count_message();
}

#[test]
fn controller() {
    run(&packed(3, "CableRobotController"), 0, SEQUENCES);
}

#[test]
fn plant() {
    run(&packed(3, "CableRobotPlant"), 0, SEQUENCES);
}

#[test]
#[ignore = "25 million sequences"]
fn night_of_controllers() {
    let (seed, sequences) = night(25_000_000);
    run(&packed(3, "CableRobotController"), seed, sequences);
}

#[test]
#[ignore = "25 million sequences"]
fn night_of_plants() {
    let (seed, sequences) = night(25_000_000);
    run(&packed(3, "CableRobotPlant"), seed, sequences);
}

fn run(packed: &Packed, seed: u64, sequences: u64) {
    let library = unsafe { Fmi3Library::new(&packed.library) }.unwrap();
    let token = CString::new(packed.token.as_str()).unwrap();
    for k in 0..sequences {
        say_progress(&packed.description.model_identifier, k, sequences);
        let mut dice = Dice::new(seed, k, &packed.references);
        unsafe { sequence(&library, &token, &mut dice) };
    }
}

unsafe fn sequence(l: &Fmi3Library, token: &CString, dice: &mut Dice) {
    unsafe {
        let wrong = dice.chance(50);
        let given = if wrong { c"{no such token}".as_ptr() } else { dice.pointer(token.as_ptr()) };
        let resource = dice.pointer(c"/tmp/Pr\u{fc}fstand S\u{fc}d/resources/".as_ptr());
        let events = dice.chance(30);
        let on = dice.chance(2);
        let c = l.fmi3InstantiateCoSimulation(
            c"i".as_ptr(),
            given,
            resource,
            false,
            on,
            events,
            false,
            null(),
            0,
            null_mut(),
            Some(log),
            None,
        );
        if wrong || given.is_null() || events {
            assert!(c.is_null());
            return explained("fmi3InstantiateCoSimulation", 3);
        }
        assert!(!c.is_null());
        super::MESSAGES.set(0);

        let mut saved: Vec<fmi3FMUState> = vec![];
        let mut time = 0.0;
        for _ in 0..dice.below(LENGTH) {
            call(l, c, dice, &mut saved, &mut time);
        }
        for mut state in saved {
            explained("fmi3FreeFMUState", l.fmi3FreeFMUState(c, &mut state));
            assert!(state.is_null());
        }
        // Usable again, as the standard says.
        assert_eq!(l.fmi3Reset(c), 0);
        assert_eq!(l.fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0), 0);
        assert_eq!(l.fmi3ExitInitializationMode(c), 0);
        assert_eq!(step(l, c, 0.0, 1e-3), 0);
        l.fmi3FreeInstance(c);
        super::MESSAGES.set(0);
    }
}

unsafe fn step(l: &Fmi3Library, c: *mut c_void, time: f64, h: f64) -> u32 {
    let (mut event, mut terminate, mut early, mut last) = (true, true, true, 0.0);
    unsafe {
        let status = l.fmi3DoStep(c, time, h, true, &mut event, &mut terminate, &mut early, &mut last);
        assert!(status != 0 || (!event && !terminate && !early && last == time + h));
        status
    }
}

unsafe fn call(
    l: &Fmi3Library,
    c: *mut c_void,
    dice: &mut Dice,
    saved: &mut Vec<fmi3FMUState>,
    time: &mut f64,
) {
    let references = dice.references();
    let n = references.len();
    let vr = if n == 0 { null() } else { dice.pointer(references.as_ptr()) };
    let mut reals: [f64; 4] = std::array::from_fn(|_| dice.real());
    let mut integers: [i32; 4] = std::array::from_fn(|_| dice.integer());
    let mut longs: [i64; 4] = integers.map(i64::from);
    let mut booleans: [bool; 4] = std::array::from_fn(|_| dice.chance(2));
    let m = if dice.chance(20) { dice.below(5) } else { n };
    unsafe {
        let (name, status) = match dice.below(30) {
            0..=3 => {
                let (start, stop) = if dice.chance(4) { (dice.real(), dice.real()) } else { (0.0, 100.0) };
                *time = start;
                let status = l.fmi3EnterInitializationMode(
                    c,
                    dice.chance(2),
                    dice.real(),
                    start,
                    dice.chance(2),
                    stop,
                );
                ("EnterInitializationMode", status)
            }
            4..=6 => ("ExitInitializationMode", l.fmi3ExitInitializationMode(c)),
            7..=10 => {
                let h = if dice.chance(4) { dice.real() } else { 1e-3 };
                let at = if dice.chance(8) { dice.real() } else { *time };
                let status = step(l, c, at, h);
                if status == 0 {
                    *time = at + h;
                }
                ("DoStep", status)
            }
            11 => ("Terminate", l.fmi3Terminate(c)),
            12 => {
                *time = 0.0;
                ("Reset", l.fmi3Reset(c))
            }
            13 => ("GetFloat64", l.fmi3GetFloat64(c, vr, n, dice.pointer_mut(reals.as_mut_ptr()), m)),
            14 => ("GetInt32", l.fmi3GetInt32(c, vr, n, dice.pointer_mut(integers.as_mut_ptr()), m)),
            15 => ("GetBoolean", l.fmi3GetBoolean(c, vr, n, dice.pointer_mut(booleans.as_mut_ptr()), m)),
            16 => ("GetInt64", l.fmi3GetInt64(c, vr, n, dice.pointer_mut(longs.as_mut_ptr()), m)),
            17 => ("SetFloat64", l.fmi3SetFloat64(c, vr, n, dice.pointer(reals.as_ptr()), m)),
            18 => ("SetInt32", l.fmi3SetInt32(c, vr, n, dice.pointer(integers.as_ptr()), m)),
            19 => ("SetBoolean", l.fmi3SetBoolean(c, vr, n, dice.pointer(booleans.as_ptr()), m)),
            20 => ("SetInt64", l.fmi3SetInt64(c, vr, n, dice.pointer(longs.as_ptr()), m)),
            21 => {
                let mut state = null_mut();
                let status = l.fmi3GetFMUState(c, dice.pointer_mut(&mut state));
                if !state.is_null() {
                    saved.push(state);
                }
                ("GetFMUState", status)
            }
            22 => {
                let state = saved.last().copied().unwrap_or(null_mut());
                ("SetFMUState", l.fmi3SetFMUState(c, state))
            }
            23 => ("states", serialise(l, c, dice, saved)),
            24 => {
                let garbage = dice.bytes();
                let mut state = null_mut();
                let status = l.fmi3DeserializeFMUState(c, garbage.as_ptr(), garbage.len(), &mut state);
                assert!(status != 0 && state.is_null());
                ("DeserializeFMUState", status)
            }
            25 => {
                let categories = [dice.pointer(c"logEvents".as_ptr()), c"noSuchCategory".as_ptr()];
                let count = dice.below(3);
                ("SetDebugLogging", l.fmi3SetDebugLogging(c, true, count, dice.pointer(categories.as_ptr())))
            }
            26 => {
                let unknown = references.as_ptr();
                let status = l.fmi3GetDirectionalDerivative(
                    c,
                    unknown,
                    n,
                    unknown,
                    n,
                    reals.as_ptr(),
                    n,
                    reals.as_mut_ptr(),
                    n,
                );
                ("GetDirectionalDerivative", status)
            }
            27 => ("SetTime", l.fmi3SetTime(c, dice.real())),
            28 => ("EnterEventMode", l.fmi3EnterEventMode(c)),
            _ => {
                // Without an instance there is nobody to tell.
                assert_eq!(step(l, null_mut(), 0.0, 1e-3), 3);
                ("nothing", 0)
            }
        };
        explained(name, status);
    }
}

/// A state there and back through bytes, spoilt at times.
unsafe fn serialise(l: &Fmi3Library, c: *mut c_void, dice: &mut Dice, saved: &mut Vec<fmi3FMUState>) -> u32 {
    let Some(&state) = saved.last() else { return 0 };
    unsafe {
        let mut size = 0;
        assert_eq!(l.fmi3SerializedFMUStateSize(c, state, &mut size), 0);
        let mut blob = vec![0u8; size];
        assert_eq!(l.fmi3SerializeFMUState(c, state, blob.as_mut_ptr(), size), 0);
        let spoilt = dice.chance(2);
        if spoilt {
            let at = dice.below(size);
            blob[at] ^= 1 << dice.below(8);
        }
        let mut copy = null_mut();
        let status = l.fmi3DeserializeFMUState(c, blob.as_ptr(), size, &mut copy);
        assert_eq!(status != 0, spoilt);
        if !copy.is_null() {
            saved.push(copy);
        }
        status
    }
}
