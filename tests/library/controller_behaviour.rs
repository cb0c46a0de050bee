//! What the controller does when somebody asks for something else than the paper's move.

use crate::common::{ClosedLoop, inputs};
use cable_robot::plan::{
    Check, Controller, ControllerInputs, ControllerParameters, Fault, PlannerKind, Status,
};
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};

fn to(goal: Pose) -> ClosedLoop {
    ClosedLoop::new(ControllerParameters::default(), PlantParameters::default(), goal, 1e-3)
}

/// Runs for `seconds` and says how small a tension got.
fn run(closed_loop: &mut ClosedLoop, seconds: f64) -> f64 {
    let end = closed_loop.time() + seconds - 1e-9;
    let mut smallest = f64::INFINITY;
    while closed_loop.time() < end {
        let (output, plant) = closed_loop.advance();
        assert_eq!(plant.slack, [false; 6], "slack at {}", closed_loop.time());
        smallest = output.motor_tension.iter().copied().fold(smallest, f64::min);
    }
    smallest
}

#[test]
fn a_new_goal_is_accepted_on_the_way() {
    let mut closed_loop = to(Pose::at(0.15, 0.15, 1.0));
    run(&mut closed_loop, 0.7);
    assert_eq!(closed_loop.controller.outputs().status, Status::Moving);
    closed_loop.goal = Pose::at(-0.1, 0.05, 1.0);
    assert!(run(&mut closed_loop, 15.0) > 0.5);
    let output = closed_loop.controller.outputs();
    assert_eq!((output.status, output.at_goal), (Status::AtGoal, true));
    assert_eq!(output.set_point, closed_loop.goal);
}

#[test]
fn a_goal_outside_the_workspace_is_a_status_and_slackens_nothing() {
    let mut closed_loop = to(Pose::at(0.0, 0.5, 1.0));
    run(&mut closed_loop, 30.0);
    let output = closed_loop.controller.outputs();
    assert_eq!(output.status, Status::GoalUnreachable);
    assert!(output.set_point.0[1] > 0.2 && output.set_point.0[1] < 0.225, "{:?}", output.set_point);
    // And back.
    closed_loop.goal = Pose::at(0.0, 0.0, 1.0);
    run(&mut closed_loop, 30.0);
    assert_eq!(closed_loop.controller.outputs().status, Status::AtGoal);
}

#[test]
fn a_goal_that_equation_15_does_not_speak_of_is_a_status() {
    for goal in [
        Pose::at(0.0, 0.0, 0.8),
        Pose(Coordinates::new(0.1, 0.0, 1.0, 0.0, 0.0, 0.5)),
        Pose::at(0.0, 0.0, -1.0),
    ] {
        let mut closed_loop = to(goal);
        run(&mut closed_loop, 1.0);
        let output = closed_loop.controller.outputs();
        assert_eq!((output.status, output.set_point_index), (Status::GoalUnreachable, 0));
    }
}

#[test]
fn disabling_lets_go_and_enabling_starts_where_the_robot_is() {
    let mut closed_loop = to(Pose::at(0.1, 0.0, 1.0));
    run(&mut closed_loop, 0.5);
    closed_loop.enable = false;
    let (output, _) = closed_loop.advance();
    assert_eq!((output.status, output.motor_tension), (Status::Disabled, PerCable::filled(6, 0.0)));
    for _ in 0..20 {
        closed_loop.advance();
    }
    closed_loop.enable = true;
    closed_loop.goal = closed_loop.plant.outputs().encoder_pose;
    let (output, plant) = closed_loop.advance();
    assert_eq!(output.set_point_index, 0);
    // It falls: the set point is where it can stop, straight ahead.
    let (ahead, fall) = (output.set_point.minus(&plant.encoder_pose), output.estimated_velocity);
    let (ahead, fall) = (ahead.fixed_rows::<3>(0).into_owned(), fall.fixed_rows::<3>(0).into_owned());
    assert!(fall.norm() > 0.1 && (ahead.normalize() - fall.normalize()).norm() < 0.05, "{ahead} {fall}");
    run(&mut closed_loop, 4.0);
    assert!(closed_loop.controller.outputs().steady);
}

