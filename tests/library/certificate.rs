//! The certificate against dense sampling, closed forms and the plant.

use cable_robot::control::{Gains, Reference, Response, lyapunov, tensions};
use cable_robot::reach::certificate::{Cause, Margins, Step, Verdict, certify, certify_with_margins};
use cable_robot::reach::in_static_workspace;
use cable_robot::robot::triangles::FACET_NORMALS;
use cable_robot::robot::{Coordinates, PerCable, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const TAUT: TensionLimits = TensionLimits { min: 0.0, max: 100.0 };

fn paper() -> Rig {
    Rig::paper(&RobotParameters::default(), TAUT)
}

/// The tensions along the closed form, by plain floating point arithmetic.
fn sampled(rig: &Rig, step: &Step, time: f64) -> Option<PerCable<f64>> {
    let response = Response::at(&step.gains, time);
    let error = step.start.minus(&step.set_point);
    let moved =
        |k: usize| response.motion(step.set_point.0[k] + error[k], step.rates[k], step.set_point.0[k]);
    let of = |derivative: usize| Coordinates::from_fn(|k, _| moved(k)[derivative]);
    tensions(rig, &Pose(of(0)), &of(1), &of(2), 0.0)
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
    let Verdict::Admissible { least, greatest, .. } = verdict else { panic!("{verdict:?}") };
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
    let rig = Rig::paper(&RobotParameters::default(), strong);
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
            Verdict::NoDistribution { .. } => panic!("of six cables"),
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
    for cable in rig.cables.iter_mut() {
        cable.anchor += jitter(0.15);
        cable.attachment += jitter(0.08) + offset;
    }
    rig.mass = rng.random_range(1.0..20.0);
    rig.inertia = Matrix3::from_diagonal(&Vector3::from_fn(|_, _| rng.random_range(0.01..0.3)));
    rig.with_limits(TensionLimits { min: rng.random_range(0.0..1.0), max: rng.random_range(50.0..300.0) })
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
            Verdict::Admissible { least, greatest, .. } => {
                admissible += 1;
                for t in times(&step.gains) {
                    let u = sampled(&rig, &step, t).unwrap();
                    let known = least - 1e-9..=greatest + 1e-9;
                    assert!(u.iter().all(|u| known.contains(u)), "case {case} at {t}: {u:?}");
                }
                assert!(least > rig.cables[0].limits.min && greatest < rig.cables[0].limits.max);
            }
            Verdict::NotAdmissible { cable, time, tension } => {
                refused += 1;
                let u = sampled(&rig, &step, time).unwrap()[cable - 1];
                assert!((u - tension).abs() < 1e-6 * (1.0 + u.abs()), "case {case}: {u} N, not {tension} N");
                assert!(
                    tension <= rig.cables[0].limits.min + 1e-9 || tension >= rig.cables[0].limits.max - 1e-9
                );
            }
            verdict @ Verdict::Undecided { .. } => {
                undecided += 1;
                println!("case {case}: {verdict:?}");
            }
            Verdict::NoDistribution { .. } => panic!("of six cables"),
        }
    }
    println!("{admissible} admissible, {refused} not, {undecided} undecided");
    assert!(admissible > 500 && refused > 500 && undecided <= 6);
}

#[test]
fn yaw_alone() {
    let turn = |from: f64, to: f64| {
        let pose = |yaw| Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, yaw));
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        Step { start: pose(from), rates: Coordinates::zeros(), set_point: pose(to), gains }
    };
    let rig = paper();
    // As far as every tension is positive when sampled, and no farther: to a ten-thousandth of a radian.
    let taut = |step: &Step| {
        times(&step.gains).all(|t| sampled(&rig, step, t).unwrap().iter().all(|u| *u > 0.0 && *u < 100.0))
    };
    let proved = |step: &Step| matches!(certify(&rig, step).unwrap(), Verdict::Admissible { .. });
    let farthest = |ok: &dyn Fn(&Step) -> bool| {
        let (mut low, mut high) = (0.0, 1.5);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if ok(&turn(0.0, middle)) { low = middle } else { high = middle }
        }
        low
    };
    let (by_samples, by_proof) = (farthest(&taut), farthest(&proved));
    println!("from rest the platform may be turned by {by_proof} rad, by samples {by_samples} rad");
    assert!(by_proof > 0.1 && (by_proof - by_samples).abs() < 1e-4);
    // The short way round.
    assert!(proved(&turn(0.05, 0.1 + std::f64::consts::TAU)));
}

