//! FMI 2.0: what these FMUs support of it.

use std::ffi::{CString, c_char};

use super::{
    call, free, get, instantiate, message_for_c, no_variables, place, set, set_debug_logging, states, text,
};
use crate::bindings::fmi2::{
    fmi2Boolean, fmi2Byte, fmi2CallbackFunctions, fmi2Component, fmi2FMUstate, fmi2False, fmi2Integer,
    fmi2Real, fmi2Status, fmi2StatusKind, fmi2StatusKind_fmi2LastSuccessfulTime,
    fmi2StatusKind_fmi2Terminated, fmi2String, fmi2Type, fmi2Type_fmi2CoSimulation, fmi2TypesPlatform,
    fmi2ValueReference, fmi2Version,
};
use crate::error::FmiError;
use crate::lifecycle::function;
use crate::log::{Log, Sink};
use crate::models::Use;
use crate::resources::path_of_uri;
use crate::variables::Kind;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    fmi2TypesPlatform.as_ptr().cast()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetVersion() -> *const c_char {
    fmi2Version.as_ptr().cast()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    let asked_for = Ok(match fmuType == fmi2Type_fmi2CoSimulation {
        true => (Use::CoSimulation, false),
        false => (Use::ModelExchange, false),
    });
    // SAFETY: the importer keeps the standard: functions and strings are NULL or valid.
    unsafe {
        let log = Log::new(sink(functions.as_ref(), instanceName), loggingOn != fmi2False as fmi2Boolean);
        let resources = text(fmuResourceLocation).and_then(|uri| path_of_uri(&uri));
        instantiate(const { function("fmi2Instantiate") }, log, asked_for, fmuGUID, resources)
    }
}

/// Hands messages to the importer's logger. It is a printf: a `%` in a message must be doubled.
///
/// # Safety
/// `name` is NULL or a C string; the logger stays callable for the life of the instance.
unsafe fn sink(functions: Option<&fmi2CallbackFunctions>, name: fmi2String) -> Sink {
    // SAFETY: the caller's promise.
    let name = CString::new(unsafe { text(name) }.unwrap_or_default()).unwrap_or_default();
    let callback = functions.and_then(|functions| Some((functions.logger?, functions.componentEnvironment)));
    Box::new(move |status, category, message| {
        let Some((logger, environment)) = callback else { return };
        let message = message_for_c(&message.replace('%', "%%"));
        // SAFETY: the caller's promise; the strings live until the logger returns.
        unsafe {
            logger(environment, name.as_ptr(), status as fmi2Status, category.as_ptr(), message.as_ptr());
        }
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    // SAFETY: the importer keeps the standard.
    unsafe { free(c) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    let on = loggingOn != fmi2False as fmi2Boolean;
    // SAFETY: the importer keeps the standard.
    unsafe { set_debug_logging(c, const { function("fmi2SetDebugLogging") }, on, categories, nCategories) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    _toleranceDefined: fmi2Boolean,
    _tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    let stop = (stopTimeDefined != fmi2False as fmi2Boolean).then_some(stopTime);
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2SetupExperiment") }, |instance| {
            instance.set_up_experiment(startTime, stop)
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2EnterInitializationMode") }, |instance| {
            instance.enter_initialization();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2ExitInitializationMode") }, |instance| instance.exit_initialization())
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2Terminate") }, |instance| {
            instance.terminate();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2Reset") }, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2DoStep") }, |instance| {
            instance.step(currentCommunicationPoint, communicationStepSize)
        })
    }
}

fn is_real(kind: Kind) -> bool {
    matches!(kind, Kind::Float64)
}

/// FMI 2 reads enumerations as integers.
fn is_integer(kind: Kind) -> bool {
    matches!(kind, Kind::Int32 | Kind::Enumeration(_))
}

fn is_boolean(kind: Kind) -> bool {
    matches!(kind, Kind::Boolean)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { get(c, const { function("fmi2GetReal") }, is_real, (vr, nvr), (value, nvr), |value| value) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    let convert = |value| value as fmi2Integer;
    // SAFETY: the importer keeps the standard.
    unsafe { get(c, const { function("fmi2GetInteger") }, is_integer, (vr, nvr), (value, nvr), convert) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let convert = |value| fmi2Boolean::from(value != 0.0);
    // SAFETY: the importer keeps the standard.
    unsafe { get(c, const { function("fmi2GetBoolean") }, is_boolean, (vr, nvr), (value, nvr), convert) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(c, const { function("fmi2GetString") }, (vr, nvr)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { set(c, const { function("fmi2SetReal") }, is_real, (vr, nvr), (value, nvr), |value| value) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { set(c, const { function("fmi2SetInteger") }, is_integer, (vr, nvr), (value, nvr), f64::from) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    let convert = |value| f64::from(value != fmi2False as fmi2Boolean);
    // SAFETY: the importer keeps the standard.
    unsafe { set(c, const { function("fmi2SetBoolean") }, is_boolean, (vr, nvr), (value, nvr), convert) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(c, const { function("fmi2SetString") }, (vr, nvr)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::get(c, const { function("fmi2GetFMUstate") }, FMUstate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::set(c, const { function("fmi2SetFMUstate") }, FMUstate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::free(c, const { function("fmi2FreeFMUstate") }, FMUstate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::serialized_size(c, const { function("fmi2SerializedFMUstateSize") }, FMUstate, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    let bytes = serializedState.cast();
    // SAFETY: the importer keeps the standard.
    unsafe { states::serialize(c, const { function("fmi2SerializeFMUstate") }, FMUstate, bytes, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    let bytes = serializedState.cast();
    // SAFETY: the importer keeps the standard.
    unsafe { states::deserialize(c, const { function("fmi2DeSerializeFMUstate") }, bytes, size, FMUstate) }
}

const NEVER_PENDING: &str = "a step is never pending, so there is no such status";

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(
    c: fmi2Component,
    _: fmi2StatusKind,
    _: *mut fmi2Status,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { call(c, const { function("fmi2GetStatus") }, |_| no_status("the status of a step")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2GetRealStatus") }, |instance| {
            if s != fmi2StatusKind_fmi2LastSuccessfulTime {
                return no_status("a real status other than fmi2LastSuccessfulTime");
            }
            place(value, "the pointer to the status")?.write(instance.time());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    _: fmi2StatusKind,
    _: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { call(c, const { function("fmi2GetIntegerStatus") }, |_| no_status("an integer status")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2GetBooleanStatus") }, |_| {
            if s != fmi2StatusKind_fmi2Terminated {
                return no_status("a Boolean status other than fmi2Terminated");
            }
            place(value, "the pointer to the status")?.write(fmi2False as fmi2Boolean);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    _: fmi2StatusKind,
    _: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { call(c, const { function("fmi2GetStringStatus") }, |_| no_status("a string status")) }
}

fn no_status(what: &'static str) -> Result<(), FmiError> {
    Err(FmiError::NoSuchStatus { what, why: NEVER_PENDING })
}
