//! `MinimumTime` by way of other poses: passed without a stop, every tension within its limits, in closed loop too.

use cable_robot::control::{static_margin, tensions};
use cable_robot::plan::through::{NoWay, Through};
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, RigFile};
use cable_robot::sim::{ClosedLoop, PlantParameters, ScenarioFile, Simulation};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const RIGS: [&str; 2] = [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")];

fn parameters(file: &RigFile) -> ControllerParameters {
    ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&file.rig) }
}

/// Poses about home at which the robot can rest with something left.
fn poses(rng: &mut Pcg64, RigFile { rig, home, .. }: &RigFile, count: usize) -> Vec<Pose> {
    let size = rig.radius();
    let mut any =
        || Coordinates::from_fn(|k, _| rng.random_range(-1.0..1.0) * if k < 3 { 0.2 * size } else { 0.1 });
    let all = std::iter::repeat_with(|| Pose(home.0 + any())).filter(|pose| rig.can_be_at(pose));
    all.filter(|pose| static_margin(rig, pose) > 0.02 * rig.weight()).take(count).collect()
}

/// The times at which it is there, and its speeds then, m/s and rad/s together.
fn passes(found: &Through, way_points: &[Pose]) -> Vec<f64> {
    let times: Vec<f64> = found.course.passes().collect();
    assert_eq!(times.len(), way_points.len());
    for (time, pose) in times.iter().zip(way_points) {
        assert!(found.course.at(*time).pose.minus(pose).amax() < 1e-9);
    }
    times.iter().map(|time| found.course.at(*time).rates.norm()).collect()
}

/// The greatest angle by which the way turns at a way point, rad.
fn sharpest(poses: &[Pose]) -> f64 {
    let turn = |three: &[Pose]| {
        let [before, after] = [0, 1].map(|k| three[k + 1].position() - three[k].position());
        before.angle(&after)
    };
    poses.windows(3).map(turn).fold(0.0, f64::max)
}

/// And how many there are.
fn median(mut values: Vec<f64>) -> (f64, usize) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values.len())
}

#[test]
fn way_points_are_passed_without_a_stop_and_sooner_than_with_one() {
    for text in RIGS {
        let file = RigFile::parse(text).unwrap();
        let (parameters, rig) = (parameters(&file), &file.rig);
        let mut rng = Pcg64::seed_from_u64(3);
        let (mut found, mut gains, mut gentle) = (0, vec![], vec![]);
        const RUNS: usize = 40;
        for run in 0..RUNS {
            let poses = poses(&mut rng, &file, 3 + run % 3);
            let through = match Through::new(&parameters, &poses) {
                Ok(through) => through,
                Err(NoWay::NoRest { .. } | NoWay::NotProved) => continue,
                Err(NoWay::Poses) => panic!("{poses:?}"),
            };
            found += 1;
            let speeds = passes(&through, &poses[1..poses.len() - 1]);
            assert!(speeds.iter().all(|speed| *speed > 1e-3 * rig.radius()), "{speeds:?} {poses:?}");
            let end = through.course.end();
            for k in 0..=2000 {
                let led = through.course.at(end * f64::from(k) / 2000.0);
                let tension = tensions(rig, &led.pose, &led.rates, &led.accelerations, 0.0).unwrap();
                for (tension, cable) in tension.iter().zip(&rig.cables) {
                    assert!(cable.limits.margin(*tension) > -1e-9, "{tension} {led:?}");
                }
            }
            let planner = Planner::from(parameters);
            let stops = poses.windows(2).map(|ends| planner.course_from_rest(&ends[0], &ends[1]));
            if let Some(stops) = stops.map(|course| course.map(|course| course.end())).sum::<Option<f64>>() {
                gains.push(end / stops);
                if sharpest(&poses) < std::f64::consts::FRAC_PI_2 {
                    gentle.push(end / stops);
                }
            }
        }
        let [all, gentle] = [gains, gentle].map(median);
        println!(
            "{}: {found} of {RUNS} ways, in the median {:.2} of the time with stops, {:.2} of {} without a turn of 90 degrees",
            file.name, all.0, gentle.0, gentle.1
        );
        assert!(found * 3 > RUNS * 2 && all.0 < 1.0 && gentle.0 < 0.9 && gentle.1 > 3);
    }
}

/// Symmetric ways had corners of polygons that differ by rounding alone, and no motion was found.
#[test]
fn ways_of_eight_cables_along_an_axis_are_found() {
    let file = RigFile::parse(RIGS[1]).unwrap();
    for via in [[0.15, 0.0, 1.5], [0.3, 0.0, 1.5], [0.2, 0.0, 1.4]] {
        let poses = [Pose::at(0.0, 0.0, 1.5), Pose::at(via[0], via[1], via[2]), Pose::at(0.35, 0.1, 1.5)];
        let found = Through::new(&parameters(&file), &poses);
        assert!(found.is_ok(), "{via:?}: {found:?}");
    }
}

