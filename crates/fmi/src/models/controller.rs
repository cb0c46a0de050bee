//! The way from values to a [`Controller`] and back.

pub(super) mod enumerations;
mod parameters;
mod rows;

use super::Interface;
use super::robot::{limits_of_cables, parameters, rig_with_limits, write_limits, write_rig, write_robot};
use crate::values::Values;
use crate::variables::{Kind, Row};
use cable_robot::control::{Reference, static_tensions};
use cable_robot::plan::{
    Check, Controller, ControllerInputs, ControllerOutputs, ControllerParameters, Fault, Pending,
    PlannerKind, PoseSource, Status, Tuning,
};
use cable_robot::robot::{ParameterError, PerCable, Pose, Rig, Shape as PaperShape, TensionLimits};
use nalgebra::Vector6;

use parameters::*;
use rows::*;
pub use rows::{PLANNER_TICK, ROWS, rows_of};

/// Starts a controller with the parameters and inputs in `values`.
pub fn start(interface: &Interface, values: &Values, time: f64) -> Result<Controller, ParameterError> {
    if interface.rig().is_none() {
        parameters(values).validate()?;
    }
    check_numbers(interface, values)?;
    Controller::new(controller_parameters(interface, values), time, &inputs(values))
}

/// Enumerations, and the same as numbers.
const NUMBERED: [(&Row, &Row); 2] = [(&PLANNER, &PLANNER_NUMBER), (&POSE_SOURCE, &POSE_SOURCE_NUMBER)];

/// The number if it is set, or else the enumeration.
fn numbered(values: &Values, (item, number): (&Row, &Row)) -> i32 {
    match values.integer(number) {
        0 => values.integer(item),
        number => number,
    }
}

/// A number is one of the enumeration's, and says no other than what that was set to.
fn check_numbers(interface: &Interface, values: &Values) -> Result<(), ParameterError> {
    for (item, number) in NUMBERED {
        let (set, given, start) =
            (values.integer(number), values.integer(item), interface.start().integer(item));
        let Some(Kind::Enumeration(kind)) = interface.scalar(item.first).map(|scalar| scalar.row.kind) else {
            continue;
        };
        let allowed = match set {
            0 => continue,
            set if !kind.has(set.into()) => {
                let [first, last] = kind.bounds();
                format!("must be 0 or from {first} to {last}")
            }
            set if given != start && given != set => {
                format!("{} = {given} says otherwise: leave one of them as it is", item.name)
            }
            _ => continue,
        };
        return Err(ParameterError { name: number.name.into(), value: set.into(), allowed: allowed.into() });
    }
    Ok(())
}

/// Rig, gains, planner and limits in `values`.
pub fn controller_parameters(interface: &Interface, values: &Values) -> ControllerParameters {
    let mut rig = match interface.rig() {
        Some(rig) => rig_with_limits(values, rig),
        None => Rig::paper(&parameters(values), common_limits(values)),
    };
    rig.accuracy = values.scalar(&ACCURACY);
    ControllerParameters {
        rig,
        lambda: values.scalar(&LAMBDA),
        eta: values.scalar(&ETA),
        planner_period: values.scalar(&PLANNER_PERIOD),
        bisection_steps: values.integer(&BISECTION_STEPS),
        // The table lets no other number in.
        planner: PlannerKind::numbered(numbered(values, NUMBERED[0])).unwrap_or(PlannerKind::Bounded),
        pose_source: if numbered(values, NUMBERED[1]) == 2 {
            PoseSource::CableLengths
        } else {
            PoseSource::EncoderPose
        },
        force_loop: values.boolean(&FORCE_LOOP),
        position_tolerance: values.scalar(&POSITION_TOLERANCE),
        angle_tolerance: values.scalar(&ANGLE_TOLERANCE),
        hold_compensation: values.boolean(&HOLD_COMPENSATION),
        command_delay: values.scalar(&COMMAND_DELAY),
        observer_bound: values.scalar(&OBSERVER_BOUND),
        mass_tolerance: values.scalar(&MASS_TOLERANCE),
        encoder_resolution: values.scalar(&ENCODER_RESOLUTION),
        disturbance_bound: values.scalar(&DISTURBANCE_BOUND),
        max_speed: values.scalar(&MAX_SPEED),
        max_angular_rate: values.scalar(&MAX_ANGULAR_RATE),
        max_cable_speed: values.scalar(&MAX_CABLE_SPEED),
        max_tension_rate: values.scalar(&MAX_TENSION_RATE),
        lift: values.scalar(&LIFT),
        largest_step: values.scalar(&LARGEST_STEP),
    }
}

