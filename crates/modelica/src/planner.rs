//! The planner as an object of C.

use std::ffi::{c_char, c_int};

use cable_robot::plan::planner::Situation;
use cable_robot::plan::{ControllerParameters, Planner};
use cable_robot::robot::Pose;

use crate::boundary::{Failure, Message, Settings, coordinates, free, give, guarded, put_pose};

/// A planner and its parameters.
pub struct Object {
    parameters: ControllerParameters,
    planner: Planner,
}

/// Makes a planner at `*object`.
///
/// # Safety
/// `object` can be written, `rig_file` is null or a C string, `message` is null or has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cable_robot_planner_create(
    object: *mut *mut Object,
    rig_file: *const c_char,
    lambda: f64,
    eta: f64,
    planner: c_int,
    least_tension: f64,
    greatest_tension: f64,
    message: *mut c_char,
    size: usize,
) -> c_int {
    let planner_period = ControllerParameters::default().planner_period;
    let settings =
        Settings { rig_file, lambda, eta, planner, planner_period, least_tension, greatest_tension };
    let make = || {
        // SAFETY: as the caller promises.
        let parameters = unsafe { settings.parameters() }?;
        // SAFETY: as the caller promises.
        unsafe { give(object, Object { parameters, planner: Planner::from(parameters) }) };
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { guarded(Message { text: message, size }, make) }
}

/// Frees it; null is allowed.
///
/// # Safety
/// `object` is null or was made here and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cable_robot_planner_free(object: *mut Object) {
    // SAFETY: as the caller promises.
    unsafe { free(object) };
}

/// The set point to give now to a robot that is at `pose`, moves with `rates` and makes for `active`, on the way to `goal`: to `set_point`, which is
/// `active` if there is none better.
///
/// # Safety
/// `object` was made here; the arrays have six numbers; `message` is null or has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cable_robot_planner_step(
    object: *const Object,
    pose: *const f64,
    rates: *const f64,
    active: *const f64,
    goal: *const f64,
    hold: f64,
    set_point: *mut f64,
    message: *mut c_char,
    size: usize,
) -> c_int {
    let step = || -> Result<(), Failure> {
        // SAFETY: as the caller promises.
        let object = unsafe { object.as_ref() }.ok_or("there is no planner")?;
        // SAFETY: as the caller promises.
        let [pose, rates, active, goal] = unsafe {
            [
                coordinates("pose", pose)?,
                coordinates("rates", rates)?,
                coordinates("setPoint", active)?,
                coordinates("goalPose", goal)?,
            ]
        };
        if !(hold.is_finite() && hold >= 0.0) {
            return Err(format!("hold = {hold} is not allowed: must be 0 or greater (s)"));
        }
        let (pose, active, goal) = (Pose(pose), Pose(active), Pose(goal));
        let rest = object.parameters.rest();
        let now = Situation { pose: &pose, rates: &rates, set_point: &active, hold, rest };
        let aim = object.planner.aim(&active, &goal);
        let next = object.planner.next_set_point(&now, &aim).unwrap_or(active);
        // SAFETY: as the caller promises.
        unsafe { put_pose(&next, set_point) };
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { guarded(Message { text: message, size }, step) }
}
