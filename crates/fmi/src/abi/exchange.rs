//! Model Exchange behind pointers; the same for both versions.

use std::ffi::c_void;

use super::{REFERENCES, StatusCode, call, same_length, slice, slice_mut};
use crate::error::FmiError;
use crate::instance::{Give, Instance};
use crate::lifecycle::Function;

/// Fills an array of C with what the instance has for it.
///
/// # Safety
/// As [`call`]; the array is NULL or has the length given.
pub unsafe fn fill(
    instance: *mut c_void,
    function: &'static Function,
    (values, length): (*mut f64, usize),
    from: fn(&mut Instance, usize, Give) -> Result<(), FmiError>,
) -> StatusCode {
    // SAFETY: the caller's promise; the values are written only, so they need not be initialised.
    unsafe {
        call(instance, function, |instance| {
            let values = slice_mut((values, length), "the array of values")?;
            from(instance, values.len(), &mut |i, value| {
                values[i].write(value);
            })
        })
    }
}

/// Sets the states.
///
/// # Safety
/// As [`call`]; the array is NULL or has the length given.
pub unsafe fn set_states(
    instance: *mut c_void,
    function: &'static Function,
    states: (*const f64, usize),
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe { call(instance, function, |instance| instance.set_states(slice(states, "the array of states")?)) }
}

/// What a directional derivative is asked for with: arrays of C.
pub struct Direction {
    pub unknown: (*const u32, usize),
    pub known: (*const u32, usize),
    pub seed: (*const f64, usize),
    pub sensitivity: (*mut f64, usize),
}

/// A directional derivative.
///
/// # Safety
/// As [`call`]; the arrays are NULL or have the lengths given.
pub unsafe fn directional_derivative(
    instance: *mut c_void,
    function: &'static Function,
    direction: Direction,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            let unknown = slice(direction.unknown, REFERENCES)?;
            let known = slice(direction.known, REFERENCES)?;
            let seed = slice(direction.seed, "the seed")?;
            let sensitivity = slice_mut(direction.sensitivity, "the sensitivity")?;
            same_length(known.len(), seed.len())?;
            same_length(unknown.len(), sensitivity.len())?;
            instance.give_directional_derivative(function, unknown, known, seed, |i, value| {
                sensitivity[i].write(value);
            })
        })
    }
}
