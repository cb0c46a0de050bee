//! FMI 3.0: instances, their life, steps and saved states. Values are in `fmi3_values`.

use std::ffi::c_char;
use std::path::PathBuf;

use super::{call, free, instantiate, message_for_c, place, set_debug_logging, states, text};
use crate::bindings::fmi3::{
    fmi3Boolean, fmi3Byte, fmi3ClockUpdateCallback, fmi3FMUState, fmi3Float64, fmi3Instance,
    fmi3InstanceEnvironment, fmi3IntermediateUpdateCallback, fmi3LockPreemptionCallback,
    fmi3LogMessageCallback, fmi3Status, fmi3String, fmi3UnlockPreemptionCallback, fmi3ValueReference,
    fmi3Version,
};
use crate::error::FmiError;
use crate::lifecycle::function;
use crate::log::{Log, Sink};
use crate::models::Use;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetVersion() -> *const c_char {
    fmi3Version.as_ptr().cast()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    earlyReturnAllowed: fmi3Boolean,
    _requiredIntermediateVariables: *const fmi3ValueReference,
    _nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    _intermediateUpdate: fmi3IntermediateUpdateCallback,
) -> fmi3Instance {
    let usage = if eventModeUsed { Use::CoSimulationWithEvents } else { Use::CoSimulation };
    let log = Log::new(sink(logMessage, instanceEnvironment), loggingOn);
    // SAFETY: the importer keeps the standard.
    unsafe {
        let resources = text(resourcePath).map(PathBuf::from);
        let function = const { function("fmi3InstantiateCoSimulation") };
        instantiate(function, log, Ok((usage, earlyReturnAllowed)), instantiationToken, resources)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
) -> fmi3Instance {
    let log = Log::new(sink(logMessage, instanceEnvironment), loggingOn);
    // SAFETY: the importer keeps the standard.
    unsafe {
        let resources = text(resourcePath).map(PathBuf::from);
        let function = const { function("fmi3InstantiateModelExchange") };
        instantiate(function, log, Ok((Use::ModelExchange, false)), instantiationToken, resources)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    _clockUpdate: fmi3ClockUpdateCallback,
    _lockPreemption: fmi3LockPreemptionCallback,
    _unlockPreemption: fmi3UnlockPreemptionCallback,
) -> fmi3Instance {
    let log = Log::new(sink(logMessage, instanceEnvironment), loggingOn);
    let name = "fmi3InstantiateScheduledExecution";
    let refused =
        Err(FmiError::Unsupported { function: name, why: "this FMU is not for Scheduled Execution" });
    // SAFETY: NULL is allowed as token.
    unsafe {
        instantiate(
            const { function("fmi3InstantiateScheduledExecution") },
            log,
            refused,
            std::ptr::null(),
            None,
        )
    }
}

/// Hands messages to the importer's logger.
fn sink(callback: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment) -> Sink {
    Box::new(move |status, category, message| {
        let Some(callback) = callback else { return };
        let message = message_for_c(message);
        // SAFETY: the importer keeps the standard: its callback works for the life of the instance, and the strings
        // live until it returns.
        unsafe { callback(environment, status as fmi3Status, category.as_ptr(), message.as_ptr()) }
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: the importer keeps the standard.
    unsafe { free(instance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    loggingOn: fmi3Boolean,
    nCategories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    let function = const { function("fmi3SetDebugLogging") };
    // SAFETY: the importer keeps the standard.
    unsafe { set_debug_logging(instance, function, loggingOn, categories, nCategories) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    _toleranceDefined: fmi3Boolean,
    _tolerance: fmi3Float64,
    startTime: fmi3Float64,
    stopTimeDefined: fmi3Boolean,
    stopTime: fmi3Float64,
) -> fmi3Status {
    let stop = stopTimeDefined.then_some(stopTime);
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EnterInitializationMode") }, |instance| {
            instance.set_up_experiment(startTime, stop)?;
            instance.enter_initialization();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3ExitInitializationMode") }, |instance| {
            instance.exit_initialization()
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3Terminate") }, |instance| {
            instance.terminate();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3Reset") }, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: fmi3Float64,
    communicationStepSize: fmi3Float64,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3DoStep") }, |instance| {
            let event = place(eventHandlingNeeded, "eventHandlingNeeded")?;
            let terminate = place(terminateSimulation, "terminateSimulation")?;
            let early = place(earlyReturn, "earlyReturn")?;
            let last = place(lastSuccessfulTime, "lastSuccessfulTime")?;
            let outcome = instance.step(currentCommunicationPoint, communicationStepSize);
            let time = instance.time();
            event.write(instance.needs_event_mode());
            terminate.write(false);
            early.write(outcome.is_ok() && time < currentCommunicationPoint + communicationStepSize);
            last.write(time);
            outcome
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::get(instance, const { function("fmi3GetFMUState") }, FMUState) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: fmi3Instance, FMUState: fmi3FMUState) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::set(instance, const { function("fmi3SetFMUState") }, FMUState) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { states::free(instance, const { function("fmi3FreeFMUState") }, FMUState) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        states::serialized_size(instance, const { function("fmi3SerializedFMUStateSize") }, FMUState, size)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    serializedState: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    let function = const { function("fmi3SerializeFMUState") };
    // SAFETY: the importer keeps the standard.
    unsafe { states::serialize(instance, function, FMUState, serializedState, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    let function = const { function("fmi3DeserializeFMUState") };
    // SAFETY: the importer keeps the standard.
    unsafe { states::deserialize(instance, function, serializedState, size, FMUState) }
}