#[test]
fn degenerate_rigs_and_motions_are_named_and_never_admissible() {
    let gains = Gains { lambda: 3.0, eta: 3.0 };
    let still =
        Step { start: Pose::default(), rates: Coordinates::zeros(), set_point: Pose::default(), gains };
    // Anchors in one line: no wrench about it.
    let mut collinear = paper();
    for (i, cable) in collinear.cables.iter_mut().enumerate() {
        cable.anchor = Vector3::new(0.1 * i as f64, 0.0, 0.0);
    }
    let mut parallel = paper();
    parallel.cables.iter_mut().for_each(|cable| cable.anchor = cable.attachment);
    let mut touching = paper();
    touching.cables[2].anchor = touching.cables[2].attachment + Vector3::new(0.0, 0.0, 1.0);
    for rig in [collinear, parallel, touching] {
        let verdict = certify(&rig, &still).unwrap();
        assert!(matches!(verdict, Verdict::Undecided { cause: Cause::Singular, .. }), "{verdict:?}");
    }
    // The paper's rig is singular when turned by a quarter.
    let mut quarter = still;
    quarter.set_point.0[5] = std::f64::consts::FRAC_PI_2;
    let verdict = certify(&paper(), &quarter).unwrap();
    assert!(matches!(verdict, Verdict::Undecided { cause: Cause::Singular, .. }), "{verdict:?}");
    // Through the singular pose there is a time before it when a tension has left its limits.
    quarter.set_point.0[5] = 2.8;
    let verdict = certify(&paper(), &quarter).unwrap();
    assert!(!matches!(verdict, Verdict::Admissible { .. }), "{verdict:?}");
    // Half a turn has no short way round.
    quarter.set_point.0[5] = std::f64::consts::PI;
    let verdict = certify(&paper(), &quarter).unwrap();
    assert!(matches!(verdict, Verdict::Undecided { cause: Cause::HalfTurn, .. }), "{verdict:?}");
    // A quarter turn of pitch, at which cables would hold the platform but the law loses the angles.
    let low = |pitch| Pose(Coordinates::new(0.048, 0.02, 10.4, 0.0, pitch, 0.0));
    let pitched = |pitch| Step { start: low(pitch - 0.01), set_point: low(pitch), ..still };
    let verdict = certify(&paper(), &pitched(1.58)).unwrap();
    assert!(matches!(verdict, Verdict::Undecided { cause: Cause::GimbalLock, .. }), "{verdict:?}");
    // Short of it the answer does not depend on margins being asked for, all of them zero.
    let verdict = certify(&paper(), &pitched(1.53)).unwrap();
    assert!(matches!(verdict, Verdict::Admissible { .. }), "{verdict:?}");
    assert_eq!(certify_with_margins(&paper(), &pitched(1.53), &Margins::default()).unwrap(), verdict);
    // Beside and above the base no cable holds the platform.
    for goal in [Pose::at(0.8, 0.0, 1.0), Pose::at(0.0, 0.0, -1.0)] {
        let verdict = certify(&paper(), &Step { set_point: goal, ..still }).unwrap();
        assert!(matches!(verdict, Verdict::NotAdmissible { .. }), "{verdict:?}");
    }
    let weightless = Rig { gravity: Vector3::zeros(), ..paper() };
    assert!(!matches!(certify(&weightless, &still).unwrap(), Verdict::Admissible { .. }));
}