#[test]
fn an_impossible_pose_holds_gravity_until_the_operator_resets() {
    let mut closed_loop = to(Pose::at(0.0, 0.0, 1.0));
    run(&mut closed_loop, 0.2);
    let mut inputs = crate::common::inputs(closed_loop.plant.outputs(), closed_loop.goal, true);
    let good = inputs.encoder_pose;
    inputs.encoder_pose = Pose::at(0.3, 0.0, 1.0);
    closed_loop.controller.step(0.2, 1e-3, &inputs);
    let check = |closed_loop: &ClosedLoop| {
        let output = closed_loop.controller.outputs();
        assert_eq!(output.status, Status::SensorFault);
        assert!(
            output.motor_tension.iter().all(|u| (u - 10.7612).abs() < 1e-3),
            "{:?}",
            output.motor_tension
        );
    };
    check(&closed_loop);
    inputs.encoder_pose = good;
    closed_loop.controller.step(0.201, 1e-3, &inputs);
    check(&closed_loop);
    inputs.enable = false;
    closed_loop.controller.step(0.202, 1e-3, &inputs);
    assert_eq!(closed_loop.controller.outputs().status, Status::Disabled);
    inputs.enable = true;
    closed_loop.controller.step(0.203, 1e-3, &inputs);
    assert_ne!(closed_loop.controller.outputs().status, Status::SensorFault);
}

#[test]
fn a_singular_pose_is_a_fault_and_not_a_number_gone_wild() {
    // Turned by 90 degrees the wrench matrix of this geometry loses rank.
    let mut closed_loop = to(Pose::default());
    let mut inputs = crate::common::inputs(closed_loop.plant.outputs(), closed_loop.goal, true);
    for k in 0..40 {
        inputs.encoder_pose = Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.08 * f64::from(k)));
        closed_loop.controller.step(f64::from(k), 1e-3, &inputs);
        let output = closed_loop.controller.outputs();
        assert!(output.motor_tension.iter().all(|u| (0.0..=100.0).contains(u)), "{output:?}");
        assert!(output.tension_margin.is_finite());
    }
}

#[test]
fn load_cells_make_up_for_friction() {
    let parameters = ControllerParameters { force_loop: true, ..Default::default() };
    let rig = PlantParameters { friction: 1.0, motor_lag: 0.01, ..Default::default() };
    let offset = |parameters| {
        let mut closed_loop = ClosedLoop::new(parameters, rig, Pose::at(0.05, 0.0, 1.0), 1e-3);
        for _ in 0..8000 {
            closed_loop.advance();
        }
        let error =
            closed_loop.plant.outputs().encoder_pose.minus(&closed_loop.controller.outputs().set_point);
        error.fixed_rows::<3>(0).norm()
    };
    let (open, closed) = (offset(ControllerParameters::default()), offset(parameters));
    println!("offset {open:.1e} m without, {closed:.1e} m with the force loop");
    assert!(closed < 0.1 * open, "{closed} m with the force loop, {open} m without");
}

/// Goals outside the workspace, one after the other, with a bisection fine enough to creep up to the very edge: what counted as rest was
/// motion enough to slacken a cable there.
#[test]
fn no_slack_at_the_edge_with_a_fine_bisection() {
    for (lambda, eta, z, steps) in [(6.9, 7.29, 1.767, 20), (3.0, 3.0, 1.0, 52), (7.8, 7.8, 1.9, 16)] {
        let parameters = ControllerParameters { lambda, eta, bisection_steps: steps, ..Default::default() };
        let rig = PlantParameters { initial_pose: Pose::at(0.0, 0.0, z), ..Default::default() };
        let mut closed_loop = ClosedLoop::new(parameters, rig, Pose::at(-0.997, -0.071, z), 1e-3);
        for goal in [(-0.997, -0.071), (-0.827, 0.562), (0.211, -0.978), (0.5, 0.5)] {
            closed_loop.goal = Pose::at(goal.0, goal.1, z);
            assert!(run(&mut closed_loop, 20.0) > 0.0);
            assert_eq!(closed_loop.controller.outputs().status, Status::GoalUnreachable);
        }
    }
}

#[test]
fn a_platform_too_heavy_for_max_tension_is_not_reported_at_its_goal() {
    let robot = RobotParameters { m: 70.0, ..Default::default() };
    let rig = Rig::paper(&robot, TensionLimits { min: 0.0, max: 100.0 });
    let parameters = ControllerParameters { rig, ..Default::default() };
    let rig = PlantParameters { rig, ..Default::default() };
    let mut closed_loop = ClosedLoop::new(parameters, rig, Pose::default(), 1e-3);
    closed_loop.advance();
    let output = closed_loop.controller.outputs();
    assert_eq!((output.status, output.at_goal), (Status::GoalUnreachable, false));
}