#[test]
fn a_controller_passes_its_way_points_and_slackens_no_cable() {
    for (text, step) in [(RIGS[0], 1e-3), (RIGS[0], 4e-3), (RIGS[1], 2e-3)] {
        let file = RigFile::parse(text).unwrap();
        let mut rng = Pcg64::seed_from_u64(4);
        let mut parameters = parameters(&file);
        (parameters.lambda, parameters.eta) = (8.0, 8.0);
        for _ in 0..4 {
            let poses = poses(&mut rng, &file, 4);
            let plant = PlantParameters { rig: file.rig, initial_pose: poses[0], ..Default::default() };
            let mut run = ClosedLoop::new(parameters, plant, poses[0]).unwrap();
            run.controller.pass_through(&poses[1..3]).unwrap();
            run.goal = poses[3];
            let mut nearest = [f64::INFINITY; 2];
            while run.moment().time < 6.0 {
                let moment = run.step(step).unwrap();
                assert!(moment.plant.slack.iter().all(|is_slack| !is_slack), "{moment:?}");
                for (nearest, pose) in nearest.iter_mut().zip(&poses[1..3]) {
                    *nearest = nearest.min(moment.plant.encoder_pose.minus(pose).amax());
                }
            }
            // Between two samples it goes on.
            assert!(nearest.iter().all(|nearest| *nearest < 0.02 * file.rig.radius()), "{nearest:?}");
            assert_eq!(run.moment().controller.status, Status::AtGoal);
            let steps = run.moment().controller.set_point_index;
            println!("{steps} motions, within {nearest:.4?} of the way points");
        }
    }
}

/// A way point outside the workspace is named with the cable that forbids it; a way there and back is no smooth one, but the controller stops between.
#[test]
fn a_way_that_cannot_be_is_refused_and_gone_in_parts_where_it_can() {
    let file = RigFile::default();
    let parameters = parameters(&file);
    let (a, b) = (Pose::default(), Pose::at(0.1, 0.0, 1.0));
    let outside = Through::new(&parameters, &[a, Pose::at(0.0, 0.4, 1.0), b]).unwrap_err().to_string();
    assert!(outside.contains("cannot rest: cable 2 would be below 0 N"), "{outside}");
    assert_eq!(Through::new(&parameters, &[a, a, b]), Err(NoWay::Poses));
    assert_eq!(Through::new(&parameters, &[a, b, a]), Err(NoWay::NotProved));
    let plant = PlantParameters { rig: file.rig, initial_pose: a, ..Default::default() };
    let mut run = ClosedLoop::new(parameters, plant, a).unwrap();
    run.controller.pass_through(&[b]).unwrap();
    let mut farthest = 0.0f64;
    while run.moment().time < 4.0 {
        let moment = run.step(1e-3).unwrap();
        assert!(moment.plant.slack.iter().all(|is_slack| !is_slack));
        farthest = farthest.max(moment.plant.encoder_pose.0[0]);
    }
    assert!((farthest - 0.1).abs() < 1e-3 && run.moment().plant.encoder_pose.minus(&a).amax() < 1e-3);
    let refused = |way_points: &[Pose]| {
        let mut run = ClosedLoop::new(parameters, plant, a).unwrap();
        run.controller.pass_through(way_points).unwrap_err().to_string()
    };
    assert!(refused(&[b; 8]).contains("way points = 8"));
    assert!(refused(&[b, Pose::at(0.0, 0.0, f64::NAN)]).contains("way point 2, z = NaN"));
    let exact = ControllerParameters { planner: PlannerKind::Exact, ..parameters };
    let mut run = ClosedLoop::new(exact, plant, a).unwrap();
    assert!(run.controller.pass_through(&[b]).unwrap_err().to_string().contains("MinimumTime"));
}

#[test]
fn a_scenario_leads_through_its_way_points() {
    let text = "title = \"t\"\nduration = 2.0\nstep = 0.001\n[[goals]]\ntime = 0.1\npose = [0.15, 0.15, 1.0]\nthrough = [[0.1, 0.0, 1.0]]\n[controller]\nplanner = \"minimum-time\"\n";
    let read = |text: &str| {
        let file = ScenarioFile::parse(text).unwrap();
        file.scenario("rig", Pose::default(), ControllerParameters::default())
    };
    let scenario = read(text).unwrap();
    let mut run = Simulation::new(&scenario).unwrap();
    let mut nearest = f64::INFINITY;
    while run.moment().time < 1.9 {
        run.step().unwrap();
        nearest = nearest.min(run.moment().plant.encoder_pose.minus(&Pose::at(0.1, 0.0, 1.0)).amax());
    }
    assert!(nearest < 2e-3 && run.moment().controller.set_point_index == 1, "{nearest}");
    let exact = text.replace("minimum-time", "exact");
    let refused = read(&exact).unwrap_err().to_string();
    assert!(refused.contains("goals[1].through[1]") && refused.contains("minimum-time"), "{refused}");
}
