//! The parameters of the controller.

use cable_robot::plan::PlannerKind;

use super::enumerations::{GENERAL_PLANNER_TYPE, PLANNER_TYPE, POSE_SOURCE_TYPE};
use crate::variables::units::{
    METRE, METRE_PER_SECOND, NEWTON, NEWTON_PER_SECOND, PER_SECOND, RADIAN, RADIAN_PER_SECOND, SECOND,
};
use crate::variables::{ABOVE_ZERO, Kind, Row, Variability, parameter, setting};

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
pub const MAX_TENSION_RATE: Row = Row {
    variability: Variability::Tunable,
    min: Some(0.0),
    ..parameter(
        33,
        "maxTensionRate",
        &NEWTON_PER_SECOND,
        &[0.0],
        "Greatest rate of a commanded tension on the way, 0 for no limit: the planner MinimumTime alone heeds it, the steps of the others are jumps",
    )
};
pub const LIFT: Row = Row {
    min: Some(0.0),
    ..parameter(
        32,
        "lift",
        &METRE,
        &[0.0],
        "By how much the platform may rise above the straight way to be quicker, 0 for not at all: the planner MinimumTime alone heeds it",
    )
};
pub const LARGEST_STEP: Row = Row {
    min: Some(0.0),
    ..parameter(
        29,
        "largestStep",
        &SECOND,
        &[0.0],
        "Longest communication step, longer ones are discarded; 0 for any: the planner Exact then computes with the longer of the last two",
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
        "planner, for importers that know no enumerations: one of its numbers, or 0: as planner says",
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
        "poseSource, for importers that know no enumerations: one of its numbers, or 0: as poseSource says",
    )
};
