//! The bridge allocates nothing once it and the controller are made: counted at the allocator, from power-on to the goal.
#![allow(unsafe_code)]

mod counting_allocator;

use cable_robot::plan::{ControllerInputs, ControllerParameters, PoseSource};
use cable_robot::robot::{PerCable, Pose, RigFile};
use cable_robot::sim::{ControllerModel, PlantParameters};
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
fn from_power_on_to_the_goal_the_bridge_allocates_nothing() {
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
    for k in 1..=3000 {
        let now = k * 4_000_000;
        rig.tick(now, &mut coming);
        calls += counted(|| coming.drain(..).for_each(|(bus, frame)| bridge.on_frame(bus, &frame, now))).1;
        let state = bridge.state();
        let command = match state {
            State::Homing => Some(OperatorCommand::Home),
            State::Ready => Some(OperatorCommand::Enable),
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
    }
    assert_eq!((bridge.state(), calls), (State::Enabled, 0));
}
