//! C strings, arrays, messages, and panics that stop here.

use std::ffi::{CStr, c_char, c_int};
use std::path::Path;
use std::ptr;

use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Coordinates, Pose, RigFile, TensionLimits};
use cable_robot_boundary::guarded as guard;

/// What failed, for people.
pub type Failure = String;

/// Where a message goes: `size` bytes, the last of which is 0.
#[derive(Clone, Copy)]
pub struct Message {
    pub text: *mut c_char,
    pub size: usize,
}

impl Message {
    /// # Safety
    /// `text` is null or has `size` bytes.
    unsafe fn put(self, failure: &str) {
        if self.text.is_null() || self.size == 0 {
            return;
        }
        let count =
            (0..=failure.len().min(self.size - 1)).rev().find(|n| failure.is_char_boundary(*n)).unwrap_or(0);
        // SAFETY: `count` and the closing 0 fit into `size` bytes.
        unsafe {
            ptr::copy_nonoverlapping(failure.as_ptr().cast(), self.text, count);
            *self.text.add(count) = 0;
        }
    }
}

/// Runs what may fail or panic, in the default floating-point environment: 0, or 1 and a message.
///
/// # Safety
/// As [`Message::put`].
pub unsafe fn guarded(message: Message, act: impl FnOnce() -> Result<(), Failure>) -> c_int {
    let failure = match guard(act) {
        Ok(Ok(())) => return 0,
        Ok(Err(failure)) => failure,
        Err(panic) => format!("the library has failed: this is a defect of CableRobot: {panic}"),
    };
    // SAFETY: as the caller promises.
    unsafe { message.put(&failure) };
    1
}

/// Puts what was made at `*object`.
///
/// # Safety
/// `object` can be written.
pub unsafe fn give<T>(object: *mut *mut T, made: T) {
    // SAFETY: as the caller promises.
    unsafe { *object = Box::into_raw(Box::new(made)) };
}

/// Frees what [`give`] gave; null is allowed.
///
/// # Safety
/// `object` is null or was given and is not used any more.
pub unsafe fn free<T>(object: *mut T) {
    if !object.is_null() {
        // SAFETY: as the caller promises.
        drop(unsafe { Box::from_raw(object) });
    }
}

/// Six finite numbers.
///
/// # Safety
/// `values` points to six.
pub unsafe fn coordinates(name: &str, values: *const f64) -> Result<Coordinates, Failure> {
    if values.is_null() {
        return Err(format!("{name} is missing"));
    }
    // SAFETY: as the caller promises.
    let found = Coordinates::from_column_slice(unsafe { std::slice::from_raw_parts(values, 6) });
    for (value, coordinate) in found.iter().zip(["x", "y", "z", "roll", "pitch", "yaw"]) {
        finite(&format!("{name}.{coordinate}"), *value)?;
    }
    Ok(found)
}

pub fn finite(name: &str, value: f64) -> Result<(), Failure> {
    if value.is_finite() { Ok(()) } else { Err(format!("{name} = {value} is not allowed: must be finite")) }
}

/// Writes a pose to six numbers.
///
/// # Safety
/// `to` points to six.
pub unsafe fn put_pose(pose: &Pose, to: *mut f64) {
    // SAFETY: as the caller promises.
    unsafe { ptr::copy_nonoverlapping(pose.0.as_ptr(), to, 6) };
}

/// What both objects are made with.
#[derive(Clone, Copy)]
pub struct Settings {
    /// Path of a rig file, empty or null for the paper's rig.
    pub rig_file: *const c_char,
    pub lambda: f64,
    pub eta: f64,
    pub planner: c_int,
    pub planner_period: f64,
    pub least_tension: f64,
    /// 0 or less for the rig's.
    pub greatest_tension: f64,
}

impl Settings {
    /// # Safety
    /// `rig_file` is null or a C string.
    pub unsafe fn parameters(&self) -> Result<ControllerParameters, Failure> {
        // SAFETY: as the caller promises.
        let path = (!self.rig_file.is_null()).then(|| unsafe { CStr::from_ptr(self.rig_file) });
        let path =
            path.map(|path| path.to_str().map_err(|_| "rigFile is not UTF-8".to_owned())).transpose()?;
        let mut rig = match path.filter(|path| !path.is_empty()) {
            None => ControllerParameters::default().rig,
            Some(path) => read(Path::new(path))?,
        };
        for cable in rig.cables.iter_mut() {
            let TensionLimits { min, max } = cable.limits;
            cable.limits = TensionLimits {
                min: min.max(self.least_tension),
                max: if self.greatest_tension > 0.0 { self.greatest_tension } else { max },
            };
        }
        let planner = PlannerKind::numbered(self.planner)
            .ok_or_else(|| format!("planner = {} is not allowed: 1 is Bounded, 2 is Exact", self.planner))?;
        let parameters = ControllerParameters {
            planner,
            lambda: self.lambda,
            eta: self.eta,
            planner_period: self.planner_period,
            ..ControllerParameters::of(&rig)
        };
        parameters.validate().map_err(|error| error.to_string())?;
        Ok(parameters)
    }
}

fn read(path: &Path) -> Result<cable_robot::robot::Rig, Failure> {
    let text =
        cable_robot_files::read_text(path).map_err(|error| format!("rigFile {}: {error}", path.display()))?;
    let file = RigFile::parse(&text).map_err(|error| format!("rigFile {}: {error}", path.display()))?;
    Ok(file.rig)
}
