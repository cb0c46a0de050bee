//! The C functions of both standards: they turn pointers into slices, call `Instance`, and turn errors into statuses.
//!
//! This is the only place of the library with `unsafe`. Every function goes through `call` (or `instantiate`), so
//! that the order of calls is checked, errors are reported, no panic reaches C and the host's floating-point environment stays
//! its own, all in one place. Pointers are
//! checked as far as a library can: NULL, alignment and length; that they point to what the standard says they point
//! to is the importer's promise, and what each SAFETY comment rests on.
#![allow(unsafe_code)]
#![allow(non_snake_case, reason = "the names are the standard's")]
#![allow(missing_docs, clippy::missing_safety_doc, reason = "the standard documents the functions")]

mod exchange;
pub mod fmi2;
pub mod fmi2_exchange;
pub mod fmi2_unsupported;
pub mod fmi3;
pub mod fmi3_buses;
pub mod fmi3_exchange;
pub mod fmi3_unsupported;
pub mod fmi3_values;
mod signatures;
mod states;

use std::borrow::Cow;
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::path::PathBuf;

use cable_robot_boundary::floating_point::in_default_environment;
use cable_robot_boundary::panics::caught;

use super::error::{FmiError, Status};
use super::instance::Instance;
use super::lifecycle::Function;
use super::log::{Category, Log};
use super::models::{Interface, Use, Variant};
use super::resources;
use super::variables::Kind;

/// What both versions return as status: an unsigned int with the numbers of [`Status`].
type StatusCode = std::ffi::c_uint;

/// Makes an instance of the model that has this token for the use asked for, whose steps may end early or not, or says why not and returns NULL. `resources` is the path of the FMU's
/// resources, where the rig of an FMU for another rig than the paper's is.
///
/// # Safety
/// `token` is NULL or a C string.
unsafe fn instantiate(
    function: &'static Function,
    log: Log,
    asked_for: Result<(Use, bool), FmiError>,
    token: *const c_char,
    resources: Option<PathBuf>,
) -> *mut c_void {
    in_default_environment(|| {
        // SAFETY: the caller's promise.
        unsafe { instantiate_here(function, log, asked_for, token, resources) }
    })
}

/// [`instantiate`], whatever the environment.
///
/// # Safety
/// As there.
unsafe fn instantiate_here(
    function: &'static Function,
    log: Log,
    asked_for: Result<(Use, bool), FmiError>,
    token: *const c_char,
    resources: Option<PathBuf>,
) -> *mut c_void {
    let made = catch(function, || {
        let (usage, returns_early) = asked_for?;
        // SAFETY: the caller's promise.
        let given = unsafe { text(token) }.unwrap_or_default();
        let (interface, node) = resources::model(&given, resources.as_deref())?;
        check_usage(function, &interface, usage)?;
        Ok((interface, node, usage, returns_early))
    });
    let instance = match made {
        Ok((interface, Some(node), ..)) => Instance::on_buses(interface, node, log),
        Ok((interface, None, usage, returns_early)) => Instance::new(interface, usage, returns_early, log),
        Err(error) => {
            log.send(Status::Error, Category::Error, &error.to_string());
            return std::ptr::null_mut();
        }
    };
    Box::into_raw(Box::new(instance)).cast()
}

fn check_usage(function: &'static Function, interface: &Interface, wanted: Use) -> Result<(), FmiError> {
    let why = match (interface.model().usage(), wanted) {
        (usage, wanted) if usage == wanted => return Ok(()),
        (Use::OnBuses, Use::CoSimulationWithEvents) => return Ok(()),
        (Use::OnBuses, Use::CoSimulation) => "eventModeUsed must be true: frames are exchanged in Event Mode",
        (Use::CoSimulation, Use::CoSimulationWithEvents) if interface.variant() == Variant::Full => {
            return Ok(());
        }
        (Use::CoSimulation, Use::CoSimulationWithEvents) => {
            "eventModeUsed must be false: this FMU has no Event Mode (hasEventMode in modelDescription.xml)"
        }
        (usage, _) => usage.refusal(),
    };
    Err(FmiError::Unsupported { function: function.name, why })
}

