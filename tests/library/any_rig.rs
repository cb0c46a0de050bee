//! The rigs of `rigs/public`, which other people published: every one is driven.

use crate::common::ClosedLoop;
use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, Rig, RigFile};
use cable_robot::sim::PlantParameters;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn public() -> impl Iterator<Item = (String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/rigs/public");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| {
        (path.file_stem().unwrap().to_string_lossy().into_owned(), std::fs::read_to_string(path).unwrap())
    })
}

/// A pose up to 15 % of the rig's radius from home, at which it can rest with 3 % of its weight to spare.
fn random_goal(rig: &Rig, home: &Pose, rng: &mut Pcg64) -> Pose {
    loop {
        let by = Coordinates::from_fn(|k, _| if k < 3 { rng.random_range(-1.0..1.0) } else { 0.0 });
        if by.norm() > 1.0 {
            continue;
        }
        let goal = Pose(home.0 + by * (0.15 * rig.radius()));
        if static_margin(rig, &goal) > 0.03 * rig.weight() {
            return goal;
        }
    }
}

#[test]
fn every_public_rig_reaches_goals_inside_its_workspace_with_all_tensions_within_limits() {
    for (name, text) in public() {
        let Ok(file) = RigFile::parse(&text) else { continue };
        let mut rng = Pcg64::seed_from_u64(5);
        let mut least = f64::INFINITY;
        let mut longest: f64 = 0.0;
        for _ in 0..5 {
            let goal = random_goal(&file.rig, &file.home, &mut rng);
            let (margin, time) = drive(&name, &file, &goal);
            least = least.min(margin);
            longest = longest.max(time);
        }
        println!("{name}: least margin {least:.3} N of {:.0} N, {longest:.2} s", file.rig.weight());
        assert!(least > 0.0, "{name}: {least} N");
    }
}

/// With tensions up to 5000 N for a platform of 1.2 N, goals beyond the border were gone to until tensions of hundreds of newtons threw the
/// platform about: cables went slack, and with the second of these goals the robot was lost.
#[test]
fn a_goal_outside_is_made_for_only_as_far_as_the_platform_can_be_held() {
    let (_, text) = public().find(|(name, _)| name == "segesta10").unwrap();
    let file = RigFile::parse(&text).unwrap();
    for (x, y, z) in [(0.0462, 1.2771, 1.0045), (0.8539, -0.8297, 0.1268), (1.1210, -0.2668, 0.0492)] {
        let (status, margin, _) = run(&file, &Pose::at(x, y, z), 8.0);
        println!("({x}, {y}, {z}): {status:?}, least margin {margin:.4} N");
        assert!(status == Status::GoalUnreachable && margin > 0.0, "{status:?}, {margin} N");
    }
}

/// Least distance of a tension from its limits on the way, N, and time to the goal, s.
fn drive(name: &str, file: &RigFile, goal: &Pose) -> (f64, f64) {
    let (status, margin, time) = run(file, goal, 40.0);
    assert_eq!(status, Status::AtGoal, "{name} after {time} s, goal {goal:?}");
    (margin, time)
}

/// From home towards a goal, until the robot is there or `duration` (s) has passed: status, least distance of a tension from its limits (N) and
/// time (s).
fn run(file: &RigFile, goal: &Pose, duration: f64) -> (Status, f64, f64) {
    let RigFile { rig, home, lambda, eta, .. } = file;
    let planner = PlannerKind::Exact;
    let controller =
        ControllerParameters { lambda: *lambda, eta: *eta, planner, ..ControllerParameters::of(rig) };
    let plant = PlantParameters { rig: *rig, initial_pose: *home, ..PlantParameters::default() };
    let mut robot = ClosedLoop::new(controller, plant, *goal, 1e-3);
    let mut least = f64::INFINITY;
    loop {
        let time = robot.time();
        let (output, _) = robot.advance();
        let margins = output.motor_tension.iter().zip(&rig.cables).map(|(u, cable)| cable.limits.margin(*u));
        least = margins.fold(least, f64::min);
        if output.status == Status::AtGoal || time >= duration {
            return (output.status, least, time);
        }
    }
}
