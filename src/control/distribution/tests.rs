use super::*;
use crate::robot::{Coordinates, Pose, RigFile};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const LIMITS: TensionLimits = TensionLimits { min: 1.0, max: 20.0 };

/// A random wrench matrix and a wrench that some tensions near the limits give.
fn random_case(rng: &mut Pcg64, cables: usize) -> (PerCable<Vector6<f64>>, Vector6<f64>) {
    let columns = PerCable::from_fn(cables, |_| Vector6::from_fn(|_, _| rng.random_range(-1.0..1.0)));
    let wrench = columns.iter().map(|column| column * rng.random_range(-6.0..27.0)).sum();
    (columns, wrench)
}

fn limits(cables: usize) -> PerCable<TensionLimits> {
    PerCable::filled(cables, LIMITS)
}

fn given(columns: &PerCable<Vector6<f64>>, tensions: &[f64]) -> Vector6<f64> {
    columns.iter().zip(tensions).map(|(column, u)| column * *u).sum()
}

fn margin(tensions: &[f64]) -> f64 {
    tensions.iter().map(|u| LIMITS.margin(*u)).fold(f64::INFINITY, f64::min)
}

fn eight() -> RigFile {
    RigFile::parse(include_str!("../../../rigs/eight.toml")).unwrap()
}

fn random_pose(rng: &mut Pcg64, home: &Pose, size: [f64; 6]) -> Pose {
    Pose(home.0 + Coordinates::from(size.map(|s| rng.random_range(-s..s))))
}

#[test]
fn tensions_are_found_wherever_there_are_any() {
    let mut rng = Pcg64::seed_from_u64(8);
    let (mut feasible, mut infeasible) = (0, 0);
    for case in 0..20_000 {
        let cables = 7 + case % 6;
        let (columns, wrench) = random_case(&mut rng, cables);
        let solutions = Solutions::new(&columns, &wrench, 1.0).unwrap();
        let widest = solutions.widest_margin(&limits(cables));
        let reference = PerCable::filled(cables, 10.0);
        match solutions.distribute(&limits(cables), &reference, 2.0) {
            Distribution::Feasible(tensions) => {
                feasible += 1;
                assert!(widest > -1e-9, "{case}: {widest}");
                assert!((given(&columns, &tensions) - wrench).norm() < 1e-9 * wrench.norm(), "{case}");
                assert!(margin(&tensions) > -1e-9, "{case}: {tensions:?}");
                assert!(widest < 2.0 || margin(&tensions) > 2.0 - 1e-3, "{case}: {widest} {tensions:?}");
            }
            Distribution::Infeasible { nearest, weights, shortfall } => {
                infeasible += 1;
                assert!(
                    widest < 1e-9 && shortfall > 0.0 && shortfall <= -widest + 1e-7,
                    "{case}: {widest} {shortfall} {weights:?}"
                );
                assert!((given(&columns, &nearest) - wrench).norm() < 1e-5, "{case}");
                shows_infeasible(&columns, &wrench, shortfall, &weights);
            }
        }
    }
    assert!(feasible > 500 && infeasible > 500, "{feasible} {infeasible}");
}

/// Checks that the weights c are Wᵀ y, and that yᵀ w is `shortfall` more than cᵀ u can be within the limits.
fn shows_infeasible(
    columns: &PerCable<Vector6<f64>>,
    wrench: &Vector6<f64>,
    shortfall: f64,
    weights: &[f64],
) {
    let matrix = DMatrix::from_fn(6, columns.len(), |k, i| columns[i][k]);
    let weights = DVector::from_column_slice(weights);
    let y = (&matrix * matrix.transpose()).lu().solve(&(&matrix * &weights)).unwrap();
    assert!((matrix.tr_mul(&y) - &weights).amax() < 1e-7 && (weights.lp_norm(1) - 1.0).abs() < 1e-9);
    let most: f64 = weights.iter().map(|c| (c * LIMITS.min).max(c * LIMITS.max)).sum();
    assert!((y.dot(&DVector::from_column_slice(wrench.as_slice())) - most - shortfall).abs() < 1e-6);
}

