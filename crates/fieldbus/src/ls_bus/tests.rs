//! Both nodes joined without an importer.

use super::*;
use crate::bridge::Fault;
use crate::simulated::{SimulatedRig, Support};
use crate::{Bridge, Frame, FrameQueue, LibraryController, OperatorCommand, State};
use cable_robot::plan::{ControllerParameters, PoseSource};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::PlantParameters;

/// So many steps make a period.
const STEPS: Nanoseconds = 4;

fn config() -> Config {
    let rig = RigFile::parse(include_str!("../../../../rigs/can/lab.toml")).unwrap();
    Config::parse(include_str!("../../../../rigs/can/akd.toml"), &rig).unwrap()
}

fn parameters(config: &Config) -> ControllerParameters {
    config.of_drives(ControllerParameters {
        lambda: config.controller.lambda,
        eta: config.controller.eta,
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        ..ControllerParameters::of(&config.rig)
    })
}

/// The two nodes, and what passed between them.
struct Joined {
    controller: ControllerNode,
    rig: RigNode,
    wishes: Wishes,
    now: Nanoseconds,
    /// Bytes each way at each bus communication point.
    trace: Vec<[Vec<u8>; 2]>,
    /// Nothing passes.
    is_cut: bool,
}

impl Joined {
    fn new() -> Self {
        let config = config();
        let wishes = Wishes { enable: false, home: false, reset: false, goal: config.home };
        let mut joined = Self {
            controller: ControllerNode::new(config.clone(), parameters(&config)),
            rig: RigNode::new(config, PlantParameters::default()).unwrap(),
            wishes,
            now: 0,
            trace: vec![],
            is_cut: false,
        };
        joined.exchange();
        joined
    }

    fn step(&mut self) {
        self.now += self.controller.config().period / STEPS;
        self.controller.step(self.now, &self.wishes);
        self.rig.step(self.now);
        self.controller.ports()[0].show();
        self.rig.ports()[0].show();
        self.exchange();
    }

    fn exchange(&mut self) {
        let [there, back] =
            [self.controller.ports(), self.rig.ports()].map(|ports| ports[0].shown().to_vec());
        let panic = &mut |notice: Notice| panic!("{notice}");
        if !self.is_cut {
            self.controller.receive(0, &back, self.now, panic);
            self.rig.receive(0, &there, self.now, panic);
        }
        self.controller.ports()[0].forget_shown();
        self.rig.ports()[0].forget_shown();
        self.trace.push([there, back]);
    }

    fn run_until(&mut self, state: State, seconds: f64) {
        let end = self.now + (seconds * 1e9) as Nanoseconds;
        while self.now < end && self.controller.state() != state {
            self.step();
        }
        assert_eq!(self.controller.state(), state, "{:?}", self.fault());
    }

    fn run(&mut self, seconds: f64) {
        let end = self.now + (seconds * 1e9) as Nanoseconds;
        while self.now < end {
            self.step();
        }
    }

    fn start(&mut self) {
        self.wishes.home = true;
        self.run_until(State::Ready, 30.0);
        self.wishes.enable = true;
        self.run_until(State::Enabled, 1.0);
        self.run(1.0);
    }

    fn fault(&self) -> Option<Fault> {
        self.controller.report().and_then(|report| report.fault)
    }
}

#[test]
fn from_power_on_to_a_goal() {
    let mut joined = Joined::new();
    joined.start();
    assert_eq!(joined.rig.support(), Support::Cables);
    joined.wishes.goal = Pose::at(0.1, 0.1, 1.0);
    joined.run(12.0);
    let there = joined.rig.plant().encoder_pose;
    assert!((there.0 - joined.wishes.goal.0).norm() < 2e-3, "{there:?}");
    assert_eq!(joined.controller.state(), State::Enabled);
    assert!(!joined.rig.plant().slack.iter().any(|slack| *slack));
}

/// A goal that was there before is no wish to go there now.
#[test]
fn what_is_enabled_stays_where_it_is_until_the_goal_changes() {
    let mut joined = Joined::new();
    joined.wishes.goal = Pose::at(0.1, 0.1, 1.0);
    joined.start();
    joined.run(3.0);
    let home = joined.controller.config().home;
    assert!((joined.rig.plant().encoder_pose.0 - home.0).norm() < 2e-3);
}

