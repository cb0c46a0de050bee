//! The functions of FMI 2.0 that these FMUs do not support: each exists, since importers look them all up, and says why
//! it does nothing.

use super::refuse;
use crate::bindings::fmi2::{fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};
use crate::lifecycle::function;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(c, const { function("fmi2CancelStep") }) }
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
