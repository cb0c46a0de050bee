//! The rigs of `rigs/public`, which other people published: every one is driven.

use cable_robot::control::static_margin;
use cable_robot::plan::{Controller, ControllerInputs, ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RigFile};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const STEP: f64 = 1e-3;

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

/// Least distance of a tension from its limits on the way, N, and time to the goal, s.
fn drive(name: &str, file: &RigFile, goal: &Pose) -> (f64, f64) {
    let RigFile { rig, home, lambda, eta, .. } = file;
    let planner = PlannerKind::Exact;
    let parameters =
        ControllerParameters { lambda: *lambda, eta: *eta, planner, ..ControllerParameters::of(rig) };
    let cables = rig.cables.len();
    let plant = PlantParameters { rig: *rig, initial_pose: *home, ..PlantParameters::default() };
    let mut plant = Plant::new(plant, &PlantInputs::none(cables)).unwrap();
    let mut inputs = ControllerInputs {
        encoder_pose: *home,
        cable_length: plant.outputs().cable_length,
        measured_tension: PerCable::filled(cables, 0.0),
        goal_pose: *goal,
        enable: true,
    };
    let mut controller = Controller::new(parameters, 0.0, &inputs).unwrap();
    let mut least = f64::INFINITY;
    for k in 0..40_000 {
        let time = f64::from(k) * STEP;
        inputs.encoder_pose = plant.outputs().encoder_pose;
        controller.step(time, STEP, &inputs);
        let outputs = controller.outputs();
        if outputs.status == Status::AtGoal {
            return (least, time);
        }
        assert!(
            !matches!(outputs.status, Status::SensorFault),
            "{name}: {:?} at {time} s, goal {goal:?}",
            outputs.status
        );
        for (u, cable) in outputs.motor_tension.iter().zip(&rig.cables) {
            least = least.min(cable.limits.margin(*u));
        }
        let pull = PlantInputs { motor_tension: outputs.motor_tension, ..PlantInputs::none(cables) };
        plant.step(&pull, STEP).unwrap();
    }
    panic!("{name}: {:?} after 40 s, goal {goal:?}, {:?}", controller.outputs().status, controller.outputs());
}
