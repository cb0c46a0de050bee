//! Commands that are held and handed on late: inputs at which cables went slack, with the law evaluated for the interval in which its
//! command acts.

use cable_robot::control::{Gains, Response};
use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use nalgebra::{Matrix2, Vector2};

/// A perfect plant, starting at rest at (0, 0, 1).
struct Case {
    gain: f64,
    /// s.
    step: f64,
    /// Whether the plant gets the tensions a step late (Jacobi order).
    is_late: bool,
    /// From when on (s).
    goals: &'static [(f64, [f64; 6])],
}

/// For how long a cable was slack in `duration` s, and the greatest angle of the platform, rad.
/// Without compensation there is no observer either: it would take the worst of the lag for a disturbance and make up for it.
fn slack(case: &Case, hold_compensation: bool, duration: f64) -> (f64, f64) {
    let &Case { gain, step, is_late, goals } = case;
    let start = PlantParameters::default();
    let command_delay = if is_late { step } else { 0.0 };
    let parameters = ControllerParameters {
        planner: PlannerKind::Exact,
        lambda: gain,
        eta: gain,
        hold_compensation,
        command_delay,
        observer_bound: if hold_compensation { 0.1 } else { 0.0 },
        ..Default::default()
    };
    let mut run = ClosedLoop::new(parameters, start, start.initial_pose).unwrap();
    run.is_late = is_late;
    let (mut slack, mut turned) = (0.0, 0.0f64);
    for _ in 0..(duration / step) as u32 {
        let time = run.moment().time;
        let given = goals.iter().rfind(|(from, _)| *from <= time + 1e-9);
        run.goal = given.map_or(start.initial_pose, |(_, goal)| Pose(Coordinates::from(*goal)));
        let Ok(moment) = run.step(step) else { return (f64::INFINITY, turned) };
        slack += step * f64::from(moment.plant.slack != [false; 6]);
        turned = turned.max(moment.plant.encoder_pose.angles().amax());
    }
    (slack, turned)
}

/// In Jacobi order the observer was told an acceleration before the plant got it, and the command acted a step late.
#[test]
fn a_master_that_hands_commands_on_late_slackens_no_cable() {
    let case = Case {
        gain: 10.0,
        step: 1e-3,
        is_late: true,
        goals: &[
            (0.1, [-0.0924, 0.1354, 0.5857, 0.0, 0.0, 0.0]),
            (0.25, [0.0687, -0.1811, 1.0526, 0.0, 0.0, 0.0]),
        ],
    };
    let (before, after) = (slack(&case, false, 2.0), slack(&case, true, 2.0));
    println!("slack for {:.3} s, compensated {:.3} s", before.0, after.0);
    assert!(before.0 > 0.01 && after.0 == 0.0, "{before:?} {after:?}");
}

/// A held torque error turns the platform; with slow gains, where the allowance is least, cables went slack and a robot was lost.
#[test]
fn turned_goals_at_slow_gains_slacken_no_cable() {
    let cases = [
        Case {
            gain: 1.5,
            step: 2e-3,
            is_late: false,
            goals: &[(0.0, [0.1379, -0.2354, 2.2404, -0.1762, 0.5602, -2.6846])],
        },
        Case {
            gain: 1.0,
            step: 1e-3,
            is_late: false,
            goals: &[(0.0, [0.1837, -0.1101, 0.7981, 0.5161, -0.1338, 1.7936])],
        },
    ];
    let mut slack_before = 0.0;
    for case in &cases {
        let (before, after) = (slack(case, false, 12.0), slack(case, true, 12.0));
        println!("gains {}: slack for {:.3} s, compensated {:.3} s", case.gain, before.0, after.0);
        assert!(after.0 == 0.0, "gains {}: {before:?} {after:?}", case.gain);
        slack_before += before.0;
    }
    assert!(slack_before > 0.1, "{slack_before}");
}