/// Frees an instance; NULL is ignored.
///
/// # Safety
/// `instance` is NULL or comes from [`instantiate`] and was not freed.
unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: the caller's promise.
        drop(unsafe { Box::from_raw(instance.cast::<Instance>()) });
    }
}

/// Runs `body` on an instance if `function` is allowed now. An error is logged and leaves the instance in the error
/// state; a warning or a discarded call is logged.
///
/// # Safety
/// `instance` is NULL or comes from [`instantiate`], was not freed, and nobody else uses it at the same time.
unsafe fn call(
    instance: *mut c_void,
    function: &'static Function,
    body: impl FnOnce(&mut Instance) -> Result<(), FmiError>,
) -> StatusCode {
    // SAFETY: the caller's promise.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else {
        return Status::Error as StatusCode; // There is no logger to tell.
    };
    in_default_environment(|| {
        let outcome = catch(function, || {
            function.check(instance.state(), instance.usage())?;
            body(instance)
        });
        let Err(error) = outcome else { return Status::Ok as StatusCode };
        instance.log.send(error.status(), error.category(), &error.to_string());
        if error.status() == Status::Error {
            instance.fail();
        }
        error.status() as StatusCode
    })
}

/// A function of the standard that this FMU does not support.
///
/// # Safety
/// As [`call`].
unsafe fn refuse(instance: *mut c_void, function: &'static Function) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe { call(instance, function, |_| Ok(())) }
}

/// The one place where a panic ends.
fn catch<T>(function: &'static Function, body: impl FnOnce() -> Result<T, FmiError>) -> Result<T, FmiError> {
    caught(body).unwrap_or_else(|message| Err(FmiError::Panic { function: function.name, message }))
}

/// The getters of both versions.
///
/// # Safety
/// As [`call`]; the arrays are NULL or have the lengths given.
unsafe fn get<T>(
    instance: *mut c_void,
    function: &'static Function,
    handles: fn(Kind) -> bool,
    references: (*const u32, usize),
    values: (*mut T, usize),
    convert: fn(f64) -> T,
) -> StatusCode {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's promise; the values are written only, so they need not be initialised.
        let (references, values) = unsafe { (slice(references, REFERENCES)?, slice_mut(values, VALUES)?) };
        let references = &behind(instance, function, references)?;
        same_length(references.len(), values.len())?;
        instance.get(function, handles, references, |i, value| {
            values[i].write(convert(value));
        })
    };
    // SAFETY: the caller's promise.
    unsafe { call(instance, function, body) }
}

/// The setters of both versions.
///
/// # Safety
/// As [`call`]; the arrays are NULL or have the lengths given.
unsafe fn set<T: Copy>(
    instance: *mut c_void,
    function: &'static Function,
    handles: fn(Kind) -> bool,
    references: (*const u32, usize),
    values: (*const T, usize),
    convert: fn(T) -> f64,
) -> StatusCode {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's promise.
        let (references, values) = unsafe { (slice(references, REFERENCES)?, slice(values, VALUES)?) };
        let references = &behind(instance, function, references)?;
        same_length(references.len(), values.len())?;
        instance.set(function, handles, references, |i| convert(values[i]))
    };
    // SAFETY: the caller's promise.
    unsafe { call(instance, function, body) }
}

/// Getters and setters of types that no variable has: right for no references at all, and for no other.
///
/// # Safety
/// As [`call`]; the array is NULL or has the length given.
unsafe fn no_variables(
    instance: *mut c_void,
    function: &'static Function,
    references: (*const u32, usize),
) -> StatusCode {
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            instance.get(function, |_| false, slice(references, REFERENCES)?, |_, _| {})
        })
    }
}

const REFERENCES: &str = "the array of value references";
const VALUES: &str = "the array of values";