/// Gains, limits and tolerances in `values`: what may change between two steps.
pub fn tuning(interface: &Interface, values: &Values) -> Tuning {
    let limits = match interface.rig() {
        Some(_) => limits_of_cables(values),
        None => PerCable::filled(interface.cables(), common_limits(values)),
    };
    Tuning {
        lambda: values.scalar(&LAMBDA),
        eta: values.scalar(&ETA),
        position_tolerance: values.scalar(&POSITION_TOLERANCE),
        angle_tolerance: values.scalar(&ANGLE_TOLERANCE),
        max_speed: values.scalar(&MAX_SPEED),
        max_angular_rate: values.scalar(&MAX_ANGULAR_RATE),
        max_cable_speed: values.scalar(&MAX_CABLE_SPEED),
        max_tension_rate: values.scalar(&MAX_TENSION_RATE),
        limits,
    }
}

/// Whether a controller that was saved at `time` (s) runs with the parameters in `values`, and its clock ticks or does not.
pub fn is_of(interface: &Interface, values: &Values, controller: &Controller, time: f64) -> bool {
    let ticks = interface
        .scalar(PLANNER_TICK.first)
        .is_none_or(|_| [0.0, 1.0].contains(&values.scalar(&PLANNER_TICK)));
    ticks && controller.is_of(&controller_parameters(interface, values)) && controller.holds_until() == time
}

fn common_limits(values: &Values) -> TensionLimits {
    // -0 is 0
    TensionLimits { min: values.scalar(&MIN_TENSION) + 0.0, max: values.scalar(&MAX_TENSION) }
}

/// Whether the controller may pull.
pub fn is_enabled(values: &Values) -> bool {
    values.boolean(&ENABLE)
}

/// What the controller reads in a step.
pub fn inputs(values: &Values) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: values.pose(&ENCODER_POSE),
        cable_length: values.cables(&CABLE_LENGTH),
        measured_tension: values.cables(&MEASURED_TENSION),
        goal_pose: values.pose(&GOAL_POSE),
        enable: is_enabled(values),
    }
}

/// Copies the outputs into `values`.
pub fn write(outputs: &ControllerOutputs, values: &mut Values) {
    values.write(&MOTOR_TENSION, outputs.motor_tension);
    values.write(&SET_POINT, outputs.set_point.0.iter().copied());
    values.write(&SET_POINT_INDEX, [outputs.set_point_index.into()]);
    values.write(&REFERENCE, outputs.reference.pose.0.iter().copied());
    values.write(&REFERENCE_VELOCITY, outputs.reference.rates.iter().copied());
    values.write(&REFERENCE_ACCELERATION, outputs.reference.accelerations.iter().copied());
    values.write(&ESTIMATED_POSE, outputs.estimated_pose.0.iter().copied());
    values.write(&ESTIMATED_VELOCITY, outputs.estimated_velocity.iter().copied());
    values.write(&STEADY, [outputs.steady.into()]);
    values.write(&AT_GOAL, [outputs.at_goal.into()]);
    values.write(&TENSION_MARGIN, [finite(outputs.tension_margin)]);
    values.write(&STATUS, [f64::from(outputs.status.number())]);
    values.write(&STATUS_NUMBER, [f64::from(outputs.status.number())]);
    values.write(&GOAL_DISTANCE, [outputs.goal_distance]);
    values.write(&FAULT, [f64::from(outputs.fault.check as i32)]);
    values.write(&FAULT_NUMBER, [f64::from(outputs.fault.check as i32)]);
    values.write(&FAULT_VALUE, [finite(outputs.fault.value)]);
    values.write(&FAULT_LIMIT, [outputs.fault.limit]);
    let [force, torque] = [0, 3].map(|k| outputs.disturbance.fixed_rows::<3>(k).into_owned());
    values.write(&DISTURBANCE_FORCE, force.iter().copied());
    values.write(&DISTURBANCE_TORQUE, torque.iter().copied());
    values.write(&ESTIMATED_MASS, [outputs.estimated_mass]);
    values.write(&PARAMETERS_PENDING, [f64::from(outputs.pending as i32)]);
}

