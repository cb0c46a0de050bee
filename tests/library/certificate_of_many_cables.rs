//! The certificate of rigs with more than six cables against linear programmes at many instants.

use cable_robot::control::{Gains, Response, static_margin};
use cable_robot::reach::certificate::{Cause, Margins, Step, Verdict, certify, certify_with_margins};
use cable_robot::reach::quadratic_program::minimise;
use cable_robot::robot::dynamics::required_wrench;
use cable_robot::robot::{Cable, Coordinates, PerCable, Pose, Rig, RigFile, RobotParameters, TensionLimits};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn eight() -> Rig {
    RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap().rig
}

/// How far from the limits the tensions can be kept (N), by plain arithmetic and a linear programme; below 0 where they cannot be kept.
fn margin(rig: &Rig, step: &Step, time: f64) -> f64 {
    let response = Response::at(&step.gains, time);
    let error = step.start.minus(&step.set_point);
    let moved =
        |k: usize| response.motion(step.set_point.0[k] + error[k], step.rates[k], step.set_point.0[k]);
    let of = |derivative: usize| Coordinates::from_fn(|k, _| moved(k)[derivative]);
    let pose = Pose(of(0));
    let wrench = required_wrench(rig, &pose, &of(1), &of(2));
    let columns = rig.cables_at(&pose).wrench_matrix();
    let matrix = DMatrix::from_fn(6, columns.len(), |k, i| columns[i][k]);
    let pseudo = matrix.clone().pseudo_inverse(1e-12).unwrap();
    let least = &pseudo * DVector::from_column_slice(wrench.as_slice());
    // In u = least + P v and the margin s, by clarabel: all numbers in units of the largest tension.
    let projection = DMatrix::identity(columns.len(), columns.len()) - pseudo * matrix;
    let unit = least.amax().max(rig.cables[0].limits.max);
    let side = |sign: f64, limit: fn(&TensionLimits) -> f64| {
        let rows = (0..columns.len()).map(|i| {
            let row: Vec<f64> = projection.row(i).iter().map(|p| sign * p).chain([1.0]).collect();
            (row, sign * (limit(&rig.cables[i].limits) - least[i]) / unit)
        });
        rows.collect::<Vec<_>>()
    };
    let (rows, bounds): (Vec<_>, Vec<_>) =
        side(-1.0, |limits| limits.min).into_iter().chain(side(1.0, |limits| limits.max)).unzip();
    let mut slope = vec![0.0; columns.len() + 1];
    slope[columns.len()] = -1.0;
    let mut curvature = vec![1e-12; columns.len() + 1];
    curvature[columns.len()] = 0.0;
    minimise(&curvature, &slope, &rows, &bounds).unwrap().unwrap().x[columns.len()] * unit
}

/// The bundled rig with every number changed.
fn random_rig(rng: &mut Pcg64) -> Rig {
    let mut rig = eight();
    let mut jitter = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
    for cable in rig.cables.iter_mut() {
        cable.anchor += jitter(0.2);
        cable.attachment += jitter(0.05);
    }
    rig.mass *= rng.random_range(0.5..1.5);
    rig.inertia = Matrix3::from_diagonal(&Vector3::from_fn(|_, _| rng.random_range(0.5..2.0)));
    rig.with_limits(TensionLimits { min: rng.random_range(0.0..10.0), max: rng.random_range(150.0..400.0) })
}

/// A step in all six coordinates from a moving start.
fn random_step(rng: &mut Pcg64) -> Step {
    let mut pose = || {
        let mut q = Coordinates::from_fn(|k, _| if k < 3 { 1.1 } else { 0.25 } * rng.random_range(-1.0..1.0));
        q[2] = 2.0 + 0.5 * q[2];
        Pose(q)
    };
    let (start, set_point) = (pose(), pose());
    let rates = Coordinates::from_fn(|_, _| rng.random_range(-0.3..0.3));
    let gains = Gains { lambda: rng.random_range(1.0..5.0), eta: rng.random_range(1.0..5.0) };
    Step { start, rates, set_point, gains }
}

