//! FMI 2.0 Model Exchange.

use super::exchange::{self, Direction};
use super::{call, place};
use crate::bindings::fmi2::{
    fmi2Boolean, fmi2Component, fmi2EventInfo, fmi2False, fmi2Real, fmi2Status, fmi2ValueReference,
};
use crate::instance::Instance;
use crate::lifecycle::function;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2EnterEventMode") }, |instance| {
            instance.enter_events();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(
    c: fmi2Component,
    eventInfo: *mut fmi2EventInfo,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2NewDiscreteStates") }, |instance| {
            let info = place(eventInfo, "the event info")?;
            instance.update_discrete_states();
            let no = fmi2False as fmi2Boolean;
            info.write(fmi2EventInfo {
                newDiscreteStatesNeeded: no,
                terminateSimulation: no,
                nominalsOfContinuousStatesChanged: no,
                valuesOfContinuousStatesChanged: no,
                nextEventTimeDefined: no,
                nextEventTime: 0.0,
            });
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2EnterContinuousTimeMode") }, |instance| {
            instance.enter_continuous_time();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    enterEventMode: *mut fmi2Boolean,
    terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(c, const { function("fmi2CompletedIntegratorStep") }, |_| {
            place(enterEventMode, "enterEventMode")?.write(fmi2False as fmi2Boolean);
            place(terminateSimulation, "terminateSimulation")?.write(fmi2False as fmi2Boolean);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { call(c, const { function("fmi2SetTime") }, |instance| instance.set_time(time)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: fmi2Component,
    x: *const fmi2Real,
    nx: usize,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { exchange::set_states(c, const { function("fmi2SetContinuousStates") }, (x, nx)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: fmi2Component, x: *mut fmi2Real, n: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { exchange::fill(c, const { function("fmi2GetDerivatives") }, (x, n), Instance::give_derivatives) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(c: fmi2Component, x: *mut fmi2Real, n: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(c, const { function("fmi2GetEventIndicators") }, (x, n), Instance::give_indicators)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, n: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { exchange::fill(c, const { function("fmi2GetContinuousStates") }, (x, n), Instance::give_states) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    x: *mut fmi2Real,
    n: usize,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(
            c,
            const { function("fmi2GetNominalsOfContinuousStates") },
            (x, n),
            Instance::give_nominals,
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        let direction = Direction {
            unknown: (vUnknown_ref, nUnknown),
            known: (vKnown_ref, nKnown),
            seed: (dvKnown, nKnown),
            sensitivity: (dvUnknown, nUnknown),
        };
        exchange::directional_derivative(c, const { function("fmi2GetDirectionalDerivative") }, direction)
    }
}
