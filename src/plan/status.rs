//! What the controller says of itself.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

/// What the controller is doing, in the order of the numbers that the FMU's enumeration has for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Status {
    /// `enable` is false: every motor gets `minTension`.
    Disabled,
    /// At rest short of the goal, waiting for the next planner tick.
    Holding,
    /// On the way to the active set point.
    Moving,
    /// At rest at the goal.
    AtGoal,
    /// The goal cannot be reached with the planner in use; the robot goes as far as is admissible and holds there.
    GoalUnreachable,
    /// The measured pose made no sense; the robot brakes from its last good state, and gravity is held there, until `enable` falls and rises
    /// again.
    SensorFault,
    /// No pose has made sense since the start: gravity is held where the robot was said to be, until one does.
    WaitingForPose,
    /// What a controller from elsewhere calls by a number that the enumeration does not have.
    Unknown(i32),
}

impl Status {
    /// All that ours has, in the order of their numbers, from 1 on.
    pub const ALL: [Self; 7] = [
        Self::Disabled,
        Self::Holding,
        Self::Moving,
        Self::AtGoal,
        Self::GoalUnreachable,
        Self::SensorFault,
        Self::WaitingForPose,
    ];

    /// The one of this number.
    pub fn of(number: i32) -> Self {
        Self::ALL.into_iter().find(|status| status.number() == number).unwrap_or(Self::Unknown(number))
    }

    /// Its number in the FMU's enumeration.
    pub fn number(self) -> i32 {
        match self {
            Self::Disabled => 1,
            Self::Holding => 2,
            Self::Moving => 3,
            Self::AtGoal => 4,
            Self::GoalUnreachable => 5,
            Self::SensorFault => 6,
            Self::WaitingForPose => 7,
            Self::Unknown(number) => number,
        }
    }

    /// For people.
    pub fn in_words(self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            Self::Disabled => "disabled",
            Self::Holding => "holding",
            Self::Moving => "moving",
            Self::AtGoal => "at the goal",
            Self::GoalUnreachable => "goal unreachable",
            Self::SensorFault => "sensor fault",
            Self::WaitingForPose => "waiting for a pose",
            Self::Unknown(_) => return Cow::Owned(self.to_string()),
        })
    }

    /// Whether the measured pose makes no sense.
    pub fn lacks_pose(self) -> bool {
        matches!(self, Self::SensorFault | Self::WaitingForPose)
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(number) => write!(f, "unknown status {number}"),
            known => fmt::Debug::fmt(known, f),
        }
    }
}