#[test]
fn questions_that_make_no_sense_are_errors_that_name_the_number() {
    let gains = Gains { lambda: 3.0, eta: 3.0 };
    let still =
        Step { start: Pose::default(), rates: Coordinates::zeros(), set_point: Pose::default(), gains };
    let message = |rig: Rig, step: Step| certify(&rig, &step).unwrap_err().to_string();
    let crossed = paper().with_limits(TensionLimits { min: 10.0, max: 1.0 });
    assert!(message(crossed, still).contains("limits.max = 1 "), "which limit");
    assert!(message(Rig { mass: -1.0, ..paper() }, still).contains("mass = -1"));
    let five = Rig { cables: PerCable::from_slice(&paper().cables[..5]).unwrap(), ..paper() };
    assert!(message(five, still).contains("5 cables"));
    let mut lost = still;
    lost.rates[3] = f64::NAN;
    assert!(message(paper(), lost).contains("a rate of the start = NaN"));
    assert!(
        message(paper(), Step { gains: Gains { lambda: 0.0, eta: 1.0 }, ..still }).contains("lambda = 0")
    );
    let margins = Margins { mass: 1.0, ..Margins::default() };
    assert!(
        certify_with_margins(&paper(), &still, &margins)
            .unwrap_err()
            .to_string()
            .contains("margins.mass = 1")
    );
}

const PERIOD: f64 = 1e-3;

/// What the runs below are given, and what is certified.
const MARGINS: Margins = Margins {
    mass: 0.01,
    centre_of_mass: 3e-5,
    force: 0.05,
    torque: 0.001,
    friction: 0.001,
    law_margin: 0.0,
    accuracy: 3e-5,
    sample_period: PERIOD,
    delay: PERIOD,
};

/// The paper's rig with the inertia of a uniform disc.
fn disc() -> RobotParameters {
    RobotParameters { i1: 0.125, i2: 0.125, i3: 0.25, ..Default::default() }
}

fn random_vector(rng: &mut Pcg64, length: f64) -> Vector3<f64> {
    let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
    v.normalize() * length
}

/// A plant whose centre of mass lies `offset` from where the controller believes it, in the platform's frame.
struct Imperfect {
    plant: Plant,
    offset: Vector3<f64>,
}

impl Imperfect {
    fn new(rng: &mut Pcg64, start: &Pose, offset: Vector3<f64>) -> Self {
        let mut off = || 1.0 + rng.random_range(-1.0..=1.0) * MARGINS.mass;
        let RobotParameters { m, i1, i2, i3, .. } = disc();
        let robot =
            RobotParameters { m: m * off(), i1: i1 * off(), i2: i2 * off(), i3: i3 * off(), ..disc() };
        let mut initial_pose = *start;
        let centre = start.position() - start.rotation() * offset;
        initial_pose.0.fixed_rows_mut::<3>(0).copy_from(&centre);
        let mut rig = Rig::paper(&robot, TAUT);
        for cable in rig.cables.iter_mut() {
            cable.anchor += random_vector(rng, MARGINS.accuracy);
            cable.attachment += random_vector(rng, MARGINS.accuracy);
        }
        let parameters =
            PlantParameters { rig, initial_pose, friction: MARGINS.friction, ..Default::default() };
        Self { plant: Plant::new(parameters, &PlantInputs::none(6)).unwrap(), offset }
    }

    /// Pose and rates of the point that the controller takes for the centre of mass.
    fn state(&self) -> (Pose, Coordinates) {
        let seen = self.plant.outputs();
        let mut pose = seen.encoder_pose;
        let arm = pose.rotation() * self.offset;
        let mut rates = Coordinates::zeros();
        rates.fixed_rows_mut::<3>(0).copy_from(&(seen.velocity + seen.angular_velocity.cross(&arm)));
        rates
            .fixed_rows_mut::<3>(3)
            .copy_from(&(pose.rate_matrix().try_inverse().unwrap() * seen.angular_velocity));
        let point = pose.position() + arm;
        pose.0.fixed_rows_mut::<3>(0).copy_from(&point);
        (pose, rates)
    }
}

