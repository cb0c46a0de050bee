//! `MinimumTime` in closed loop: as fast as planned, and taut, whatever goals come when.

use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::{Cable, Coordinates, Pose, RigFile, TensionLimits};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn parameters(planner: PlannerKind, gain: f64) -> ControllerParameters {
    ControllerParameters { planner, lambda: gain, eta: gain, ..Default::default() }
}

fn closed_loop(parameters: ControllerParameters, start: Pose) -> ClosedLoop {
    let plant = PlantParameters { rig: parameters.rig, initial_pose: start, ..Default::default() };
    ClosedLoop::new(parameters, plant, start).unwrap()
}

/// When the goal is given, s: at a decision of the planner.
const GIVEN: f64 = 0.1;

/// Seconds until the robot, from rest, stays within 2 % of the way to the goal, and until it counts as being there; at 1 kHz, gains of 3.
fn times_to_goal(planner: PlannerKind, goal: Pose) -> [f64; 2] {
    let start = Pose::default();
    let mut run = closed_loop(parameters(planner, 3.0), start);
    let way = goal.minus(&start).norm();
    let mut since = [f64::NAN; 2];
    // Until the controller knows that it started at rest.
    run.goal = start;
    while run.moment().time < GIVEN {
        run.step(1e-3).unwrap();
    }
    run.goal = goal;
    while run.moment().time < GIVEN + 10.0 {
        let moment = run.step(1e-3).unwrap();
        assert_eq!(moment.plant.slack, [false; 6]);
        let is_near = moment.plant.encoder_pose.minus(&goal).norm() <= 0.02 * way;
        for (since, is_so) in since.iter_mut().zip([is_near, moment.controller.at_goal]) {
            *since = if !is_so { f64::NAN } else { since.min(moment.time - GIVEN) };
        }
    }
    since
}

#[test]
fn the_papers_move_is_made_in_the_time_that_was_planned() {
    let goal = Pose::at(0.15, 0.15, 1.0);
    let [bounded, exact, fastest] = PlannerKind::ALL.map(|planner| times_to_goal(planner, goal));
    let planner = Planner::from(parameters(PlannerKind::MinimumTime, 3.0));
    let planned = planner.course_from_rest(&Pose::default(), &goal).unwrap().end();
    println!(
        "planned {planned:.4} s; within 2 %, and at the goal, s: {fastest:.3?}, Exact {exact:.3?}, Bounded {bounded:.3?}"
    );
    assert!(fastest[1] <= 1.02 * planned + 2e-3);
    assert!(exact[1] > 4.0 * fastest[1] && bounded[1] > 12.0 * fastest[1]);
    assert!(exact[0] > 3.7 * fastest[0] && bounded[0] > 12.0 * fastest[0]);
}

/// Higher up the pendulum is shorter: the platform may be quicker on a way that rises.
#[test]
fn a_platform_that_may_rise_is_there_a_tenth_sooner() {
    let limits = TensionLimits { min: 0.5, max: 40.0 };
    let (start, goal) = (Pose::default(), Pose::at(0.15, 0.15, 1.0));
    let time = |lift: f64| {
        let mut parameters = parameters(PlannerKind::MinimumTime, 3.0);
        parameters.rig = parameters.rig.with_limits(limits);
        parameters.lift = lift;
        let course = Planner::from(parameters).course_from_rest(&start, &goal).unwrap();
        let height = |k: i32| course.at(course.end() * f64::from(k) / 100.0).pose.0[2];
        let risen = (0..=100).map(height).fold(0.0, |risen: f64, z| risen.max(1.0 - z));
        assert!(risen <= lift + 1e-12 && risen >= 0.5 * lift, "{risen} {lift}");
        assert!(course.at(course.end()).pose.minus(&goal).amax() < 1e-12);
        course.end()
    };
    let [straight, low, high] = [0.0, 0.05, 0.2].map(time);
    println!("straight on {straight:.4} s, by at most 0.05 m up {low:.4} s, by at most 0.2 m {high:.4} s");
    assert!(low < 0.95 * straight && high < 0.91 * straight);
}