/// The references of the scalars behind those from outside: other ones only where there are arrays.
///
/// # Errors
/// Names the first of which importers are shown no variable.
fn behind<'a>(
    instance: &Instance,
    function: &'static Function,
    references: &'a [u32],
) -> Result<Cow<'a, [u32]>, FmiError> {
    let interface = instance.interface();
    if interface.variant() != Variant::Full {
        return Ok(references.into());
    }
    let mut scalars = vec![];
    for &reference in references {
        let shown = interface.scalar(reference).filter(|scalar| interface.is_shown(scalar));
        let (function, model) = (function.name, interface.model().identifier());
        let array = shown.ok_or(FmiError::UnknownReference { function, model, reference })?;
        scalars.extend(interface.scalars_of(array.row).map(|scalar| scalar.reference));
    }
    Ok(scalars.into())
}

fn same_length(scalars: usize, values: usize) -> Result<(), FmiError> {
    if scalars == values {
        return Ok(());
    }
    let wanted = format!("{scalars}, the number of scalars behind the value references");
    Err(FmiError::Length { argument: VALUES, given: values, wanted })
}

/// Switches log categories; no names (also a NULL array) means all of them.
///
/// # Safety
/// As [`call`]; `names` is NULL or has `count` entries, each NULL or a C string.
unsafe fn set_debug_logging(
    instance: *mut c_void,
    function: &'static Function,
    on: bool,
    names: *const *const c_char,
    count: usize,
) -> StatusCode {
    let count = if names.is_null() { 0 } else { count };
    // SAFETY: the caller's promise.
    unsafe {
        call(instance, function, |instance| {
            let names = slice((names, count), "the array of categories")?;
            let names: Vec<String> = names.iter().map(|&name| text(name).unwrap_or_default()).collect();
            instance.log.enable(on, &names)
        })
    }
}

/// An array from C. No elements need no array.
///
/// # Safety
/// The pointer is NULL or points to that many initialised `T` that nobody changes during the call.
unsafe fn slice<'a, T>(
    (pointer, length): (*const T, usize),
    argument: &'static str,
) -> Result<&'a [T], FmiError> {
    if length == 0 {
        return Ok(&[]);
    }
    check_array(pointer, length, argument)?;
    // SAFETY: the caller's promise and the checks.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// An array of C to write to.
///
/// # Safety
/// The pointer is NULL or points to room for that many `T` that nobody else uses during the call.
unsafe fn slice_mut<'a, T>(
    (pointer, length): (*mut T, usize),
    argument: &'static str,
) -> Result<&'a mut [MaybeUninit<T>], FmiError> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_array(pointer, length, argument)?;
    // SAFETY: the caller's promise and the checks.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast(), length) })
}

/// A single place of C to write to.
///
/// # Safety
/// As [`slice_mut`].
unsafe fn place<'a, T>(pointer: *mut T, argument: &'static str) -> Result<&'a mut MaybeUninit<T>, FmiError> {
    // SAFETY: the caller's promise.
    let place = unsafe { slice_mut((pointer, 1), argument) }?;
    Ok(&mut place[0])
}

fn check_array<T>(pointer: *const T, length: usize, argument: &'static str) -> Result<(), FmiError> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(FmiError::Pointer { argument });
    }
    let greatest = isize::MAX as usize / size_of::<T>();
    if length > greatest {
        return Err(FmiError::Length { argument, given: length, wanted: format!("at most {greatest}") });
    }
    Ok(())
}

/// A string of C, if there is one.
///
/// # Safety
/// `pointer` is NULL or a C string.
unsafe fn text(pointer: *const c_char) -> Option<String> {
    // SAFETY: the caller's promise.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}

/// A message as C wants it. `#` starts a reference to a variable in log messages of both versions; doubled it is itself.
fn message_for_c(message: &str) -> CString {
    CString::new(message.replace('\0', "").replace('#', "##")).unwrap_or_default()
}