fn times(gains: &Gains) -> impl Iterator<Item = f64> + use<> {
    let scale = 20.0 / gains.lambda.min(gains.eta);
    (0..=200).map(move |k| scale * (f64::from(k) / 200.0).powi(2))
}

/// Counts of a run of cases.
#[derive(Debug, Default)]
struct Count {
    admissible: usize,
    refused: usize,
    undecided: usize,
}

impl Count {
    /// Takes in a case and checks its verdict.
    fn check(&mut self, case: usize, rig: &Rig, step: &Step) {
        match certify(rig, step).unwrap() {
            Verdict::Admissible { least, greatest, .. } => {
                self.admissible += 1;
                assert!(
                    rig.cables[0].limits.min < least
                        && least <= greatest
                        && greatest < rig.cables[0].limits.max
                );
                for t in times(&step.gains) {
                    let margin = margin(rig, step, t);
                    assert!(margin > -1e-6, "case {case} at {t}: {margin}");
                }
            }
            Verdict::NoDistribution { time, shortfall, at_least, at_greatest } => {
                self.refused += 1;
                let lacking = -margin(rig, step, time);
                // Proved, so no more than the best tensions lack; and sharp.
                assert!(
                    lacking > 0.0 && (shortfall - lacking).abs() < 1e-4 * (1.0 + lacking),
                    "case {case}: {lacking} N, not {shortfall}"
                );
                assert!(
                    (1..=3).contains(&(at_least.len() + at_greatest.len())),
                    "{at_least:?} {at_greatest:?}"
                );
            }
            verdict => {
                self.undecided += 1;
                println!("case {case}: {verdict:?}");
            }
        }
    }
}

#[test]
fn eight_cables_against_a_linear_programme_at_many_instants() {
    let mut rng = Pcg64::seed_from_u64(80);
    let mut count = Count::default();
    for case in 0..300 {
        let rig = if case % 2 == 0 { eight() } else { random_rig(&mut rng) };
        count.check(case, &rig, &random_step(&mut rng));
    }
    println!("{count:?}");
    assert!(count.admissible > 50 && count.refused > 50 && count.undecided <= 1, "{count:?}");
}

fn still_at(pose: Pose) -> Step {
    let gains = Gains { lambda: 3.0, eta: 3.0 };
    Step { start: pose, rates: Coordinates::zeros(), set_point: pose, gains }
}

#[test]
fn at_rest_it_is_the_static_workspace() {
    let mut rng = Pcg64::seed_from_u64(81);
    let rig = eight();
    let mut holds = [0, 0];
    for _ in 0..1000 {
        let q = [2.2, 1.7, 0.9, 0.3, 0.3, 0.3].map(|size| rng.random_range(-size..size));
        let pose = Pose(Coordinates::from(q) + Coordinates::z() * 2.0);
        let margin = static_margin(&rig, &pose);
        let verdict = certify(&rig, &still_at(pose)).unwrap();
        match verdict {
            Verdict::Admissible { least, .. } => {
                holds[0] += 1;
                assert!(
                    margin > 0.0 && (least - rig.cables[0].limits.min - margin).abs() < 1e-3,
                    "{margin} {verdict:?}"
                );
            }
            Verdict::NoDistribution { shortfall, .. } => {
                holds[1] += 1;
                assert!((margin + shortfall).abs() < 1e-4 * (1.0 + shortfall), "{margin}, {verdict:?}");
            }
            _ => assert!(margin.abs() < 1e-5, "{margin}: {verdict:?}"),
        }
    }
    assert!(holds[0] > 200 && holds[1] > 200, "{holds:?}");
}