/// Least and greatest tension commanded or pulled on the way, and how far a command was from the closed form at most.
fn run(rng: &mut Pcg64, rig: &Rig, step: &Step, offset: Vector3<f64>) -> [f64; 3] {
    // The law believes in a disc.
    let believed = Rig { inertia: Rig::paper(&disc(), TAUT).inertia, ..*rig };
    let mut imperfect = Imperfect::new(rng, &step.start, offset);
    let mut told = (step.start, step.rates);
    let mut range = [f64::INFINITY, 0.0_f64, 0.0];
    let mut inputs = PlantInputs::none(6);
    for k in 0..1500 {
        if k % 300 == 0 {
            inputs.disturbance_force = random_vector(rng, MARGINS.force);
            inputs.disturbance_torque = random_vector(rng, MARGINS.torque);
        }
        let (pose, rates) = told;
        inputs.motor_tension = lyapunov::tension_command(
            &believed,
            &step.gains,
            &pose,
            &rates,
            &Reference::resting(&step.set_point),
            0.0,
        )
        .unwrap();
        told = imperfect.state(); // used one period later
        let closed_form = sampled(rig, step, f64::from(k) * PERIOD).unwrap();
        for (command, closed_form) in inputs.motor_tension.iter().zip(closed_form) {
            range[2] = range[2].max((command - closed_form).abs());
        }
        imperfect.plant.step(&inputs, PERIOD).unwrap();
        for u in inputs.motor_tension.into_iter().chain(imperfect.plant.outputs().measured_tension) {
            range = [range[0].min(u), range[1].max(u), range[2]];
        }
    }
    range
}

/// 300 accepted steps on plants with everything wrong at once that [`MARGINS`] allow.
#[test]
fn no_cable_leaves_the_certified_range_on_an_imperfect_plant() {
    let mut rng = Pcg64::seed_from_u64(42);
    let (mut accepted, mut admissible, mut used) = (0, 0, vec![]);
    while accepted < 300 {
        let mut step = random_step(&mut rng, 0.05);
        step.rates = Coordinates::zeros();
        step.gains = Gains { lambda: rng.random_range(2.0..5.0), eta: rng.random_range(2.0..5.0) };
        for k in 3..6 {
            step.start.0[k] *= 0.3;
            step.set_point.0[k] *= 0.3;
        }
        let mut rig = Rig::paper(&disc(), TAUT);
        let offset = random_vector(&mut rng, MARGINS.centre_of_mass);
        rig.cables.iter_mut().for_each(|cable| cable.attachment -= offset);
        let nominal = certify(&rig, &step).unwrap();
        admissible += usize::from(matches!(nominal, Verdict::Admissible { .. }));
        let Verdict::Admissible { least, greatest, .. } =
            certify_with_margins(&rig, &step, &MARGINS).unwrap()
        else {
            continue;
        };
        accepted += 1;
        let [low, high, departure] = run(&mut rng, &rig, &step, offset);
        assert!(
            low >= least && high <= greatest && low > 0.0,
            "{low} to {high} N, not {least} to {greatest} N"
        );
        let closed_form =
            times(&step.gains).flat_map(|t| sampled(&rig, &step, t).unwrap()).fold(f64::INFINITY, f64::min);
        used.push(departure / (closed_form - least));
    }
    used.sort_by(f64::total_cmp);
    println!(
        "{accepted} accepted of {admissible} admissible without margins; the commands left the closed form by {:.0} % (median) \
         and {:.0} % (at most) of what the margins take from the smallest tension",
        100.0 * used[used.len() / 2],
        100.0 * used[used.len() - 1]
    );
}

