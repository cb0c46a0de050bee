//! The controller as an object of C.

use std::ffi::{c_char, c_int};
use std::ptr;

use cable_robot::plan::{Controller, ControllerInputs, ControllerParameters};
use cable_robot::robot::{PerCable, Pose};

use crate::boundary::{Failure, Message, Settings, coordinates, finite, free, give, guarded, put_pose};

/// A controller that starts with its first step: there its pose is known.
pub struct Object {
    parameters: ControllerParameters,
    running: Option<Controller>,
}

/// Makes a controller at `*object`; what it is not told is as in the FMU.
///
/// # Safety
/// `object` can be written, `rig_file` is null or a C string, `message` is null or has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cable_robot_controller_create(
    object: *mut *mut Object,
    rig_file: *const c_char,
    lambda: f64,
    eta: f64,
    planner: c_int,
    planner_period: f64,
    least_tension: f64,
    greatest_tension: f64,
    command_delay: f64,
    observer_bound: f64,
    message: *mut c_char,
    size: usize,
) -> c_int {
    let settings =
        Settings { rig_file, lambda, eta, planner, planner_period, least_tension, greatest_tension };
    let make = || {
        // SAFETY: as the caller promises.
        let parameters =
            ControllerParameters { command_delay, observer_bound, ..unsafe { settings.parameters() }? };
        parameters.validate().map_err(|error| error.to_string())?;
        // SAFETY: as the caller promises.
        unsafe { give(object, Object { parameters, running: None }) };
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
pub unsafe extern "C" fn cable_robot_controller_free(object: *mut Object) {
    // SAFETY: as the caller promises.
    unsafe { free(object) };
}

/// One step: reads the pose measured at `time` (s) and the goal, gives the tensions to hold for `hold` (s). `cables` is the length of `motor_tension`.
///
/// # Safety
/// `object` was made here; `pose`, `goal` and `set_point` have six numbers, `motor_tension` has `cables`, the others one; `message` is null or has
/// `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cable_robot_controller_step(
    object: *mut Object,
    time: f64,
    hold: f64,
    pose: *const f64,
    goal: *const f64,
    enable: c_int,
    motor_tension: *mut f64,
    cables: usize,
    set_point: *mut f64,
    tension_margin: *mut f64,
    status: *mut c_int,
    message: *mut c_char,
    size: usize,
) -> c_int {
    let step = || -> Result<(), Failure> {
        // SAFETY: as the caller promises.
        let object = unsafe { object.as_mut() }.ok_or("there is no controller")?;
        let count = object.parameters.rig.cables.len();
        if cables != count {
            return Err(format!("motorTension has {cables} elements: the rig has {count} cables"));
        }
        finite("time", time)?;
        if !(hold.is_finite() && hold > 0.0) {
            return Err(format!("samplePeriod = {hold} is not allowed: must be greater than 0 (s)"));
        }
        let none = PerCable::filled(count, 0.0);
        let inputs = ControllerInputs {
            // SAFETY: as the caller promises.
            encoder_pose: Pose(unsafe { coordinates("encoderPose", pose) }?),
            cable_length: none,
            measured_tension: none,
            // SAFETY: as the caller promises.
            goal_pose: Pose(unsafe { coordinates("goalPose", goal) }?),
            enable: enable != 0,
        };
        let outputs = object.step(time, hold, &inputs)?;
        // SAFETY: as the caller promises.
        unsafe {
            ptr::copy_nonoverlapping(outputs.motor_tension.as_ptr(), motor_tension, count);
            put_pose(&outputs.set_point, set_point);
            *tension_margin = outputs.tension_margin;
            *status = outputs.status.number();
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { guarded(Message { text: message, size }, step) }
}

impl Object {
    fn step(
        &mut self,
        time: f64,
        hold: f64,
        inputs: &ControllerInputs,
    ) -> Result<cable_robot::plan::ControllerOutputs, Failure> {
        if self.running.is_none() {
            let started =
                Controller::new(self.parameters, time, inputs).map_err(|error| error.to_string())?;
            self.running = Some(started);
        }
        let controller = self.running.as_mut().ok_or("the controller has not started")?;
        if inputs.enable {
            self.parameters.check_step(hold).map_err(|error| error.to_string())?;
        }
        controller.step(time, hold, inputs);
        Ok(*controller.outputs())
    }
}
