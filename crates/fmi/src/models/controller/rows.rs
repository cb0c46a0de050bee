//! The variables of the controller: its inputs and outputs, and the tables of all.

use cable_robot::robot::{Rig, Shape as PaperShape};

use super::super::robot::{
    A, ANCHOR, ATTACHMENT, B, CABLE_MAX, CABLE_MIN, G, GRAVITY, I1, I2, I3, INERTIA, M, MASS, REST_LENGTH,
    REST_TENSION, TIME,
};
use super::enumerations::{FAULT_TYPE, STATUS_TYPE};
use super::parameters::*;
use crate::variables::units::{KILOGRAM, METRE, NEWTON, NEWTON_METRE};
use crate::variables::{Kind, Row, Shape, Variability, input, output};

pub const ENCODER_POSE: Row = input(
    100,
    "encoderPose",
    Shape::Pose,
    None,
    &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    "Measured pose of the platform",
);
pub const CABLE_LENGTH: Row = Row {
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
pub const MEASURED_TENSION: Row = Row {
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
pub const GOAL_POSE: Row = Row {
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
pub const ENABLE: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..input(124, "enable", Shape::Scalar, None, &[1.0], "Whether the controller may pull")
};

/// What the measured pose follows from.
pub const MEASUREMENT: &[&Row] = &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH];
/// What mode and set point follow from: the controller starts where the robot is.
pub const MODE: &[&Row] =
    &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &ENABLE];
pub const MODE_AND_GOAL: &[&Row] =
    &[&A, &B, &ANCHOR, &ATTACHMENT, &POSE_SOURCE, &ENCODER_POSE, &CABLE_LENGTH, &GOAL_POSE, &ENABLE];
/// What the tensions follow from: at rest at the set point the law (4) holds the weight, whatever its gains.
pub const WEIGHT: &[&Row] = &[
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

pub const MOTOR_TENSION: Row = Row {
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
pub const SET_POINT: Row = Row {
    variability: Variability::Discrete,
    ..output(206, "setPoint", Shape::Pose, None, MODE, "The active set point x_d")
};
pub const SET_POINT_INDEX: Row = Row {
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
pub const ESTIMATED_POSE: Row =
    output(213, "estimatedPose", Shape::Pose, None, MEASUREMENT, "Estimate of the pose at the step's inputs");
pub const ESTIMATED_VELOCITY: Row = output(
    219,
    "estimatedVelocity",
    Shape::PoseRate,
    None,
    &[],
    "Estimate of the rates of the six coordinates of the pose",
);
pub const STEADY: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(225, "steady", Shape::Scalar, None, MODE, "At rest at the active set point")
};
pub const AT_GOAL: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(226, "atGoal", Shape::Scalar, None, MODE_AND_GOAL, "At rest at the goal")
};
pub const TENSION_MARGIN: Row = Row {
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
pub const GOAL_DISTANCE: Row = output(
    229,
    "goalDistance",
    Shape::Scalar,
    Some(&METRE),
    &[],
    "From the goal to where the robot goes instead, root mean square of the ways of the attachments; 0 if the goal can be reached",
);
pub const STATUS: Row = Row {
    kind: Kind::Enumeration(&STATUS_TYPE),
    variability: Variability::Discrete,
    ..output(228, "status", Shape::Scalar, None, MODE_AND_GOAL, "What the controller is doing")
};

pub const FAULT: Row = Row {
    kind: Kind::Enumeration(&FAULT_TYPE),
    variability: Variability::Discrete,
    ..output(
        230,
        "fault",
        Shape::Scalar,
        None,
        MODE,
        "Why the status is SensorFault or WaitingForPose: the check that failed",
    )
};
pub const FAULT_VALUE: Row = Row {
    variability: Variability::Discrete,
    ..output(231, "faultValue", Shape::Scalar, None, MODE, "What that check found, m or rad")
};
pub const FAULT_LIMIT: Row = Row {
    variability: Variability::Discrete,
    ..output(232, "faultLimit", Shape::Scalar, None, MODE, "What it is compared with, m or rad")
};

pub const DISTURBANCE_FORCE: Row = output(
    233,
    "disturbanceForce",
    Shape::Vector,
    Some(&NEWTON),
    &[],
    "Estimate of the force on the platform besides cables and weight, base frame; zero without observer",
);
pub const DISTURBANCE_TORQUE: Row = output(
    236,
    "disturbanceTorque",
    Shape::Vector,
    Some(&NEWTON_METRE),
    &[],
    "Estimate of the torque on the platform besides that of the cables, base frame; zero without observer",
);
pub const ESTIMATED_MASS: Row = output(
    239,
    "estimatedMass",
    Shape::Scalar,
    Some(&KILOGRAM),
    &[&M, &MASS],
    "Mass of the platform if the estimated force is weight: of use at rest",
);

pub const STATUS_NUMBER: Row = Row {
    kind: Kind::Int32,
    variability: Variability::Discrete,
    ..output(
        240,
        "statusNumber",
        Shape::Scalar,
        None,
        MODE_AND_GOAL,
        "status, for importers that know no enumerations",
    )
};
pub const FAULT_NUMBER: Row = Row {
    kind: Kind::Int32,
    variability: Variability::Discrete,
    ..output(241, "faultNumber", Shape::Scalar, None, MODE, "fault, for importers that know no enumerations")
};
pub const PARAMETERS_PENDING: Row = Row {
    kind: Kind::Int32,
    variability: Variability::Discrete,
    ..output(
        242,
        "parametersPending",
        Shape::Scalar,
        None,
        &[],
        "0: all parameters act. 1: those changed since act from the planner's next decision on. 2: not yet, the motion under way is not proved to go on with them",
    )
};
pub const REFERENCE: Row = output(
    243,
    "reference",
    Shape::Pose,
    None,
    MODE,
    "What the law follows when the command of this step begins to act: the set point, or the motion to it",
);
pub const REFERENCE_VELOCITY: Row =
    output(249, "referenceVelocity", Shape::PoseRate, None, &[], "Its rates: zero where it is a set point");
pub const REFERENCE_ACCELERATION: Row =
    output(255, "referenceAcceleration", Shape::PoseAcceleration, None, &[], "Its accelerations");

/// In FMUs that show all of FMI 3.
pub const PLANNER_TICK: Row = Row {
    kind: Kind::Clock,
    variability: Variability::Discrete,
    ..output(
        700,
        "plannerTick",
        Shape::Scalar,
        None,
        &[],
        "Ticks where the planner will decide in the step to come, with the inputs as they are then",
    )
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
    &OBSERVER_BOUND,
    &ACCURACY,
    &MASS_TOLERANCE,
    &ENCODER_RESOLUTION,
    &DISTURBANCE_BOUND,
    &MAX_SPEED,
    &MAX_ANGULAR_RATE,
    &MAX_CABLE_SPEED,
    &MAX_TENSION_RATE,
    &LIFT,
    &LARGEST_STEP,
    &PLANNER_NUMBER,
    &POSE_SOURCE_NUMBER,
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
    &DISTURBANCE_FORCE,
    &DISTURBANCE_TORQUE,
    &ESTIMATED_MASS,
    &STATUS_NUMBER,
    &FAULT_NUMBER,
    &PARAMETERS_PENDING,
    &REFERENCE,
    &REFERENCE_VELOCITY,
    &REFERENCE_ACCELERATION,
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
