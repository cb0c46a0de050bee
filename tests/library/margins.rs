//! Anchors and attachments that are not where the rig file says, within its `accuracy`: the robot goes where it can rest with the margin,
//! and no cable goes slack.

use cable_robot::control::{Sensitivity, static_margin};
use cable_robot::plan::{Controller, ControllerInputs, ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::reach::certificate::{Step, Verdict, certify};
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn parameters(inertia: [f64; 3], accuracy: f64, gain: f64) -> ControllerParameters {
    let [i1, i2, i3] = inertia;
    let robot = RobotParameters { i1, i2, i3, ..RobotParameters::default() };
    let mut rig = Rig::paper(&robot, TensionLimits { min: 0.0, max: 100.0 });
    rig.accuracy = accuracy;
    ControllerParameters {
        planner: PlannerKind::Exact,
        lambda: gain,
        eta: gain,
        hold_compensation: true,
        ..ControllerParameters::of(&rig)
    }
}

/// The rig with both ends of each cable anywhere within `by` m.
fn off(rng: &mut Pcg64, rig: &Rig, by: f64) -> Rig {
    let mut off = *rig;
    for cable in off.cables.iter_mut() {
        for end in [&mut cable.anchor, &mut cable.attachment] {
            let way = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64));
            *end += way.normalize() * (by * rng.random_range(0.0..1.0f64).cbrt());
        }
    }
    off
}

fn inputs(pose: Pose) -> ControllerInputs {
    let none = PerCable::filled(6, 0.0);
    ControllerInputs {
        encoder_pose: pose,
        cable_length: none,
        measured_tension: none,
        goal_pose: pose,
        enable: true,
    }
}

struct Outcome {
    slack: bool,
    reached: bool,
    smallest: f64,
    turned: f64,
}

/// Twelve seconds to a goal from rest at (0, 0, 1), at least one and a half.
fn run(parameters: &ControllerParameters, truth: Rig, goal: Pose) -> Outcome {
    let step = 1e-3;
    let plant_parameters = PlantParameters { rig: truth, ..PlantParameters::default() };
    let mut run = ClosedLoop::new(*parameters, plant_parameters, goal).unwrap();
    let mut outcome = Outcome { slack: false, reached: false, smallest: f64::INFINITY, turned: 0.0 };
    for k in 0..12_000 {
        let Ok(moment) = run.step(step) else {
            outcome.slack = true;
            break;
        };
        outcome.slack |= moment.plant.slack != [false; 6];
        outcome.smallest = moment.controller.motor_tension.iter().copied().fold(outcome.smallest, f64::min);
        outcome.turned = outcome.turned.max(moment.plant.encoder_pose.angles().amax());
        if moment.controller.status == Status::AtGoal && k > 1500 {
            outcome.reached = true;
            break;
        }
    }
    outcome
}

/// The rig with the ends of the cables off by `by` m so that they turn the platform about an axis of the base as much as they can.
fn turning(rig: &Rig, axis: Vector3<f64>, by: f64) -> Rig {
    let cables = rig.cables_at(&Pose::default());
    let mut off = *rig;
    for (j, cable) in off.cables.iter_mut().enumerate() {
        let (arm, direction) = (cables.arm[j], cables.direction[j]);
        // u (a × ε)·n = u ε·(n × a), with ε across d; u (α × d)·n = u α·(d × n).
        let across = axis.cross(&arm);
        let across = across - direction * across.dot(&direction);
        let (bent, moved) = (across / cables.free[j], direction.cross(&axis));
        cable.anchor += bent.try_normalize(1e-9).unwrap_or_default() * by;
        cable.attachment += (moved - bent).try_normalize(1e-9).unwrap_or_default() * by;
    }
    off
}

#[derive(Clone, Copy)]
enum Goals {
    /// Where the platform can rest with what the accuracy costs there and a quarter of a newton more.
    Restable,
    /// Where it cannot rest: the robot goes to the border.
    Outside,
}

/// Random rigs within `accuracy` of the one believed, whose controller is told `told`.
fn campaign(seed: u64, count: u32, inertia: [f64; 3], accuracy: f64, told: f64, goals: Goals) -> Found {
    let (drawn, told) = (parameters(inertia, accuracy, 5.0).rig, parameters(inertia, told, 5.0));
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut found = Found { slack: 0, reached: 0, smallest: f64::INFINITY };
    for _ in 0..count {
        let goal = loop {
            let wide = Coordinates::new(0.3, 0.3, 0.3, 0.2, 0.2, 0.6);
            let goal = Pose(Pose::default().0 + wide.map(|most| rng.random_range(-most..most)));
            let margin = static_margin(&drawn, &goal);
            let is_wanted = match goals {
                Goals::Restable => Sensitivity::new(&drawn, &goal)
                    .is_some_and(|sensitivity| margin > sensitivity.geometry(accuracy) + 0.25),
                Goals::Outside => margin < -0.5,
            };
            if is_wanted {
                break goal;
            }
        };
        let outcome = run(&told, off(&mut rng, &drawn, accuracy), goal);
        found.slack += u32::from(outcome.slack);
        found.reached += u32::from(outcome.reached);
        found.smallest = found.smallest.min(outcome.smallest);
    }
    println!(
        "off by up to {accuracy} m, told {} m: {count} runs, {} slack, {} reached, smallest tension {:.3} N",
        told.rig.accuracy, found.slack, found.reached, found.smallest
    );
    found
}