#[test]
fn two_cables_more_beside_others_take_nothing_away() {
    let mut rng = Pcg64::seed_from_u64(82);
    let limits = TensionLimits { min: 0.0, max: 100.0 };
    let six = Rig::paper(&RobotParameters::default(), limits);
    let eight = Rig { cables: PerCable::from_fn(8, |i| six.cables[[0, 1, 2, 3, 4, 5, 0, 3][i]]), ..six };
    let (mut admissible, mut refused) = (0, 0);
    for case in 0..1000 {
        let mut pose = || {
            let size = [0.2, 0.2, 0.3, 0.1, 0.1, 0.2];
            Pose(Coordinates::z() + Coordinates::from(size.map(|size| rng.random_range(-size..size))))
        };
        let (start, set_point) = (pose(), pose());
        let step = Step { start, set_point, ..still_at(start) };
        match (certify(&six, &step).unwrap(), certify(&eight, &step).unwrap()) {
            (Verdict::Admissible { .. }, Verdict::Admissible { .. }) => admissible += 1,
            (Verdict::NotAdmissible { cable, .. }, Verdict::NoDistribution { at_least, .. }) => {
                refused += 1;
                // Where one pulls, its neighbour may; where one would have to push, both would.
                if [1, 4].contains(&cable) {
                    assert!(
                        at_least.numbers().any(|c| [1, 4, 7, 8].contains(&c)),
                        "case {case}: {at_least:?}"
                    );
                }
            }
            verdicts => panic!("case {case}: {verdicts:?}"),
        }
    }
    println!("{admissible} admissible, {refused} not");
    assert!(admissible > 100 && refused > 100);
}

#[test]
fn the_farthest_step_is_that_of_the_samples() {
    let rig = eight();
    let start = Pose::at(0.0, 0.0, 2.0);
    let to = |along: &Coordinates, length: f64| Step {
        set_point: Pose(start.0 + along * length),
        ..still_at(start)
    };
    let mut rng = Pcg64::seed_from_u64(83);
    for _ in 0..12 {
        let along = Coordinates::from_fn(|k, _| if k < 3 { 1.0 } else { 0.3 } * rng.random_range(-1.0..1.0));
        let farthest = |ok: &dyn Fn(&Step) -> bool| {
            let (mut low, mut high) = (0.0, 4.0);
            for _ in 0..22 {
                let middle = 0.5 * (low + high);
                if ok(&to(&along, middle)) { low = middle } else { high = middle }
            }
            low
        };
        let sampled = |step: &Step| times(&step.gains).all(|t| margin(&rig, step, t) > 0.0);
        let proved = |step: &Step| matches!(certify(&rig, step).unwrap(), Verdict::Admissible { .. });
        let (by_samples, by_proof) = (farthest(&sampled), farthest(&proved));
        println!("{by_proof} {by_samples}");
        assert!(by_proof > 0.1 && by_proof < by_samples + 1e-5 && by_proof > by_samples - 1e-3);
    }
}

