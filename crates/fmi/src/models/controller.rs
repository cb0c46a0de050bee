//! The controller's variables, and the way from values to a [`Controller`] and back.

use super::Interface;
use super::robot::{
    A, ANCHOR, ATTACHMENT, B, CABLE_MAX, CABLE_MIN, G, GRAVITY, I1, I2, I3, INERTIA, M, MASS, REST_LENGTH,
    REST_TENSION, TIME, parameters, rig_with_limits, write_limits, write_rig, write_robot,
};
use crate::values::Values;
use crate::variables::units::{METRE, NEWTON, PER_SECOND, RADIAN, SECOND};
use crate::variables::{Enumeration, Kind, Row, Shape, Variability, input, output, parameter, setting};
use cable_robot::control::static_tensions;
use cable_robot::plan::{
    Check, Controller, ControllerInputs, ControllerOutputs, ControllerParameters, Fault, PlannerKind,
    PoseSource, Status,
};
use cable_robot::robot::{ParameterError, Pose, Rig, Shape as PaperShape, TensionLimits};

const PLANNER_TYPE: Enumeration = Enumeration {
    name: "Planner",
    description: "The reachable domain that the planner uses",
    first: 1,
    items: &PLANNERS,
};

/// The planners of a rig that is not the paper's: all but the first.
const GENERAL_PLANNER_TYPE: Enumeration =
    Enumeration { first: 2, items: PLANNERS.split_at(1).1, ..PLANNER_TYPE };

const PLANNERS: [(&str, &str); PlannerKind::ALL.len()] = {
    let mut items = [("", ""); PlannerKind::ALL.len()];
    let mut k = 0;
    while k < items.len() {
        items[k] = PlannerKind::ALL[k].described();
        k += 1;
    }
    items
};
const POSE_SOURCE_TYPE: Enumeration = Enumeration {
    name: "PoseSource",
    description: "Where the measured pose comes from",
    first: 1,
    items: &[
        ("EncoderPose", "The input encoderPose"),
        ("CableLengths", "Forward kinematics of the input cableLength"),
    ],
};
const STATUS_TYPE: Enumeration = Enumeration {
    name: "Status",
    description: "What the controller is doing",
    first: 1,
    items: &[
        ("Disabled", "enable is false: every motor gets minTension"),
        ("Holding", "At rest short of the goal, waiting for the planner's next decision"),
        ("Moving", "On the way to the active set point"),
        ("AtGoal", "At rest at the goal"),
        ("GoalUnreachable", "The goal cannot be had: the robot goes as far as is admissible and holds there"),
        (
            "SensorFault",
            "The measured pose made no sense (see fault): gravity is held at the last good pose until enable falls and rises, or, \
             if no pose has made sense since the start, until one does",
        ),
    ],
};
const FAULT_TYPE: Enumeration = Enumeration {
    name: "Fault",
    description: "Which check a measurement failed",
    first: 1,
    items: &[
        ("None", "None failed"),
        ("NotSet", "The first encoderPose was zero in all six coordinates, as if never set"),
        (
            "AboveAnchors",
            "Every anchor lies below its attachment; faultValue: height of the highest above it",
        ),
        ("Pitch", "encoderPose.pitch is too near a quarter turn; faultValue: its absolute value"),
        ("PositionJump", "encoderPose is too far from where the robot should be by now; faultValue: how far"),
        (
            "AngleJump",
            "encoderPose is turned too far from how the robot should be by now; faultValue: how far",
        ),
        (
            "CableLengths",
            "cableLength belongs to no pose near the last one; faultValue: the length that is farthest off",
        ),
        ("Singular", "No tensions give the wrench that the law wants"),
    ],
};

