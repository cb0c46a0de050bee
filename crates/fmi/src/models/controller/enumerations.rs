//! The enumerations of the controller.

use cable_robot::plan::PlannerKind;

use crate::variables::Enumeration;

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
        (
            "GoalUnreachable",
            "The goal cannot be reached: the robot goes as far as is admissible and holds there",
        ),
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