/// The jump of the pose was judged against the last one: at 7 m/s the watchdog called the controller's own motion a fault, and the robot was lost.
#[test]
fn a_fast_way_down_is_no_sensor_fault() {
    let case =
        Case { gain: 3.0, step: 1e-2, is_late: false, goals: &[(0.0, [0.0, 0.0, 10.0, 0.0, 0.0, 0.0])] };
    for hold_compensation in [false, true] {
        let (slack, turned) = slack(&case, hold_compensation, 6.0);
        assert!(
            slack == 0.0 && turned < 0.05,
            "compensated {hold_compensation}: slack for {slack} s, turned by {turned} rad"
        );
    }
}

/// The allowance counted the spread between the cables, not the change over time: the robot stopped 2.6 mm short of a goal at which it
/// can rest with 0.48 N.
#[test]
fn a_goal_that_leaves_half_a_newton_is_reached() {
    let goal = Pose::at(0.158, 0.158, 1.0);
    let parameters =
        ControllerParameters { planner: PlannerKind::Exact, lambda: 8.0, eta: 8.0, ..Default::default() };
    let mut run = ClosedLoop::new(parameters, PlantParameters::default(), goal).unwrap();
    for _ in 0..1000 {
        assert_eq!(run.step(4e-3).unwrap().plant.slack, [false; 6]);
    }
    assert_eq!(run.controller.outputs().status, Status::AtGoal);
}

/// With gains of 200 and steps of 20 ms the sampled loop has no stability left: the robot ended 7 m from its goal, and nothing had said so.
#[test]
fn a_step_too_long_for_the_gains_is_refused() {
    let lost =
        Case { gain: 200.0, step: 20e-3, is_late: false, goals: &[(0.5, [0.05, 0.05, 1.0, 0.0, 0.0, 0.0])] };
    assert_eq!(slack(&lost, true, 5.0).0, f64::INFINITY);
    let with = |largest_step, command_delay| ControllerParameters {
        planner: PlannerKind::Exact,
        lambda: 200.0,
        eta: 200.0,
        largest_step,
        command_delay,
        ..Default::default()
    };
    let refusal = |parameters: ControllerParameters| parameters.validate().unwrap_err().to_string();
    assert_eq!(
        with(0.0, 0.0).check_step(20e-3).unwrap_err().to_string(),
        "parameter step = 0.02 is not allowed: must be at most 2.500e-3 (s): with the planner Exact (lambda + eta) times step and commandDelay together is at \
         most 1, and no step longer than largestStep"
    );
    assert_eq!(with(0.0, 1e-3).check_step(1.5e-3), Ok(()));
    assert!(with(0.0, 1e-3).check_step(1.6e-3).is_err() && with(1e-3, 1e-3).check_step(1.1e-3).is_err());
    assert!(refusal(with(20e-3, 0.0)).contains("parameter largestStep = 0.02"));
    assert!(refusal(with(0.0, 20e-3)).contains("parameter commandDelay = 0.02"));
    assert_eq!(
        ControllerParameters { planner: PlannerKind::Bounded, ..with(0.0, 0.0) }.check_step(0.5),
        Ok(())
    );
}

/// For how long nothing may go wrong: at (λ + η) h = 1 the sampled loop of one coordinate dies away nearly as the closed form does, and from 4 on not at all.
#[test]
fn the_longest_step_is_a_quarter_of_what_the_sampled_loop_bears() {
    let decay = |product: f64| {
        // One step of 1 s with the acceleration of the closed form in its middle.
        let gains = Gains { lambda: 0.5 * product, eta: 0.5 * product };
        let column = |x: f64, v: f64| {
            let acceleration = Response::at(&gains, 0.5).motion(x, v, 0.0)[2];
            Vector2::new(x + v + 0.5 * acceleration, v + acceleration)
        };
        let step = Matrix2::from_columns(&[column(1.0, 0.0), column(0.0, 1.0)]);
        step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    };
    assert!((decay(1.0) - (-0.5f64).exp()).abs() < 0.02, "{}", decay(1.0));
    assert!((decay(4.0) - 1.0).abs() < 1e-9 && decay(3.9) < 1.0 && decay(4.1) > 1.0);
}
