//! Gains, limits and tolerances changed while the controller runs.

use cable_robot::plan::{ControllerParameters, Pending, PlannerKind, Status, Tuning};
use cable_robot::robot::{Pose, TensionLimits};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::common::random_goal;

const STEP: f64 = 1e-3;

fn started(goal: Pose) -> ClosedLoop {
    let parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
    ClosedLoop::new(parameters, PlantParameters::default(), goal).unwrap()
}

fn with_gains(run: &ClosedLoop, gain: f64) -> Tuning {
    Tuning { lambda: gain, eta: gain, ..run.controller.tuning() }
}

/// Runs for some steps; no cable may be slack.
fn go_on(run: &mut ClosedLoop, steps: u32) {
    for _ in 0..steps {
        let moment = run.step(STEP).unwrap();
        assert_eq!(moment.plant.slack, [false; 6], "at {} s", moment.time);
    }
}

#[test]
fn at_rest_changed_gains_act_from_the_next_decision_on() {
    let mut run = started(Pose::default());
    go_on(&mut run, 120);
    run.controller.tune(&with_gains(&run, 8.0)).unwrap();
    assert_eq!(run.controller.outputs().pending, Pending::Undecided);
    go_on(&mut run, 50);
    assert_eq!((run.controller.outputs().pending, run.controller.parameters().lambda), (Pending::No, 8.0));
    // As fast as a controller that was started with them.
    run.goal = Pose::at(0.1, 0.0, 1.0);
    let given = run.moment().time;
    while run.controller.outputs().status != Status::AtGoal {
        go_on(&mut run, 1);
        assert!(run.moment().time < given + 2.0);
    }
}

/// A greatest tension that the motion under way does not keep when it brakes: it ends first.
#[test]
fn a_limit_that_the_motion_does_not_keep_waits_until_it_does() {
    let mut run = started(Pose::at(0.0, 0.0, 2.0));
    go_on(&mut run, 60);
    let limits = run.controller.tuning().limits.map(|limits| TensionLimits { max: 10.9, ..limits });
    let wanted = Tuning { limits, ..run.controller.tuning() };
    run.controller.tune(&wanted).unwrap();
    go_on(&mut run, 100);
    assert_eq!(run.controller.outputs().pending, Pending::NotProved);
    assert_eq!(run.controller.tuning(), wanted);
    assert_eq!(run.controller.parameters().rig.cables[0].limits.max, 100.0);
    let mut kept = false;
    for _ in 0..8000 {
        go_on(&mut run, 1);
        let outputs = run.controller.outputs();
        let greatest = outputs.motor_tension.iter().copied().fold(0.0, f64::max);
        kept |= outputs.pending == Pending::No;
        assert!(!kept || greatest < 10.9, "{greatest} N at {} s", run.moment().time);
    }
    assert!(kept);
}

#[test]
fn gains_changed_at_any_time_slacken_no_cable() {
    let mut rng = Pcg64::seed_from_u64(77);
    let (mut taken, mut waited) = (0, 0);
    for _ in 0..25 {
        let mut run = started(random_goal(&mut rng, 1.0, 0.01));
        for _ in 0..12 {
            run.controller.tune(&with_gains(&run, rng.random_range(1.0..12.0))).unwrap();
            for _ in 0..rng.random_range(20..400) {
                go_on(&mut run, 1);
                waited += u32::from(run.controller.outputs().pending == Pending::NotProved);
            }
            taken += u32::from(run.controller.outputs().pending == Pending::No);
            run.goal = random_goal(&mut rng, 1.0, 0.01);
        }
    }
    println!("{taken} of 300 tunings act at their end, {waited} steps waited");
    assert!(taken > 200 && waited > 0);
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let mut run = started(Pose::at(0.1, 0.0, 1.0));
    go_on(&mut run, 70);
    let (before, running) = (run.controller.tuning(), run.controller.clone());
    let refused = run.controller.tune(&with_gains(&run, -1.0)).unwrap_err().to_string();
    assert!(refused.contains("parameter lambda = -1"), "{refused}");
    assert_eq!(run.controller, running);
    // The same once more changes nothing either.
    run.controller.tune(&before).unwrap();
    assert_eq!(run.controller, running);
}

#[test]
fn while_disabled_what_is_tuned_acts_with_the_next_step() {
    let mut run = started(Pose::default());
    run.enable = false;
    go_on_slack(&mut run, 3);
    run.controller.tune(&with_gains(&run, 5.0)).unwrap();
    go_on_slack(&mut run, 1);
    assert_eq!((run.controller.outputs().pending, run.controller.parameters().eta), (Pending::No, 5.0));
}

/// Disabled motors hold nothing.
fn go_on_slack(run: &mut ClosedLoop, steps: u32) {
    for _ in 0..steps {
        run.step(STEP).unwrap();
    }
}
