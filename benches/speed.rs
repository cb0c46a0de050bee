//! What is claimed about speed, all in one run so that the figures can be compared with each other: `cargo bench`.
//!
//! The two benches through FMI step the packed FMUs: `cargo fmu build` makes them.

use std::hint::black_box;
use std::path::PathBuf;

use cable_robot::control::lyapunov::tension_command;
use cable_robot::control::{Gains, Reference};
use cable_robot::plan::bisection::smallest_admissible;
use cable_robot::plan::linear_program::smallest_beta;
use cable_robot::plan::minimum_time::Line;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::reach::certificate::{Step, certify};
use cable_robot::reach::exact::NEVER_SLACK;
use cable_robot::reach::{BoundedDomain, ExactDomain};
use cable_robot::robot::{
    Coordinates, PerCable, Pose, Rig, RigFile, RobotParameters, TensionLimits, forward_kinematics,
};
use cable_robot::sim::{ClosedLoop, Moment, PlantParameters};
use cable_robot_import::{Fmu, Instance};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Vector2, Vector3};

const STEP: f64 = 1e-3;
/// Controller steps of a motion and of the rest after it, in the bench of each rig: 2 s.
const UNDER_WAY: usize = 2000;

/// Plant and controller at rest at the paper's start, each pulling what holds it there.
fn at_rest(goal: Pose) -> ClosedLoop {
    ClosedLoop::new(ControllerParameters::default(), PlantParameters::default(), goal).unwrap()
}

fn library_steps(c: &mut Criterion) {
    let ClosedLoop { mut controller, mut plant, .. } = at_rest(Pose::default());
    let Moment { controller_inputs: resting, plant_inputs: pull, .. } = *at_rest(Pose::default()).moment();
    let mut count = 0u32;
    c.bench_function("controller step, library", |b| {
        b.iter(|| {
            count += 1;
            controller.step(f64::from(count) * STEP, STEP, black_box(&resting));
        })
    });
    c.bench_function("plant step, library", |b| b.iter(|| plant.step(black_box(&pull), STEP).unwrap()));
}

fn packed(model: &str) -> Instance {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join(format!("target/fmu/fmi3/{model}.fmu"));
    let instance = Fmu::open(path).unwrap().instantiate(model, Box::new(|_| {})).unwrap();
    instance.enter_initialization(0.0, None).unwrap();
    instance.exit_initialization().unwrap();
    instance
}

fn fmi_steps(c: &mut Criterion) {
    for (name, model) in [("controller", "CableRobotController"), ("plant", "CableRobotPlant")] {
        let instance = packed(model);
        let mut count = 0u32;
        c.bench_function(&format!("{name} step, packed FMU (FMI 3)"), |b| {
            b.iter(|| {
                instance.do_step(f64::from(count) * STEP, STEP).unwrap();
                count += 1;
            })
        });
    }
}

fn kinematics(c: &mut Criterion) {
    let rig = RigFile::default().rig;
    let pose = Pose::at(0.001, 0.002, 1.001);
    let length = rig.cables_at(&pose).length;
    c.bench_function("forward kinematics, 2 mm from the guess", |b| {
        b.iter(|| forward_kinematics(&rig, black_box(&length), &Pose::default()).unwrap())
    });
}

fn decisions(c: &mut Criterion) {
    let domain = BoundedDomain::new(
        &RobotParameters::default(),
        &Gains { lambda: 3.0, eta: 3.0 },
        Vector2::zeros(),
        1.0,
    );
    let (x_prev, x_f) = (Vector2::zeros(), Vector2::new(0.15, 0.15));
    c.bench_function("planner decision, bisection N = 8", |b| {
        b.iter(|| smallest_admissible(8, |beta| domain.contains(black_box(&(x_f + (x_prev - x_f) * beta)))))
    });
    c.bench_function("planner decision, linear programme", |b| {
        b.iter(|| smallest_beta(black_box(&domain), &x_prev, &x_f).unwrap())
    });
    c.bench_function("bounded test", |b| b.iter(|| domain.contains(black_box(&x_f))));
}

