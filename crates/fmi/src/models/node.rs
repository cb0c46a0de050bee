//! The variables of the nodes on buses: what an operator would press and see, and what stands in the lab.

use serde::{Deserialize, Serialize};

use super::controller::enumerations::STATUS_TYPE;
use super::robot::TIME;
use crate::values::Values;
use crate::variables::units::NEWTON;
use crate::variables::{Causality, Enumeration, Kind, Row, Shape, Variability, input, output, setting};
use cable_robot::robot::Pose;

/// Which node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NodeKind {
    /// The bridge with its controller.
    Controller,
    /// Drives, load cells and the platform.
    Rig,
}

/// Both, in the order of their FMUs.
pub const NODES: [NodeKind; 2] = [NodeKind::Controller, NodeKind::Rig];

/// Value reference of a bus's first variable: Rx_Data, Tx_Data, Rx_Clock, Tx_Clock, then those of the next bus.
pub const FIRST_OF_BUSES: u32 = 1000;

/// Cycles that a step may have.
pub const LONGEST_STEP: u32 = 16;
/// Bytes that a bus may bring at once, and that may be sent at once (`maxSize`).
pub const ROOM: usize = 24_576;

/// The structural parameter that FMI-LS-BUS demands of every node on CAN.
const BUS_NOTIFICATIONS: Row = Row {
    causality: Causality::Structural,
    ..setting(
        1,
        "org.fmi_standard.fmi_ls_bus.Can_BusNotifications",
        Kind::Boolean,
        &[0.0],
        "Whether the bus tells of frames that were confirmed, dropped or destroyed. The node waits for none of these, and counts those that come",
    )
};

pub(crate) const ENABLE: Row = button(
    100,
    "enable",
    "Held while the controller may pull. Letting go leads to the safe output. Pressed too early it has to be let go of first",
);
pub(crate) const HOME: Row = button(
    101,
    "home",
    "Held: the platform stands at its home pose, the slack may be taken up as soon as the nodes are ready",
);
pub(crate) const RESET: Row =
    button(102, "reset", "When pressed: set everything up anew. The drives lose their torque");
pub(crate) const GOAL_POSE: Row = Row {
    variability: Variability::Discrete,
    ..input(
        103,
        "goalPose",
        Shape::Pose,
        None,
        &[0.0],
        "A change while the state is Enabled sends the platform there; what is enabled anew stays where it is",
    )
};

pub(crate) const STATE: Row = Row {
    kind: Kind::Enumeration(&STATE_TYPE),
    ..discrete(200, "state", Shape::Scalar, "What the bridge is doing")
};
pub(crate) const STATE_NUMBER: Row =
    Row { kind: Kind::Int32, ..discrete(201, "stateNumber", Shape::Scalar, "The same as a number") };
pub(crate) const STATUS: Row = Row {
    kind: Kind::Enumeration(&STATUS_TYPE),
    ..discrete(202, "status", Shape::Scalar, "What the controller is doing; Disabled while it is not asked")
};
pub(crate) const STATUS_NUMBER: Row =
    Row { kind: Kind::Int32, ..discrete(203, "statusNumber", Shape::Scalar, "The same as a number") };
pub(crate) const FAULT: Row = Row {
    kind: Kind::String,
    ..discrete(
        204,
        "fault",
        Shape::Scalar,
        "The first fault since the last reset, with its value; empty if there is none",
    )
};
pub(crate) const POSE: Row =
    output(205, "pose", Shape::Pose, None, &[], "Where the bridge takes the platform to be, by the encoders");
