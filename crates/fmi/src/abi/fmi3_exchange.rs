//! FMI 3.0: events, and Model Exchange.

use super::exchange::{self, Direction};
use super::{call, place};
use crate::bindings::fmi3::{fmi3Boolean, fmi3Float64, fmi3Instance, fmi3Status, fmi3ValueReference};
use crate::instance::Instance;
use crate::lifecycle::function;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EnterEventMode") }, |instance| {
            instance.enter_events();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EnterStepMode") }, |instance| {
            instance.enter_steps();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EvaluateDiscreteStates(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EvaluateDiscreteStates") }, |instance| {
            instance.evaluate_discrete_states();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: fmi3Instance,
    discreteStatesNeedUpdate: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    nominalsOfContinuousStatesChanged: *mut fmi3Boolean,
    valuesOfContinuousStatesChanged: *mut fmi3Boolean,
    nextEventTimeDefined: *mut fmi3Boolean,
    nextEventTime: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3UpdateDiscreteStates") }, |instance| {
            let flags = [
                place(discreteStatesNeedUpdate, "discreteStatesNeedUpdate")?,
                place(terminateSimulation, "terminateSimulation")?,
                place(nominalsOfContinuousStatesChanged, "nominalsOfContinuousStatesChanged")?,
                place(valuesOfContinuousStatesChanged, "valuesOfContinuousStatesChanged")?,
                place(nextEventTimeDefined, "nextEventTimeDefined")?,
            ];
            place(nextEventTime, "nextEventTime")?.write(0.0);
            for flag in flags {
                flag.write(false);
            }
            instance.update_discrete_states();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3EnterContinuousTimeMode") }, |instance| {
            instance.enter_continuous_time();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: fmi3Instance,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    enterEventMode: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3CompletedIntegratorStep") }, |_| {
            place(enterEventMode, "enterEventMode")?.write(false);
            place(terminateSimulation, "terminateSimulation")?.write(false);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { call(instance, const { function("fmi3SetTime") }, |instance| instance.set_time(time)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(
    instance: fmi3Instance,
    x: *const fmi3Float64,
    n: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { exchange::set_states(instance, const { function("fmi3SetContinuousStates") }, (x, n)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    instance: fmi3Instance,
    x: *mut fmi3Float64,
    n: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(
            instance,
            const { function("fmi3GetContinuousStateDerivatives") },
            (x, n),
            Instance::give_derivatives,
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(
    instance: fmi3Instance,
    x: *mut fmi3Float64,
    n: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(
            instance,
            const { function("fmi3GetEventIndicators") },
            (x, n),
            Instance::give_indicators,
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(
    instance: fmi3Instance,
    x: *mut fmi3Float64,
    n: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(instance, const { function("fmi3GetContinuousStates") }, (x, n), Instance::give_states)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    instance: fmi3Instance,
    x: *mut fmi3Float64,
    n: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        exchange::fill(
            instance,
            const { function("fmi3GetNominalsOfContinuousStates") },
            (x, n),
            Instance::give_nominals,
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(
    instance: fmi3Instance,
    number: *mut usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3GetNumberOfEventIndicators") }, |instance| {
            place(number, "the pointer to the number")?.write(instance.number_of_indicators());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(
    instance: fmi3Instance,
    number: *mut usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        call(instance, const { function("fmi3GetNumberOfContinuousStates") }, |instance| {
            place(number, "the pointer to the number")?.write(instance.number_of_states());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    nUnknowns: usize,
    knowns: *const fmi3ValueReference,
    nKnowns: usize,
    seed: *const fmi3Float64,
    nSeed: usize,
    sensitivity: *mut fmi3Float64,
    nSensitivity: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe {
        let direction = Direction {
            unknown: (unknowns, nUnknowns),
            known: (knowns, nKnowns),
            seed: (seed, nSeed),
            sensitivity: (sensitivity, nSensitivity),
        };
        exchange::directional_derivative(
            instance,
            const { function("fmi3GetDirectionalDerivative") },
            direction,
        )
    }
}