/// FMI knows no infinite numbers; what overflows is beyond every limit as the greatest number too.
fn finite(value: f64) -> f64 {
    value.clamp(f64::MIN, f64::MAX)
}

/// Copies the settings into `values`, but for the rig.
fn write_settings(parameters: &ControllerParameters, values: &mut Values) {
    values.write(&LAMBDA, [parameters.lambda]);
    values.write(&ETA, [parameters.eta]);
    values.write(&PLANNER_PERIOD, [parameters.planner_period]);
    values.write(&BISECTION_STEPS, [parameters.bisection_steps.into()]);
    values.write(&PLANNER, [f64::from(parameters.planner as i32)]);
    let cable_lengths = parameters.pose_source == PoseSource::CableLengths;
    values.write(&POSE_SOURCE, [if cable_lengths { 2.0 } else { 1.0 }]);
    NUMBERED.iter().for_each(|(_, number)| values.write(number, [0.0]));
    values.write(&FORCE_LOOP, [parameters.force_loop.into()]);
    values.write(&POSITION_TOLERANCE, [parameters.position_tolerance]);
    values.write(&ANGLE_TOLERANCE, [parameters.angle_tolerance]);
    values.write(&HOLD_COMPENSATION, [parameters.hold_compensation.into()]);
    values.write(&COMMAND_DELAY, [parameters.command_delay]);
    values.write(&OBSERVER_BOUND, [parameters.observer_bound]);
    values.write(&ACCURACY, [parameters.rig.accuracy]);
    values.write(&MASS_TOLERANCE, [parameters.mass_tolerance]);
    values.write(&ENCODER_RESOLUTION, [parameters.encoder_resolution]);
    values.write(&DISTURBANCE_BOUND, [parameters.disturbance_bound]);
    values.write(&MAX_SPEED, [parameters.max_speed]);
    values.write(&MAX_ANGULAR_RATE, [parameters.max_angular_rate]);
    values.write(&MAX_CABLE_SPEED, [parameters.max_cable_speed]);
    values.write(&MAX_TENSION_RATE, [parameters.max_tension_rate]);
    values.write(&LIFT, [parameters.lift]);
    values.write(&LARGEST_STEP, [parameters.largest_step]);
}

/// Copies parameters into `values`. Those of the paper's interface take the paper's robot of the rig.
pub fn write_parameters(interface: &Interface, parameters: &ControllerParameters, values: &mut Values) {
    write_settings(parameters, values);
    match (interface.rig(), PaperShape::of(&parameters.rig)) {
        (None, Ok(shape)) => {
            write_robot(&shape.robot, values);
            let limits = parameters.rig.common_limits();
            values.write(&MIN_TENSION, [limits.min]);
            values.write(&MAX_TENSION, [limits.max]);
        }
        _ => {
            write_rig(&parameters.rig, values);
            write_limits(&parameters.rig, values);
        }
    }
}

/// The start values of a rig's table: at home, at rest.
pub fn write_start(parameters: &ControllerParameters, home: &Pose, values: &mut Values) {
    write_settings(parameters, values);
    write_rig(&parameters.rig, values);
    write_limits(&parameters.rig, values);
    values.write(&ENCODER_POSE, home.0.iter().copied());
    values.write(&GOAL_POSE, home.0.iter().copied());
    values.write(&CABLE_LENGTH, parameters.rig.cables_at(home).length);
    let tension = static_tensions(&parameters.rig, home, 0.0);
    values.write(&MEASURED_TENSION, tension.unwrap_or_else(|| parameters.rig.cables.map(|_| 0.0)));
}