pub(crate) const TRUE_POSE: Row = Row { description: "Where the platform is", ..POSE };
pub(crate) const MOTOR_TENSION: Row = Row {
    seventh: 230,
    nominal: Some(10.0),
    ..output(211, "motorTension", Shape::Cables, Some(&NEWTON), &[], "Commanded tension of the motor")
};
pub(crate) const TRUE_TENSION: Row = Row { description: "What the motor pulls", ..MOTOR_TENSION };
pub(crate) const SLACK: Row = Row {
    seventh: 240,
    kind: Kind::Boolean,
    ..discrete(217, "slack", Shape::Cables, "Whether the cable pulls with nothing")
};
pub(crate) const SUPPORT: Row = Row {
    kind: Kind::Enumeration(&SUPPORT_TYPE),
    ..discrete(223, "support", Shape::Scalar, "What carries the platform")
};
pub(crate) const SUPPORT_NUMBER: Row =
    Row { kind: Kind::Int32, ..discrete(224, "supportNumber", Shape::Scalar, "The same as a number") };

const CONTROLLER_ROWS: &[&Row] = &[
    &TIME,
    &BUS_NOTIFICATIONS,
    &ENABLE,
    &HOME,
    &RESET,
    &GOAL_POSE,
    &STATE,
    &STATE_NUMBER,
    &STATUS,
    &STATUS_NUMBER,
    &FAULT,
    &POSE,
    &MOTOR_TENSION,
];
const RIG_ROWS: &[&Row] =
    &[&TIME, &BUS_NOTIFICATIONS, &TRUE_POSE, &TRUE_TENSION, &SLACK, &SUPPORT, &SUPPORT_NUMBER];

const STATE_TYPE: Enumeration = Enumeration {
    name: "BridgeState",
    description: "What the bridge is doing",
    first: 1,
    items: &[
        ("Configuring", "Nodes are reset, set up and started"),
        ("Homing", "Waiting for home"),
        ("TakingUpSlack", "Drives are enabled and make the cables taut"),
        ("Ready", "Taut and plausible; waiting for enable"),
        ("Enabled", "The weight is taken off the stand, then the controller's tensions are commanded"),
        ("Stopping", "On the way to the safe output"),
        ("Safe", "The safe output, after enable was let go"),
        ("Fault", "The safe output, after a fault"),
        ("Lowering", "The platform is let down to its stand"),
    ],
};
const SUPPORT_TYPE: Enumeration = Enumeration {
    name: "Support",
    description: "What carries the platform",
    first: 1,
    items: &[
        ("Stand", "Its stand, at the home pose"),
        ("Cables", "The cables"),
        ("Floor", "The floor: it fell"),
    ],
};

const fn button(first: u32, name: &'static str, description: &'static str) -> Row {
    Row {
        kind: Kind::Boolean,
        variability: Variability::Discrete,
        ..input(first, name, Shape::Scalar, None, &[0.0], description)
    }
}

const fn discrete(first: u32, name: &'static str, shape: Shape, description: &'static str) -> Row {
    Row { variability: Variability::Discrete, ..output(first, name, shape, None, &[], description) }
}

impl NodeKind {
    /// Its table.
    pub(super) fn rows(self) -> &'static [&'static Row] {
        match self {
            NodeKind::Controller => CONTROLLER_ROWS,
            NodeKind::Rig => RIG_ROWS,
        }
    }

    /// Goal and pose at home.
    pub(super) fn write_start(self, home: &Pose, start: &mut Values) {
        if self == NodeKind::Controller {
            start.write(&GOAL_POSE, home.0.iter().copied());
        }
    }

    /// One sentence for the XML.
    pub(super) fn description(self, rig: &str) -> String {
        match self {
            NodeKind::Controller => format!(
                "The controller of the cable robot {rig} behind the frames of its drives and load cells, on a simulated CAN bus (FMI-LS-BUS)"
            ),
            NodeKind::Rig => format!(
                "Drives, load cells and platform of the cable robot {rig} on a simulated CAN bus (FMI-LS-BUS)"
            ),
        }
    }
}

/// Value references of a bus's variables, and what follows its name in theirs.
pub fn of_bus(bus: usize) -> [(u32, &'static str); 4] {
    let first = FIRST_OF_BUSES + 4 * bus as u32;
    [(first, "Rx_Data"), (first + 1, "Tx_Data"), (first + 2, "Rx_Clock"), (first + 3, "Tx_Clock")]
}
