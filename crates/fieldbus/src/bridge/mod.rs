//! The bridge: one state machine between a controller and the nodes on the buses. Frames and times in, frames out; no input or
//! output of its own, so that the same inputs give the same bits (docs/rig.md).

mod course;
mod fault;
mod follow;
mod intake;
mod jog;
mod lower;
mod measure;
mod operator;
mod output;
mod queue;
mod quiet;
mod reaction;
mod slack;
mod startup;
mod state;
mod survey;
#[cfg(test)]
mod tests;
mod trial;
mod watch;
mod weigh;

pub use fault::{Fault, TransportError};
pub use jog::JogDirection;
pub use queue::FrameQueue;
pub use startup::Identity;
pub use state::{Cause, CycleReport, Event, OperatorCommand, Refusal, State};
pub use trial::AfterSilence;

use course::Course;
use fault::FaultList;
use follow::{Follower, ModeQuestion};
use jog::Jog;
use lower::Way;
use measure::{CellMonitor, Encoder};
use reaction::Reaction;
use slack::SlackStep;
use startup::Startup;
use state::EventLog;
use trial::Trial;
use weigh::Stand;

use super::Nanoseconds;
use super::canopen::eds::Use;
use super::canopen::{Node, Object};
use super::cia402::DriveState;
use super::config::Config;
use cable_robot::plan::ControllerOutputs;
use cable_robot::robot::{PerCable, Pose};
use cable_robot::sim::ControllerModel;

/// What the bridge asks of the objects of a node on a bus, a drive's or a load cell's.
pub fn needs(config: &Config, (bus, node): (usize, Node)) -> Vec<(Object, Use)> {
    let drives = config.drives.iter().enumerate();
    let mut drives = drives.filter(|(_, drive)| (drive.bus, drive.node) == (bus, node));
    let startup = match drives.next() {
        Some((cable, _)) => Startup::drive(config, cable),
        None => Startup::load_cell(config, node),
    };
    startup.needs()
}

/// The state with what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// For another master; nothing is sent.
    Listening {
        since: Nanoseconds,
    },
    /// Zero torque, voltage off.
    Quieting {
        since: Nanoseconds,
    },
    Configuring,
    Homing {
        since: Nanoseconds,
    },
    TakingUpSlack {
        since: Nanoseconds,
        /// None until all drives are enabled.
        step: Option<SlackStep>,
    },
    Ready,
    /// First the weight is taken over from `from` to `lifted`, then the controller pulls.
    Enabled {
        since: Nanoseconds,
        from: PerCable<f64>,
        lifted: PerCable<f64>,
        confirmed: Nanoseconds,
    },
    Stopping {
        since: Nanoseconds,
        from: PerCable<f64>,
        to: SafePull,
    },
    Safe(SafePull),
    Fault(SafePull),
    /// In a survey.
    Trying(Trial),
    Jogging(Jog),
    Lowering {
        since: Nanoseconds,
        from: Held,
        way: Way,
    },
    Off,
    Shadow {
        is_homed: bool,
    },
}

/// What the motors pull in safety; `None` with the drives off.
type SafePull = Option<Held>;

/// Tensions, and the lengths around which each winch is a spring and a damper.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    /// Where the platform hangs with these.
    pose: Pose,
    /// N.
    tension: PerCable<f64>,
    /// What each pulls at least, N.
    least: f64,
    /// m.
    length: PerCable<f64>,
    /// By how much that changes, m/s.
    rate: PerCable<f64>,
}

/// A node of the rig.
#[derive(Clone, Debug)]
struct Peer {
    node: Node,
    bus: usize,
    startup: Startup,
    /// When its last heartbeat came.
    heard: Nanoseconds,
}

/// A drive as its frames show it.
#[derive(Clone, Copy, Debug, Default)]
struct DriveMonitor {
    state: Option<DriveState>,
    encoder: Encoder,
    /// Left Operation enabled while it was to stay there, since the last reset: it pulls nothing any more.
    has_left: bool,
}