fn exact(c: &mut Criterion) {
    let gains = Gains { lambda: 5.0, eta: 5.0 };
    let (from, goal) = (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.15, 0.15, 0.9));
    let domain =
        |velocity| ExactDomain::new(&RobotParameters::default(), &gains, NEVER_SLACK, from, velocity);
    let (at_rest, moving) = (domain(Vector3::zeros()), domain(Vector3::new(0.1, -0.05, 0.02)));
    c.bench_function("exact test from rest", |b| b.iter(|| at_rest.contains(black_box(&goal))));
    c.bench_function("exact test from a velocity", |b| b.iter(|| moving.contains(black_box(&goal))));
    c.bench_function("exact ray from rest", |b| b.iter(|| at_rest.ray(black_box(&(goal - from)))));
    let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
    let step = |set_point| Step { start: Pose::default(), rates: Coordinates::zeros(), set_point, gains };
    let near = step(Pose(Coordinates::new(0.05, 0.02, 0.95, 0.02, 0.0, 0.05)));
    let far = step(Pose::at(0.3, 0.0, 1.0));
    c.bench_function("certificate, admissible step", |b| b.iter(|| certify(&rig, black_box(&near)).unwrap()));
    c.bench_function("certificate, refused step", |b| b.iter(|| certify(&rig, black_box(&far)).unwrap()));
    let eight = RigFile::parse(include_str!("../rigs/eight.toml")).unwrap().rig;
    let start = Pose::at(0.0, 0.0, 2.0);
    let near = Step { start, ..step(Pose(Coordinates::new(0.5, 0.3, 1.8, 0.0, 0.1, 0.2))) };
    let far = Step { start, ..step(Pose::at(1.8, 1.4, 1.0)) };
    for (name, step) in [("admissible", near), ("refused", far)] {
        c.bench_function(&format!("certificate of eight cables, {name} step"), |b| {
            b.iter(|| certify(&eight, black_box(&step)).unwrap())
        });
    }
    c.bench_function("exact farthest from a velocity", |b| {
        b.iter(|| moving.farthest(&from, black_box(&goal)))
    });
}

