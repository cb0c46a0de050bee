//! What the planner `Exact` leaves unused for what is not in its proof: commands that are held, masters that hand them on late, encoders.

use crate::common::random_goal;
use crate::common::{ClosedLoop, inputs};
use cable_robot::control::Response;
use cable_robot::plan::{Controller, ControllerParameters, PlannerKind, Status};
use cable_robot::reach::certificate::{Margins, Step, certify_with_margins};
use cable_robot::reach::{Verdict, certify};
use cable_robot::robot::{Coordinates, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn exact(gain: f64) -> ControllerParameters {
    ControllerParameters { planner: PlannerKind::Exact, lambda: gain, eta: gain, ..Default::default() }
}

/// Who is stepped first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Controller,
    /// Both with what the other said a step before (Jacobi).
    Both,
}

/// Smallest tension that is commanded in twelve runs with four goals each, at heights that change much; 0 for a slack cable. And how many
/// goals were reached in three seconds.
fn smallest_held(gain: f64, step: f64, order: Order) -> (f64, u32) {
    let mut rng = Pcg64::seed_from_u64(7);
    let (mut smallest, mut reached) = (f64::INFINITY, 0);
    for _ in 0..12 {
        let z = rng.random_range(0.5..1.5);
        let mut goal = || {
            let mut goal = random_goal(&mut rng, z, 0.005);
            goal.0[2] = z * rng.random_range(0.6..1.5);
            goal
        };
        let rig = PlantParameters { initial_pose: goal(), ..Default::default() };
        let hanging = Plant::new(rig, &PlantInputs::none(6)).unwrap();
        let seen = inputs(hanging.outputs(), rig.initial_pose, true);
        let mut controller = Controller::new(exact(gain), 0.0, &seen).unwrap();
        let mut pull =
            PlantInputs { motor_tension: controller.outputs().motor_tension, ..PlantInputs::none(6) };
        let mut plant = Plant::new(rig, &pull).unwrap();
        let mut count = 0;
        for _ in 0..4 {
            let goal = goal();
            for _ in 0..(3.0 / step) as u32 {
                let late = controller.outputs().motor_tension;
                controller.step(f64::from(count) * step, step, &inputs(plant.outputs(), goal, true));
                let now = controller.outputs().motor_tension;
                pull.motor_tension = if order == Order::Both { late } else { now };
                plant.step(&pull, step).unwrap();
                count += 1;
                let least = now.iter().copied().fold(f64::INFINITY, f64::min);
                smallest = smallest.min(least);
                let margin = controller.outputs().tension_margin;
                assert!(
                    order == Order::Both || margin <= least + 1e-9,
                    "tensionMargin {margin}, then {least} N"
                );
                if plant.outputs().slack != [false; 6] {
                    smallest = 0.0;
                }
                if controller.outputs().at_goal {
                    break;
                }
            }
            reached += u32::from(controller.outputs().status == Status::AtGoal);
        }
    }
    (smallest, reached)
}

/// An allowance that knew the weight but not how far the tensions swing let cables go slack at gains of 13 and more, and at 8 with a master
/// that hands the commands on a step late.
#[test]
fn no_cable_goes_slack_at_high_gains_or_with_a_late_master() {
    for (order, most) in [(Order::Controller, 0.064), (Order::Both, 0.026)] {
        for (gain, step) in [
            (3.0, 1e-3),
            (3.0, 4e-3),
            (5.0, 1e-3),
            (8.0, 1e-3),
            (8.0, 4e-3),
            (13.0, 1e-3),
            (15.0, 1e-3),
            (20.0, 1e-3),
        ] {
            if 2.0 * gain * step > most {
                continue;
            }
            let (smallest, reached) = smallest_held(gain, step, order);
            println!("{order:?} first, gains {gain}, step {step} s: {smallest:.3} N, {reached} of 48 goals");
            assert!(smallest > 0.03, "{order:?} first, gains {gain}, step {step} s: {smallest} N");
        }
    }
}

/// Smallest tension on the way from rest at `start` to `goal`, given from the first step on; 0 for a slack cable. Steps of `step` s, but for
/// those that `short` picks, which are of 0.1 ms.
fn smallest_from_rest(
    controller: ControllerParameters,
    step: f64,
    start: Pose,
    goal: Pose,
    short: impl Fn(u32) -> bool,
) -> f64 {
    let parameters = PlantParameters { initial_pose: start, ..Default::default() };
    let hanging = Plant::new(parameters, &PlantInputs::none(6)).unwrap();
    let mut controller = Controller::new(controller, 0.0, &inputs(hanging.outputs(), goal, true)).unwrap();
    let mut pull = PlantInputs { motor_tension: controller.outputs().motor_tension, ..PlantInputs::none(6) };
    let mut plant = Plant::new(parameters, &pull).unwrap();
    let (mut time, mut smallest) = (0.0, f64::INFINITY);
    for k in 0.. {
        if time > 3.0 {
            break;
        }
        let h = if short(k) { 1e-4 } else { step };
        controller.step(time, h, &inputs(plant.outputs(), goal, true));
        pull.motor_tension = controller.outputs().motor_tension;
        plant.step(&pull, h).unwrap();
        time += h;
        let slack = plant.outputs().slack != [false; 6];
        smallest = pull.motor_tension.iter().copied().fold(smallest, f64::min) * f64::from(!slack);
    }
    smallest
}

