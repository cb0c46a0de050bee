//! Orbits outside the static workspace: proofs against dense samples, the closed form against proofs, and the
//! law that follows them.

use std::f64::consts::TAU;
use std::ops::Range;

use cable_robot::control::distribution::widest_margin;
use cable_robot::control::{static_margin, static_tensions, swing, tensions};
use cable_robot::plan::orbit::{Figure, Follower, Orbit, OrbitError, Part, Proof, Trajectory, reach_of_p};
use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, PoseSource, Status};
use cable_robot::reach::Verdict;
use cable_robot::robot::dynamics::required_wrench;
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RigFile};
use cable_robot::sim::{ClosedLoop, Plant, PlantInputs, PlantParameters};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const STEP: f64 = 1e-3;
const NEVER: Range<f64> = f64::INFINITY..f64::INFINITY;

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
                assert!(proof.least >= proof.kept && proof.greatest <= 100.0 - proof.kept, "{proof:?}");
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
    /// From the motion, m.
    farthest: f64,
    is_slack: bool,
    last: ControllerOutputs,
    /// Where the motion ends, and three seconds later.
    arrival: Pose,
    end: Pose,
}

/// The loop from rest at a pose, with the ideal plant of Table I.
fn started(orbit: &Orbit, from: Pose) -> ClosedLoop<Follower> {
    let rig = parameters().rig;
    started_with(orbit, &parameters(), PlantParameters { rig, initial_pose: from, ..Default::default() })
}

fn started_with(
    orbit: &Orbit,
    parameters: &ControllerParameters,
    plant: PlantParameters,
) -> ClosedLoop<Follower> {
    let (from, cables) = (plant.initial_pose, plant.rig.cables.len());
    let plant = Plant::new(plant, &PlantInputs::none(cables)).unwrap();
    let seen = ControllerInputs {
        encoder_pose: from,
        cable_length: plant.outputs().cable_length,
        measured_tension: plant.outputs().measured_tension,
        goal_pose: from,
        enable: true,
    };
    let follower = Follower::new(orbit, parameters, (0.0, STEP), &seen).unwrap();
    ClosedLoop::with_models(follower, plant, from, &PlantInputs::none(cables)).unwrap()
}

/// Pushed, and blind for some time (s): three seconds longer than `motion` takes.
fn follow(closed: &mut ClosedLoop<Follower>, push: impl Fn(f64) -> Vector3<f64>, blind: Range<f64>) -> Run {
    let proof = closed.controller.proof().clone();
    let motion = proof.stopped(blind.start.min(proof.trajectory.end()));
    let moment = *closed.moment();
    let mut run = Run {
        smallest: f64::INFINITY,
        farthest: 0.0,
        is_slack: false,
        last: moment.controller,
        arrival: moment.plant.encoder_pose,
        end: moment.plant.encoder_pose,
    };
    for _ in 0..((motion.end() + 3.0) / STEP) as u32 {
        let time = closed.moment().time;
        closed.disturbance_force = push(time);
        let see = |inputs: &mut ControllerInputs| {
            if blind.contains(&time) {
                inputs.encoder_pose.0.fill(f64::NAN);
            }
        };
        let moment = *closed.step_seeing(STEP, see).unwrap();
        let led = motion.at(moment.time);
        run.smallest = moment.plant.measured_tension.iter().copied().fold(run.smallest, f64::min);
        run.farthest = run.farthest.max((moment.plant.encoder_pose.position() - led.pose.position()).norm());
        run.is_slack |= moment.plant.slack.iter().any(|slack| *slack);
        if moment.time <= motion.end() {
            run.arrival = moment.plant.encoder_pose;
        }
        (run.last, run.end) = (moment.controller, moment.plant.encoder_pose);
    }
    run
}

fn from_the_centre(orbit: &Orbit, push: impl Fn(f64) -> Vector3<f64>) -> Run {
    follow(&mut started(orbit, orbit.centre), push, NEVER)
}

fn undisturbed(_: f64) -> Vector3<f64> {
    Vector3::zeros()
}

#[test]
fn a_circle_of_0_4_m_keeps_0_9_n_where_rest_would_need_a_cable_that_pushes() {
    let out = static_tensions(&parameters().rig, &Pose::at(0.0, 0.4, 1.0), 0.0).unwrap();
    let least = out.into_iter().fold(f64::INFINITY, f64::min);
    let run = from_the_centre(&circle(), undisturbed);
    println!("at rest {least:.3} N; on the circle {:.3} N, {:.3} µm off", run.smallest, 1e6 * run.farthest);
    assert!(least < -8.0 && run.smallest > 0.9 && run.farthest < 3e-4, "{least} {}", run.smallest);
    assert_eq!(run.last.status, Status::AtGoal);
    assert!(run.end.minus(&Pose::at(0.0, 0.0, 1.0)).amax() < 1e-4);
    let beside = Pose::at(0.0014, -0.0014, 1.0);
    let off = follow(&mut started(&circle(), beside), undisturbed, NEVER);
    println!("from 2 mm beside: {:.3} N", off.smallest);
    assert!(off.smallest > 0.9 && !off.is_slack);
}