/// A pose about home, turned by up to `turn` (rad), at which the robot can rest.
fn inside(rng: &mut Pcg64, RigFile { rig, home, .. }: &RigFile, turn: f64) -> Pose {
    let size = rig.radius();
    let mut any =
        || Coordinates::from_fn(|k, _| rng.random_range(-1.0..1.0) * if k < 3 { 0.4 * size } else { turn });
    let poses = std::iter::repeat_with(|| Pose(home.0 + any()));
    let mut above = poses.filter(|pose| rig.can_be_at(pose));
    above.find(|pose| static_margin(rig, pose) > 0.005 * rig.weight()).unwrap()
}

/// Goals at random times, reached or not: the smallest tension commanded beyond the least, as a share of the weight, and how many goals were reached.
fn with_changing_goals(
    file: &RigFile,
    [turn, lift]: [f64; 2],
    (gain, step, is_late): (f64, f64, bool),
    runs: usize,
) -> (f64, usize) {
    let mut rng = Pcg64::seed_from_u64(8);
    let (mut least, mut reached) = (f64::INFINITY, 0);
    for _ in 0..runs {
        let parameters = ControllerParameters {
            planner: PlannerKind::MinimumTime,
            lambda: gain,
            eta: gain,
            command_delay: if is_late { step } else { 0.0 },
            lift,
            ..ControllerParameters::of(&file.rig)
        };
        let mut run = closed_loop(parameters, inside(&mut rng, file, turn));
        run.is_late = is_late;
        for _ in 0..8 {
            run.goal = inside(&mut rng, file, turn);
            let patience = if rng.random_range(0.0..1.0) < 0.6 { rng.random_range(0.05..0.6) } else { 3.0 };
            let begin = run.moment().time;
            let mut promised = 0.0f64;
            while run.moment().time < begin + patience {
                let moment = run.step(step).unwrap();
                assert!(moment.plant.slack.iter().all(|is_slack| !is_slack), "{parameters:?} {moment:?}");
                let commanded = moment.controller.motor_tension;
                let smallest = commanded.into_iter().fold(f64::INFINITY, f64::min);
                let over = |(u, cable): (&f64, &Cable)| cable.limits.margin(*u);
                least = commanded.iter().zip(&file.rig.cables).map(over).fold(least, f64::min);
                // From the decision that took up the goal on.
                let is_taken_up = moment.time > begin + parameters.planner_period + 2.0 * step;
                let is_so = !is_taken_up || smallest > promised - 1e-3 * file.rig.weight();
                assert!(is_so, "{smallest} {promised} {moment:?}");
                promised = if is_taken_up { promised.max(moment.controller.tension_margin) } else { 0.0 };
            }
            let is_there = run.moment().controller.status == Status::AtGoal;
            assert!(is_there || patience < 3.0, "{:?}", run.moment());
            reached += usize::from(is_there);
        }
    }
    (least / file.rig.weight(), reached)
}

#[test]
fn goals_that_change_on_the_way_slacken_no_cable() {
    let rigs = [
        (include_str!("../../rigs/paper.toml"), [0.0, 0.0], 6),
        (include_str!("../../rigs/paper.toml"), [0.3, 0.0], 6),
        (include_str!("../../rigs/paper.toml"), [0.2, 0.1], 4),
        (include_str!("../../rigs/eight.toml"), [0.2, 0.0], 2),
        (include_str!("../../rigs/public/cogiro.toml"), [0.1, 0.5], 1),
    ];
    let settings =
        [(3.0, 1e-3, false), (3.0, 4e-3, true), (8.0, 1e-3, true), (8.0, 4e-3, false), (3.0, 20e-3, false)];
    for (text, turn_and_lift, runs) in rigs {
        let file = RigFile::parse(text).unwrap();
        for setting in settings {
            let (least, reached) = with_changing_goals(&file, turn_and_lift, setting, runs);
            let goals = 8 * runs;
            println!(
                "{}, turns and lift {turn_and_lift:?}, {setting:?}: {:.2} % of the weight left, {reached} of {goals} goals reached",
                file.name,
                100.0 * least
            );
            assert!(least > 1e-3 && reached * 5 > goals);
        }
    }
}

