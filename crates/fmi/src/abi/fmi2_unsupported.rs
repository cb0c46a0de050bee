//! The functions of FMI 2.0 that these FMUs do not support: each exists, since importers look them all up, and says why
//! it does nothing.

use super::refuse;
use crate::bindings::fmi2::{
    fmi2Boolean, fmi2Component, fmi2EventInfo, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference,
};
use crate::lifecycle::function;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2CancelStep") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    _: *const fmi2ValueReference,
    _: usize,
    _: *const fmi2ValueReference,
    _: usize,
    _: *const fmi2Real,
    _: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetDirectionalDerivative") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    _: *const fmi2ValueReference,
    _: usize,
    _: *const fmi2Integer,
    _: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2SetRealInputDerivatives") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    _: *const fmi2ValueReference,
    _: usize,
    _: *const fmi2Integer,
    _: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetRealOutputDerivatives") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2EnterEventMode") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: fmi2Component, _: *mut fmi2EventInfo) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2NewDiscreteStates") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2EnterContinuousTimeMode") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _: fmi2Boolean,
    _: *mut fmi2Boolean,
    _: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2CompletedIntegratorStep") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, _: fmi2Real) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2SetTime") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: fmi2Component,
    _: *const fmi2Real,
    _: usize,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2SetContinuousStates") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: fmi2Component, _: *mut fmi2Real, _: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetDerivatives") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(c: fmi2Component, _: *mut fmi2Real, _: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetEventIndicators") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: fmi2Component, _: *mut fmi2Real, _: usize) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetContinuousStates") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    _: *mut fmi2Real,
    _: usize,
) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2GetNominalsOfContinuousStates") }) }
}
