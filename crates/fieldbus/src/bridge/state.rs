//! What the bridge is doing, what an operator may ask, and what is remembered of both.

use std::fmt;

use thiserror::Error;

use super::fault::Fault;
use super::jog::JogDirection;
use super::trial::AfterSilence;
use crate::Nanoseconds;
use crate::canopen::Emergency;
use crate::cia402::DriveState;
use cable_robot::plan::ControllerOutputs;
use cable_robot::robot::{PerCable, Pose};

/// What the bridge is doing: docs/rig.md has the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Nodes are reset, set up and started.
    Configuring,
    /// Waiting for the operator to confirm that the platform stands at the home pose.
    Homing,
    /// Drives are enabled and make the cables taut.
    TakingUpSlack,
    /// Taut and plausible; waiting for the operator to enable the controller.
    Ready,
    /// The weight is taken off the stand, then the controller's tensions are commanded.
    Enabled,
    /// On the way to the safe output.
    Stopping,
    /// The safe output, after the operator let go.
    Safe,
    /// The safe output, after a fault.
    Fault,
    /// In a survey: load cells are read, one motor pulls a little, or the drives' watchdogs are tried, the platform on
    /// its stand; or it is lifted a little and weighed.
    Trying,
    /// One cable is hauled in or paid out, the platform on its stand.
    Jogging,
    /// The platform is let down to its stand.
    Lowering,
    /// Drives off, for good.
    Off,
    /// Nothing is sent: what the controller would do is computed beside another that does it.
    Shadow,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// What an operator may ask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OperatorCommand {
    /// The platform stands at the home pose, nobody is near the cables: take up the slack. To be given again within `timeouts.enable`, until
    /// the bridge is ready.
    Home,
    /// The controller may pull. To be given again within `timeouts.enable`, for as long as it may.
    Enable,
    /// No longer.
    Release,
    /// Where the platform shall go; in Enabled and Shadow only. What is enabled anew stays where it is.
    Goal(Pose),
    /// A person has put the platform on blocks at this pose, measured in the base frame; in Ready, while poses are surveyed.
    Placed(Pose),
    /// The motor of a cable (from 0) shall pull a little; in Homing, in a survey. To be given again within `timeouts.enable`.
    Pull(usize),
    /// A cable (from 0) shall move, all others left alone; in Homing. To be given again within `timeouts.enable`.
    Jog(usize, JogDirection),
    /// The platform, on its stand at home or on blocks where it was placed last, shall be lifted a little and weighed; in Ready, in a survey. To be given again within `timeouts.enable`.
    Weigh,
    /// Every cable is slack: what do the load cells say; in Homing, in a survey.
    Zero,
    /// Whether the drives stop by themselves when the bridge is silent; in Homing, in a survey.
    TryWatchdog,
    /// No longer, and let the platform down at once if it hangs.
    Lower,
    /// Let the platform down if it hangs, then set everything up again, and reset the drives' faults. The drives lose their torque.
    Reset,
    /// Let the platform down if it hangs, then off.
    Shutdown,
}

impl fmt::Display for OperatorCommand {
    /// As an operator gives it in a line, every number in full.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Home => f.write_str("home"),
            Self::Enable => f.write_str("enable"),
            Self::Release => f.write_str("release"),
            Self::Reset => f.write_str("reset"),
            Self::Shutdown => f.write_str("shutdown"),
            Self::Lower => f.write_str("lower"),
            Self::Pull(cable) => write!(f, "pull {}", cable + 1),
            Self::Jog(cable, direction) => write!(f, "jog {} {direction}", cable + 1),
            Self::Weigh => f.write_str("weigh"),
            Self::Zero => f.write_str("zero"),
            Self::TryWatchdog => f.write_str("watchdog"),
            Self::Goal(pose) => numbers(f, "goal", pose),
            Self::Placed(pose) => numbers(f, "placed", pose),
        }
    }
}