struct Found {
    slack: u32,
    reached: u32,
    smallest: f64,
}

const DISC: [f64; 3] = [0.125, 0.125, 0.25];
const TABLE_I: [f64; 3] = [0.018, 0.018, 0.075];

#[test]
fn no_cable_goes_slack_while_the_geometry_is_off_by_a_millimetre() {
    for (seed, count, inertia) in [(1, 1000, DISC), (2, 200, TABLE_I)] {
        let found = campaign(seed, count, inertia, 1e-3, 1e-3, Goals::Restable);
        assert!(
            found.slack == 0 && found.reached * 10 >= count * 9,
            "{} slack, {} reached",
            found.slack,
            found.reached
        );
    }
}

/// At the border of the workspace, where the robot goes for a goal beyond, it is the margin that keeps the cables taut.
#[test]
fn at_the_border_cables_go_slack_without_the_margin() {
    let at_border = |told| campaign(3, 100, DISC, 5e-3, told, Goals::Outside);
    let (with, without) = (at_border(5e-3), at_border(0.0));
    assert!(with.slack == 0 && without.slack > 0, "{} slack, without {}", with.slack, without.slack);
}

/// The largest accuracy that is borne at the start, m.
fn largest_borne(mut parameters: ControllerParameters) -> f64 {
    parameters.rig.accuracy = 1.0;
    let refused = Controller::new(parameters, 0.0, &inputs(Pose::default())).unwrap_err().to_string();
    let (_, rest) = refused.split_once("at most ").unwrap();
    rest.split_once(" can").unwrap().0.parse().unwrap()
}

#[test]
fn at_the_start_the_worst_geometry_that_is_borne_slackens_no_cable() {
    for (inertia, gain) in [(DISC, 5.0), (TABLE_I, 3.0), (TABLE_I, 5.0)] {
        let mut parameters = parameters(inertia, 0.0, gain);
        let borne = largest_borne(parameters);
        parameters.rig.accuracy = 0.99 * borne;
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        for axis in axes.into_iter().chain(axes.map(|axis| -axis)) {
            let outcome = run(&parameters, turning(&parameters.rig, axis, borne), Pose::default());
            println!(
                "{borne} m at gains {gain}: {:.3} N, turned by {:.3} rad",
                outcome.smallest, outcome.turned
            );
            assert!(!outcome.slack && outcome.turned > 0.01);
        }
    }
}

/// Without observer a torque turns the platform for good: five millimetres are too many for Table I's inertia.
#[test]
fn what_cannot_be_borne_is_refused_with_what_can() {
    let mut parameters = parameters(TABLE_I, 5e-3, 3.0);
    assert!(Controller::new(parameters, 0.0, &inputs(Pose::default())).is_ok());
    parameters.observer_bound = 0.0;
    let refused = Controller::new(parameters, 0.0, &inputs(Pose::default())).unwrap_err().to_string();
    assert!(refused.contains("parameter accuracy = 0.005"), "{refused}");
    let borne = largest_borne(parameters);
    println!("without observer {borne} m are borne");
    assert!(borne > 1e-3 && borne < 5e-3, "{borne}");
}

/// One step between random points at z = 1 that leaves 0.7 N without margins, gains 5: how many are left with 1 % of the mass, 1 mm of the geometry
/// and encoders of 0.05 mm unknown.
#[test]
fn most_steps_are_left_with_everything_unknown_at_once() {
    let certain = parameters(DISC, 0.0, 5.0);
    let uncertain = ControllerParameters {
        mass_tolerance: 0.01,
        encoder_resolution: 5e-5,
        ..parameters(DISC, 1e-3, 5.0)
    };
    let planner = Planner::from(uncertain);
    let limits = certain.rig.limits().map(|limits| limits.shrunk(0.7));
    let mut rng = Pcg64::seed_from_u64(4);
    let mut point = || loop {
        let place = Pose::at(rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3), 1.0);
        if static_margin(&certain.rig, &place) > 0.0 {
            return place;
        }
    };
    let (mut steps, mut left) = (0, 0);
    while steps < 500 {
        let (start, set_point) = (point(), point());
        let step = Step { start, rates: Coordinates::zeros(), set_point, gains: certain.gains() };
        let rig = certain.rig;
        let rig = rig.with_limits(limits[0]);
        if matches!(certify(&rig, &step), Ok(Verdict::Admissible { .. })) {
            steps += 1;
            left += u32::from(planner.next_from_rest(&start, &set_point) == Some(set_point));
        }
    }
    println!("{left} of {steps} steps are left");
    assert!(left * 10 >= steps * 8, "{left} of {steps}");
}
