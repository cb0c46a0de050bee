//! Orbits outside the static workspace: proofs against dense samples, the closed form against proofs, and the law that follows them.

use std::f64::consts::TAU;

use cable_robot::control::{static_tensions, tensions};
use cable_robot::plan::orbit::{Figure, Follower, Orbit, OrbitError, Part, Proof, Trajectory, reach_of_p};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, Status};
use cable_robot::reach::Verdict;
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RigFile};
use cable_robot::sim::{ClosedLoop, ControllerModel, Plant, PlantInputs, PlantParameters};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const STEP: f64 = 1e-3;

/// The circle: 0.4 m about the middle, of a hexagon of apothem 0.225 m.
fn circle() -> Orbit {
    let figure = Figure::Circle { radius: 0.4 };
    Orbit { centre: Pose::at(0.0, 0.0, 1.0), figure, rate: 2.75, turns: 2.0, start: 2.5 }
}

fn parameters() -> ControllerParameters {
    ControllerParameters::default()
}

fn proved(orbit: &Orbit) -> Result<Proof, OrbitError> {
    orbit.prove(&parameters(), &Coordinates::zeros(), STEP)
}

/// The tensions of the full inverse dynamics of a motion at a time, N.
fn tensions_at(rig: &Rig, trajectory: &Trajectory, time: f64) -> PerCable<f64> {
    let led = trajectory.at(time);
    tensions(rig, &led.pose, &led.rates, &led.accelerations, 0.0).unwrap()
}

/// Least of them in dense samples, N.
fn least(rig: &Rig, trajectory: &Trajectory, [from, to]: [f64; 2]) -> f64 {
    let times = (0..=2000).map(|k| from + (to - from) * f64::from(k) / 2000.0);
    times.flat_map(|time| tensions_at(rig, trajectory, time)).fold(f64::INFINITY, f64::min)
}

fn any_orbit(rng: &mut Pcg64) -> Orbit {
    let radius = rng.random_range(0.1..0.6);
    let figure = match rng.random_range(0..3) {
        0 => Figure::Circle { radius },
        1 => Figure::Line { radius, direction: rng.random_range(-3.0..3.0) },
        _ => {
            Figure::Hypotrochoid { radius, share: rng.random_range(0.02..0.2), lobes: rng.random_range(2..5) }
        }
    };
    let centre =
        Pose::at(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1), rng.random_range(0.7..1.4));
    let (rate, start) = (rng.random_range(2.0..4.0), rng.random_range(1.0..4.0));
    Orbit { centre, figure, rate, turns: rng.random_range(0.2..2.0), start }
}

#[test]
fn what_is_proved_holds_in_dense_samples_and_what_is_refused_does_not() {
    let rig = parameters().rig;
    let mut rng = Pcg64::seed_from_u64(12);
    let (mut admitted, mut broken) = (0, 0);
    for _ in 0..150 {
        let orbit = any_orbit(&mut rng);
        match proved(&orbit) {
            Ok(proof) => {
                admitted += 1;
                let whole = proof.trajectory;
                assert!(least(&rig, &whole, [0.0, whole.end()]) >= proof.least, "{orbit:?}");
                for _ in 0..6 {
                    let begin = rng.random_range(0.0..whole.stop_begins());
                    let stop = proof.stopped(begin);
                    assert!(
                        stop.stop_begins() >= begin && stop.end() - begin <= proof.longest_to_rest + 1e-9
                    );
                    assert!(least(&rig, &stop, [0.0, stop.end()]) >= proof.least, "{orbit:?} {begin}");
                    let rest = stop.at(stop.end());
                    assert!(rest.pose.minus(&orbit.centre).amax() < 1e-12 && rest.rates.amax() < 1e-12);
                }
            }
            Err(OrbitError::Refused(refusal)) => {
                let Verdict::NotAdmissible { cable, time, tension } = refusal.verdict else { continue };
                broken += 1;
                let whole = Orbit { turns: 2.0, ..orbit }.trajectory();
                let motion = match refusal.part {
                    Part::Stop(begin) => whole.stopped(begin),
                    _ => whole,
                };
                let found = tensions_at(&rig, &motion, time)[cable - 1];
                assert!(
                    (found - tension).abs() < 1e-6 && tension <= refusal.kept,
                    "{orbit:?} {refusal} {found}"
                );
            }
            Err(other) => panic!("{other}"),
        }
    }
    println!("{admitted} proved, {broken} refused for a tension");
    assert!(admitted > 20 && broken > 20, "{admitted} {broken}");
}