const LAMBDA: Row = Row {
    min: Some(0.0),
    max: Some(1000.0),
    ..parameter(8, "lambda", &PER_SECOND, &[3.0], "Gain lambda of Eq. (2), Table II")
};
const ETA: Row = Row {
    min: Some(0.0),
    max: Some(1000.0),
    ..parameter(9, "eta", &PER_SECOND, &[3.0], "Gain eta of Eq. (4), Table II")
};
const PLANNER_PERIOD: Row = Row {
    min: Some(0.0),
    ..parameter(10, "plannerPeriod", &SECOND, &[0.05], "Time T_s between two decisions of the planner")
};
const BISECTION_STEPS: Row = Row {
    min: Some(1.0),
    max: Some(52.0),
    ..setting(
        11,
        "bisectionSteps",
        Kind::Int32,
        &[8.0],
        "Number N of halvings in the search for a set point, Eq. (17)",
    )
};
const MIN_TENSION: Row = Row {
    min: Some(0.0),
    nominal: Some(10.0),
    ..parameter(12, "minTension", &NEWTON, &[0.0], "Least tension that is ever commanded")
};
const MAX_TENSION: Row = Row {
    min: Some(0.0),
    nominal: Some(10.0),
    ..parameter(13, "maxTension", &NEWTON, &[100.0], "Greatest tension that is ever commanded")
};
const PLANNER: Row = setting(
    14,
    "planner",
    Kind::Enumeration(&PLANNER_TYPE),
    &[1.0],
    "Which reachable domain the planner uses",
);
const GENERAL_PLANNER: Row = Row { kind: Kind::Enumeration(&GENERAL_PLANNER_TYPE), start: &[2.0], ..PLANNER };
const POSE_SOURCE: Row = setting(
    15,
    "poseSource",
    Kind::Enumeration(&POSE_SOURCE_TYPE),
    &[1.0],
    "Which input is the measured pose",
);
const FORCE_LOOP: Row =
    setting(16, "forceLoop", Kind::Boolean, &[0.0], "Whether the load cells correct the motors, Section VII");

const POSITION_TOLERANCE: Row = Row {
    min: Some(0.0),
    ..parameter(
        17,
        "positionTolerance",
        &METRE,
        &[0.0],
        "Distance (and speed in m/s) up to which the robot is at rest at a pose; 0 follows the rig's size, 2 mm for the paper's, 10 mm at most",
    )
};
const ANGLE_TOLERANCE: Row = Row {
    min: Some(0.0),
    ..parameter(
        18,
        "angleTolerance",
        &RADIAN,
        &[0.0],
        "The same for each angle (and its rate in rad/s); 0 is 0.01 rad",
    )
};
const HOLD_COMPENSATION: Row = setting(
    19,
    "holdCompensation",
    Kind::Boolean,
    &[0.0],
    "Whether the law is evaluated for the interval in which the command will act, instead of the instant of the measurement",
);
const COMMAND_DELAY: Row = Row {
    min: Some(0.0),
    ..parameter(
        20,
        "commandDelay",
        &SECOND,
        &[0.0],
        "With holdCompensation: from a measurement to the moment at which its command acts. 0: the controller is stepped before the plant; one step: both \
         with what the other gave a step before",
    )
};
const ENCODER_POSE: Row = input(
    100,
    "encoderPose",
    Shape::Pose,
    None,
    &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    "Measured pose of the platform",
);
const CABLE_LENGTH: Row = Row {
    seventh: 500,
    ..input(
        106,
        "cableLength",
        Shape::Cables,
        Some(&METRE),
        &[REST_LENGTH],
        "Measured cable length, used when poseSource = CableLengths",
    )
};
const MEASURED_TENSION: Row = Row {
    seventh: 510,
    nominal: Some(10.0),
    ..input(
        112,
        "measuredTension",
        Shape::Cables,
        Some(&NEWTON),
        &[REST_TENSION],
        "Load cell of the cable, used when forceLoop is true",
    )
};
const GOAL_POSE: Row = Row {
    variability: Variability::Discrete,
    ..input(
        118,
        "goalPose",
        Shape::Pose,
        None,
        &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "Goal x_f, may change at any time",
    )
};
const ENABLE: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..input(124, "enable", Shape::Scalar, None, &[1.0], "Whether the controller may pull")
};

/// What the measured pose follows from.
const MEASUREMENT: &[&Row] = &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH];
/// What mode and set point follow from: the controller starts where the robot is.
const MODE: &[&Row] = &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &ENABLE];
const MODE_AND_GOAL: &[&Row] =
    &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &GOAL_POSE, &ENABLE];
/// What the tensions follow from: at rest at the set point the law (4) holds the weight, whatever its gains.
const WEIGHT: &[&Row] = &[
    &A,
    &B,
    &M,
    &G,
    &MASS,
    &GRAVITY,
    &ANCHOR,
    &ATTACHMENT,
    &CABLE_MIN,
    &CABLE_MAX,
    &MIN_TENSION,
    &MAX_TENSION,
    &POSE_SOURCE,
    &ENCODER_POSE,
    &CABLE_LENGTH,
    &ENABLE,
];