/// The pose is lost on the way: the robot stops on the line that it is on, and hangs there.
#[test]
fn a_lost_pose_ends_in_a_stop_on_the_line() {
    for (gain, share, delay) in [(3.0, 0.2, 0.0), (3.0, 0.5, 1e-3), (8.0, 0.45, 0.0), (8.0, 0.8, 4e-3)] {
        let mut parameters = parameters(PlannerKind::MinimumTime, gain);
        parameters.command_delay = delay;
        let (start, goal) = (Pose::at(-0.1, -0.1, 0.9), Pose::at(0.12, 0.1, 1.1));
        let duration = Planner::from(parameters).course_from_rest(&start, &goal).unwrap().end();
        let mut run = closed_loop(parameters, start);
        run.is_late = delay > 0.0;
        run.goal = goal;
        let step = if delay > 0.0 { delay } else { 1e-3 };
        while run.moment().time < share * duration {
            run.step(step).unwrap();
        }
        let seen = run.moment().plant.encoder_pose;
        let end = run.moment().time + 1.0;
        while run.moment().time < end {
            let moment =
                run.step_seeing(step, |inputs| inputs.encoder_pose = Pose::at(0.0, 0.0, 9.0)).unwrap();
            assert_eq!(moment.plant.slack, [false; 6]);
        }
        let moment = run.moment();
        let (at, speed) = (moment.plant.encoder_pose, moment.plant.velocity.norm());
        let (way, gone) = (goal.position() - start.position(), at.position() - start.position());
        let aside = (gone - way * (gone.dot(&way) / way.norm_squared())).norm();
        println!("{gain} {share}: {speed:.4} m/s left, {:.1} mm aside", 1e3 * aside);
        assert_eq!(moment.controller.status, Status::SensorFault);
        assert!(speed < 1e-3 && aside < 1e-3 && at.minus(&seen).norm() < 0.25, "{moment:?}");
    }
}

/// Found by `study held --planner minimum-time --runs 10000 --seed 11`, run 3177. Commands that are held over a switch displace the platform, and low gains take that back slowly: the
/// displacement itself was not reckoned with.
#[test]
fn commands_held_long_over_a_switch_with_low_gains_slacken_no_cable() {
    let step = 0.015278289267636032;
    let parameters = ControllerParameters {
        lambda: 0.5030712770288837,
        eta: 0.7292116826633246,
        command_delay: step,
        ..parameters(PlannerKind::MinimumTime, 3.0)
    };
    let pose = |numbers: [f64; 6]| Pose(Coordinates::from(numbers));
    let goals = [
        (2.239, pose([-0.03261, 0.05084, 0.75826, 0.43667, 0.20428, -1.25627])),
        (3.296, pose([-0.05482, 0.00491, 0.78653, 0.14769, -0.19821, -0.8234])),
    ];
    let mut run = closed_loop(parameters, Pose::default());
    run.is_late = true;
    while run.moment().time < 12.0 {
        let given = goals.iter().rfind(|(time, _)| *time <= run.moment().time);
        run.goal = given.map_or(Pose::default(), |(_, goal)| *goal);
        let moment = run.step(step).unwrap();
        assert_eq!(moment.plant.slack, [false; 6], "{moment:?}");
    }
}

/// Errors were taken as for steps of `Exact`, and a motion was refused where not all they could cost was left: of 129 goals of rigs like this one was reached.
#[test]
fn a_wrong_mass_friction_and_coarse_encoders_do_not_keep_the_robot_from_its_goals() {
    let mut parameters = parameters(PlannerKind::MinimumTime, 3.0);
    (parameters.mass_tolerance, parameters.encoder_resolution) = (0.05, 1e-4);
    let weight = parameters.rig.weight();
    parameters.disturbance_bound = 0.03 * weight;
    let goals = [
        Pose::at(0.05, 0.04, 1.0),
        Pose(Coordinates::new(-0.04, 0.02, 0.9, 0.05, -0.03, 0.1)),
        Pose::default(),
    ];
    for mass in [0.95, 1.05] {
        let mut plant = PlantParameters {
            rig: parameters.rig,
            friction: 0.0034 * weight,
            encoder_resolution: 1e-4,
            ..Default::default()
        };
        plant.rig.mass *= mass;
        let mut run = ClosedLoop::new(parameters, plant, Pose::default()).unwrap();
        for goal in goals {
            run.goal = goal;
            let given = run.moment().time;
            while run.moment().time < given + 0.1 || !run.moment().controller.at_goal {
                let moment = run.step(2e-3).unwrap();
                assert_eq!(moment.plant.slack, [false; 6]);
                assert!(moment.time < given + 15.0, "{:?} at {goal:?}", moment.controller.status);
            }
            println!("{mass} of the mass: {:.2} s to {goal:?}", run.moment().time - given);
        }
    }
}
