//! The certificate against dense sampling, closed forms and the plant.

use std::time::Instant;

use cable_robot::control::{Gains, Response};
use cable_robot::reach::certificate::{Cause, Step, Verdict, certify};
use cable_robot::reach::in_static_workspace;
use cable_robot::robot::geometry::FACET_NORMALS;
use cable_robot::robot::{
    Coordinates, Geometry, Pose, Rig, RobotParameters, TensionLimits, dynamics, tensions,
};
use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const TAUT: TensionLimits = TensionLimits { min: 0.0, max: 100.0 };

fn paper() -> Rig {
    Rig::triangular(&RobotParameters::default(), TAUT)
}

/// The tensions along the closed form, by plain floating point arithmetic.
fn sampled(rig: &Rig, step: &Step, time: f64) -> Option<[f64; 6]> {
    let geometry = Geometry {
        anchor: std::array::from_fn(|i| rig.anchors[i]),
        attachment: std::array::from_fn(|i| rig.attachments[i]),
    };
    let [i1, i2, i3] = rig.inertia.into();
    let robot = RobotParameters { m: rig.mass, i1, i2, i3, g: rig.g, ..Default::default() };
    let response = Response::at(&step.gains, time);
    let error = step.start.minus(&step.set_point);
    let moved = |k: usize| response.motion(step.set_point.0[k] + error[k], step.rates[k], step.set_point.0[k]);
    let of = |derivative: usize| Coordinates::from_fn(|k, _| moved(k)[derivative]);
    tensions(&robot, &geometry, &Pose(of(0)), &of(1), &of(2))
}

#[test]
fn the_move_of_section_vi_takes_one_step() {
    let step = Step {
        start: Pose::default(),
        rates: Coordinates::zeros(),
        set_point: Pose::at(0.15, 0.15, 1.0),
        gains: Gains { lambda: 3.0, eta: 3.0 },
    };
    let verdict = certify(&paper(), &step).unwrap();
    let Verdict::Admissible { least, greatest } = verdict else { panic!("{verdict:?}") };
    println!("{verdict:?}");
    assert!(least > 0.0 && least < 1.0501 && greatest < 25.0, "{verdict:?}");
}

/// A step of the paper's rig from rest at zero orientation.
fn level_step(rng: &mut Pcg64) -> Step {
    let robot = RobotParameters::default();
    let mut point = || loop {
        let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        if in_static_workspace(&robot, &point) {
            return point;
        }
    };
    let (from, to) = (point(), point());
    let gains = Gains { lambda: rng.random_range(1.0..10.0), eta: rng.random_range(1.0..10.0) };
    let (z0, z) = (rng.random_range(0.4..2.5), rng.random_range(0.4..2.5));
    let start = Pose::at(from.x, from.y, z0);
    Step { start, rates: Coordinates::zeros(), set_point: Pose::at(to.x, to.y, z), gains }
}

/// The least of (g - z'')(a/2 - n·P) - z n·P'' over time and cables, which is positive exactly where all cables are taut: from rest
/// A + B f + C f'', whose derivative vanishes where (B - C λη) φ = C (λ + η) φ': at one time at most.
fn least_of_the_closed_form(step: &Step) -> f64 {
    let robot = RobotParameters::default();
    let Gains { lambda, eta } = step.gains;
    let error = step.start.minus(&step.set_point);
    let of_step = |t: f64| Response::at(&step.gains, t).step_error();
    let mut least = f64::INFINITY;
    for normal in FACET_NORMALS {
        let along = |q: &Coordinates| normal.x * q[0] + normal.y * q[1];
        let (slack, moved) = (robot.a / 2.0 - along(&step.set_point.0), along(&error));
        let (z, dz) = (step.set_point.0[2], error[2]);
        // (g - dz f'')(slack - moved f) - (z + dz f) moved f'': the products f f'' cancel.
        let (a, b, c) = (robot.g * slack, -robot.g * moved, -dz * slack - z * moved);
        let value = |t: f64| {
            let [f, _, ddf] = of_step(t);
            a + b * f + c * ddf
        };
        least = least.min(a).min(value(0.0));
        // φ'/φ = f''/f' falls from infinity to -min(λ, η).
        let target = (b - c * lambda * eta) / (c * (lambda + eta));
        if c != 0.0 && target > -lambda.min(eta) {
            let (mut low, mut high) = (0.0, 60.0 / lambda.min(eta));
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                let [_, df, ddf] = of_step(middle);
                if ddf / df > target { low = middle } else { high = middle }
            }
            least = least.min(value(low));
        }
    }
    least
}

#[test]
fn agrees_with_the_closed_form_for_translations() {
    let strong = TensionLimits { min: 0.0, max: 1e6 };
    let rig = Rig::triangular(&RobotParameters::default(), strong);
    let mut rng = Pcg64::seed_from_u64(40);
    let (mut admissible, mut refused, mut undecided) = (0, 0, 0);
    for case in 0..10_000 {
        let step = level_step(&mut rng);
        let truth = least_of_the_closed_form(&step);
        match certify(&rig, &step).unwrap() {
            Verdict::Admissible { .. } => {
                admissible += 1;
                assert!(truth > 0.0, "case {case}: {truth} {step:?}");
            }
            Verdict::NotAdmissible { .. } => {
                refused += 1;
                assert!(truth <= 1e-12, "case {case}: {truth} {step:?}");
            }
            Verdict::Undecided { .. } => {
                undecided += 1;
                assert!(truth.abs() < 1e-9, "case {case}: {truth} {step:?}");
            }
        }
    }
    println!("{admissible} admissible, {refused} not, {undecided} undecided");
    assert!(admissible > 1000 && refused > 1000 && undecided <= 1);
}

