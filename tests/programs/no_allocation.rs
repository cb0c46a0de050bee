//! A control step allocates nothing, in the library and through the FMI functions: counted at the allocator.
//!
//! With it, what an instance takes from the heap at all.
#![allow(unsafe_code)]

mod counting_allocator;

use std::ffi::CString;
use std::ptr::{null, null_mut};

use cable_robot::plan::orbit::{Figure, Follower, Orbit};
use cable_robot::plan::{ControllerInputs, ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, RigFile, TensionLimits};
use cable_robot::sim::{ClosedLoop, Plant, PlantInputs, PlantParameters};
use cable_robot_fmi::abi::{fmi3::*, fmi3_values::*};
use cable_robot_fmi::variables::Causality;
use cable_robot_fmi::{CO_SIMULATION, Model};
use counting_allocator::{BYTES, CALLS};

#[test]
fn steps_of_the_library_allocate_nothing() {
    let rig = PlantParameters {
        encoder_resolution: 1e-5,
        friction: 0.1,
        load_cell_noise: 0.1,
        ..Default::default()
    };
    let parameters = ControllerParameters { force_loop: true, ..Default::default() };
    let mut closed_loop = ClosedLoop::new(parameters, rig, Pose::at(0.15, 0.15, 1.0)).unwrap();
    let before = CALLS.get();
    for _ in 0..3000 {
        closed_loop.step(1e-3).unwrap();
    }
    assert_eq!(CALLS.get() - before, 0, "allocations in 3000 steps with 60 planner ticks");
    assert!(closed_loop.controller.outputs().set_point_index >= 1);
}

/// Turning, the planner asks the certificate: at every tick, also where it refuses.
#[test]
fn steps_of_the_exact_planner_allocate_nothing() {
    let mut parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
    parameters.rig = parameters.rig.with_limits(TensionLimits { min: 0.0, max: 16.0 });
    let goal = Pose(Coordinates::new(0.05, 0.0, 0.9, 0.1, 0.0, 0.9));
    let mut closed_loop = ClosedLoop::new(parameters, PlantParameters::default(), goal).unwrap();
    let before = CALLS.get();
    for _ in 0..3000 {
        closed_loop.step(1e-3).unwrap();
    }
    assert_eq!(CALLS.get() - before, 0, "allocations in 3000 steps with 60 planner ticks");
    let output = closed_loop.controller.outputs();
    assert!(output.set_point_index >= 1 && output.status == Status::GoalUnreachable, "{output:?}");
}

/// The search for the nearest pose called a solver, which allocated: at goals that are not reachable, of any rig.
#[test]
fn goals_that_are_not_reachable_allocate_nothing() {
    for text in [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")] {
        let file = RigFile::parse(text).unwrap();
        let mut parameters = ControllerParameters::of(&file.rig);
        parameters.planner = PlannerKind::Exact;
        let rig = PlantParameters { rig: file.rig, initial_pose: file.home, ..Default::default() };
        let mut closed_loop = ClosedLoop::new(parameters, rig, file.home).unwrap();
        closed_loop.step(1e-3).unwrap();
        let before = CALLS.get();
        for away in [[5.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.5, 0.0], [0.4, 0.3, 0.1, 1.5], [0.0, 9.0, 0.3, -2.0]]
        {
            let [x, y, z, yaw] = away;
            closed_loop.goal = Pose(file.home.0 + Coordinates::new(x, y, z, 0.1, 0.0, yaw));
            for _ in 0..500 {
                closed_loop.step(1e-3).unwrap();
            }
        }
        assert_eq!(CALLS.get() - before, 0, "allocations in 2000 steps");
        assert_eq!(closed_loop.controller.outputs().status, Status::GoalUnreachable);
    }
}

/// Goals that change on the way, then a pose that is lost: plans, their proofs and their stops.
#[test]
fn the_fastest_motions_allocate_nothing() {
    for text in [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")] {
        let file = RigFile::parse(text).unwrap();
        let parameters =
            ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&file.rig) };
        let plant = PlantParameters { rig: file.rig, initial_pose: file.home, ..Default::default() };
        let mut closed_loop = ClosedLoop::new(parameters, plant, file.home).unwrap();
        closed_loop.step(1e-3).unwrap();
        let before = CALLS.get();
        for (x, yaw) in [(0.1, 0.0), (-0.1, 0.2), (0.05, -0.1), (9.0, 0.0), (0.1, 0.1)] {
            closed_loop.goal = Pose(file.home.0 + Coordinates::new(x, 0.05, -0.02, 0.0, 0.0, yaw));
            for _ in 0..200 {
                closed_loop.step(1e-3).unwrap();
            }
        }
        for _ in 0..200 {
            closed_loop.step_seeing(1e-3, |inputs| inputs.encoder_pose.0[0] += 5.0).unwrap();
        }
        assert_eq!(CALLS.get() - before, 0, "allocations in 1200 steps");
        let output = closed_loop.controller.outputs();
        assert!(output.set_point_index >= 4 && output.status == Status::SensorFault, "{output:?}");
    }
}

