//! FMI 3.0: what only nodes on buses have, but for the planner's clock: clocks, binary variables, texts, Configuration Mode.

use super::{REFERENCES, VALUES, call, get, no_variables, same_length, slice, slice_mut};
use crate::bindings::fmi3::{
    fmi3Binary, fmi3Clock, fmi3Instance, fmi3Status, fmi3String, fmi3ValueReference,
};
use crate::lifecycle::function;
use crate::models::Use;
use crate::variables::Kind;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterConfigurationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EnterConfigurationMode") }, |instance| {
            instance.enter_configuration();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitConfigurationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3ExitConfigurationMode") }, |instance| {
            instance.exit_configuration();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetClock(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3Clock,
) -> fmi3Status {
    let function = const { function("fmi3GetClock") };
    let is_clock = |kind| matches!(kind, Kind::Clock);
    // SAFETY: the importer keeps the standard.
    unsafe {
        if !is_on_buses(instance) {
            return get(instance, function, is_clock, (references, count), (values, count), |value| {
                value != 0.0
            });
        }
        call(instance, function, |instance| {
            let (references, values) =
                (slice((references, count), REFERENCES)?, slice_mut((values, count), VALUES)?);
            instance.get_clocks(function, references, |i, ticks| _ = values[i].write(ticks))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetClock(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *const fmi3Clock,
) -> fmi3Status {
    let function = const { function("fmi3SetClock") };
    // SAFETY: the importer keeps the standard. A `bool` of Rust is 0 or 1, one from C may be any byte.
    unsafe {
        call(instance, function, |instance| {
            let (references, values) =
                (slice((references, count), REFERENCES)?, slice((values.cast::<u8>(), count), VALUES)?);
            instance.set_clocks(function, references, |i| values[i] != 0)
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetString(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3String,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetString") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        if !is_on_buses(instance) {
            return no_variables(instance, function, (references, count));
        }
        call(instance, function, |instance| {
            let (references, values) =
                (slice((references, count), REFERENCES)?, slice_mut((values, room), VALUES)?);
            same_length(count, room)?;
            for (i, &reference) in references.iter().enumerate() {
                let text = instance.text(function, reference)?.as_ptr();
                values[i].write(text);
            }
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBinary(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    sizes: *mut usize,
    values: *mut fmi3Binary,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetBinary") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        if !is_on_buses(instance) {
            return no_variables(instance, function, (references, count));
        }
        call(instance, function, |instance| {
            let references = slice((references, count), REFERENCES)?;
            let (sizes, values) = (slice_mut((sizes, room), SIZES)?, slice_mut((values, room), VALUES)?);
            same_length(count, room)?;
            for (i, &reference) in references.iter().enumerate() {
                let bytes = instance.binary(function, reference)?;
                sizes[i].write(bytes.len());
                values[i].write(bytes.as_ptr());
            }
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBinary(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    sizes: *const usize,
    values: *const fmi3Binary,
    given: usize,
) -> fmi3Status {
    let function = const { function("fmi3SetBinary") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        if !is_on_buses(instance) {
            return no_variables(instance, function, (references, count));
        }
        call(instance, function, |instance| {
            let references = slice((references, count), REFERENCES)?;
            let (sizes, values) = (slice((sizes, given), SIZES)?, slice((values, given), VALUES)?);
            same_length(count, given)?;
            for (i, &reference) in references.iter().enumerate() {
                instance.set_binary(function, reference, slice((values[i], sizes[i]), VALUES)?)?;
            }
            Ok(())
        })
    }
}

const SIZES: &str = "the array of sizes";

/// Whether it has clocks of its own.
///
/// # Safety
/// As [`call`].
unsafe fn is_on_buses(instance: fmi3Instance) -> bool {
    // SAFETY: the caller's promise.
    let instance = unsafe { instance.cast::<crate::instance::Instance>().as_ref() };
    instance.is_some_and(|instance| instance.usage() == Use::OnBuses)
}
