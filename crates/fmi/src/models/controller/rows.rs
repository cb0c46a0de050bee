//! The variables of the controller.

use cable_robot::plan::PlannerKind;
use cable_robot::robot::{Rig, Shape as PaperShape};

use super::super::robot::{
    A, ANCHOR, ATTACHMENT, B, CABLE_MAX, CABLE_MIN, G, GRAVITY, I1, I2, I3, INERTIA, M, MASS, REST_LENGTH,
    REST_TENSION, TIME,
};
use crate::variables::units::{
    KILOGRAM, METRE, METRE_PER_SECOND, NEWTON, NEWTON_METRE, PER_SECOND, RADIAN, RADIAN_PER_SECOND, SECOND,
};
use crate::variables::{
    ABOVE_ZERO, Enumeration, Kind, Row, Shape, Variability, input, output, parameter, setting,
};

pub const PLANNER_TYPE: Enumeration = Enumeration {
    name: "Planner",
    description: "The reachable domain that the planner uses",
    first: 1,
    items: &PLANNERS,
};

/// The planners of a rig that is not the paper's: all but the first.
pub const GENERAL_PLANNER_TYPE: Enumeration =
    Enumeration { first: 2, items: PLANNERS.split_at(1).1, ..PLANNER_TYPE };

pub const PLANNERS: [(&str, &str); PlannerKind::ALL.len()] = {
    let mut items = [("", ""); PlannerKind::ALL.len()];
    let mut k = 0;
    while k < items.len() {
        items[k] = PlannerKind::ALL[k].described();
        k += 1;
    }
    items
};
pub const POSE_SOURCE_TYPE: Enumeration = Enumeration {
    name: "PoseSource",
    description: "Where the measured pose comes from",
    first: 1,
    items: &[
        ("EncoderPose", "The input encoderPose"),
        ("CableLengths", "Forward kinematics of the input cableLength"),
    ],
};
pub const STATUS_TYPE: Enumeration = Enumeration {
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
            "The measured pose made no sense (see fault): the robot brakes from its last good state and gravity is held there until enable falls and rises",
        ),
        (
            "WaitingForPose",
            "No pose has made sense since the start (see fault): gravity is held where the robot was said to be until one does",
        ),
    ],
};
pub const FAULT_TYPE: Enumeration = Enumeration {
    name: "Fault",
    description: "Which check a measurement failed",
    first: 1,
    items: &[
        ("None", "None failed"),
        ("NotSet", "encoderPose was zero in all six coordinates from the first step on, as if never set"),
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

pub const LAMBDA: Row = Row {
    variability: Variability::Tunable,
    min: Some(ABOVE_ZERO),
    max: Some(1000.0),
    ..parameter(8, "lambda", &PER_SECOND, &[3.0], "Gain lambda of Eq. (2), Table II")
};
pub const ETA: Row = Row {
    variability: Variability::Tunable,
    min: Some(ABOVE_ZERO),
    max: Some(1000.0),
    ..parameter(9, "eta", &PER_SECOND, &[3.0], "Gain eta of Eq. (4), Table II")
};
pub const PLANNER_PERIOD: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(10, "plannerPeriod", &SECOND, &[0.05], "Time T_s between two decisions of the planner")
};
pub const BISECTION_STEPS: Row = Row {
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
pub const MIN_TENSION: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    nominal: Some(10.0),
    ..parameter(12, "minTension", &NEWTON, &[0.0], "Least tension that is ever commanded")
};
pub const MAX_TENSION: Row = Row {
    variability: Variability::Tunable,
    min: Some(ABOVE_ZERO),
    nominal: Some(10.0),
    ..parameter(13, "maxTension", &NEWTON, &[100.0], "Greatest tension that is ever commanded")
};
pub const PLANNER: Row = setting(
    14,
    "planner",
    Kind::Enumeration(&PLANNER_TYPE),
    &[1.0],
    "Which reachable domain the planner uses",
);
pub const GENERAL_PLANNER: Row =
    Row { kind: Kind::Enumeration(&GENERAL_PLANNER_TYPE), start: &[2.0], ..PLANNER };
pub const POSE_SOURCE: Row = setting(
    15,
    "poseSource",
    Kind::Enumeration(&POSE_SOURCE_TYPE),
    &[1.0],
    "Which input is the measured pose",
);
pub const FORCE_LOOP: Row =
    setting(16, "forceLoop", Kind::Boolean, &[0.0], "Whether the load cells correct the motors, Section VII");

pub const POSITION_TOLERANCE: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        17,
        "positionTolerance",
        &METRE,
        &[0.0],
        "Distance (and speed in m/s) up to which the robot is at rest at a pose; 0 follows the rig's size, 2 mm for the paper's, 10 mm at most",
    )
};
pub const ANGLE_TOLERANCE: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        18,
        "angleTolerance",
        &RADIAN,
        &[0.0],
        "The same for each angle (and its rate in rad/s); 0 is 0.01 rad",
    )
};
pub const HOLD_COMPENSATION: Row = setting(
    19,
    "holdCompensation",
    Kind::Boolean,
    &[1.0],
    "Whether the law is evaluated for the interval in which the command will act, instead of the instant of the measurement",
);
pub const COMMAND_DELAY: Row = Row {
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
pub const OBSERVER_BOUND: Row = Row {
    min: Some(0.0),
    max: Some(1.0),
    ..setting(
        21,
        "observerBound",
        Kind::Float64,
        &[0.1],
        "Largest constant force on the platform that is estimated and made up for, as a share of the weight; the largest torque is that force at the \
         platform's radius. 0: no observer. The planner Bounded has none",
    )
};
pub const ACCURACY: Row = Row {
    min: Some(0.0),
    ..parameter(
        22,
        "accuracy",
        &METRE,
        &[0.0],
        "Anchors and attachments lie within this distance of where they are said to be: the planner Exact leaves room for it",
    )
};
pub const MASS_TOLERANCE: Row = Row {
    min: Some(0.0),
    ..setting(
        23,
        "massTolerance",
        Kind::Float64,
        &[0.0],
        "By which share the mass of the platform may differ: the planner Exact leaves room for it",
    )
};
pub const ENCODER_RESOLUTION: Row = Row {
    min: Some(0.0),
    ..parameter(
        24,
        "encoderResolution",
        &METRE,
        &[0.0],
        "Smallest change of a cable's length that the encoders see: the planner Exact leaves room for it",
    )
};
pub const DISTURBANCE_BOUND: Row = Row {
    min: Some(0.0),
    ..parameter(
        25,
        "disturbanceBound",
        &NEWTON,
        &[0.0],
        "Largest force on the platform that is not known, the largest torque being that force at the platform's radius: the planner Exact leaves room for it",
    )
};
pub const MAX_SPEED: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        26,
        "maxSpeed",
        &METRE_PER_SECOND,
        &[0.0],
        "Greatest speed of the centre of mass on the way to any set point, 0 for no limit: the planner Exact heeds it",
    )
};
pub const MAX_ANGULAR_RATE: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        27,
        "maxAngularRate",
        &RADIAN_PER_SECOND,
        &[0.0],
        "Greatest angular velocity of the platform, 0 for no limit: the planner Exact heeds it",
    )
};
pub const MAX_CABLE_SPEED: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        28,
        "maxCableSpeed",
        &METRE_PER_SECOND,
        &[0.0],
        "Greatest speed of a cable, 0 for no limit: the planner Exact heeds it",
    )
};
pub const LARGEST_STEP: Row = Row {
    min: Some(0.0),
    ..parameter(
        29,
        "largestStep",
        &SECOND,
        &[0.0],
        "Longest communication step, longer ones are discarded; 0 for any: the planner Exact then reckons with the longer of the last two",
    )
};
pub const PLANNER_NUMBER: Row = Row {
    min: Some(0.0),
    max: Some(PlannerKind::ALL.len() as f64),
    ..setting(
        30,
        "plannerNumber",
        Kind::Int32,
        &[0.0],
        "planner, for importers that know no enumerations; 0: as planner says",
    )
};
pub const POSE_SOURCE_NUMBER: Row = Row {
    min: Some(0.0),
    max: Some(2.0),
    ..setting(
        31,
        "poseSourceNumber",
        Kind::Int32,
        &[0.0],
        "poseSource, for importers that know no enumerations; 0: as poseSource says",
    )
};
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
    "From the goal to where the robot goes instead, root mean square of the ways of the attachments; 0 if the goal can be had",
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