/// Eq. (O4) is sufficient, so the certificate, which knows nothing of it, must admit: 43.6 N/m is m g/(3a).
#[test]
fn what_the_closed_form_admits_is_proved() {
    let mut rng = Pcg64::seed_from_u64(3);
    let mut admitted = 0;
    for _ in 0..300 {
        let orbit = any_orbit(&mut rng);
        let orbit = Orbit { centre: Pose::at(0.0, 0.0, orbit.centre.0[2]), ..orbit };
        if reach_of_p(&orbit, orbit.centre.0[2], 9.81) < 0.225 - 0.11 / 43.6 {
            admitted += 1;
            assert!(proved(&orbit).is_ok(), "{orbit:?} {:?}", proved(&orbit));
        }
    }
    println!("{admitted} admitted by the closed form");
    assert!(admitted > 20, "{admitted}");
}

/// What the closed loop comes to.
struct Run {
    /// N.
    smallest: f64,
    /// From the reference, m.
    farthest: f64,
    is_slack: bool,
    last: ControllerOutputs,
    end: Pose,
}

fn follow(orbit: &Orbit, from: Pose, push: impl Fn(f64) -> Vector3<f64>) -> Run {
    let parameters = parameters();
    let plant = PlantParameters { rig: parameters.rig, initial_pose: from, ..PlantParameters::default() };
    let plant = Plant::new(plant, &PlantInputs::none(6)).unwrap();
    let seen = ControllerInputs {
        encoder_pose: from,
        cable_length: plant.outputs().cable_length,
        measured_tension: plant.outputs().measured_tension,
        goal_pose: from,
        enable: true,
    };
    let follower = Follower::new(orbit, &parameters, (0.0, STEP), &seen).unwrap();
    let end = follower.proof().trajectory.end() + 4.0;
    let mut closed = ClosedLoop::with_models(follower, plant, from, &PlantInputs::none(6)).unwrap();
    let mut run = Run {
        smallest: f64::INFINITY,
        farthest: 0.0,
        is_slack: false,
        last: closed.moment().controller,
        end: from,
    };
    for _ in 0..(end / STEP) as u32 {
        closed.disturbance_force = push(closed.moment().time);
        let led = closed.controller.proof().trajectory.at(closed.moment().time + STEP);
        let moment = *closed.step(STEP).unwrap();
        run.smallest = moment.plant.measured_tension.iter().copied().fold(run.smallest, f64::min);
        run.farthest = run.farthest.max((moment.plant.encoder_pose.position() - led.pose.position()).norm());
        run.is_slack |= moment.plant.slack.iter().any(|slack| *slack);
        (run.last, run.end) = (moment.controller, moment.plant.encoder_pose);
    }
    run
}

fn undisturbed(_: f64) -> Vector3<f64> {
    Vector3::zeros()
}

#[test]
fn a_circle_of_0_4_m_keeps_0_9_n_where_rest_would_need_a_cable_that_pushes() {
    let out = static_tensions(&parameters().rig, &Pose::at(0.0, 0.4, 1.0), 0.0).unwrap();
    let least = out.into_iter().fold(f64::INFINITY, f64::min);
    let run = follow(&circle(), Pose::at(0.0, 0.0, 1.0), undisturbed);
    println!("at rest {least:.3} N; on the circle {:.3} N, {:.3} mm off", run.smallest, 1e3 * run.farthest);
    assert!(least < -8.0 && run.smallest > 0.9 && run.farthest < 3e-4, "{least} {}", run.smallest);
    assert_eq!(run.last.status, Status::AtGoal);
    assert!(run.end.minus(&Pose::at(0.0, 0.0, 1.0)).amax() < 1e-4);
    let off = follow(&circle(), Pose::at(0.0014, -0.0014, 1.0), undisturbed);
    println!("from 2 mm beside: {:.3} N", off.smallest);
    assert!(off.smallest > 0.9 && !off.is_slack);
}

