//! The controller's variables, and the way from values to a [`Controller`] and back.

use super::robot::{A, B, G, I1, I2, I3, M, REST_LENGTH, REST_TENSION, TIME, parameters, write_robot};
use crate::fmi::values::Values;
use crate::fmi::variables::units::{METRE, NEWTON, PER_SECOND, SECOND};
use crate::fmi::variables::{Enumeration, Kind, Row, Shape, Variability, input, output, parameter, setting};
use crate::plan::{
    Controller, ControllerInputs, ControllerOutputs, ControllerParameters, PlannerKind, PoseSource, Status,
};
use crate::robot::ParameterError;

const PLANNER_TYPE: Enumeration = Enumeration {
    name: "Planner",
    description: "The reachable domain that the planner uses",
    items: &[
        ("Bounded", "The paper's domain, Eq. (15): steps in x and y from rest"),
        (
            "Exact",
            "Every step that is proved to keep the tensions within their limits, from any state: a set point at every tick",
        ),
    ],
};
const POSE_SOURCE_TYPE: Enumeration = Enumeration {
    name: "PoseSource",
    description: "Where the measured pose comes from",
    items: &[
        ("EncoderPose", "The input encoderPose"),
        ("CableLengths", "Forward kinematics of the input cableLength"),
    ],
};
const STATUS_TYPE: Enumeration = Enumeration {
    name: "Status",
    description: "What the controller is doing",
    items: &[
        ("Disabled", "enable is false: every motor gets minTension"),
        ("Holding", "At rest short of the goal, waiting for the planner's next decision"),
        ("Moving", "On the way to the active set point"),
        ("AtGoal", "At rest at the goal"),
        ("GoalUnreachable", "The goal cannot be had: the robot goes as far as is admissible and holds there"),
        (
            "SensorFault",
            "The measured pose made no sense: gravity is held at the last good pose until enable falls and rises",
        ),
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
const POSE_SOURCE: Row = setting(
    15,
    "poseSource",
    Kind::Enumeration(&POSE_SOURCE_TYPE),
    &[1.0],
    "Which input is the measured pose",
);
const FORCE_LOOP: Row =
    setting(16, "forceLoop", Kind::Boolean, &[0.0], "Whether the load cells correct the motors, Section VII");

const ENCODER_POSE: Row = input(
    100,
    "encoderPose",
    Shape::Pose,
    None,
    &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    "Measured pose of the platform",
);
const CABLE_LENGTH: Row = input(
    106,
    "cableLength",
    Shape::Cables,
    Some(&METRE),
    &[REST_LENGTH],
    "Measured cable length, used when poseSource = CableLengths",
);
const MEASURED_TENSION: Row = Row {
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
const MEASUREMENT: &[&Row] = &[&A, &B, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH];
/// What mode and set point follow from: the controller starts where the robot is.
const MODE: &[&Row] = &[&A, &B, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &ENABLE];
const MODE_AND_GOAL: &[&Row] = &[&A, &B, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &GOAL_POSE, &ENABLE];
/// What the tensions follow from: at rest at the set point the law (4) holds the weight, whatever its gains.
const WEIGHT: &[&Row] =
    &[&A, &B, &M, &G, &MIN_TENSION, &MAX_TENSION, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &ENABLE];

const MOTOR_TENSION: Row = Row {
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

/// The table, in ascending order of value references.
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
];

/// Starts a controller with the parameters and inputs in `values`.
pub fn start(values: &Values, time: f64) -> Result<Controller, ParameterError> {
    Controller::new(controller_parameters(values), time, &inputs(values))
}

/// Robot, gains, planner and limits in `values`.
pub fn controller_parameters(values: &Values) -> ControllerParameters {
    ControllerParameters {
        robot: parameters(values),
        lambda: values.scalar(&LAMBDA),
        eta: values.scalar(&ETA),
        planner_period: values.scalar(&PLANNER_PERIOD),
        bisection_steps: values.integer(&BISECTION_STEPS),
        min_tension: values.scalar(&MIN_TENSION) + 0.0, // -0 is 0
        max_tension: values.scalar(&MAX_TENSION),
        planner: if values.integer(&PLANNER) == 2 { PlannerKind::Exact } else { PlannerKind::Bounded },
        pose_source: if values.integer(&POSE_SOURCE) == 2 {
            PoseSource::CableLengths
        } else {
            PoseSource::EncoderPose
        },
        force_loop: values.boolean(&FORCE_LOOP),
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
}

/// Copies parameters into `values`.
pub fn write_parameters(parameters: &ControllerParameters, values: &mut Values) {
    write_robot(&parameters.robot, values);
    values.write(&LAMBDA, [parameters.lambda]);
    values.write(&ETA, [parameters.eta]);
    values.write(&PLANNER_PERIOD, [parameters.planner_period]);
    values.write(&BISECTION_STEPS, [parameters.bisection_steps.into()]);
    values.write(&MIN_TENSION, [parameters.min_tension]);
    values.write(&MAX_TENSION, [parameters.max_tension]);
    values.write(&PLANNER, [f64::from(parameters.planner as i32)]);
    let cable_lengths = parameters.pose_source == PoseSource::CableLengths;
    values.write(&POSE_SOURCE, [if cable_lengths { 2.0 } else { 1.0 }]);
    values.write(&FORCE_LOOP, [parameters.force_loop.into()]);
}

/// Copies inputs into `values`.
pub fn write_inputs(inputs: &ControllerInputs, values: &mut Values) {
    values.write(&ENCODER_POSE, inputs.encoder_pose.0.iter().copied());
    values.write(&CABLE_LENGTH, inputs.cable_length);
    values.write(&MEASURED_TENSION, inputs.measured_tension);
    values.write(&GOAL_POSE, inputs.goal_pose.0.iter().copied());
    values.write(&ENABLE, [inputs.enable.into()]);
}

/// What [`write()`] wrote; a number that stands for no status is read as [`Status::Moving`].
pub fn outputs(values: &Values) -> ControllerOutputs {
    let number = values.integer(&STATUS);
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Pose;

    #[test]
    fn the_start_values_are_the_defaults_of_the_domain() {
        let values = Values::new(ROWS);
        assert_eq!(controller_parameters(&values), ControllerParameters::default());
        assert_eq!(inputs(&values).encoder_pose, Pose::default());
        assert_eq!(inputs(&values).goal_pose, Pose::default());
        assert!(inputs(&values).enable);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut values = Values::new(ROWS);
        for (k, reference) in ROWS.iter().flat_map(|row| row.references()).enumerate() {
            values.put(reference, k as f64);
        }
        let flags = [(&FORCE_LOOP, 1.0), (&ENABLE, 0.0), (&STEADY, 1.0), (&AT_GOAL, 1.0), (&STATUS, 5.0)];
        let numbers = [(&PLANNER, 2.0), (&POSE_SOURCE, 2.0)];
        flags.iter().chain(&numbers).for_each(|(row, value)| values.put(row.first, *value));
        let mut copy = Values::new(ROWS);
        copy.put(TIME.first, values.at(TIME.first));
        write_parameters(&controller_parameters(&values), &mut copy);
        write_inputs(&inputs(&values), &mut copy);
        write(&outputs(&values), &mut copy);
        assert_eq!(copy, values);
    }
}