/// The bridge with all its memory. After [`Bridge::new`] nothing is allocated any more.
#[derive(Clone, Debug)]
pub struct Bridge {
    config: Config,
    home_length: PerCable<f64>,
    torque_frames: Vec<(usize, u16, [Option<usize>; 3])>,
    peers: Vec<Peer>,
    mode: Mode,
    /// Time of the cycle, and what is added to the caller's so that it never goes back.
    time: Nanoseconds,
    offset: Nanoseconds,
    is_started: bool,
    drives: Vec<DriveMonitor>,
    cells: Vec<CellMonitor>,
    followers: Vec<Follower>,
    reactions: Vec<Reaction>,
    mode_question: ModeQuestion,
    course: Option<Course>,
    /// For each encoder, all lengths (m) when its value last changed.
    still_since: Vec<PerCable<f64>>,
    /// The last pose that was plausible, and the one measured in this cycle.
    pose: Pose,
    measured_pose: Option<Pose>,
    goal: Pose,
    /// The tensions commanded last, N.
    commanded: PerCable<f64>,
    /// The last tensions of the controller that passed every check, N.
    certified: PerCable<f64>,
    answer: Option<ControllerOutputs>,
    /// Found since the last cycle.
    pending: FaultList,
    /// Told since the last reset.
    reported_faults: FaultList,
    /// The first since the last reset.
    fault: Option<Fault>,
    has_spoken: bool,
    /// Whether nodes are Operational and torques are sent.
    is_running: bool,
    is_resetting_drives: bool,
    is_shutting_down: bool,
    /// Whether poses are measured with cables under pretension, and the controller is never enabled.
    is_survey: bool,
    /// Where it was placed last, and what it is lifted from to be weighed.
    placed: Option<Stand>,
    stand: Stand,
    /// Which drives have shown in a survey that they haul their own cable in.
    proved: PerCable<Option<Identity>>,
    /// Who the drives are to be.
    expected: Option<PerCable<Identity>>,
    /// Whether everything is set up anew once the platform is down.
    is_reset_due: bool,
    /// When a platform that hangs is let down; None if it is not.
    lowers_at: Option<Nanoseconds>,
    /// Whether the operator let go since the controller was last enabled.
    is_released: bool,
    /// When home was last given, and whether it came too late, so that it must be released first.
    home_given: Nanoseconds,
    is_home_stale: bool,
    next_heartbeat: Nanoseconds,
    /// Consecutive cycles in which the transport had no room, and whether this is one.
    no_room: u32,
    had_no_room: bool,
    events: EventLog,
}

impl Bridge {
    /// Starts in [`State::Configuring`] with the first cycle.
    pub fn new(config: Config) -> Self {
        let (home, cables) = (config.home, config.rig.cables.len());
        let nothing = PerCable::filled(cables, 0.0);
        let peer = |node, bus, startup| Peer { node, bus, startup, heard: 0 };
        let mut peers: Vec<_> = (0..cables)
            .map(|i| peer(config.drives[i].node, config.drives[i].bus, Startup::drive(&config, i)))
            .collect();
        for cell in &config.load_cells {
            if peers.iter().all(|peer| peer.node != cell.node) {
                peers.push(peer(cell.node, cell.bus, Startup::load_cell(&config, cell.node)));
            }
        }
        let home_length = config.rig.cables_at(&home).length;
        Self {
            home_length,
            torque_frames: config.torque_frames(),
            peers,
            mode: Mode::Listening { since: 0 },
            time: 0,
            offset: 0,
            is_started: false,
            drives: vec![DriveMonitor::default(); cables],
            cells: vec![CellMonitor::default(); cables],
            followers: vec![Follower::new(); cables],
            reactions: vec![Reaction::default(); cables],
            mode_question: ModeQuestion::default(),
            course: None,
            pose: home,
            measured_pose: None,
            goal: home,
            commanded: nothing,
            still_since: vec![nothing; cables],
            certified: nothing,
            answer: None,
            pending: FaultList::default(),
            reported_faults: FaultList::default(),
            fault: None,
            has_spoken: false,
            is_running: false,
            is_resetting_drives: false,
            is_shutting_down: false,
            is_survey: false,
            placed: None,
            stand: Stand { pose: home, length: home_length },
            proved: PerCable::filled(cables, None),
            expected: None,
            is_reset_due: false,
            lowers_at: None,
            is_released: true,
            home_given: 0,
            is_home_stale: false,
            next_heartbeat: 0,
            no_room: 0,
            had_no_room: false,
            events: EventLog::new(),
            config,
        }
    }

    /// Sends nothing, ever, and needs no operator: reads the frames of a rig that another controller drives, and computes what its own
    /// would do. The platform is taken to be at the home pose when everything was heard for the first time.
    pub fn shadow(config: Config) -> Self {
        Self { mode: Mode::Shadow { is_homed: false }, ..Self::new(config) }
    }

    /// Goes as far as Ready. There a person puts the platform at poses measured in the base frame; what lengths say of its pose is not judged,
    /// since whether the files are right is what is to be found out.
    pub fn survey(config: Config) -> Self {
        Self { is_survey: true, ..Self::new(config) }
    }

    /// The same, for these drives only: another one in the place of one of them is a fault once the nodes are set up.
    #[must_use]
    pub fn expecting(self, drives: PerCable<Identity>) -> Self {
        Self { expected: Some(drives), ..self }
    }

