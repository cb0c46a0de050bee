//! Margins of the certificate for more than six cables and for pulleys, against plants with everything wrong at once that they allow.

use cable_robot::control::{Gains, Reference, lyapunov};
use cable_robot::reach::certificate::{Margins, Step, Verdict, certify, certify_with_margins};
use cable_robot::robot::{Coordinates, Pose, Pulley, Rig, RigFile};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A rig, what is wrong with the plants that it is run on, and the steps that are tried.
struct Case {
    name: &'static str,
    rig: Rig,
    margins: Margins,
    /// Of the start and the set point: height, and how far (m) and how much turned (rad) from there.
    height: f64,
    size: f64,
    turn: f64,
}

fn cases() -> [Case; 3] {
    let of_eight = Margins {
        mass: 0.001,
        centre_of_mass: 0.0,
        force: 0.1,
        torque: 0.005,
        friction: 0.004,
        law_margin: 1.0,
        accuracy: 4e-6,
        sample_period: 2e-4,
        delay: 2e-4,
    };
    let of_six =
        Margins { friction: 0.0005, law_margin: 0.0, accuracy: 1e-5, torque: 0.002, force: 0.05, ..of_eight };
    let at = |name, rig, margins, height, size, turn| Case { name, rig, margins, height, size, turn };
    [
        at("eight cables", eight(), of_eight, 2.0, 0.5, 0.1),
        at("eight over pulleys", over_pulleys(eight()), of_eight, 2.0, 0.5, 0.1),
        at("six over pulleys", six_over_pulleys(), of_six, 1.0, 0.05, 0.03),
    ]
}

fn eight() -> Rig {
    RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap().rig
}

/// Each cable over a pulley of 8 cm that swivels about a vertical line.
fn over_pulleys(mut rig: Rig) -> Rig {
    for cable in rig.cables.iter_mut() {
        cable.pulley = Some(Pulley { radius: 0.08, axis: -Vector3::z() });
    }
    rig
}

/// The paper's, with the inertia of a uniform disc.
fn six_over_pulleys() -> Rig {
    let mut rig = RigFile::parse(include_str!("../../rigs/paper.toml")).unwrap().rig;
    rig.inertia *= 0.125 / rig.inertia[(0, 0)];
    rig.cables.iter_mut().for_each(|cable| cable.pulley = Some(Pulley { radius: 0.03, axis: -Vector3::z() }));
    rig
}

fn random_vector(rng: &mut Pcg64, length: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64)).normalize() * length
}

/// A truth that the margins allow.
fn truth(rng: &mut Pcg64, Case { rig, margins, .. }: &Case) -> Rig {
    let mut truth = *rig;
    truth.mass *= 1.0 + margins.mass * rng.random_range(-1.0..=1.0);
    truth.inertia *= 1.0 + margins.mass * rng.random_range(-1.0..=1.0);
    for cable in truth.cables.iter_mut() {
        cable.anchor += random_vector(rng, margins.accuracy);
        cable.attachment += random_vector(rng, margins.accuracy);
    }
    truth
}

/// Least and greatest tension commanded or pulled on the way, N.
fn run(rng: &mut Pcg64, case: &Case, step: &Step) -> [f64; 2] {
    let Case { rig, margins, .. } = case;
    let parameters = PlantParameters {
        rig: truth(rng, case),
        initial_pose: step.start,
        friction: margins.friction,
        ..Default::default()
    };
    let mut inputs = PlantInputs::none(rig.cables.len());
    let mut plant = Plant::new(parameters, &inputs).unwrap();
    let mut seen = (step.start, step.rates);
    let mut range = [f64::INFINITY, 0.0_f64];
    for k in 0..(1.5 / margins.sample_period) as usize {
        if k % 1000 == 0 {
            inputs.disturbance_force = random_vector(rng, margins.force);
            inputs.disturbance_torque = random_vector(rng, margins.torque);
        }
        let (pose, rates) = seen;
        inputs.motor_tension = lyapunov::tension_command(
            rig,
            &step.gains,
            &pose,
            &rates,
            &Reference::resting(&step.set_point),
            margins.law_margin,
        )
        .unwrap();
        seen = state(&plant); // used one period later
        plant.step(&inputs, margins.sample_period).unwrap();
        for u in inputs.motor_tension.into_iter().chain(plant.outputs().measured_tension) {
            range = [range[0].min(u), range[1].max(u)];
        }
    }
    range
}

fn state(plant: &Plant) -> (Pose, Coordinates) {
    let now = plant.outputs();
    let turning = now.encoder_pose.rate_matrix().try_inverse().unwrap() * now.angular_velocity;
    let v = now.velocity;
    (now.encoder_pose, Coordinates::new(v.x, v.y, v.z, turning.x, turning.y, turning.z))
}

fn random_step(rng: &mut Pcg64, case: &Case) -> Step {
    let Case { height, size, turn, .. } = *case;
    let mut pose = || {
        let scale = Coordinates::new(size, size, 0.2 * size, turn, turn, turn);
        let by = Coordinates::from_fn(|_, _| rng.random_range(-1.0..1.0));
        Pose(Coordinates::z() * height + by.component_mul(&scale))
    };
    let (start, set_point) = (pose(), pose());
    let gains = Gains { lambda: rng.random_range(2.0..5.0), eta: rng.random_range(2.0..5.0) };
    Step { start, rates: Coordinates::zeros(), set_point, gains }
}

/// 60 accepted steps of each rig.
#[test]
fn no_tension_leaves_the_certified_range_on_imperfect_plants_of_eight_cables_and_of_pulleys() {
    for case in cases() {
        let mut rng = Pcg64::seed_from_u64(77);
        let (mut accepted, mut admissible) = (0, 0);
        while accepted < 60 {
            let step = random_step(&mut rng, &case);
            let Verdict::Admissible { .. } = certify(&case.rig, &step).unwrap() else { continue };
            admissible += 1;
            assert!(admissible < 2000, "{}: {accepted} accepted", case.name);
            let verdict = certify_with_margins(&case.rig, &step, &case.margins).unwrap();
            let Verdict::Admissible { least, greatest, .. } = verdict else { continue };
            accepted += 1;
            let [low, high] = run(&mut rng, &case, &step);
            assert!(
                low >= least && high <= greatest,
                "{}: {low} to {high} N, not {least} to {greatest} N, {step:?}",
                case.name
            );
        }
        println!("{}: {accepted} accepted of {admissible} admissible without margins", case.name);
    }
}