#[test]
fn set_points_keep_the_tensions_that_the_drives_allow() {
    for planner in [PlannerKind::Bounded, PlannerKind::Exact] {
        for (min, max) in [(4.0, 100.0), (0.0, 18.0)] {
            let mut parameters = ControllerParameters { planner, ..Default::default() };
            parameters.rig = parameters.rig.with_limits(TensionLimits { min, max });
            let rig = PlantParameters::default();
            let mut closed_loop = ClosedLoop::new(parameters, rig, Pose::at(0.15, 0.15, 1.0), 1e-3);
            let mut tensions = vec![];
            for _ in 0..12_000 {
                tensions.extend(closed_loop.advance().0.motor_tension);
            }
            // Nothing is clipped: the limits are never met, only neared.
            assert!(tensions.iter().all(|u| *u > min && *u < max), "{planner:?}");
            let output = closed_loop.controller.outputs();
            assert_eq!(output.status, Status::GoalUnreachable);
            assert!(output.set_point.0[0] > 0.03, "{:?}", output.set_point);
        }
    }
}

/// Many scripts end the initialisation first and hand over the measured pose with the first step only.
#[test]
fn the_pose_of_the_first_step_is_where_the_robot_starts() {
    let rig = PlantParameters { initial_pose: Pose::at(0.1, 0.0, 1.5), ..Default::default() };
    let mut closed_loop =
        ClosedLoop::new(ControllerParameters::default(), rig, Pose::at(0.1, 0.0, 1.5), 1e-3);
    let unknown = crate::common::inputs(closed_loop.plant.outputs(), closed_loop.goal, true);
    let start = ControllerInputs { encoder_pose: Pose::default(), ..unknown };
    closed_loop.controller = Controller::new(ControllerParameters::default(), 0.0, &start).unwrap();
    let (output, _) = closed_loop.advance();
    assert_eq!(output.status, Status::AtGoal);
    assert_eq!(output.set_point, closed_loop.goal);
}

#[test]
fn at_goal_does_not_flicker_with_coarse_encoders() {
    let rig = PlantParameters { encoder_resolution: 1e-4, ..Default::default() };
    let mut closed_loop =
        ClosedLoop::new(ControllerParameters::default(), rig, Pose::at(0.1, 0.0, 1.0), 1e-3);
    while !closed_loop.controller.outputs().at_goal {
        assert!(closed_loop.time() < 20.0);
        closed_loop.advance();
    }
    for _ in 0..5000 {
        assert!(closed_loop.advance().0.at_goal, "at {}", closed_loop.time());
    }
}

/// The tensions of the nonsense pose were held.
#[test]
fn a_first_pose_that_cannot_be_holds_gravity_where_the_robot_was_said_to_be() {
    for wrong in [Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 1.5, 0.0)), Pose::at(0.0, 0.0, -1.0)] {
        let hanging = Plant::new(PlantParameters::default(), &PlantInputs::none(6)).unwrap();
        let good = inputs(hanging.outputs(), Pose::default(), true);
        let mut controller = Controller::new(ControllerParameters::default(), 0.0, &good).unwrap();
        controller.step(0.0, 1e-3, &ControllerInputs { encoder_pose: wrong, ..good });
        let output = controller.outputs();
        assert_eq!(output.status, Status::WaitingForPose);
        assert!(output.motor_tension.iter().all(|u| (u - 10.7612).abs() < 1e-3), "{output:?}");
    }
}

/// Masters with unit delays hand over zeros first: that latched a fault for ever, and nothing said why.
#[test]
fn first_poses_of_zeros_are_waited_out() {
    let paper = ControllerParameters::default();
    // Where the origin is a place like any other, zeros are a pose like any other.
    let mut floor = paper;
    floor.rig.cables.iter_mut().for_each(|cable| cable.anchor.z -= 1.0);
    let cases = [(paper, Pose::at(0.1, 0.0, 1.0)), (floor, Pose::at(0.1, 0.0, 0.0))];
    for ((parameters, at), unset) in
        cases.into_iter().flat_map(|case| (1..=5).map(move |unset| (case, unset)))
    {
        let plant = PlantParameters { rig: parameters.rig, initial_pose: at, ..Default::default() };
        let hanging = Plant::new(plant, &PlantInputs::none(6)).unwrap();
        let good = inputs(hanging.outputs(), at, true);
        let zeros = ControllerInputs { encoder_pose: Pose(Coordinates::zeros()), ..good };
        let mut controller = Controller::new(parameters, 0.0, &good).unwrap();
        let held = controller.outputs().motor_tension;
        for k in 0..unset {
            controller.step(f64::from(k) * 1e-3, 1e-3, &zeros);
            let output = controller.outputs();
            assert_eq!((output.status, output.fault.check), (Status::WaitingForPose, Check::NotSet));
            // Meanwhile gravity is held where the robot was said to be.
            assert!(output.motor_tension.iter().zip(&held).all(|(now, then)| (now - then).abs() < 1e-9));
        }
        controller.step(f64::from(unset) * 1e-3, 1e-3, &good);
        let output = controller.outputs();
        assert!(!matches!(output.status, Status::SensorFault | Status::WaitingForPose), "{output:?}");
        assert_eq!((output.fault, output.set_point), (Fault::NONE, at));
        assert!(output.motor_tension.iter().zip(&held).all(|(now, then)| (now - then).abs() < 1e-9));
    }
}