/// The greatest margin by looking at every vertex of the polyhedron in (u, s).
fn widest_by_vertices(columns: &PerCable<Vector6<f64>>, wrench: &Vector6<f64>) -> f64 {
    let cables = columns.len();
    let rows = 2 * cables;
    let free = cables - 6 + 1;
    let mut best = f64::NEG_INFINITY;
    let mut picked: Vec<usize> = (0..free).collect();
    loop {
        let matrix = DMatrix::from_fn(cables + 1, cables + 1, |k, i| match (k < 6, i == cables) {
            (true, true) => 0.0,
            (true, false) => columns[i][k],
            (false, true) => 1.0,
            (false, false) => {
                let (cable, sign) = (picked[k - 6] % cables, if picked[k - 6] < cables { -1.0 } else { 1.0 });
                if i == cable { sign } else { 0.0 }
            }
        });
        let right = DVector::from_fn(cables + 1, |k, _| match k {
            0..6 => wrench[k],
            _ if picked[k - 6] < cables => -LIMITS.min,
            _ => LIMITS.max,
        });
        if let Some(x) = matrix.lu().solve(&right)
            && margin(&x.as_slice()[..cables]) >= x[cables] - 1e-9
        {
            best = best.max(x[cables]);
        }
        let Some(k) = (0..free).rev().find(|k| picked[*k] < rows - free + k) else { return best };
        picked[k] += 1;
        for j in k + 1..free {
            picked[j] = picked[j - 1] + 1;
        }
    }
}

#[test]
fn widest_margin_is_that_of_the_best_vertex() {
    let mut rng = Pcg64::seed_from_u64(9);
    for case in 0..200 {
        let cables = 7 + case % 2;
        let (columns, wrench) = random_case(&mut rng, cables);
        let expected = widest_by_vertices(&columns, &wrench);
        let found = Solutions::new(&columns, &wrench, 1.0).unwrap().widest_margin(&limits(cables));
        assert!((found - expected).abs() < 1e-8, "{case}: {found}, not {expected}");
    }
}

/// A quadratic programme without margin lies on a limit in 80 of these poses.
#[test]
fn the_margin_is_kept_wherever_it_can_be() {
    let RigFile { rig, home, .. } = eight();
    let mut rng = Pcg64::seed_from_u64(300);
    let mut able = 0;
    while able < 300 {
        let pose = random_pose(&mut rng, &home, [1.5, 1.0, 0.6, 0.2, 0.2, 0.2]);
        let columns = rig.cables_at(&pose).wrench_matrix();
        let wrench = rig.static_wrench();
        let solutions = Solutions::new(&columns, &wrench, rig.platform_radius()).unwrap();
        if solutions.widest_margin(&rig.limits()) < 20.0 {
            continue;
        }
        able += 1;
        let tensions = share(&rig, &columns, &wrench, 20.0).unwrap();
        for (u, limits) in tensions.iter().zip(rig.limits()) {
            assert!(limits.margin(*u) > 20.0 - 1e-3, "{tensions:?}");
        }
    }
}

#[test]
fn tensions_change_no_faster_than_the_lipschitz_bound() {
    let RigFile { rig, home, .. } = eight();
    let mut rng = Pcg64::seed_from_u64(12);
    let mut closest: f64 = 0.0;
    for _ in 0..300 {
        let columns =
            rig.cables_at(&random_pose(&mut rng, &home, [1.2, 0.8, 0.5, 0.2, 0.2, 0.2])).wrench_matrix();
        let bound = lipschitz(&columns, rig.platform_radius());
        let random = |rng: &mut Pcg64, size: f64| Vector6::from_fn(|_, _| rng.random_range(-size..size));
        let first = rig.static_wrench() + random(&mut rng, 100.0);
        let change = random(&mut rng, 1.0);
        let of = |wrench: &Vector6<f64>| share(&rig, &columns, wrench, 20.0).unwrap();
        let moved: f64 = of(&(first + change)).iter().zip(of(&first)).map(|(a, b)| (a - b).powi(2)).sum();
        let mut scaled = change;
        scaled.fixed_rows_mut::<3>(3).unscale_mut(rig.platform_radius());
        closest = closest.max(moved.sqrt() / (bound * scaled.norm()));
    }
    assert!(closest <= 1.0 && closest > 0.05, "{closest}");
}