/// What docs/certificate.md says of Table I.
#[test]
fn margins_that_table_i_bears() {
    let none = Margins::default();
    let step = Step {
        start: Pose::default(),
        rates: Coordinates::zeros(),
        set_point: Pose::at(0.06, 0.03, 1.0),
        gains: Gains { lambda: 3.0, eta: 3.0 },
    };
    let borne = |robot: &RobotParameters, margins: Margins| {
        let verdict = certify_with_margins(&Rig::paper(robot, TAUT), &step, &margins).unwrap();
        println!("I = {}: {margins:?}: {verdict:?}", robot.i1);
        matches!(verdict, Verdict::Admissible { .. })
    };
    let light = RobotParameters::default();
    assert!(borne(&light, none));
    assert!(borne(&light, Margins { mass: 0.02, ..none }));
    assert!(borne(&light, Margins { force: 0.1, ..none }));
    assert!(borne(&light, Margins { sample_period: 1e-3, delay: 1e-3, ..none }));
    assert!(borne(&light, Margins { centre_of_mass: 3e-5, ..none }));
    assert!(borne(&light, Margins { friction: 2e-3, ..none }));
    assert!(!borne(&light, Margins { centre_of_mass: 1e-4, ..none }));
    assert!(borne(&disc(), Margins { centre_of_mass: 1e-4, ..none }));
    assert!(borne(&light, Margins { accuracy: 1e-5, ..none }));
    assert!(borne(&disc(), Margins { accuracy: 1e-4, ..none }));
    assert!(!borne(&disc(), Margins { accuracy: 1e-3, ..none }));
}

#[test]
fn numbers_of_any_size_get_an_answer() {
    let mut rng = Pcg64::seed_from_u64(44);
    let mut admissible = 0;
    for _ in 0..1000 {
        let mut any = |typical: f64| {
            let exponent = if rng.random_bool(0.05) { rng.random_range(-300.0..300.0) } else { 0.0 };
            typical * 10f64.powf(exponent)
        };
        let mut rig = paper();
        for cable in rig.cables.iter_mut() {
            cable.anchor.z = any(0.01);
            cable.attachment.x *= any(1.0);
        }
        (rig.mass, rig.gravity) = (any(6.0), Vector3::z() * any(9.81));
        rig.inertia = Matrix3::from_diagonal(&Vector3::new(any(0.1), any(0.1), any(0.2)));
        rig = rig.with_limits(TensionLimits { min: 0.0, max: any(f64::MAX) });
        let start = Pose(Coordinates::new(any(0.01), any(-0.01), any(1.0), any(0.01), any(0.01), any(0.01)));
        let rates = Coordinates::from_fn(|_, _| any(0.01));
        let set_point = Pose::at(any(0.02), any(-0.05), any(1.0));
        let step = Step { start, rates, set_point, gains: Gains { lambda: any(3.0), eta: any(4.0) } };
        let margins = Margins { mass: 0.001, force: any(0.01), delay: any(1e-4), ..Margins::default() };
        let _ = certify_with_margins(&rig, &step, &margins).unwrap();
        if let Verdict::Admissible { least, .. } = certify(&rig, &step).unwrap() {
            admissible += 1;
            for t in times(&step.gains) {
                // Plain floating point does not follow every such motion.
                let Some(u) = sampled(&rig, &step, t) else { continue };
                assert!(u.iter().all(|u| *u > 0.5 * least), "{u:?} at {t}: {rig:?} {step:?}");
            }
        }
    }
    println!("{admissible} admissible");
    assert!(admissible > 200);
}

/// Motions that turn away from a quarter turn of pitch, or from half a turn of yaw, were undecided: the sign of a rate was ignored.
#[test]
fn a_motion_that_turns_away_from_where_angles_are_lost_is_proved() {
    let gains = Gains { lambda: 1.0, eta: 1.0 };
    let pitched = |pitch: f64, rate: f64| Step {
        start: Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, pitch, 0.0)),
        rates: Coordinates::new(0.0, 0.0, 0.0, 0.0, rate, 0.0),
        set_point: Pose::default(),
        gains,
    };
    let cause = |step: &Step| match certify(&paper(), step).unwrap() {
        Verdict::Undecided { cause, .. } => Some(cause),
        _ => None,
    };
    // φ is at most 1/e: from 0.3 rad at 3.9 rad/s the pitch would pass a quarter turn.
    assert_eq!(cause(&pitched(0.3, 3.9)), Some(Cause::GimbalLock));
    assert_ne!(cause(&pitched(0.3, -3.9)), Some(Cause::GimbalLock));
}