/// What holding costs was taken from the step before, which the first one has not: two cables went slack at 0.208 and 0.124 s.
#[test]
fn a_goal_given_with_the_first_step_slackens_no_cable() {
    let cases = [
        (8.0, 4e-3, [-0.1783, 0.0549, 0.8911], [-0.0503, 0.0234, 0.5972]),
        (15.0, 2e-3, [-0.0269, 0.2041, 1.0691], [-0.0711, 0.2115, 0.3977]),
    ];
    for (gain, step, [x, y, z], goal) in cases {
        let (start, goal) = (Pose::at(x, y, z), Pose::at(goal[0], goal[1], goal[2]));
        // The planner's ticks are 50 ms apart: 13 steps of 4 ms, 25 of 2 ms.
        let ways: [(&str, &dyn Fn(u32) -> bool); 3] = [
            ("equal steps", &|_| false),
            ("a short step before a tick", &|k| k % 13 == 12 || k % 25 == 24),
            ("a short step at a tick", &|k| k > 0 && k % 13 == 0),
        ];
        for (name, short) in ways {
            let smallest = smallest_from_rest(exact(gain), step, start, goal, short);
            println!("gains {gain}, {step} s, {name}: {smallest:.3} N");
            assert!(smallest > 0.1, "gains {gain}, {step} s, {name}: {smallest} N");
        }
    }
}

/// The longer of the last two steps says nothing of the next one where two short ones come before each long one.
#[test]
fn a_long_step_after_short_ones_costs_nothing_if_the_longest_is_known() {
    let (start, goal) = (Pose::at(-0.1783, 0.0549, 0.8911), Pose::at(-0.0503, 0.0234, 0.5972));
    let [known, unknown] = [0.02, 0.0].map(|largest_step| {
        let parameters = ControllerParameters { largest_step, ..exact(8.0) };
        smallest_from_rest(parameters, 0.02, start, goal, |k| k % 3 < 2)
    });
    println!("smallest tension {known:.3} N, without largestStep {unknown:.3} N");
    assert!(known > 0.1 && unknown < 0.5 * known, "{known} N, {unknown} N");
}

/// The greatest distance (m) of the platform from the closed form (12), (13) on the way from rest to a goal that takes one step.
fn off_the_closed_form(gain: f64, step: f64, order: Order, hold_compensation: bool) -> f64 {
    let (start, goal) = (Pose::at(-0.1, 0.05, 0.9), Pose::at(0.0, 0.02, 0.7));
    let plant_parameters = PlantParameters { initial_pose: start, ..Default::default() };
    let command_delay = if order == Order::Both { step } else { 0.0 };
    let parameters = ControllerParameters { hold_compensation, command_delay, ..exact(gain) };
    let hanging = Plant::new(plant_parameters, &PlantInputs::none(6)).unwrap();
    let mut controller = Controller::new(parameters, 0.0, &inputs(hanging.outputs(), goal, true)).unwrap();
    let mut pull = PlantInputs { motor_tension: controller.outputs().motor_tension, ..PlantInputs::none(6) };
    let mut plant = Plant::new(plant_parameters, &pull).unwrap();
    let mut farthest = 0.0f64;
    for k in 0..(1.5 / step) as u32 {
        let time = f64::from(k) * step;
        let late = controller.outputs().motor_tension;
        controller.step(time, step, &inputs(plant.outputs(), goal, true));
        assert_eq!((controller.outputs().set_point, controller.outputs().set_point_index), (goal, 1));
        pull.motor_tension = if order == Order::Both { late } else { controller.outputs().motor_tension };
        plant.step(&pull, step).unwrap();
        // The motion begins when the first command acts.
        let since = (time + step - command_delay).max(0.0);
        let (closed, ..) =
            Response::at(&parameters.gains(), since).motion_of(&start, &Coordinates::zeros(), &goal);
        farthest = farthest.max((plant.outputs().encoder_pose.position() - closed.position()).norm());
    }
    farthest
}

/// Evaluated for the instant of the measurement the error falls with the step, evaluated for the interval in which it acts with its square,
/// also when the command is handed on a step late.
#[test]
fn a_law_evaluated_for_when_it_acts_errs_by_the_square_of_the_step() {
    for order in [Order::Controller, Order::Both] {
        let of = |step: f64, is_on: bool| off_the_closed_form(5.0, step, order, is_on);
        let [plain, fine] = [4e-3, 2e-3].map(|step| of(step, false));
        let [compensated, finer] = [4e-3, 2e-3].map(|step| of(step, true));
        println!(
            "{order:?} first: {plain:.2e} and {fine:.2e} m, compensated {compensated:.2e} and {finer:.2e} m"
        );
        assert!(plain / fine < 2.5 && compensated / finer > 3.0, "{plain} {fine} {compensated} {finer}");
        assert!(compensated < 0.05 * plain, "{compensated} {plain}");
    }
}

