//! The functions of FMI 3.0 that these FMUs do not support: each exists, since importers look them all up, and says why
//! it does nothing.

use super::refuse;
use crate::bindings::fmi3::{
    fmi3DependencyKind, fmi3Float64, fmi3Instance, fmi3Int32, fmi3IntervalQualifier, fmi3Status, fmi3UInt64,
    fmi3ValueReference,
};
use crate::lifecycle::function;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    instance: fmi3Instance,
    _: fmi3ValueReference,
    _: *mut usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetNumberOfVariableDependencies") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetVariableDependencies(
    instance: fmi3Instance,
    _: fmi3ValueReference,
    _: *mut usize,
    _: *mut fmi3ValueReference,
    _: *mut usize,
    _: *mut fmi3DependencyKind,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetVariableDependencies") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3Float64,
    _: usize,
    _: *mut fmi3Float64,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetAdjointDerivative") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3Int32,
    _: *mut fmi3Float64,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetOutputDerivatives") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetIntervalDecimal(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *mut fmi3Float64,
    _: *mut fmi3IntervalQualifier,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetIntervalDecimal") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetIntervalFraction(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *mut fmi3UInt64,
    _: *mut fmi3UInt64,
    _: *mut fmi3IntervalQualifier,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetIntervalFraction") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetShiftDecimal(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetShiftDecimal") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetShiftFraction(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *mut fmi3UInt64,
    _: *mut fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3GetShiftFraction") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetIntervalDecimal(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3SetIntervalDecimal") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetIntervalFraction(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3UInt64,
    _: *const fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3SetIntervalFraction") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetShiftDecimal(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3SetShiftDecimal") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetShiftFraction(
    instance: fmi3Instance,
    _: *const fmi3ValueReference,
    _: usize,
    _: *const fmi3UInt64,
    _: *const fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3SetShiftFraction") }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ActivateModelPartition(
    instance: fmi3Instance,
    _: fmi3ValueReference,
    _: fmi3Float64,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { refuse(instance, const { function("fmi3ActivateModelPartition") }) }
}