fn numbers(f: &mut fmt::Formatter<'_>, word: &str, pose: &Pose) -> fmt::Result {
    f.write_str(word)?;
    pose.0.iter().try_for_each(|number| write!(f, " {number}"))
}

/// Why a command was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Not now.
    #[error("{command} is not possible in {state}")]
    State {
        /// What was asked.
        command: OperatorCommand,
        /// What the bridge is doing.
        state: State,
    },
    /// In a survey no pull has shown what the motor does.
    #[error("which way the motor of cable {cable} turns is not known: pull {cable} first")]
    DirectionUnknown {
        /// From 1.
        cable: usize,
    },
    /// Enable has been pressed since before it was possible, or home since it was not given in time.
    #[error("it is still pressed from before: release it first")]
    StillPressed,
    /// A goal is no pose.
    #[error("{} is not finite", OperatorCommand::Goal(*.0))]
    Goal(Pose),
    /// A goal is outside of the box.
    #[error("the goal is outside of limits.space: {axis} = {at} m")]
    OutOfBox {
        /// x, y or z.
        axis: char,
        /// m.
        at: f64,
    },
    /// The platform is not at rest.
    #[error("cable {cable} moves at {speed:.3} m/s: the platform must be at rest")]
    Moving {
        /// From 1.
        cable: usize,
        /// m/s.
        speed: f64,
    },
    /// The platform stands neither at home nor where it was placed last.
    #[error(
        "cable {cable} is {off:+.4} m off its length at home: put the platform back on its stand, or where it was placed last"
    )]
    NotAtHome {
        /// From 1.
        cable: usize,
        /// m.
        off: f64,
    },
    /// Something is missing.
    #[error("not yet: {0}")]
    NotYet(Fault),
}

/// Why the controller's tensions ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// The operator let go.
    Released,
    /// The operator's enable was not given again in time.
    EnableExpired,
    /// The operator wants the platform down.
    Lower,
    /// The operator wants everything set up anew.
    Reset,
    /// The program ends.
    Shutdown,
    /// Something failed.
    Fault(Fault),
    /// The platform was let down and stands.
    Landed,
    /// A cable that was hauled in is taut.
    Taut,
    /// A cable that was jogged was faster than `limits.cable_speed`.
    TooFast,
    /// A cable that was jogged went the other way.
    WrongWay,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Released => f.write_str("the operator let go"),
            Self::EnableExpired => f.write_str("the operator's button was not given again in time"),
            Self::Lower => f.write_str("the operator wants the platform down"),
            Self::Reset => f.write_str("everything is to be set up anew"),
            Self::Shutdown => f.write_str("the program ends"),
            Self::Landed => f.write_str("the platform stands"),
            Self::Taut => f.write_str("the motor pulls with slack.pretension and nothing moves"),
            Self::TooFast => f.write_str("the cable was faster than limits.cable_speed"),
            Self::WrongWay => f.write_str(
                "its encoder says that the cable went the other way: somebody moved the platform, or a sign is wrong",
            ),
            Self::Fault(fault) => fault.fmt(f),
        }
    }
}

/// Something to log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A new state.
    Entered(State),
    /// The controller's tensions ended.
    Stopped(Cause),
    /// The motors are off again, the platform on its stand.
    LetGo(Cause),
    /// A fault, also one that came after the first.
    Fault(Fault),
    /// The platform was placed at a pose, and each cable read so much longer than at home, m.
    Placed(Pose, PerCable<f64>),
    /// A motor has pulled.
    Pulled {
        /// Its cable, from 0.
        cable: usize,
        /// At last, N.
        tension: f64,
        /// By how much each encoder says that its cable came in, m.
        came_in: PerCable<f64>,
    },
    /// A cable was hauled in or paid out.
    Jogged {
        /// From 0.
        cable: usize,
        /// By how much its encoder says that it came in, m.
        came_in: f64,
        /// What its load cell said at last, N.
        measured: f64,
    },
    /// The platform was lifted, and its load cells read at rest.
    Weighed {
        /// That they carry, kg.
        mass: f64,
        /// How much higher than it stood it hung, m.
        rise: f64,
        /// Its largest angle, rad.
        tilt: f64,
        /// Where it hung.
        pose: Pose,
        /// What each load cell said, N, in the mean.
        reading: PerCable<f64>,
    },
    /// It did not leave its stand.
    NotLifted,
    /// What each load cell said of a slack cable, N, in the mean.
    Zeroed(PerCable<f64>),
    /// What each drive did when nothing was sent any more.
    WatchdogTried(PerCable<AfterSilence>),
    /// Every drive left Operation enabled by itself then.
    WatchdogProved,
    /// A node's emergency message, also one that says that an error is gone.
    Emergency(Emergency),
    /// So many emergency messages came at once that these were lost.
    Lost(u64),
}

