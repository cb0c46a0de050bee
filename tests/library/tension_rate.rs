//! `maxTensionRate`: no commanded tension changes by more in a step than it allows, on the way, on stops, and where goals change.

use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RigFile, TensionLimits};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const PAPER: &str = include_str!("../../rigs/paper.toml");
const EIGHT: &str = include_str!("../../rigs/eight.toml");

/// How a motion is led: both gains (1/s), for how long a command is held (s), whether it acts a step late, and the greatest rate (N/s).
#[derive(Clone, Copy, Debug)]
struct Setting {
    gain: f64,
    step: f64,
    is_late: bool,
    rate: f64,
}

fn parameters(rig: &Rig, setting: Setting) -> ControllerParameters {
    ControllerParameters {
        planner: PlannerKind::MinimumTime,
        lambda: setting.gain,
        eta: setting.gain,
        command_delay: if setting.is_late { setting.step } else { 0.0 },
        max_tension_rate: setting.rate,
        ..ControllerParameters::of(rig)
    }
}

/// A closed loop whose commands are looked at.
struct Watched {
    run: ClosedLoop,
    setting: Setting,
    before: PerCable<f64>,
    /// The greatest rate of a command so far, N/s.
    fastest: f64,
}

impl Watched {
    /// At rest at `start`, for as long as the controller needs to know that.
    fn at_rest(rig: &Rig, setting: Setting, start: Pose) -> Self {
        let plant = PlantParameters { rig: *rig, initial_pose: start, ..Default::default() };
        let mut run = ClosedLoop::new(parameters(rig, setting), plant, start).unwrap();
        run.is_late = setting.is_late;
        let before = run.controller.outputs().motor_tension;
        let mut watched = Self { run, setting, before, fastest: 0.0 };
        watched.go_on(0.1, false);
        watched
    }

    /// For so many seconds; with the pose `lost`, no pose that makes sense is seen.
    fn go_on(&mut self, duration: f64, lost: bool) {
        let end = self.run.moment().time + duration - 0.5 * self.setting.step;
        while self.run.moment().time < end {
            let see = |inputs: &mut cable_robot::plan::ControllerInputs| {
                if lost {
                    inputs.encoder_pose = Pose::at(0.0, 0.0, 9.0);
                }
            };
            let moment = self.run.step_seeing(self.setting.step, see).unwrap();
            assert!(!moment.plant.slack.contains(&true), "{moment:?}");
            let commanded = moment.controller.motor_tension;
            let change = commanded.iter().zip(&self.before).map(|(u, before)| (u - before).abs());
            self.fastest = self.fastest.max(change.fold(0.0, f64::max) / self.setting.step);
            self.before = commanded;
        }
    }

    fn status(&self) -> Status {
        self.run.moment().controller.status
    }

    /// As a share of what is allowed.
    fn share(&self) -> f64 {
        self.fastest / self.setting.rate
    }
}

/// A pose about home, turned by up to `turn` (rad), at which the robot can rest.
fn inside(rng: &mut Pcg64, RigFile { rig, home, .. }: &RigFile, turn: f64) -> Pose {
    let size = rig.radius();
    let mut any =
        || Coordinates::from_fn(|k, _| rng.random_range(-1.0..1.0) * if k < 3 { 0.3 * size } else { turn });
    let poses = std::iter::repeat_with(|| Pose(home.0 + any()));
    let mut above = poses.filter(|pose| rig.can_be_at(pose));
    above.find(|pose| static_margin(rig, pose) > 0.01 * rig.weight()).unwrap()
}

#[test]
fn the_papers_move_keeps_the_rate_of_its_tensions() {
    let rig = RigFile::default().rig.with_limits(TensionLimits { min: 0.5, max: 40.0 });
    let (start, goal) = (Pose::default(), Pose::at(0.15, 0.15, 1.0));
    let mut jumps = 0.0f64;
    for (rate, most) in [(0.0, 0.58), (1000.0, 0.62), (400.0, 0.66)] {
        let setting = Setting { gain: 3.0, step: 1e-3, is_late: false, rate };
        let planned = Planner::from(parameters(&rig, setting)).course_from_rest(&start, &goal).unwrap().end();
        let mut watched = Watched::at_rest(&rig, setting, start);
        watched.fastest = 0.0;
        watched.run.goal = goal;
        watched.go_on(planned + 0.2, false);
        println!("at most {rate} N/s: planned {planned:.4} s, commanded {:.1} N/s at most", watched.fastest);
        assert_eq!(watched.status(), Status::AtGoal);
        assert!(planned < most);
        if rate == 0.0 {
            jumps = watched.fastest;
        } else {
            assert!(watched.share() <= 1.0 && watched.share() > 0.95, "{}", watched.share());
        }
    }
    assert!(jumps > 10_000.0, "{jumps}");
}