#[test]
fn what_makes_no_sense_and_what_cannot_be_told_is_named() {
    let rig = eight();
    let home = still_at(Pose::at(0.0, 0.0, 2.0));
    let message = |rig: &Rig| certify(rig, &home).unwrap_err().to_string();
    assert!(message(&rig.with_limits(TensionLimits { min: 10.0, max: 1.0 })).contains("limits.max = 1 "));
    let mut nan = rig;
    nan.cables[7].attachment.y = f64::NAN;
    assert!(message(&nan).contains("a coordinate of an attachment = NaN"));
    // No upper limit is no limit.
    let endless = rig.with_limits(TensionLimits { min: 5.0, max: f64::INFINITY });
    assert!(matches!(certify(&endless, &home).unwrap(), Verdict::Admissible { .. }));
    let aside = Step { set_point: Pose::at(0.0, 3.0, 2.0), ..home };
    assert!(matches!(certify(&endless, &aside).unwrap(), Verdict::NoDistribution { .. }));

    // Margins of 0 are no margins.
    let none = Margins::default();
    assert_eq!(certify_with_margins(&rig, &home, &none).unwrap(), certify(&rig, &home).unwrap());

    // Nothing holds the platform about the line of the anchors, or sideways where all cables are parallel.
    let mut collinear = rig;
    let on_a_line = |(i, cable): (usize, &mut Cable)| cable.anchor = Vector3::new(0.1 * i as f64, 0.0, 0.0);
    collinear.cables.iter_mut().enumerate().for_each(on_a_line);
    let mut parallel = rig;
    parallel.cables.iter_mut().for_each(|cable| cable.anchor = cable.attachment);
    for rig in [collinear, parallel] {
        let verdict = certify(&rig, &home).unwrap();
        assert!(matches!(verdict, Verdict::Undecided { cause: Cause::Singular, .. }), "{verdict:?}");
    }
    // The crossed cables let this platform turn far, but half a turn has no short way round.
    let turn = |yaw: f64| Step { set_point: Pose(home.set_point.0 + Coordinates::ith(5, yaw)), ..home };
    assert!(times(&home.gains).all(|t| margin(&rig, &turn(3.2), t) > 10.0));
    assert!(matches!(certify(&rig, &turn(3.2)).unwrap(), Verdict::Admissible { .. }));
    let verdict = certify(&rig, &turn(std::f64::consts::PI)).unwrap();
    assert!(matches!(verdict, Verdict::Undecided { cause: Cause::HalfTurn, .. }), "{verdict:?}");
    // On the way to 2.5 rad it passes a pose where the wrench matrix lacks rank.
    let verdict = certify(&rig, &turn(2.5)).unwrap();
    assert!(matches!(verdict, Verdict::Undecided { cause: Cause::Singular, .. }), "{verdict:?}");
    // At and above the posts, and without weight, the cables pull the wrong way.
    for goal in [Pose::at(0.0, 0.0, 0.0), Pose::at(0.0, 0.0, -1.0), Pose::at(0.0, 3.0, 2.0)] {
        let verdict = certify(&rig, &Step { set_point: goal, ..home }).unwrap();
        assert!(matches!(verdict, Verdict::NoDistribution { .. }), "{verdict:?}");
    }
    let verdict = certify(&Rig { gravity: Vector3::zeros(), ..rig }, &home).unwrap();
    assert!(matches!(verdict, Verdict::NoDistribution { .. }), "{verdict:?}");
}

#[test]
fn numbers_of_any_size_get_an_answer() {
    let mut rng = Pcg64::seed_from_u64(84);
    let mut admissible = 0;
    for _ in 0..300 {
        let mut any = |typical: f64| {
            let exponent = if rng.random_bool(0.05) { rng.random_range(-300.0..300.0) } else { 0.0 };
            typical * 10f64.powf(exponent)
        };
        let mut rig = eight();
        for cable in rig.cables.iter_mut() {
            cable.anchor.z = any(0.01);
            cable.attachment.x *= any(1.0);
        }
        (rig.mass, rig.gravity) = (any(30.0), Vector3::z() * any(9.81));
        rig.inertia = Matrix3::from_diagonal(&Vector3::new(any(1.0), any(1.0), any(2.0)));
        rig = rig.with_limits(TensionLimits { min: 0.0, max: any(400.0) });
        let start = Pose(Coordinates::new(any(0.01), any(-0.01), any(2.0), any(0.01), any(0.01), any(0.01)));
        let gains = Gains { lambda: any(3.0), eta: any(4.0) };
        let step = Step {
            start,
            rates: Coordinates::zeros(),
            set_point: Pose::at(any(0.2), any(-0.1), any(2.0)),
            gains,
        };
        if let Verdict::Admissible { least, .. } = certify(&rig, &step).unwrap() {
            admissible += 1;
            assert!(least > 0.0);
        }
    }
    println!("{admissible} admissible");
    assert!(admissible > 30);
}
