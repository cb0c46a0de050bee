//! The bridge allocates nothing once it and the controller are made: counted at the allocator, from power-on to the goal.
#![allow(unsafe_code)]

mod counting_allocator;

use cable_robot::plan::{ControllerInputs, ControllerParameters, PoseSource};
use cable_robot::robot::{PerCable, Pose, RigFile};
use cable_robot::sim::{ControllerModel, PlantParameters};
use cable_robot_fieldbus::ls_bus::{ControllerNode, RigNode, Wishes};
use cable_robot_fieldbus::simulated::SimulatedRig;
use cable_robot_fieldbus::{Bridge, Config, FrameQueue, LibraryController, OperatorCommand, State};
use counting_allocator::CALLS;

/// What `action` returns, and how often it allocated.
fn counted<T>(action: impl FnOnce() -> T) -> (T, usize) {
    let before = CALLS.get();
    let result = action();
    (result, CALLS.get() - before)
}

#[test]
fn from_power_on_to_the_goal_and_down_again_the_bridge_allocates_nothing() {
    let lab = RigFile::parse(include_str!("../../rigs/can/lab.toml")).unwrap();
    let config = Config::parse(include_str!("../../rigs/can/akd.toml"), &lab).unwrap();
    let mut rig = SimulatedRig::new(config.clone(), PlantParameters::default()).unwrap();
    let parameters = ControllerParameters {
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        ..Default::default()
    };
    let (mut controller, mut out) = (LibraryController::new(parameters), FrameQueue::new());
    // The controller is made in its first step.
    let home = Pose::default();
    let still = ControllerInputs {
        encoder_pose: home,
        cable_length: parameters.rig.cables_at(&home).length,
        measured_tension: PerCable::filled(6, 0.0),
        goal_pose: home,
        enable: false,
    };
    controller.start(&still).unwrap();
    let mut bridge = Bridge::new(config);
    let (mut coming, mut calls, mut goal_sent) = (vec![], 0, false);
    // Then it is let down, and off.
    const DOWN: u64 = 3000;
    for k in 1..=2 * DOWN {
        let now = k * 4_000_000;
        rig.tick(now, &mut coming);
        calls += counted(|| coming.drain(..).for_each(|(bus, frame)| bridge.on_frame(bus, &frame, now))).1;
        let state = bridge.state();
        let command = match state {
            State::Homing | State::TakingUpSlack => Some(OperatorCommand::Home),
            State::Ready => Some(OperatorCommand::Enable),
            State::Enabled if k > DOWN => Some(OperatorCommand::Shutdown),
            State::Enabled if !goal_sent => Some(OperatorCommand::Goal(Pose::at(0.15, 0.15, 1.0))),
            State::Enabled => Some(OperatorCommand::Enable),
            _ => None,
        };
        goal_sent |= state == State::Enabled;
        calls += counted(|| command.map(|command| bridge.operator(command, now))).1;
        let (report, allocations) = counted(|| bridge.cycle(now, &mut controller, &mut out));
        calls += allocations;
        out.frames().iter().for_each(|(bus, frame)| rig.on_frame(*bus, frame, now, &mut coming));
        assert_eq!(report.fault, None);
        assert!(k != DOWN || state == State::Enabled, "{state}");
    }
    assert_eq!((bridge.state(), calls), (State::Off, 0));
}

/// The same of the node on a simulated bus: what it receives, its cycles, and what it sends. The one step that allocates is the first that asks
/// the controller, which is made then.
#[test]
fn a_node_on_a_simulated_bus_allocates_nothing_either() {
    let lab = RigFile::parse(include_str!("../../rigs/can/lab.toml")).unwrap();
    let config = Config::parse(include_str!("../../rigs/can/akd.toml"), &lab).unwrap();
    let parameters = ControllerParameters {
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        ..ControllerParameters::of(&config.rig)
    };
    let mut wishes = Wishes { enable: false, home: true, reset: false, goal: config.home };
    let mut rig = RigNode::new(config.clone(), PlantParameters::default()).unwrap();
    let mut node = ControllerNode::new(config, parameters);
    let mut allocating = vec![];
    for k in 1..=16_000 {
        let (now, was) = (k * 1_000_000, node.state());
        wishes.enable = matches!(was, State::Ready | State::Enabled);
        if was == State::Enabled && k > 15_000 {
            wishes.goal = Pose::at(0.1, 0.1, 1.0);
        }
        rig.step(now);
        rig.ports()[0].show();
        let ((), allocations) = counted(|| {
            node.step(now, &wishes);
            node.ports()[0].show();
            node.receive(0, rig.ports()[0].shown(), now, &mut |notice| panic!("{notice}"));
            while node.take_event().is_some() {}
        });
        allocating.extend((allocations > 0).then_some(was));
        rig.ports()[0].forget_shown();
        rig.receive(0, node.ports()[0].shown(), now, &mut |notice| panic!("{notice}"));
        node.ports()[0].forget_shown();
    }
    assert_eq!((node.state(), allocating), (State::Enabled, vec![State::Ready]));
}