const EVENTS: usize = 128;
/// So many of them may be emergency messages. Of states and faults a cycle has fewer than the rest.
const EMERGENCIES: usize = 64;

/// The latest events that nobody has taken yet. A burst of emergency messages takes no room from states and faults: what is too much
/// is lost, and counted.
#[derive(Clone, Debug)]
pub(super) struct EventLog {
    events: [Option<(Nanoseconds, Event)>; EVENTS],
    first: usize,
    length: usize,
    lost: u64,
}

impl EventLog {
    pub fn new() -> Self {
        Self { events: [None; EVENTS], first: 0, length: 0, lost: 0 }
    }

    pub fn push(&mut self, now: Nanoseconds, event: Event) {
        let room = if matches!(event, Event::Emergency(_)) { EMERGENCIES } else { EVENTS };
        if self.length >= room {
            self.lost += 1;
            return;
        }
        self.events[(self.first + self.length) % EVENTS] = Some((now, event));
        self.length += 1;
    }

    /// The oldest; after the last one, at `now`, how many were lost.
    pub fn pop(&mut self, now: Nanoseconds) -> Option<(Nanoseconds, Event)> {
        let Some(event) = self.events[self.first].take() else {
            let lost = std::mem::take(&mut self.lost);
            return (lost > 0).then_some((now, Event::Lost(lost)));
        };
        (self.first, self.length) = ((self.first + 1) % EVENTS, self.length - 1);
        Some(event)
    }
}

/// One cycle as it is logged and shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleReport {
    /// When it began.
    pub time: Nanoseconds,
    /// What the bridge is doing.
    pub state: State,
    /// The first fault since the last reset.
    pub fault: Option<Fault>,
    /// m.
    pub length: PerCable<f64>,
    /// The last plausible one: what the controller and the safe output go by.
    pub pose: Pose,
    /// Of these lengths, whatever it is; none while an encoder is silent or at fault, or no torque is on.
    pub measured_pose: Option<Pose>,
    /// Load cells, N.
    pub measured: PerCable<f64>,
    /// The tensions commanded from now on, N.
    pub tension: PerCable<f64>,
    /// The same as it is sent, ‰ of the rated torques.
    pub target_torque: PerCable<i16>,
    /// As last heard.
    pub drive: PerCable<Option<DriveState>>,
    /// Cycles since each encoder, and each load cell, was last heard.
    pub missed: PerCable<[u32; 2]>,
    /// What the controller answered in this cycle, if it was asked.
    pub controller: Option<ControllerOutputs>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_of_emergency_messages_hides_no_state() {
        let mut log = EventLog::new();
        let emergency = Emergency { node: 3, code: 0x8130, register: 0, maker: [0; 5] };
        (0..70).for_each(|k| log.push(k, Event::Emergency(emergency)));
        log.push(70, Event::Entered(State::Stopping));
        let events: Vec<_> = std::iter::from_fn(|| log.pop(71)).collect();
        assert_eq!(events.len(), 64 + 2);
        assert_eq!(events[64..], [(70, Event::Entered(State::Stopping)), (71, Event::Lost(6))]);
        log.push(99, Event::Entered(State::Off));
        assert_eq!((log.pop(99).unwrap().0, log.pop(99)), (99, None));
    }
}