#[test]
fn a_push_of_1_n_in_the_worst_of_12_directions_slackens_no_cable() {
    let orbit = circle();
    for begin in [1.0, 4.0, 8.25] {
        let smallest = (0..12).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / 12.0).sin_cos();
            let push = |time: f64| {
                let acts = (begin..begin + 0.2).contains(&time);
                if acts { Vector3::new(cos, sin, 0.0) } else { Vector3::zeros() }
            };
            let run = from_the_centre(&orbit, push);
            assert!(!run.is_slack && run.last.status == Status::AtGoal, "{begin} {k}");
            run.smallest
        });
        let worst = smallest.fold(f64::INFINITY, f64::min);
        println!("pushed at {begin} s: {worst:.3} N");
        assert!(worst > 0.0);
    }
}

/// What is not in the proof: rigs that are not perfect.
#[test]
fn imperfect_rigs_go_round_outside_as_well() {
    let table_i = parameters();
    let plant = PlantParameters { rig: table_i.rig, ..Default::default() };
    let late = ControllerParameters { command_delay: STEP, ..table_i };
    let measured = ControllerParameters { force_loop: true, ..table_i };
    let of_lengths = ControllerParameters { pose_source: PoseSource::CableLengths, ..table_i };
    for (name, parameters, plant) in [
        ("commands a step late, told", late, plant),
        ("motors that lag by 5 ms", table_i, PlantParameters { motor_lag: 0.005, ..plant }),
        (
            "pose from cable lengths, to 0.01 mm",
            of_lengths,
            PlantParameters { encoder_resolution: 1e-5, ..plant },
        ),
        ("friction 0.2 N, force loop", measured, PlantParameters { friction: 0.2, ..plant }),
        ("friction 0.2 N", table_i, PlantParameters { friction: 0.2, ..plant }),
    ] {
        let mut closed = started_with(&circle(), &parameters, plant);
        closed.is_late = parameters.command_delay > 0.0;
        let run = follow(&mut closed, undisturbed, NEVER);
        println!("{name}: smallest tension {:.3} N, {:.2} mm off", run.smallest, 1e3 * run.farthest);
        assert!(!run.is_slack && run.smallest > 0.9, "{name}");
    }
}

#[test]
fn an_orbit_begins_in_its_centre_and_holds_no_command_longer_than_was_proved() {
    let seen = |pose: Pose| ControllerInputs {
        encoder_pose: pose,
        cable_length: PerCable::filled(6, 1.0),
        measured_tension: PerCable::filled(6, 1.0),
        goal_pose: pose,
        enable: true,
    };
    let begun = |pose: Pose| Follower::new(&circle(), &parameters(), (0.0, STEP), &seen(pose));
    let away = begun(Pose::at(0.003, 0.0, 1.0)).unwrap_err().to_string();
    assert!(away.contains("encoderPose = 0.003") && away.contains("within 0.002 m"), "{away}");
    let turned = begun(Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.02))).unwrap_err().to_string();
    assert!(turned.contains("encoderPose = 0.02") && turned.contains("within 0.01 rad"), "{turned}");
    assert!(begun(Pose::at(f64::NAN, 0.0, 1.0)).is_err());
    let longer = begun(Pose::at(0.0, 0.0, 1.0)).unwrap().check_step(2.0 * STEP).unwrap_err().to_string();
    assert!(longer.contains("step = 0.002"), "{longer}");
}

/// How a platform that is a little off leaves the motion under its tensions, at a time (s) of the circle: the
/// greatest κ, 1/s².
fn kappa(time: f64) -> f64 {
    let (rig, trajectory) = (parameters().rig, circle().trajectory());
    swing(&rig, &trajectory.at(time).pose, &tensions_at(&rig, &trajectory, time))[1]
}

/// A pose that is lost: the spiral into the centre, without one.
#[test]
fn a_lost_pose_ends_in_the_proved_spiral_into_the_centre() {
    println!(
        "κ of x'' = κ x under held tensions, 1/s²: {:.1} in the centre, {:.1} on the circle",
        kappa(0.0),
        kappa(4.0)
    );
    for (from, until) in [0.3, 1.0, 1.9, 3.0, 4.4, 8.2]
        .into_iter()
        .flat_map(|from| [(from, from + 0.1), (from, f64::INFINITY)])
    {
        let mut closed = started(&circle(), circle().centre);
        let run = follow(&mut closed, undisturbed, from..until);
        let proof = closed.controller.proof();
        let off = run.arrival.minus(&circle().centre);
        let [away, turned] = [0, 3].map(|k| 1e3 * off.fixed_rows::<3>(k).norm());
        println!(
            "blind from {from} to {until:.1} s: in the centre {:.3} s later, {away:.3} mm and {turned:.2} mrad off; smallest tension {:.3} N",
            proof.stopped(from).end() - from,
            run.smallest
        );
        assert!(run.last.status == Status::SensorFault && !run.is_slack && run.smallest > proof.least);
        let is_seen_again = until.is_finite();
        assert!(
            away < if is_seen_again { 0.01 } else { 5.0 } && (turned < 0.1 || !is_seen_again),
            "{from} {until}"
        );
    }
}