/// What holding the tensions costs grows with the mass; a margin that does not was used up.
#[test]
fn a_heavy_robot_with_high_gains_slackens_no_cable() {
    let mut rng = Pcg64::seed_from_u64(41);
    for case in 0..24 {
        let m = [12.0, 20.0, 50.0][case % 3];
        let scale = m / 6.0;
        let robot = RobotParameters {
            m,
            i1: 0.018 * scale,
            i2: 0.018 * scale,
            i3: 0.075 * scale,
            ..Default::default()
        };
        let gain = if case % 2 == 0 { 8.0 } else { 10.0 };
        let heavy = Rig::paper(&robot, TensionLimits { min: 0.0, max: 1000.0 });
        let parameters = ControllerParameters { rig: heavy, ..exact(gain) };
        let rig = PlantParameters { rig: heavy, initial_pose: Pose::at(0.0, 0.0, 2.0), ..Default::default() };
        let mut run = ClosedLoop::new(parameters, rig, Pose::at(0.15, 0.15, 1.0), 1e-3);
        for _ in 0..6 {
            for _ in 0..1500 {
                assert_eq!(
                    run.advance().1.slack,
                    [false; 6],
                    "m = {m}, gain {gain}, case {case}, at {}",
                    run.time()
                );
            }
            run.goal = random_goal(&mut rng, 1.2, 0.0);
        }
    }
}

/// What the planner's allowance stands for could be proved with the certificate's margins; docs/exact.md says why it is not.
#[test]
fn a_proof_for_held_commands_asks_for_far_more_than_the_allowance() {
    let gains = exact(3.0).gains();
    let share_proved = |tilt: f64, sample_period: f64| {
        let limits = TensionLimits { min: 0.1, max: 100.0 };
        let rig = Rig::paper(&RobotParameters::default(), limits);
        let mut rng = Pcg64::seed_from_u64(43);
        let (mut steps, mut proved) = (0, 0);
        while steps < 100 {
            let mut pose = || {
                let level = random_goal(&mut rng, 1.0, 0.02).0;
                let mut angle = || tilt * rng.random_range(-1.0..1.0);
                Pose(Coordinates::new(level[0], level[1], level[2], angle(), angle(), angle()))
            };
            let step = Step { start: pose(), rates: Coordinates::zeros(), set_point: pose(), gains };
            if !matches!(certify(&rig, &step), Ok(Verdict::Admissible { .. })) {
                continue;
            }
            let margins = Margins { sample_period, ..Margins::default() };
            steps += 1;
            proved += i32::from(matches!(
                certify_with_margins(&rig, &step, &margins),
                Ok(Verdict::Admissible { .. })
            ));
        }
        f64::from(proved) / f64::from(steps)
    };
    for tilt in [0.0, 0.2] {
        let (slow, fast) = (share_proved(tilt, 1e-3), share_proved(tilt, 1e-4));
        println!(
            "angles to {tilt}: of 100 admissible steps {:.0} % proved held for 1 ms, {:.0} % for 0.1 ms",
            100.0 * slow,
            100.0 * fast
        );
        assert!(slow < 0.7 && fast > 0.8);
    }
}

/// Smallest tension in twenty runs with changing goals, 0 for a slack cable, of a controller that is told the resolution of its encoders or not.
fn smallest_with_encoders(gain: f64, resolution: f64, is_told: bool) -> f64 {
    let mut rng = Pcg64::seed_from_u64(44);
    let mut smallest = f64::INFINITY;
    for _ in 0..20 {
        let z = rng.random_range(0.5..2.0);
        let initial_pose = Pose::at(0.0, 0.0, z);
        let rig = PlantParameters { encoder_resolution: resolution, initial_pose, ..Default::default() };
        let encoder_resolution = if is_told { resolution } else { 0.0 };
        let parameters = ControllerParameters { encoder_resolution, ..exact(gain) };
        let mut run = ClosedLoop::new(parameters, rig, initial_pose, 1e-3);
        for _ in 0..8 {
            run.goal = random_goal(&mut rng, z, 0.0);
            for _ in 0..400 {
                let (output, plant) = run.advance();
                smallest = output.motor_tension.iter().copied().fold(smallest, f64::min);
                if plant.slack != [false; 6] {
                    return 0.0;
                }
            }
        }
    }
    smallest
}

#[test]
fn what_coarse_encoders_leave_of_the_allowance() {
    for gain in [3.0, 8.0] {
        let [told, untold] = [true, false].map(|is_told| {
            let found = [0.0, 1e-5, 3e-5, 1e-4].map(|r| (r, smallest_with_encoders(gain, r, is_told)));
            let said = found.map(|(r, u)| format!("{u:.3} N with {r} m")).join(", ");
            println!("gains of {gain}, told {is_told}: {said}");
            found
        });
        assert!(told.iter().all(|(_, smallest)| *smallest > 0.0), "{told:?}");
        assert!(untold[1].1 > 0.0 && untold[3].1 == 0.0, "{untold:?}");
    }
}
