//! FMI 3.0: getting and setting values. Numbers have the types Float64, Int32, Boolean and Enumeration (which travels as Int64); clocks, texts
//! and binary variables are in `fmi3_buses`; the other types' functions exist and know no variable.

use super::{get, no_variables, set};
use crate::bindings::fmi3::{
    fmi3Boolean, fmi3Float32, fmi3Float64, fmi3Instance, fmi3Int8, fmi3Int16, fmi3Int32, fmi3Int64,
    fmi3Status, fmi3String, fmi3UInt8, fmi3UInt16, fmi3UInt32, fmi3UInt64, fmi3ValueReference,
};
use crate::lifecycle::function;
use crate::variables::Kind;

fn is_float64(kind: Kind) -> bool {
    matches!(kind, Kind::Float64)
}

/// Enumerations too: fmpy reads them with this function up to 0.3.23, where the standard has fmi3GetInt64.
fn is_int32(kind: Kind) -> bool {
    matches!(kind, Kind::Int32 | Kind::Enumeration(_))
}

fn is_enumeration(kind: Kind) -> bool {
    matches!(kind, Kind::Enumeration(_))
}

fn is_boolean(kind: Kind) -> bool {
    matches!(kind, Kind::Boolean)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3Float64,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetFloat64") };
    // SAFETY: the importer keeps the standard.
    unsafe { get(instance, function, is_float64, (references, count), (values, room), |value| value) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *const fmi3Float64,
    given: usize,
) -> fmi3Status {
    let function = const { function("fmi3SetFloat64") };
    // SAFETY: the importer keeps the standard.
    unsafe { set(instance, function, is_float64, (references, count), (values, given), |value| value) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3Int32,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetInt32") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        get(instance, function, is_int32, (references, count), (values, room), |value| value as fmi3Int32)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *const fmi3Int32,
    given: usize,
) -> fmi3Status {
    let function = const { function("fmi3SetInt32") };
    // SAFETY: the importer keeps the standard.
    unsafe { set(instance, function, is_int32, (references, count), (values, given), f64::from) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3Int64,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetInt64") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        get(instance, function, is_enumeration, (references, count), (values, room), |value| {
            value as fmi3Int64
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *const fmi3Int64,
    given: usize,
) -> fmi3Status {
    let function = const { function("fmi3SetInt64") };
    // SAFETY: the importer keeps the standard.
    unsafe {
        set(instance, function, is_enumeration, (references, count), (values, given), |value| value as f64)
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *mut fmi3Boolean,
    room: usize,
) -> fmi3Status {
    let function = const { function("fmi3GetBoolean") };
    // SAFETY: the importer keeps the standard.
    unsafe { get(instance, function, is_boolean, (references, count), (values, room), |value| value != 0.0) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    values: *const fmi3Boolean,
    given: usize,
) -> fmi3Status {
    let function = const { function("fmi3SetBoolean") };
    // A `bool` of Rust is 0 or 1, one from C may be any byte.
    let bytes = values.cast::<u8>();
    // SAFETY: the importer keeps the standard.
    unsafe {
        set(instance, function, is_boolean, (references, count), (bytes, given), |byte| f64::from(byte != 0))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3Float32,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetFloat32") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt8(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3Int8,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetInt8") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt8(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3UInt8,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetUInt8") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt16(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3Int16,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetInt16") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt16(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3UInt16,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetUInt16") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3UInt32,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetUInt32") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *mut fmi3UInt64,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3GetUInt64") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3Float32,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetFloat32") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt8(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3Int8,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetInt8") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt8(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3UInt8,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetUInt8") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt16(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3Int16,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetInt16") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt16(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3UInt16,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetUInt16") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt32(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3UInt32,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetUInt32") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt64(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3UInt64,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetUInt64") }, (references, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetString(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    count: usize,
    _: *const fmi3String,
    _: usize,
) -> fmi3Status {
    // SAFETY: the importer keeps the standard.
    unsafe { no_variables(instance, const { function("fmi3SetString") }, (references, count)) }
}