/// The drives hold their cables, as with brakes: cables of fixed lengths, as springs that pull only; or pull
/// with nothing.
#[test]
fn what_happens_when_the_drives_go_off() {
    const FINE: f64 = 1e-4;
    let mut closed = started(&circle(), circle().centre);
    while closed.moment().time < 4.0 {
        closed.step(STEP).unwrap();
    }
    let held = closed.moment().plant.cable_length;
    let (mut braked, mut free) = (closed.plant.clone(), closed.plant);
    let (mut slack, mut greatest, mut before) = (PerCable::filled(6, 0.0), 0.0_f64, held);
    let mut path = vec![];
    for _ in 0..100_000 {
        let now = braked.outputs().cable_length;
        let pull = PerCable::from_fn(6, |i| {
            (5e4 * (now[i] - held[i]) + 50.0 * (now[i] - before[i]) / FINE).max(0.0)
        });
        before = now;
        let inputs = PlantInputs { motor_tension: pull, ..PlantInputs::none(6) };
        braked.step(&inputs, FINE).unwrap();
        greatest = pull.iter().copied().fold(greatest, f64::max);
        (0..6).for_each(|i| slack[i] += if pull[i] > 0.0 { 0.0 } else { FINE });
        path.push(braked.outputs().encoder_pose);
    }
    let away = |pose: &Pose| pose.position().xy().norm();
    let turned = path.iter().map(|pose| pose.0.fixed_rows::<3>(3).amax()).fold(0.0, f64::max);
    let [nearest, farthest] = [f64::min, f64::max].map(|pick| path.iter().map(away).reduce(pick).unwrap());
    println!(
        "brakes at {:.3} m: in 10 s it swings between {nearest:.3} and {farthest:.3} m from the middle, turned by up to {turned:.2} rad,\n\
         cables slack for {:.1?} s, greatest tension {greatest:.0} N",
        away(&path[0]),
        &slack[..]
    );
    assert!(farthest < 0.42 && turned > 0.2 && slack.iter().all(|time| *time > 0.5));
    let before = free.outputs().encoder_pose;
    for _ in 0..300 {
        free.step(&PlantInputs::none(6), STEP).unwrap();
    }
    let moved = free.outputs().encoder_pose.minus(&before);
    println!("no torque: 0.3 s later it has fallen {:.2} m and flown {:.2} m", moved[2], moved.xy().norm());
    assert!((moved[2] - 0.5 * 9.81 * 0.09).abs() < 1e-3 && (moved.xy().norm() - 1.1 * 0.3).abs() < 1e-2);
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
    assert!(late.contains("step = 0.2") && late.contains("from 0 to 1.667e-1"), "{late}");
}

/// Eight cables share the load in many ways; the certificate shows one, and where there is none it names the
/// cables.
#[test]
fn eight_cables_have_orbits_too() {
    let RigFile { rig, home, .. } = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
    let parameters = ControllerParameters::of(&rig);
    let rate = Orbit::natural_rate(&rig, &home);
    let of_radius = |radius: f64| {
        let figure = Figure::Circle { radius };
        let orbit = Orbit { centre: home, figure, rate, turns: 1.0, start: 4.0 * TAU / rate };
        (orbit, orbit.prove(&parameters, &Coordinates::zeros(), STEP))
    };
    let (orbit, proof) = of_radius(2.5);
    let proof = proof.unwrap();
    let times = (0..400).map(|k| proof.trajectory.end() * f64::from(k) / 399.0);
    let [mut at_rest, mut moving] = [f64::INFINITY; 2];
    for time in times {
        let led = proof.trajectory.at(time);
        let wrench = required_wrench(&rig, &led.pose, &led.rates, &led.accelerations);
        let columns = rig.cables_at(&led.pose).wrench_matrix();
        moving = moving.min(widest_margin(&rig, &columns, &wrench));
        at_rest = at_rest.min(static_margin(&rig, &led.pose));
    }
    println!(
        "{} cables, {:.1} m: margin at rest {at_rest:.1} N, in motion {moving:.2} N",
        8,
        orbit.figure.radius()
    );
    assert!(at_rest < -10.0 && moving >= proof.kept);
    let plant = PlantParameters { rig, initial_pose: home, ..Default::default() };
    let run = follow(&mut started_with(&orbit, &parameters, plant), undisturbed, NEVER);
    println!("in a loop: smallest tension {:.3} N, {:.3} mm off", run.smallest, 1e3 * run.farthest);
    assert!(run.last.status == Status::AtGoal && !run.is_slack && run.farthest < 1e-3);
    assert!(run.smallest >= rig.common_limits().min);
    let refused = of_radius(3.5).1.unwrap_err().to_string();
    println!("{refused}");
    assert!(refused.contains("no tensions keep the limits") && refused.contains("; cable"), "{refused}");
}