    /// Who the drives say they are, once they are set up.
    pub fn identities(&self) -> PerCable<Identity> {
        PerCable::from_fn(self.cables(), |i| self.peers[i].startup.identity())
    }

    /// What it was made from.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// How many cables it drives.
    fn cables(&self) -> usize {
        self.config.rig.cables.len()
    }

    /// What it is doing.
    pub fn state(&self) -> State {
        match self.mode {
            Mode::Listening { .. } | Mode::Quieting { .. } | Mode::Configuring => State::Configuring,
            Mode::Homing { .. } => State::Homing,
            Mode::TakingUpSlack { .. } => State::TakingUpSlack,
            Mode::Ready => State::Ready,
            Mode::Enabled { .. } => State::Enabled,
            Mode::Stopping { .. } => State::Stopping,
            Mode::Safe(_) => State::Safe,
            Mode::Fault(_) => State::Fault,
            Mode::Trying(_) => State::Trying,
            Mode::Jogging(_) => State::Jogging,
            Mode::Lowering { .. } => State::Lowering,
            Mode::Off => State::Off,
            Mode::Shadow { .. } => State::Shadow,
        }
    }

    /// The first fault since the last reset.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// The next thing to log, with its time.
    pub fn take_event(&mut self) -> Option<(Nanoseconds, Event)> {
        self.events.pop(self.time)
    }

    /// One cycle at `now`: reads what has arrived, steps the controller if it is its turn, and puts all that is to be sent now into `out`.
    pub fn cycle(
        &mut self,
        now: Nanoseconds,
        controller: &mut dyn ControllerModel,
        out: &mut FrameQueue,
    ) -> CycleReport {
        out.clear();
        self.advance_clock(now);
        self.measure();
        self.watch_nodes();
        self.watch_drives();
        self.watch_reactions();
        self.watch_followers();
        self.follow_pose();
        self.answer = None;
        if self.pending.is_empty() && self.asks_the_controller() {
            self.ask(controller);
        }
        self.watch_course();
        for fault in std::mem::take(&mut self.pending).iter() {
            self.fail(fault);
        }
        self.proceed(out);
        self.ask_for_mode(out);
        let torques = self.send(out);
        self.report(now, torques)
    }

    fn peer(&mut self, bus: usize, node: Node) -> Option<&mut Peer> {
        self.peers.iter_mut().find(|peer| (peer.bus, peer.node) == (bus, node))
    }

    /// Notes a fault for the next cycle.
    fn raise(&mut self, fault: Fault) {
        self.pending.insert(fault);
    }

    fn expect(&mut self, result: Result<(), Fault>) {
        if let Err(fault) = result {
            self.raise(fault);
        }
    }

    fn asks_the_controller(&self) -> bool {
        match self.mode {
            _ if self.is_survey => false,
            Mode::Ready | Mode::Enabled { .. } | Mode::Shadow { is_homed: true } => true,
            // On the way down nothing depends on it.
            Mode::Safe(_) => self.lowers_at.is_none_or(|at| at > self.time),
            _ => false,
        }
    }

    fn advance_clock(&mut self, now: Nanoseconds) {
        let time = now + self.offset;
        if !self.is_started {
            self.is_started = true;
            self.time = time;
            self.next_heartbeat = time;
            self.events.push(time, Event::Entered(self.state()));
            if let Mode::Listening { since } = &mut self.mode {
                *since = time;
            }
            return;
        }
        if time <= self.time {
            self.raise_if_active(Fault::ClockBackwards { by: self.time - time });
            self.offset += self.time + self.config.period - time;
            self.time += self.config.period;
            return;
        }
        let gap = time - self.time;
        if gap > self.config.period * u64::from(self.config.limits.lost_cycles + 1) {
            // What nodes and frames have to say of the time without the bridge follows from it.
            if self.is_active() {
                self.pending.insert_first(Fault::Overrun { gap });
            }
        }
        self.time = time;
    }

    fn raise_if_active(&mut self, fault: Fault) {
        if self.is_active() {
            self.raise(fault);
        }
    }

    /// Load cells, N.
    fn measured(&self) -> PerCable<f64> {
        PerCable::from_fn(self.cables(), |i| self.cells[i].tension())
    }

    fn report(&self, time: Nanoseconds, target_torque: PerCable<i16>) -> CycleReport {
        CycleReport {
            time,
            state: self.state(),
            fault: self.fault,
            length: self.lengths(),
            pose: self.pose,
            measured_pose: self.measured_pose,
            measured: self.measured(),
            tension: self.commanded,
            target_torque,
            drive: PerCable::from_fn(self.cables(), |i| self.drives[i].state),
            missed: PerCable::from_fn(self.cables(), |i| {
                [self.drives[i].encoder.missed, self.cells[i].missed]
            }),
            controller: self.answer,
        }
    }
}