/// Where the origin is the robot's own place, it starts there a few steps later.
#[test]
fn a_robot_that_is_at_the_origin_starts_there() {
    let mut parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
    parameters.rig.cables.iter_mut().for_each(|cable| cable.anchor.z -= 1.0);
    let home = Pose(Coordinates::zeros());
    let plant = PlantParameters { rig: parameters.rig, initial_pose: home, ..Default::default() };
    let hanging = Plant::new(plant, &PlantInputs::none(6)).unwrap();
    let seen = inputs(hanging.outputs(), home, true);
    let mut controller = Controller::new(parameters, 0.0, &seen).unwrap();
    for k in 0..20 {
        controller.step(f64::from(k) * 1e-3, 1e-3, &seen);
        let expected = if k < 5 { Status::WaitingForPose } else { Status::AtGoal };
        assert_eq!(controller.outputs().status, expected, "{k}");
        assert!(controller.outputs().motor_tension.iter().all(|u| (u - 10.7612).abs() < 1e-3));
    }
}

#[test]
fn a_fault_says_which_check_and_what_value_and_ends_with_it() {
    let mut closed_loop = to(Pose::at(0.0, 0.0, 1.0));
    run(&mut closed_loop, 0.2);
    let good = inputs(closed_loop.plant.outputs(), closed_loop.goal, true);
    assert_eq!(closed_loop.controller.outputs().fault, Fault::NONE);
    closed_loop.controller.step(
        0.2,
        1e-3,
        &ControllerInputs { encoder_pose: Pose::at(0.3, 0.0, 1.0), ..good },
    );
    let fault = closed_loop.controller.outputs().fault;
    assert_eq!(fault.check, Check::PositionJump);
    assert!((fault.value - 0.3).abs() < 1e-6 && (fault.limit - 0.052).abs() < 1e-9, "{fault:?}");
    closed_loop.controller.step(0.201, 1e-3, &good);
    assert_eq!(closed_loop.controller.outputs().fault, fault, "the first one stays");
    closed_loop.controller.step(0.202, 1e-3, &ControllerInputs { enable: false, ..good });
    assert_eq!(closed_loop.controller.outputs().fault, Fault::NONE);
}

/// Each jitter was a new goal with a new set point, and the robot never at it.
#[test]
fn a_goal_that_jitters_is_reached_all_the_same() {
    for planner in [PlannerKind::Bounded, PlannerKind::Exact] {
        let parameters = ControllerParameters { planner, ..Default::default() };
        let goal = Pose::at(0.1, 0.05, 1.0);
        let mut run = ClosedLoop::new(parameters, PlantParameters::default(), goal, 1e-3);
        for k in 0..9000 {
            run.goal.0[0] = goal.0[0] + if k % 2 == 0 { 1e-6 } else { -1e-6 };
            let (output, _) = run.advance();
            assert!(k < 8000 || (output.at_goal && output.steady), "{planner:?}: {output:?}");
        }
        assert!(run.controller.outputs().set_point_index < 6);
    }
}

/// What counts as rest was kept from the border, 14 mm at these gains, though the motion that it leaves dies away.
#[test]
fn high_gains_do_not_keep_the_papers_planner_from_the_border() {
    let parameters = ControllerParameters { lambda: 8.0, eta: 8.0, ..Default::default() };
    let mut run = ClosedLoop::new(parameters, PlantParameters::default(), Pose::at(0.0, 0.213, 1.0), 1e-3);
    while !run.controller.outputs().at_goal {
        assert!(run.advance().1.slack == [false; 6] && run.time() < 60.0, "{:?}", run.controller.outputs());
    }
    assert_eq!(run.controller.outputs().set_point_index, 21);
}

/// The exact domain's condition for the upper limit is far too cautious near the base; the planner refused what no limit forbids.
#[test]
fn the_papers_planner_moves_near_the_base() {
    let rig = PlantParameters { initial_pose: Pose::at(0.0, 0.0, 0.1), ..Default::default() };
    let mut run = ClosedLoop::new(ControllerParameters::default(), rig, Pose::at(0.05, 0.05, 0.1), 1e-3);
    while !run.controller.outputs().at_goal {
        let (output, plant) = run.advance();
        assert!(plant.slack == [false; 6] && output.motor_tension.iter().all(|u| *u < 100.0));
        assert!(run.time() < 20.0, "{output:?}");
    }
}