/// Rigs of six cables that are the paper's and are not, of eight and of twelve, and a pose a little off their homes.
fn rigs() -> [(&'static str, Rig, Pose); 4] {
    let RigFile { rig: paper, home, .. } = RigFile::default();
    let mut six = paper;
    six.cables.iter_mut().enumerate().for_each(|(i, cable)| cable.anchor.z += 0.01 * i as f64);
    let RigFile { rig: eight, home: of_eight, .. } =
        RigFile::parse(include_str!("../rigs/eight.toml")).unwrap();
    let mut cables: Vec<_> = eight.cables.iter().copied().collect();
    for i in 0..4 {
        let mut cable = eight.cables[i];
        cable.anchor *= 0.8;
        cables.push(cable);
    }
    let twelve = Rig { cables: PerCable::from_slice(&cables).unwrap(), ..eight };
    [
        ("the paper's rig", paper, home),
        ("six cables", six, home),
        ("eight cables", eight, of_eight),
        ("twelve cables", twelve, of_eight),
    ]
}

/// Of each the law, the plant, a decision of `Exact`, and its controller's steps from home to another pose, with what it measured in closed loop.
fn any_rig(c: &mut Criterion) {
    for (name, rig, home) in rigs() {
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        let size = rig.radius();
        let by = Coordinates::new(0.1 * size, 0.05 * size, 0.02 * size, 0.0, 0.0, 0.05);
        let (at, rates) = (Pose(home.0 + by), Coordinates::repeat(0.05));
        let margin = 0.0017 * rig.weight();
        c.bench_function(&format!("law, {name}"), |b| {
            b.iter(|| {
                tension_command(&rig, &gains, black_box(&at), &rates, &Reference::resting(&home), margin)
                    .unwrap()
            })
        });
        let parameters =
            ControllerParameters { planner: PlannerKind::Exact, ..ControllerParameters::of(&rig) };
        let planner = Planner::from(parameters);
        c.bench_function(&format!("decision, {name}"), |b| {
            b.iter(|| planner.next_from_rest(black_box(&home), &at))
        });
        let plant = PlantParameters { rig, initial_pose: home, ..Default::default() };
        let mut joined = ClosedLoop::new(parameters, plant, at).unwrap();
        let start = joined.controller.clone();
        let seen: Vec<_> = (0..UNDER_WAY)
            .map(|_| {
                joined.step(STEP).unwrap();
                let Moment { time, controller_inputs, .. } = *joined.moment();
                (time, controller_inputs)
            })
            .collect();
        let (mut moving, pull) = (joined.plant.clone(), joined.moment().plant_inputs);
        c.bench_function(&format!("plant step, {name}"), |b| {
            b.iter(|| moving.step(black_box(&pull), STEP).unwrap())
        });
        c.bench_function(&format!("{UNDER_WAY} controller steps, Exact, {name}"), |b| {
            b.iter(|| {
                let mut controller = start.clone();
                seen.iter().for_each(|(time, inputs)| controller.step(*time, STEP, black_box(inputs)));
                controller
            })
        });
    }
}

/// A line in closed form, and ways that are timed on a grid and proved.
fn minimum_time(c: &mut Criterion) {
    let limits = TensionLimits { min: 0.5, max: 40.0 };
    let (start, end) = (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.15, 0.15, 1.0));
    let line = Line::new(&RobotParameters::default(), limits, &start, &end);
    let whole = line.fastest(0.0, f64::INFINITY).unwrap();
    let [s, v, _] = whole.at(0.4 * whole.duration);
    c.bench_function("minimum time: a line", |b| b.iter(|| black_box(&line).fastest(0.0, f64::INFINITY)));
    c.bench_function("minimum time: a stop on it", |b| b.iter(|| black_box(&line).stop(s, v)));
    again_on_the_way(c);
    for (name, rig, home) in rigs().into_iter().filter(|(_, rig, _)| rig.cables.len() <= 8) {
        let by = Coordinates::new(0.1, 0.05, 0.02, 0.0, 0.0, 0.0) * rig.radius();
        let goal = Pose(home.0 + by + Coordinates::new(0.0, 0.0, 0.0, 0.05, 0.0, 0.1));
        let parameters =
            ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&rig) };
        let planner = Planner::from(parameters);
        assert!(planner.course_from_rest(&home, &goal).is_some());
        c.bench_function(&format!("minimum time: a turned way, {name}"), |b| {
            b.iter(|| planner.course_from_rest(black_box(&home), &goal))
        });
    }
}

/// A new goal on the way to another: on to it without a stop, on the paper's robot, level and turned.
fn again_on_the_way(c: &mut Criterion) {
    let rig = Rig::paper(&RobotParameters::default(), TensionLimits::default());
    let parameters =
        ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&rig) };
    let planner = Planner::from(parameters);
    let start = Pose::at(0.0, 0.0, 1.0);
    for (name, turn) in [("level", 0.0), ("turned", 0.1)] {
        let by = Coordinates::new(0.0, 0.0, 0.0, 0.0, 0.0, turn);
        let (goal, next) = (Pose(Pose::at(0.15, 0.15, 1.0).0 + by), Pose(Pose::at(-0.1, 0.1, 1.05).0 - by));
        let course = planner.course_from_rest(&start, &goal).unwrap();
        let begin = 0.4 * course.end();
        assert!(planner.course_from(&course, begin, &next).is_some());
        c.bench_function(&format!("minimum time: again on the way, {name}"), |b| {
            b.iter(|| planner.course_from(black_box(&course), begin, &next))
        });
    }
}

/// Throughput in elements a second is simulated milliseconds a second.
fn closed_loop(c: &mut Criterion) {
    let mut group = c.benchmark_group("closed loop, library");
    group.throughput(Throughput::Elements(1000)).sample_size(20);
    group.bench_function("one simulated second of the paper's manoeuvre at 1 kHz", |b| {
        b.iter(|| {
            let mut joined = at_rest(Pose::at(0.15, 0.15, 1.0));
            for _ in 0..1000 {
                joined.step(STEP).unwrap();
            }
            joined.moment().plant
        })
    });
    group.finish();
}

criterion_group!(
    benches,
    library_steps,
    fmi_steps,
    kinematics,
    decisions,
    exact,
    any_rig,
    minimum_time,
    closed_loop
);
criterion_main!(benches);