/// An orbit, and after a pose that makes no sense its stop.
#[test]
fn orbits_allocate_nothing() {
    let (parameters, centre) = (ControllerParameters::default(), Pose::default());
    let figure = Figure::Circle { radius: 0.4 };
    let orbit = Orbit { centre, figure, rate: 2.75, turns: 1.0, start: 2.5 };
    let plant = Plant::new(PlantParameters::default(), &PlantInputs::none(6)).unwrap();
    let resting = ClosedLoop::new(parameters, PlantParameters::default(), centre).unwrap();
    let seen = &resting.moment().controller_inputs;
    let follower = Follower::new(&orbit, &parameters, (0.0, 1e-3), seen).unwrap();
    let mut closed_loop = ClosedLoop::with_models(follower, plant, centre, &PlantInputs::none(6)).unwrap();
    closed_loop.step(1e-3).unwrap();
    let before = CALLS.get();
    for k in 0..6000 {
        let lose = |inputs: &mut ControllerInputs| {
            if k == 3000 {
                inputs.encoder_pose.0[0] += 5.0;
            }
        };
        closed_loop.step_seeing(1e-3, lose).unwrap();
    }
    assert_eq!(CALLS.get() - before, 0, "allocations in 6000 steps");
    assert_eq!(closed_loop.controller.outputs().status, Status::SensorFault);
}

/// Gains changed on the way, those that are taken and those that wait: also of a rig that is the paper's only turned.
#[test]
fn tuning_allocates_nothing() {
    let eight = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
    let mut turned = RigFile::default();
    for cable in turned.rig.cables.iter_mut() {
        for end in [&mut cable.anchor, &mut cable.attachment] {
            *end = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, 0.3) * *end;
        }
    }
    for (file, planner) in [
        (RigFile::default(), PlannerKind::Bounded),
        (turned.clone(), PlannerKind::Bounded),
        (turned, PlannerKind::Exact),
        (eight, PlannerKind::Exact),
    ] {
        let mut parameters = ControllerParameters::of(&file.rig);
        parameters.planner = planner;
        let plant = PlantParameters { rig: file.rig, initial_pose: file.home, ..Default::default() };
        let mut closed_loop = ClosedLoop::new(parameters, plant, file.home).unwrap();
        closed_loop.goal = Pose(file.home.0 + Coordinates::new(0.05, 0.02, 0.0, 0.0, 0.0, 0.0));
        closed_loop.step(1e-3).unwrap();
        let before = CALLS.get();
        for k in 0..20 {
            let mut tuning = closed_loop.controller.tuning();
            (tuning.lambda, tuning.eta) = (3.0 + f64::from(k), 3.0);
            closed_loop.controller.tune(&tuning).unwrap();
            for _ in 0..100 {
                closed_loop.step(1e-3).unwrap();
            }
        }
        assert_eq!(CALLS.get() - before, 0, "allocations in 20 tunings, {planner:?}");
    }
}

#[test]
fn steps_through_fmi_allocate_nothing_and_an_instance_is_small() {
    for interface in CO_SIMULATION.map(Model::interface) {
        let model = interface.model();
        let token = CString::new(interface.token()).unwrap();
        let before = BYTES.get();
        unsafe {
            let instance = fmi3InstantiateCoSimulation(
                c"i".as_ptr(),
                token.as_ptr(),
                null(),
                false,
                false,
                false,
                false,
                null(),
                0,
                null_mut(),
                None,
                None,
            );
            assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(instance), 0);
            let bytes = BYTES.get() - before;
            println!("{}: {bytes} bytes an instance", model.identifier());
            assert!(bytes < 256 * 1024);

            let reference = [interface.rows_with(Causality::Output).next().unwrap().first];
            let mut value = [0.0];
            let before = CALLS.get();
            for k in 0..1000 {
                assert_eq!(fmi3GetFloat64(instance, reference.as_ptr(), 1, value.as_mut_ptr(), 1), 0);
                let (mut event, mut terminate, mut early, mut last) = (false, false, false, 0.0);
                let time = f64::from(k) * 1e-3;
                let status =
                    fmi3DoStep(instance, time, 1e-3, true, &mut event, &mut terminate, &mut early, &mut last);
                assert_eq!(status, 0);
            }
            assert_eq!(CALLS.get() - before, 0, "allocations in 1000 steps of {}", model.identifier());
            fmi3FreeInstance(instance);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn frames_through_a_serial_line_allocate_nothing() {
    use cable_robot_fieldbus::frame::Frame;
    use cable_robot_fieldbus::transport::{Transport, now, open, pseudo_terminal};

    let (mut adapter, device) = pseudo_terminal().unwrap();
    let mut program = open(&format!("slcan:{}", device.display()), 1_000_000, &[]).unwrap();
    let before = CALLS.get();
    for k in 0..1000u32 {
        program.send(&Frame::data(0x201, k.to_le_bytes())).unwrap();
        let received = adapter.receive(now() + 10_000_000_000).unwrap().unwrap();
        adapter.send(&received.frame).unwrap();
        assert_eq!(program.receive(now() + 10_000_000_000).unwrap().unwrap().frame, received.frame);
    }
    drop(adapter);
    assert!(program.receive(0).is_err());
    assert_eq!(CALLS.get() - before, 0, "allocations in 1000 echoed frames and a hang-up");
}