#[test]
fn silence_of_the_bus_leads_to_the_safe_output() {
    let mut joined = Joined::new();
    joined.start();
    joined.is_cut = true;
    joined.run(0.03);
    joined.is_cut = false;
    assert!(matches!(joined.fault(), Some(Fault::EncoderSilent { cable: 1 })), "{:?}", joined.fault());
    joined.run_until(State::Fault, 1.0);
    assert_eq!(joined.rig.support(), Support::Cables);
    // A reset sets everything up anew. The drives lose their torque, so that the platform is not at home any more.
    joined.wishes = Wishes { enable: false, home: false, reset: true, ..joined.wishes };
    joined.run_until(State::Homing, 30.0);
    assert_eq!(joined.fault(), None);
}

#[test]
fn a_button_that_is_let_go_leads_to_the_safe_output() {
    let mut joined = Joined::new();
    joined.start();
    joined.wishes.enable = false;
    // At once, not when the enable expires.
    joined.run(joined.controller.config().period as f64 * 1e-9);
    assert_eq!(joined.controller.state(), State::Stopping);
    joined.run_until(State::Safe, 1.0);
    assert_eq!(joined.fault(), None);
}

#[test]
fn a_bus_that_is_off_is_a_fault() {
    let mut joined = Joined::new();
    joined.start();
    let destroyed = [0x31, 0, 0, 0, 15, 0, 0, 0, 0x81, 1, 0, 0, 5, 1, 1];
    let bytes: Vec<u8> = (0..32).flat_map(|_| destroyed).collect();
    let mut told = 0;
    joined.controller.receive(0, &bytes, joined.now, &mut |_| told += 1);
    assert_eq!(told, 32 + 2);
    joined.run(0.01);
    assert_eq!(joined.fault(), Some(Fault::BusOff { bus: 0 }));
}

/// Bridge and rig themselves, without any byte of the standard: the same frames at the same times, from power-on to Enabled and a goal.
#[test]
fn the_frames_are_those_of_bridge_and_rig_themselves() {
    let mut joined = Joined::new();
    let config = config();
    let mut bridge = Bridge::new(config.clone());
    let mut controller = LibraryController::new(parameters(&config));
    let mut rig = SimulatedRig::new(config.clone(), PlantParameters::default()).unwrap();
    let (mut out, mut coming) = (FrameQueue::new(), vec![]);
    let goal = Pose::at(0.1, 0.1, 1.0);
    for k in 1..=24_000 {
        joined.wishes.home = true;
        joined.wishes.enable = bridge.state() == State::Ready || bridge.state() == State::Enabled;
        if k == 20_000 {
            assert_eq!(bridge.state(), State::Enabled);
            joined.wishes.goal = goal;
        }
        joined.step();

        let now = k * config.period / STEPS;
        let mut sent: Vec<(usize, Frame)> = vec![];
        if k % STEPS == 0 {
            let _ = bridge.operator(OperatorCommand::Home, now);
            if joined.wishes.enable {
                let _ = bridge.operator(OperatorCommand::Enable, now);
            }
            if k == 20_000 {
                bridge.operator(OperatorCommand::Goal(goal), now).unwrap();
            }
            bridge.cycle(now, &mut controller, &mut out);
            sent.extend_from_slice(out.frames());
        }
        rig.tick(now, &mut coming);
        let heard = std::mem::take(&mut coming);
        heard.iter().for_each(|(bus, frame)| bridge.on_frame(*bus, frame, now));
        sent.iter().for_each(|(bus, frame)| rig.on_frame(*bus, frame, now, &mut coming));
        let [there, back] = joined.trace.last().unwrap();
        assert_eq!((bytes(&sent), bytes(&heard)), (there.clone(), back.clone()), "step {k}");
    }
    assert_eq!(bridge.state(), State::Enabled);
}

fn bytes(frames: &[(usize, Frame)]) -> Vec<u8> {
    let mut bytes = vec![];
    frames.iter().for_each(|(_, frame)| operation::Request::Transmit(*frame).write(&mut bytes));
    bytes
}

/// Importers add up their steps: 0.1 + 0.2 is not 0.3.
#[test]
fn a_cycle_is_due_at_a_communication_point_that_is_rounded() {
    let (config, mut joined) = (config(), Joined::new());
    joined.controller.step(config.period - 1, &joined.wishes);
    assert_eq!(joined.controller.report().unwrap().time, config.period);
    joined.controller.step(config.period, &joined.wishes);
    assert_eq!(joined.controller.report().unwrap().time, config.period);
}