const MOTOR_TENSION: Row = Row {
    seventh: 520,
    nominal: Some(10.0),
    ..output(
        200,
        "motorTension",
        Shape::Cables,
        Some(&NEWTON),
        WEIGHT,
        "What the motor of the cable shall pull",
    )
};
const SET_POINT: Row = Row {
    variability: Variability::Discrete,
    ..output(206, "setPoint", Shape::Pose, None, MODE, "The active set point x_d")
};
const SET_POINT_INDEX: Row = Row {
    kind: Kind::Int32,
    variability: Variability::Discrete,
    ..output(
        212,
        "setPointIndex",
        Shape::Scalar,
        None,
        &[],
        "Number of the active set point; 0 is the pose at which the controller was enabled",
    )
};
const ESTIMATED_POSE: Row =
    output(213, "estimatedPose", Shape::Pose, None, MEASUREMENT, "Estimate of the pose at the step's inputs");
const ESTIMATED_VELOCITY: Row = output(
    219,
    "estimatedVelocity",
    Shape::PoseRate,
    None,
    &[],
    "Estimate of the rates of the six coordinates of the pose",
);
const STEADY: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(225, "steady", Shape::Scalar, None, MODE, "At rest at the active set point")
};
const AT_GOAL: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(226, "atGoal", Shape::Scalar, None, MODE_AND_GOAL, "At rest at the goal")
};
const TENSION_MARGIN: Row = Row {
    nominal: Some(10.0),
    ..output(
        227,
        "tensionMargin",
        Shape::Scalar,
        Some(&NEWTON),
        WEIGHT,
        "Smallest tension of any cable predicted from now on",
    )
};
const GOAL_DISTANCE: Row = output(
    229,
    "goalDistance",
    Shape::Scalar,
    Some(&METRE),
    &[],
    "From the goal to where the robot goes instead, root mean square of the ways of the attachments; 0 if the goal can be had",
);
const STATUS: Row = Row {
    kind: Kind::Enumeration(&STATUS_TYPE),
    variability: Variability::Discrete,
    ..output(228, "status", Shape::Scalar, None, MODE_AND_GOAL, "What the controller is doing")
};

const FAULT: Row = Row {
    kind: Kind::Enumeration(&FAULT_TYPE),
    variability: Variability::Discrete,
    ..output(230, "fault", Shape::Scalar, None, MODE, "Why the status is SensorFault: the check that failed")
};
const FAULT_VALUE: Row = Row {
    variability: Variability::Discrete,
    ..output(231, "faultValue", Shape::Scalar, None, MODE, "What that check found, m or rad")
};
const FAULT_LIMIT: Row = Row {
    variability: Variability::Discrete,
    ..output(232, "faultLimit", Shape::Scalar, None, MODE, "What it is compared with, m or rad")
};

/// The table of the paper's rig.
pub const ROWS: &[&Row] = &[
    &TIME,
    &A,
    &B,
    &M,
    &I1,
    &I2,
    &I3,
    &G,
    &LAMBDA,
    &ETA,
    &PLANNER_PERIOD,
    &BISECTION_STEPS,
    &MIN_TENSION,
    &MAX_TENSION,
    &PLANNER,
    &POSE_SOURCE,
    &FORCE_LOOP,
    &POSITION_TOLERANCE,
    &ANGLE_TOLERANCE,
    &HOLD_COMPENSATION,
    &COMMAND_DELAY,
    &ENCODER_POSE,
    &CABLE_LENGTH,
    &MEASURED_TENSION,
    &GOAL_POSE,
    &ENABLE,
    &MOTOR_TENSION,
    &SET_POINT,
    &SET_POINT_INDEX,
    &ESTIMATED_POSE,
    &ESTIMATED_VELOCITY,
    &STEADY,
    &AT_GOAL,
    &TENSION_MARGIN,
    &STATUS,
    &GOAL_DISTANCE,
    &FAULT,
    &FAULT_VALUE,
    &FAULT_LIMIT,
];

/// The table of another rig.
pub fn rows_of(rig: &Rig) -> Vec<&'static Row> {
    let planner = if PaperShape::of(rig).is_ok() { &PLANNER } else { &GENERAL_PLANNER };
    let of_paper = [&A, &B, &M, &I1, &I2, &I3, &G, &MIN_TENSION, &MAX_TENSION, &PLANNER].map(|row| row.name);
    let mut rows =
        vec![&TIME, &MASS, &INERTIA, &GRAVITY, &ANCHOR, &ATTACHMENT, &CABLE_MIN, &CABLE_MAX, planner];
    rows.extend(ROWS.iter().skip(1).filter(|row| !of_paper.contains(&row.name)));
    rows
}