/// Goals one after the other, some given on the way to the one before: the greatest share of the rate, how many were reached of those that were given time, and what the motions take
/// longer than without a limit.
fn with_goals(file: &RigFile, turn: f64, setting: Setting, goals: usize) -> (f64, [usize; 2], f64) {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut watched = Watched::at_rest(&file.rig, setting, inside(&mut rng, file, turn));
    watched.fastest = 0.0;
    let (mut reached, mut longer) = ([0, 0], 0.0);
    for _ in 0..goals {
        let goal = inside(&mut rng, file, turn);
        let (status, from) = (watched.status(), watched.run.moment().controller.set_point);
        watched.run.goal = goal;
        if rng.random_range(0.0..1.0) < 0.4 {
            watched.go_on(rng.random_range(0.05..0.5), false);
            continue;
        }
        let time = |setting| {
            let planner = Planner::from(parameters(&file.rig, setting));
            planner.course_from_rest(&from, &goal).map(|course| course.end())
        };
        let times = [setting, Setting { rate: 0.0, ..setting }].map(time);
        if let (Status::AtGoal, [Some(slow), Some(fast)]) = (status, times) {
            longer = f64::max(longer, slow / fast - 1.0);
        }
        watched.go_on(4.0, false);
        reached[0] += usize::from(watched.status() == Status::AtGoal);
        reached[1] += 1;
    }
    (watched.share(), reached, longer)
}

fn check_goals(rigs: &[(&str, f64, usize)]) {
    let settings =
        [(3.0, 1e-3, false), (8.0, 1e-3, true), (3.0, 4e-3, true), (8.0, 4e-3, false), (3.0, 20e-3, false)];
    for (text, turn, goals) in rigs {
        let file = RigFile::parse(text).unwrap();
        for (k, (gain, step, is_late)) in settings.into_iter().enumerate() {
            let rate = [12.0, 30.0][k % 2] * file.rig.weight();
            let setting = Setting { gain, step, is_late, rate };
            let (share, reached, longer) = with_goals(&file, *turn, setting, *goals);
            println!(
                "{}, turned by {turn}, {setting:?}: {share:.4} of the rate, {reached:?} reached, motions up to {:.0} % longer",
                file.name,
                1e2 * longer
            );
            assert!(share <= 1.0 && reached[0] == reached[1], "{share} {reached:?}");
        }
    }
}

#[test]
fn goals_that_change_on_the_way_keep_the_rate_too() {
    check_goals(&[(PAPER, 0.2, 4)]);
}

#[test]
#[ignore = "takes long: cargo test --test library many_goals -- --ignored"]
fn many_goals_that_change_on_the_way_keep_the_rate_too() {
    check_goals(&[(PAPER, 0.0, 10), (PAPER, 0.2, 10), (EIGHT, 0.15, 5)]);
}

/// The pose is lost on the way.
#[test]
fn stops_keep_the_rate_and_are_stops() {
    for (text, turn, runs) in [(PAPER, 0.0, 6), (PAPER, 0.2, 6), (EIGHT, 0.15, 3)] {
        let file = RigFile::parse(text).unwrap();
        let mut rng = Pcg64::seed_from_u64(3);
        let (mut most, mut sooner) = (0.0f64, 0);
        for run in 0..runs {
            let (gain, step) = [(3.0, 1e-3), (8.0, 4e-3)][run % 2];
            let setting = Setting { gain, step, is_late: false, rate: 15.0 * file.rig.weight() };
            let [start, goal] = [(); 2].map(|()| inside(&mut rng, &file, turn));
            let planner = Planner::from(parameters(&file.rig, setting));
            let planned = planner.course_from_rest(&start, &goal).unwrap().end();
            let mut watched = Watched::at_rest(&file.rig, setting, start);
            watched.fastest = 0.0;
            watched.run.goal = goal;
            watched.go_on(rng.random_range(0.2..0.9) * planned, false);
            watched.go_on(planned + 0.3, true);
            let moment = watched.run.moment();
            assert_eq!(watched.status(), Status::SensorFault);
            assert!(moment.plant.velocity.norm() < 0.02 * file.rig.radius(), "{moment:?}");
            most = most.max(watched.share());
            let left = moment.plant.encoder_pose.minus(&goal).norm() / start.minus(&goal).norm();
            sooner += usize::from(left > 0.02);
        }
        println!(
            "{}, turned by {turn}: {most:.4} of the rate, {sooner} of {runs} stop before the goal",
            file.name
        );
        assert!(most <= 1.0 && sooner * 3 >= runs, "{most} {sooner}");
    }
}

#[test]
fn a_rate_too_small_for_any_motion_is_named() {
    let rig = RigFile::default().rig;
    let (start, goal) = (Pose::default(), Pose::at(0.15, 0.15, 1.0));
    let setting = Setting { gain: 3.0, step: 1e-3, is_late: false, rate: 1e-7 };
    let parameters = parameters(&rig, setting);
    assert!(Planner::from(parameters).is_kept_by_rate(&start, &goal));
    let mut watched = Watched::at_rest(&rig, setting, start);
    watched.run.goal = goal;
    watched.go_on(1.0, false);
    assert_eq!(watched.status(), Status::GoalUnreachable);
    assert!(watched.run.moment().plant.encoder_pose.minus(&start).norm() < 1e-4);
}

#[test]
fn a_rate_that_makes_no_sense_and_one_that_nobody_heeds_are_refused_by_name() {
    let refused = |planner, max_tension_rate| {
        let parameters = ControllerParameters { planner, max_tension_rate, ..Default::default() };
        parameters.validate().unwrap_err().to_string()
    };
    for rate in [f64::NAN, f64::INFINITY, -1.0] {
        let said = refused(PlannerKind::MinimumTime, rate);
        assert!(said.contains(&format!("maxTensionRate = {rate}")), "{said}");
    }
    for planner in [PlannerKind::Bounded, PlannerKind::Exact] {
        let said = refused(planner, 400.0);
        assert!(said.contains("maxTensionRate = 400") && said.contains("MinimumTime"), "{said}");
    }
}