/// Copies inputs into `values`.
pub fn write_inputs(inputs: &ControllerInputs, values: &mut Values) {
    values.write(&ENCODER_POSE, inputs.encoder_pose.0.iter().copied());
    values.write(&CABLE_LENGTH, inputs.cable_length);
    values.write(&MEASURED_TENSION, inputs.measured_tension);
    values.write(&GOAL_POSE, inputs.goal_pose.0.iter().copied());
    values.write(&ENABLE, [inputs.enable.into()]);
}

/// What [`write()`] wrote, of a fault without the pose.
pub fn outputs(values: &Values) -> ControllerOutputs {
    let (number, fault) = (values.integer(&STATUS), values.integer(&FAULT));
    let (force, torque) = (values.vector(&DISTURBANCE_FORCE), values.vector(&DISTURBANCE_TORQUE));
    ControllerOutputs {
        motor_tension: values.cables(&MOTOR_TENSION),
        set_point: values.pose(&SET_POINT),
        set_point_index: values.integer(&SET_POINT_INDEX),
        reference: Reference {
            pose: values.pose(&REFERENCE),
            rates: values.pose(&REFERENCE_VELOCITY).0,
            accelerations: values.pose(&REFERENCE_ACCELERATION).0,
        },
        estimated_pose: values.pose(&ESTIMATED_POSE),
        estimated_velocity: values.pose(&ESTIMATED_VELOCITY).0,
        steady: values.boolean(&STEADY),
        at_goal: values.boolean(&AT_GOAL),
        goal_distance: values.scalar(&GOAL_DISTANCE),
        tension_margin: values.scalar(&TENSION_MARGIN),
        disturbance: Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z),
        estimated_mass: values.scalar(&ESTIMATED_MASS),
        pending: Pending::ALL[values.integer(&PARAMETERS_PENDING).clamp(0, 2) as usize],
        status: Status::of(number),
        fault: Fault {
            check: Check::ALL.into_iter().find(|check| *check as i32 == fault).unwrap_or(Check::None),
            value: values.scalar(&FAULT_VALUE),
            limit: values.scalar(&FAULT_LIMIT),
            ..Fault::NONE
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::robot::TIME;
    use super::*;
    use crate::Model;
    use cable_robot::robot::RobotParameters;

    #[test]
    fn the_start_values_are_the_defaults_of_the_domain() {
        let interface = Model::Controller.interface();
        let values = interface.start().clone();
        assert_eq!(controller_parameters(&interface, &values), ControllerParameters::default());
        assert_eq!(inputs(&values).encoder_pose, Pose::default());
        assert_eq!(inputs(&values).goal_pose, Pose::default());
        assert!(inputs(&values).enable);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let interface = Model::Controller.interface();
        let mut values = interface.start().clone();
        for (k, scalar) in interface.scalars().enumerate() {
            values.put(scalar.reference, k as f64);
        }
        // Numbers that the paper's robot is recognised by.
        write_robot(&RobotParameters { a: 0.7, b: 0.2, ..RobotParameters::default() }, &mut values);
        let flags = [
            (&FORCE_LOOP, 1.0),
            (&HOLD_COMPENSATION, 1.0),
            (&ENABLE, 0.0),
            (&STEADY, 1.0),
            (&AT_GOAL, 1.0),
            (&STATUS, 5.0),
            (&FAULT, 4.0),
            (&STATUS_NUMBER, 5.0),
            (&FAULT_NUMBER, 4.0),
            (&PARAMETERS_PENDING, 2.0),
            (&PLANNER_NUMBER, 0.0),
            (&POSE_SOURCE_NUMBER, 0.0),
        ];
        let numbers = [(&PLANNER, 2.0), (&POSE_SOURCE, 2.0)];
        flags.iter().chain(&numbers).for_each(|(row, value)| values.put(row.first, *value));
        let mut copy = interface.start().clone();
        copy.put(TIME.first, values.at(TIME.first));
        write_parameters(&interface, &controller_parameters(&interface, &values), &mut copy);
        write_inputs(&inputs(&values), &mut copy);
        write(&outputs(&values), &mut copy);
        assert_eq!(copy, values);
    }
}