#[test]
fn tensions_are_continuous_along_a_way_through_the_border() {
    let RigFile { rig, home, .. } = eight();
    // Out of the workspace: margins are given up, then limits.
    let far = Coordinates::new(2.5, 1.8, -0.5, 0.3, -0.2, 0.4);
    let of = |s: f64| {
        let pose = Pose(home.0 + far * s);
        share(&rig, &rig.cables_at(&pose).wrench_matrix(), &rig.static_wrench(), 20.0).unwrap()
    };
    let apart = |a: &PerCable<f64>, b: &PerCable<f64>| {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    for k in 0..2000 {
        let s = f64::from(k) / 2000.0;
        let (near, nearer) = (apart(&of(s), &of(s + 1e-4)), apart(&of(s), &of(s + 1e-7)));
        assert!(nearer < 0.02 * near.max(1e-1), "at {s}: {near} N, {nearer} N");
    }
}

#[test]
fn a_limit_of_its_own_and_none_at_all_are_kept() {
    let RigFile { mut rig, home, .. } = eight();
    rig.cables.iter_mut().for_each(|cable| cable.limits.max = f64::INFINITY);
    rig.cables[2].limits = TensionLimits { min: 60.0, max: 70.0 };
    let columns = rig.cables_at(&home).wrench_matrix();
    let tensions = share(&rig, &columns, &rig.static_wrench(), 1.0).unwrap();
    assert!((61.0 - 1e-3..69.0 + 1e-3).contains(&tensions[2]), "{tensions:?}");
    let solutions = Solutions::new(&columns, &rig.static_wrench(), rig.platform_radius()).unwrap();
    let with_huge = rig.limits().map(|l| TensionLimits { max: l.max.min(1e13), ..l });
    let (none, huge) = (solutions.widest_margin(&rig.limits()), solutions.widest_margin(&with_huge));
    assert!((none - huge).abs() < 1e-9 && none > 0.0, "{none} {huge}");
}

#[test]
fn cables_side_by_side_share_and_a_singular_matrix_is_refused() {
    let mut rng = Pcg64::seed_from_u64(3);
    let (six, wrench) = random_case(&mut rng, 6);
    let doubled = PerCable::from_fn(12, |i| six[i % 6]);
    let solutions = Solutions::new(&doubled, &wrench, 1.0).unwrap();
    let Distribution::Feasible(tensions) = solutions.distribute(
        &PerCable::filled(12, TensionLimits { min: -1e9, max: 1e9 }),
        &PerCable::filled(12, 5.0),
        0.0,
    ) else {
        panic!("not found")
    };
    for i in 0..6 {
        assert!((tensions[i] - tensions[i + 6]).abs() < 1e-9);
    }
    let mut flat = PerCable::from_fn(8, |i| six[i % 6]);
    flat.iter_mut().for_each(|column| column[4] = 2.0 * column[1]);
    assert!(Solutions::new(&flat, &wrench, 1.0).is_none());
}

#[test]
#[ignore = "prints times"]
fn how_long_it_takes() {
    let mut rng = Pcg64::seed_from_u64(5);
    for cables in [7, 8, 10, 12, 16] {
        let cases: Vec<_> = (0..2000).map(|_| random_case(&mut rng, cables)).collect();
        let start = std::time::Instant::now();
        let sum: f64 = cases
            .iter()
            .map(|(columns, wrench)| {
                Solutions::new(columns, wrench, 1.0).unwrap().widest_margin(&limits(cables))
            })
            .sum();
        println!("{cables}: widest margin {:?} {sum}", start.elapsed() / 2000);
    }
    let RigFile { rig, home, .. } = eight();
    let poses: Vec<_> =
        (0..2000).map(|_| random_pose(&mut rng, &home, [1.5, 1.0, 0.6, 0.2, 0.2, 0.2])).collect();
    let columns: Vec<_> = poses.iter().map(|pose| rig.cables_at(pose).wrench_matrix()).collect();
    let start = std::time::Instant::now();
    let sum: f64 =
        columns.iter().map(|columns| share(&rig, columns, &rig.static_wrench(), 20.0).unwrap()[0]).sum();
    println!("rigs/eight.toml: share {:?} {sum}", start.elapsed() / 2000);
    let start = std::time::Instant::now();
    let sum: f64 = columns
        .iter()
        .map(|columns| Solutions::new(columns, &rig.static_wrench(), 0.5).unwrap().least[0])
        .sum();
    println!("rigs/eight.toml: solutions {:?} {sum}", start.elapsed() / 2000);
}