/// A rig like the paper's with every number changed: ends of the cables out of their planes, centre of mass off.
fn random_rig(rng: &mut Pcg64) -> Rig {
    let mut rig = paper();
    let mut jitter = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
    let offset = jitter(0.03);
    for i in 0..6 {
        rig.anchors[i] += jitter(0.15);
        rig.attachments[i] += jitter(0.08) + offset;
    }
    rig.mass = rng.random_range(1.0..20.0);
    rig.inertia = Vector3::from_fn(|_, _| rng.random_range(0.01..0.3));
    rig.limits = TensionLimits { min: rng.random_range(0.0..1.0), max: rng.random_range(50.0..300.0) };
    rig
}

/// A step in all six coordinates from a moving start.
fn random_step(rng: &mut Pcg64, size: f64) -> Step {
    let mut pose = |size: f64| {
        let mut q = Coordinates::from_fn(|_, _| rng.random_range(-size..size));
        q[2] = 1.0 + 2.0 * q[2];
        Pose(q)
    };
    let (start, set_point) = (pose(size), pose(size));
    let rates = Coordinates::from_fn(|_, _| rng.random_range(-0.3..0.3)) * rng.random_range(0.0..1.0);
    let gains = Gains { lambda: rng.random_range(1.0..8.0), eta: rng.random_range(1.0..8.0) };
    Step { start, rates, set_point, gains }
}

/// Times at which a motion is sampled, ever coarser.
fn times(gains: &Gains) -> impl Iterator<Item = f64> + use<> {
    let scale = 20.0 / gains.lambda.min(gains.eta);
    (0..=1000).map(move |k| scale * (f64::from(k) / 1000.0).powi(2))
}

#[test]
fn any_rig_and_any_step_against_dense_sampling() {
    let mut rng = Pcg64::seed_from_u64(41);
    let (mut admissible, mut refused, mut undecided) = (0, 0, 0);
    for case in 0..6000 {
        let rig = random_rig(&mut rng);
        let size = rng.random_range(0.02..0.25);
        let step = random_step(&mut rng, size);
        match certify(&rig, &step).unwrap() {
            Verdict::Admissible { least, greatest } => {
                admissible += 1;
                for t in times(&step.gains) {
                    let u = sampled(&rig, &step, t).unwrap();
                    let known = least - 1e-9..=greatest + 1e-9;
                    assert!(u.iter().all(|u| known.contains(u)), "case {case} at {t}: {u:?}");
                }
                assert!(least > rig.limits.min && greatest < rig.limits.max);
            }
            Verdict::NotAdmissible { cable, time, tension } => {
                refused += 1;
                let u = sampled(&rig, &step, time).unwrap()[cable - 1];
                assert!((u - tension).abs() < 1e-6 * (1.0 + u.abs()), "case {case}: {u} N, not {tension} N");
                assert!(tension <= rig.limits.min + 1e-9 || tension >= rig.limits.max - 1e-9);
            }
            verdict @ Verdict::Undecided { .. } => {
                undecided += 1;
                println!("case {case}: {verdict:?}");
            }
        }
    }
    println!("{admissible} admissible, {refused} not, {undecided} undecided");
    assert!(admissible > 500 && refused > 500 && undecided <= 6);
}

#[test]
fn time_taken() {
    let mut rng = Pcg64::seed_from_u64(41);
    for level in [true, false] {
        let mut taken = [vec![], vec![]];
        for _ in 0..3000 {
            let (rig, step) = if level { (paper(), level_step(&mut rng)) } else { (random_rig(&mut rng), random_step(&mut rng, 0.1)) };
            let start = Instant::now();
            let verdict = certify(&rig, &step).unwrap();
            let us = start.elapsed().as_secs_f64() * 1e6;
            taken[usize::from(matches!(verdict, Verdict::Admissible { .. }))].push(us);
        }
        for (name, mut taken) in ["not", "admissible"].into_iter().zip(taken) {
            taken.sort_by(f64::total_cmp);
            println!("level {level} {name}: {} cases, median {} us, 99 % {} us max {}", taken.len(), taken[taken.len() / 2], taken[taken.len() * 99 / 100], taken[taken.len() - 1]);
        }
    }
}

#[test]
fn explore() {
    use cable_robot::reach::certificate::{Margins, certify_with_margins};
    let none = Margins::default();
    for (w, heavy) in [(3.0, false), (3.0, true), (5.0, false), (5.0, true)] {
        let mut rig = paper();
        if heavy {
            rig.inertia = Vector3::new(0.125, 0.125, 0.25);
        }
        let step = Step {
            start: Pose::default(),
            rates: Coordinates::zeros(),
            set_point: Pose::at(0.06, 0.03, 1.0),
            gains: Gains { lambda: w, eta: w },
        };
        println!("{w} {heavy} {:?}", certify(&rig, &step));
        for m in [
            Margins { mass: 0.02, ..none },
            Margins { centre_of_mass: 1e-4, ..none },
            Margins { force: 0.1, ..none },
            Margins { torque: 0.005, ..none },
            Margins { friction: 0.01, ..none },
            Margins { sample_period: 1e-3, ..none },
            Margins { delay: 1e-3, ..none },
            Margins { mass: 0.01, centre_of_mass: 1e-4, force: 0.05, torque: 0.002, friction: 0.005, sample_period: 1e-3, delay: 0.0 },
        ] {
            println!("{w} {:?}", m);
            println!("     {:?}", certify_with_margins(&rig, &step, &m));
        }
    }
}
