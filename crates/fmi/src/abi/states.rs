//! Saved states behind pointers; the same for both versions.

use std::ffi::c_void;

use super::{StatusCode, call, place, slice, slice_mut};
use crate::error::FmiError;
use crate::lifecycle::Function;
use crate::state::Snapshot;

/// Saves the instance's state behind `*target`: into the state that is there, or into a new one if it is NULL.
///
/// # Safety
/// As [`call`]; `target` is NULL or points to NULL or to a state from here.
pub unsafe fn get(
    instance: *mut c_void,
    function: &'static Function,
    target: *mut *mut c_void,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            let target = place(target, "the pointer to the FMU state")?.assume_init_mut();
            match target.cast::<Snapshot>().as_mut() {
                Some(existing) => existing.clone_from(instance.snapshot()),
                None => *target = Box::into_raw(Box::new(instance.snapshot().clone())).cast(),
            }
            Ok(())
        })
    }
}

/// Goes back to a saved state.
///
/// # Safety
/// As [`call`]; `state` is NULL or a state from here.
pub unsafe fn set(instance: *mut c_void, function: &'static Function, state: *mut c_void) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe { call(instance, function, |instance| instance.restore(saved(state)?)) }
}

/// Frees a saved state and leaves NULL in its place; NULL is ignored.
///
/// # Safety
/// As [`call`]; `state` is NULL or points to NULL or to a state from here.
pub unsafe fn free(
    instance: *mut c_void,
    function: &'static Function,
    state: *mut *mut c_void,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |_| {
            if let Some(state) = state.as_mut()
                && !state.is_null()
            {
                drop(Box::from_raw(state.cast::<Snapshot>()));
                *state = std::ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// How many bytes [`serialize`] will write.
///
/// # Safety
/// As [`call`]; `state` is NULL or a state from here, `size` is NULL or a place to write to.
pub unsafe fn serialized_size(
    instance: *mut c_void,
    function: &'static Function,
    state: *mut c_void,
    size: *mut usize,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            place(size, "the pointer to the size")?
                .write(saved(state)?.to_bytes(instance.interface())?.len());
            Ok(())
        })
    }
}

/// Writes a saved state as bytes.
///
/// # Safety
/// As [`call`]; `state` is NULL or a state from here, `bytes` is NULL or has room for `size` bytes.
pub unsafe fn serialize(
    instance: *mut c_void,
    function: &'static Function,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            let source = saved(state)?.to_bytes(instance.interface())?;
            if size < source.len() {
                let wanted = format!("{}, as the size function says", source.len());
                return Err(FmiError::Length { argument: BYTES, given: size, wanted });
            }
            let target = slice_mut((bytes, source.len()), BYTES)?;
            for (target, source) in target.iter_mut().zip(source) {
                target.write(source);
            }
            Ok(())
        })
    }
}

/// Makes a state from bytes.
///
/// # Safety
/// As [`call`]; `bytes` is NULL or has `size` bytes, `target` is NULL or a place to write to.
pub unsafe fn deserialize(
    instance: *mut c_void,
    function: &'static Function,
    bytes: *const u8,
    size: usize,
    target: *mut *mut c_void,
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            let target = place(target, "the pointer to the FMU state")?;
            let snapshot = Snapshot::from_bytes(instance.interface(), slice((bytes, size), BYTES)?)?;
            target.write(Box::into_raw(Box::new(snapshot)).cast());
            Ok(())
        })
    }
}

const BYTES: &str = "the array of bytes";

/// # Safety
/// `state` is NULL or a state from here.
unsafe fn saved<'a>(state: *mut c_void) -> Result<&'a Snapshot, FmiError> {
    // SAFETY: the caller's promise.
    unsafe { state.cast::<Snapshot>().as_ref() }.ok_or(FmiError::Pointer { argument: "the FMU state" })
}