#[test]
fn a_push_of_1_n_in_the_worst_of_12_directions_slackens_no_cable() {
    let orbit = circle();
    for begin in [1.2, 3.1, 4.0, 7.9] {
        let smallest = (0..12).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / 12.0).sin_cos();
            let push = |time: f64| {
                let acts = (begin..begin + 0.2).contains(&time);
                if acts { Vector3::new(cos, sin, 0.0) } else { Vector3::zeros() }
            };
            let run = follow(&orbit, orbit.centre, push);
            assert!(!run.is_slack && run.last.status == Status::AtGoal, "{begin} {k}");
            run.smallest
        });
        let worst = smallest.fold(f64::INFINITY, f64::min);
        println!("pushed at {begin} s: {worst:.3} N");
        assert!(worst > 0.0);
    }
}

#[test]
fn a_circle_that_is_too_large_is_refused_with_its_cable() {
    let large = Orbit { figure: Figure::Circle { radius: 1.2 }, ..circle() };
    let refused = proved(&large).unwrap_err().to_string();
    println!("{refused}");
    assert!(refused.starts_with("at full size: cable ") && refused.contains("would pull -"), "{refused}");
    let short = proved(&Orbit { start: 0.5, ..circle() }).unwrap_err().to_string();
    println!("{short}");
    assert!(short.starts_with("the start: cable "), "{short}");
    let longer = Orbit { start: 0.5, ..circle() }.with_shortest_start(&parameters(), STEP).unwrap();
    assert!(longer.start < 2.5 && proved(&longer).is_ok(), "{}", longer.start);
    let smaller = large.with_largest_radius(&parameters(), STEP).unwrap();
    println!("shortest start {:.2} s, largest radius {:.3} m", longer.start, smaller.figure.radius());
    assert!((0.4..1.2).contains(&smaller.figure.radius()) && proved(&smaller).is_ok());
}

#[test]
fn every_number_that_makes_no_sense_is_named() {
    let said = |orbit: Orbit| proved(&orbit).unwrap_err().to_string();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let figure = Figure::Circle { radius: bad };
        assert!(said(Orbit { figure, ..circle() }).contains(&format!("radius = {bad}")));
        assert!(said(Orbit { rate: bad, ..circle() }).contains(&format!("rate = {bad}")));
        assert!(said(Orbit { turns: bad, ..circle() }).contains(&format!("turns = {bad}")));
        assert!(said(Orbit { start: bad, ..circle() }).contains(&format!("start = {bad}")));
    }
    assert!(said(Orbit { start: 1e9, ..circle() }).contains("no longer than 40 turns"));
    let figure = Figure::Hypotrochoid { radius: 0.2, share: 0.1, lobes: 1 };
    assert!(said(Orbit { figure, ..circle() }).contains("lobes = 1"));
    let figure = Figure::Line { radius: 0.2, direction: f64::NAN };
    assert!(said(Orbit { figure, ..circle() }).contains("direction = NaN"));
    let late = circle().prove(&parameters(), &Coordinates::zeros(), 0.2).unwrap_err().to_string();
    assert!(late.contains("step = 0.2") && late.contains("at most 1.667e-1"), "{late}");
}

/// Eight cables share the load in many ways; the certificate shows one.
#[test]
fn eight_cables_have_orbits_too() {
    let RigFile { rig, home, .. } = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
    let parameters = ControllerParameters::of(&rig);
    let figure = Figure::Circle { radius: 0.4 * rig.radius() };
    let rate = Orbit::natural_rate(&rig, &home);
    let orbit = Orbit { centre: home, figure, rate, turns: 1.0, start: 2.0 * TAU / rate };
    match orbit.prove(&parameters, &Coordinates::zeros(), STEP) {
        Ok(proof) => println!("{:.3} {:.3} {:.3}", proof.least, proof.greatest, proof.longest_to_rest),
        Err(error) => println!("{error}"),
    }
}