/// Starts a controller with the parameters and inputs in `values`.
pub fn start(interface: &Interface, values: &Values, time: f64) -> Result<Controller, ParameterError> {
    if interface.rig().is_none() {
        parameters(values).validate()?;
    }
    Controller::new(controller_parameters(interface, values), time, &inputs(values))
}

/// Rig, gains, planner and limits in `values`.
pub fn controller_parameters(interface: &Interface, values: &Values) -> ControllerParameters {
    let rig = match interface.rig() {
        Some(rig) => rig_with_limits(values, rig),
        None => {
            // -0 is 0
            let limits =
                TensionLimits { min: values.scalar(&MIN_TENSION) + 0.0, max: values.scalar(&MAX_TENSION) };
            Rig::paper(&parameters(values), limits)
        }
    };
    ControllerParameters {
        rig,
        lambda: values.scalar(&LAMBDA),
        eta: values.scalar(&ETA),
        planner_period: values.scalar(&PLANNER_PERIOD),
        bisection_steps: values.integer(&BISECTION_STEPS),
        // The table lets no other number in.
        planner: PlannerKind::numbered(values.integer(&PLANNER)).unwrap_or(PlannerKind::Bounded),
        pose_source: if values.integer(&POSE_SOURCE) == 2 {
            PoseSource::CableLengths
        } else {
            PoseSource::EncoderPose
        },
        force_loop: values.boolean(&FORCE_LOOP),
        position_tolerance: values.scalar(&POSITION_TOLERANCE),
        angle_tolerance: values.scalar(&ANGLE_TOLERANCE),
        hold_compensation: values.boolean(&HOLD_COMPENSATION),
        command_delay: values.scalar(&COMMAND_DELAY),
    }
}

/// What the controller reads in a step.
pub fn inputs(values: &Values) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: values.pose(&ENCODER_POSE),
        cable_length: values.cables(&CABLE_LENGTH),
        measured_tension: values.cables(&MEASURED_TENSION),
        goal_pose: values.pose(&GOAL_POSE),
        enable: values.boolean(&ENABLE),
    }
}

/// Copies the outputs into `values`.
pub fn write(outputs: &ControllerOutputs, values: &mut Values) {
    values.write(&MOTOR_TENSION, outputs.motor_tension);
    values.write(&SET_POINT, outputs.set_point.0.iter().copied());
    values.write(&SET_POINT_INDEX, [outputs.set_point_index.into()]);
    values.write(&ESTIMATED_POSE, outputs.estimated_pose.0.iter().copied());
    values.write(&ESTIMATED_VELOCITY, outputs.estimated_velocity.iter().copied());
    values.write(&STEADY, [outputs.steady.into()]);
    values.write(&AT_GOAL, [outputs.at_goal.into()]);
    values.write(&TENSION_MARGIN, [outputs.tension_margin]);
    values.write(&STATUS, [f64::from(outputs.status as i32)]);
    values.write(&GOAL_DISTANCE, [outputs.goal_distance]);
    values.write(&FAULT, [f64::from(outputs.fault.check as i32)]);
    values.write(&FAULT_VALUE, [outputs.fault.value]);
    values.write(&FAULT_LIMIT, [outputs.fault.limit]);
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
    values.write(&FORCE_LOOP, [parameters.force_loop.into()]);
    values.write(&POSITION_TOLERANCE, [parameters.position_tolerance]);
    values.write(&ANGLE_TOLERANCE, [parameters.angle_tolerance]);
    values.write(&HOLD_COMPENSATION, [parameters.hold_compensation.into()]);
    values.write(&COMMAND_DELAY, [parameters.command_delay]);
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

/// What [`write()`] wrote, of a fault without the pose; a number that stands for no status is read as [`Status::Moving`].
pub fn outputs(values: &Values) -> ControllerOutputs {
    let (number, fault) = (values.integer(&STATUS), values.integer(&FAULT));
    ControllerOutputs {
        motor_tension: values.cables(&MOTOR_TENSION),
        set_point: values.pose(&SET_POINT),
        set_point_index: values.integer(&SET_POINT_INDEX),
        estimated_pose: values.pose(&ESTIMATED_POSE),
        estimated_velocity: values.pose(&ESTIMATED_VELOCITY).0,
        steady: values.boolean(&STEADY),
        at_goal: values.boolean(&AT_GOAL),
        goal_distance: values.scalar(&GOAL_DISTANCE),
        tension_margin: values.scalar(&TENSION_MARGIN),
        status: Status::ALL.into_iter().find(|status| *status as i32 == number).unwrap_or(Status::Moving),
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
