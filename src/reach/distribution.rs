//! How six or more cables may share a wrench: W u = w with u_min ≤ u ≤ u_max.
//!
//! All solutions of W u = w are u = u₀ + N z, where N spans the null space of W; with six cables at a regular pose there is one,
//! and nothing is left to optimise.

use nalgebra::{DMatrix, DVector, Matrix6xX, Vector6};

use super::quadratic_program::{Optimum, SolverError, minimise};
use crate::robot::TensionLimits;

/// A row of the wrench matrix counts as a combination of others if what it adds is below this share of the largest row.
const RANK_TOLERANCE: f64 = 1e-9;

/// Whether the cables can give a wrench within their limits.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// They can.
    Feasible {
        /// The tensions farthest from the limits, N.
        tensions: Vec<f64>,
        /// How far: the smallest distance of a tension to a limit, N; 0 or greater.
        margin: f64,
    },
    /// They cannot.
    Infeasible {
        /// By how much every limit would have to be widened, N; infinite if no tensions at all give the wrench.
        shortfall: f64,
        /// Which limits stand against the wrench, one number a cable: above 0 where the greatest tension does, below 0 where the
        /// least does, 0 where neither. Their absolute values add up to 1; none if no tensions at all give the wrench.
        ///
        /// They are c = Wᵀ y for a y with yᵀ w - max cᵀ u = `shortfall`, the greatest over all u within the limits, up to the
        /// solver's tolerances.
        weights: Vec<f64>,
    },
}

impl Distribution {
    /// The margin where it is feasible, minus the shortfall where it is not, N.
    pub fn signed_margin(&self) -> f64 {
        match self {
            Self::Feasible { margin, .. } => *margin,
            Self::Infeasible { shortfall, .. } => -shortfall,
        }
    }
}

/// All tensions that give a wrench: `particular` + `null_space` z.
struct Solutions {
    particular: DVector<f64>,
    /// Orthonormal columns, orthogonal to `particular`.
    null_space: DMatrix<f64>,
}

impl Solutions {
    /// `None` if no tensions give the wrench, or if it cannot be told from the matrix, which holds a number
    /// that is not finite. The matrix must have six columns at least.
    fn new(wrench_matrix: &Matrix6xX<f64>, wrench: &Vector6<f64>) -> Option<Self> {
        let cables = wrench_matrix.ncols();
        // Wᵀ P = Q R, with columns of zeros that make Q square: its last columns then span the null space.
        let mut square = DMatrix::zeros(cables, cables);
        square.columns_mut(0, 6).copy_from(&wrench_matrix.transpose());
        let qr = square.col_piv_qr();
        let (q, r) = (qr.q(), qr.r());
        let largest = r[(0, 0)].abs();
        let rank = (0..6).take_while(|k| r[(*k, *k)].abs() > RANK_TOLERANCE * largest).count();

        // Rᵀ (Qᵀ u) = Pᵀ w, of which the first `rank` rows tell Qᵀ u and the others must hold by themselves.
        let mut right = DVector::zeros(cables);
        right.rows_mut(0, 6).copy_from(wrench);
        qr.p().permute_rows(&mut right);
        let mut known = right.rows(0, rank).into_owned();
        r.view((0, 0), (rank, rank)).tr_solve_upper_triangular_mut(&mut known).then_some(())?;
        let particular = q.columns(0, rank) * known;
        let null_space = q.columns(rank, cables - rank).into_owned();
        let lacking = (wrench_matrix * &particular - wrench).norm();
        (lacking <= RANK_TOLERANCE * wrench.norm()).then_some(Self { particular, null_space })
    }

    fn tensions(&self, z: &[f64]) -> Vec<f64> {
        (&self.particular + &self.null_space * DVector::from_column_slice(z)).as_slice().to_vec()
    }

    /// Rows and bounds of u ≥ u_min and u ≤ u_max in z.
    fn limits(&self, limits: &TensionLimits) -> (Vec<Vec<f64>>, Vec<f64>) {
        let side = |sign: f64, limit: f64| {
            let row = move |i: usize| self.null_space.row(i).iter().map(|n| sign * n).collect();
            (0..self.particular.len()).map(move |i| (row(i), sign * (limit - self.particular[i])))
        };
        side(-1.0, limits.min).chain(side(1.0, limits.max)).unzip()
    }
}

/// The tensions that keep the greatest least distance to the limits: a linear programme, solved at once for six cables. The limits
/// must be finite.
///
/// # Errors
/// [`SolverError`] if clarabel gives no answer.
pub fn widest_margin(
    wrench_matrix: &Matrix6xX<f64>,
    wrench: &Vector6<f64>,
    limits: &TensionLimits,
) -> Result<Distribution, SolverError> {
    let Some(solutions) = Solutions::new(wrench_matrix, wrench) else {
        return Ok(Distribution::Infeasible { shortfall: f64::INFINITY, weights: vec![] });
    };
    let freedom = solutions.null_space.ncols();
    let optimum = (freedom > 0).then(|| widest(&solutions, freedom, limits)).transpose()?;
    let tensions = solutions.tensions(optimum.as_ref().map_or(&[], |optimum| &optimum.x));
    let margin = margin(&tensions, limits);
    if margin >= 0.0 {
        return Ok(Distribution::Feasible { tensions, margin });
    }
    let cables = tensions.len();
    let weights = match optimum {
        Some(Optimum { multipliers, .. }) => {
            (0..cables).map(|i| multipliers[cables + i] - multipliers[i]).collect()
        }
        None => worst(&tensions, limits),
    };
    Ok(Distribution::Infeasible { shortfall: -margin, weights })
}

/// Weights of the one limit that is broken most.
fn worst(tensions: &[f64], limits: &TensionLimits) -> Vec<f64> {
    let beyond = |u: f64| (limits.min - u).max(u - limits.max);
    let side = |u: f64| if u > limits.max { 1.0 } else { -1.0 };
    let most = tensions.iter().map(|u| beyond(*u)).fold(f64::NEG_INFINITY, f64::max);
    let first = tensions.iter().position(|u| beyond(*u) == most);
    tensions.iter().enumerate().map(|(i, u)| if Some(i) == first { side(*u) } else { 0.0 }).collect()
}

/// z of the greatest margin s, and a multiplier for each limit: maximise s subject to u_min + s ≤ u₀ + N z ≤ u_max - s.
fn widest(solutions: &Solutions, freedom: usize, limits: &TensionLimits) -> Result<Optimum, SolverError> {
    let (mut rows, bounds) = solutions.limits(limits);
    let (unit, bounds) = scaled(bounds);
    rows.iter_mut().for_each(|row| row.push(1.0));
    let mut slope = vec![0.0; freedom];
    slope.push(-1.0);
    let optimum = minimise(&vec![0.0; freedom + 1], &slope, &rows, &bounds)?;
    // s may be as negative as it needs: there always is a solution.
    let mut optimum = optimum.ok_or_else(|| SolverError::Unsolved("PrimalInfeasible".to_owned()))?;
    optimum.x.truncate(freedom);
    optimum.x.iter_mut().for_each(|z| *z *= unit);
    Ok(optimum)
}

/// The largest bound in absolute value, N, and the bounds as shares of it: the solver's tolerances are those of numbers about one.
fn scaled(bounds: Vec<f64>) -> (f64, Vec<f64>) {
    let unit = bounds.iter().fold(0.0, |largest: f64, bound| largest.max(bound.abs()));
    (unit, bounds.into_iter().map(|bound| bound / unit).collect())
}

/// The tensions nearest to the middle of their range, in the sense of least squares: a quadratic programme whose solution is
/// continuous in the wrench. `None` if the limits cannot be kept.
///
/// # Errors
/// [`SolverError`] if clarabel gives no answer.
pub fn nearest_mid_range(
    wrench_matrix: &Matrix6xX<f64>,
    wrench: &Vector6<f64>,
    limits: &TensionLimits,
) -> Result<Option<Vec<f64>>, SolverError> {
    let Some(solutions) = Solutions::new(wrench_matrix, wrench) else { return Ok(None) };
    let freedom = solutions.null_space.ncols();
    if freedom == 0 {
        let tensions = solutions.tensions(&[]);
        return Ok((margin(&tensions, limits) >= 0.0).then_some(tensions));
    }
    // |u₀ + N z - middle|² with NᵀN = 1: its slope at z = 0 is 2 Nᵀ(u₀ - middle).
    let from_middle = solutions.particular.add_scalar(-0.5 * (limits.min + limits.max));
    let slope = solutions.null_space.tr_mul(&from_middle);
    let (rows, bounds) = solutions.limits(limits);
    let (unit, bounds) = scaled(bounds);
    let optimum = minimise(&vec![1.0; freedom], (slope / unit).as_slice(), &rows, &bounds)?;
    Ok(optimum.map(|optimum| solutions.tensions(&optimum.x.iter().map(|z| z * unit).collect::<Vec<_>>())))
}

/// Smallest distance to a limit, N; negative where one is broken.
fn margin(tensions: &[f64], limits: &TensionLimits) -> f64 {
    tensions.iter().map(|u| (u - limits.min).min(limits.max - u)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::dynamics::static_tensions;
    use crate::robot::{Geometry, Pose, Rig, RobotParameters};
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};

    const LIMITS: TensionLimits = TensionLimits { min: 1.0, max: 20.0 };

    /// A random wrench matrix and a wrench that some tensions near the limits give.
    fn random_case(rng: &mut rand_pcg::Pcg64, cables: usize) -> (Matrix6xX<f64>, Vector6<f64>) {
        let matrix = Matrix6xX::from_fn(cables, |_, _| rng.random_range(-1.0..1.0));
        let tensions = DVector::from_fn(cables, |_, _| rng.random_range(-6.0..27.0));
        let wrench = &matrix * tensions;
        (matrix, wrench)
    }

    /// The greatest margin by looking at every vertex of the polyhedron in (z, s) with one or two unknowns z.
    fn by_vertices(solutions: &Solutions, limits: &TensionLimits) -> f64 {
        let freedom = solutions.null_space.ncols();
        let (rows, bounds) = solutions.limits(limits);
        let corner = |picked: [usize; 3]| -> Option<Vector3<f64>> {
            // With one unknown the second coordinate is held at zero by the third row.
            let matrix = Matrix3::from_fn(|r, c| match (c, freedom) {
                (2, _) => f64::from(r < 2 || freedom == 2),
                (1, 1) => f64::from(r == 2),
                _ if r == 2 && freedom == 1 => 0.0,
                _ => rows[picked[r]][c],
            });
            let right = Vector3::from_fn(|r, _| if r == 2 && freedom == 1 { 0.0 } else { bounds[picked[r]] });
            matrix.lu().solve(&right)
        };
        let meets = |x: &Vector3<f64>| {
            rows.iter().zip(&bounds).all(|(row, bound)| {
                row.iter().zip(x.iter()).map(|(a, x)| a * x).sum::<f64>() + x[2] <= bound + 1e-9
            })
        };
        let last = if freedom == 2 { rows.len() } else { 1 };
        let mut best = f64::NEG_INFINITY;
        for i in 0..rows.len() {
            for j in 0..i {
                for k in 0..if freedom == 2 { j } else { last } {
                    best = corner([i, j, k]).filter(meets).map_or(best, |x| best.max(x[2]));
                }
            }
        }
        best
    }

    /// Checks that the weights c are Wᵀ y, and that yᵀ w is `shortfall` more than cᵀ u can be within the limits.
    fn shows_infeasible(matrix: &Matrix6xX<f64>, wrench: &Vector6<f64>, shortfall: f64, weights: &[f64]) {
        let weights = DVector::from_column_slice(weights);
        let y = (matrix * matrix.transpose()).lu().solve(&(matrix * &weights)).unwrap();
        assert!((matrix.tr_mul(&y) - &weights).amax() < 1e-6 && (weights.lp_norm(1) - 1.0).abs() < 1e-6);
        let most: f64 = weights.iter().map(|c| (c * LIMITS.min).max(c * LIMITS.max)).sum();
        assert!(
            (y.dot(wrench) - most - shortfall).abs() < 1e-5,
            "{} is not {shortfall}",
            y.dot(wrench) - most
        );
    }

    #[test]
    fn margin_is_that_of_the_best_vertex() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
        let (mut feasible, mut infeasible) = (0, 0);
        for case in 0..1000 {
            let (matrix, wrench) = random_case(&mut rng, 7 + case % 2);
            let expected = by_vertices(&Solutions::new(&matrix, &wrench).unwrap(), &LIMITS);
            let found = widest_margin(&matrix, &wrench, &LIMITS).unwrap();
            assert!((found.signed_margin() - expected).abs() < 1e-5, "{case}: {found:?}, not {expected}");
            match found {
                Distribution::Feasible { tensions, margin } => {
                    feasible += 1;
                    assert!((&matrix * DVector::from(tensions.clone()) - wrench).norm() < 1e-9);
                    assert!(tensions.iter().all(|u| *u >= 1.0 + margin - 1e-9 && *u <= 20.0 - margin + 1e-9));
                }
                Distribution::Infeasible { shortfall, weights } => {
                    infeasible += 1;
                    shows_infeasible(&matrix, &wrench, shortfall, &weights);
                }
            }
        }
        assert!(feasible > 100 && infeasible > 100, "{feasible} and {infeasible}");
    }

    #[test]
    fn six_cables_have_the_tensions_of_the_direct_solution() {
        let robot = RobotParameters::default();
        let rig = Rig::triangular(&robot, TensionLimits { min: 0.0, max: 100.0 });
        let mut rng = rand_pcg::Pcg64::seed_from_u64(6);
        for _ in 0..2000 {
            let pose = Pose::at(rng.random_range(-0.4..0.4), rng.random_range(-0.4..0.4), 0.8);
            let direct = static_tensions(&robot, &Geometry::new(&robot), &pose).unwrap();
            let smallest = direct.iter().copied().fold(f64::INFINITY, f64::min);
            let (matrix, wrench) = (rig.wrench_matrix(&pose), rig.static_wrench());
            let found = widest_margin(&matrix, &wrench, &rig.limits).unwrap();
            assert!((found.signed_margin() - smallest).abs() < 1e-9);
            match found {
                Distribution::Feasible { tensions, .. } => {
                    for (u, direct) in tensions.iter().zip(direct) {
                        assert!((u - direct).abs() < 1e-9);
                    }
                    assert_eq!(nearest_mid_range(&matrix, &wrench, &rig.limits).unwrap(), Some(tensions));
                }
                Distribution::Infeasible { shortfall, weights } => {
                    assert!((shortfall + smallest).abs() < 1e-9);
                    assert_eq!(
                        weights.iter().position(|c| *c == -1.0),
                        direct.iter().position(|u| *u == smallest)
                    );
                }
            }
        }
    }

    #[test]
    fn nothing_feasible_lies_nearer_to_the_middle() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(80);
        let off_middle = |u: &[f64]| u.iter().map(|u| (u - 10.5).powi(2)).sum::<f64>();
        let (mut found, mut tried) = (0, 0);
        for _ in 0..500 {
            let (matrix, wrench) = random_case(&mut rng, 8);
            let nearest = nearest_mid_range(&matrix, &wrench, &LIMITS).unwrap();
            let signed = widest_margin(&matrix, &wrench, &LIMITS).unwrap().signed_margin();
            assert!(nearest.is_some() == (signed >= 0.0) || signed.abs() < 1e-6, "{signed}");
            let Some(nearest) = nearest else { continue };
            found += 1;
            assert!((&matrix * DVector::from(nearest.clone()) - wrench).norm() < 1e-9);
            assert!(margin(&nearest, &LIMITS) > -1e-6);
            let solutions = Solutions::new(&matrix, &wrench).unwrap();
            for _ in 0..200 {
                let other =
                    solutions.tensions(&[rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0)]);
                if margin(&other, &LIMITS) >= 0.0 {
                    tried += 1;
                    assert!(off_middle(&other) >= off_middle(&nearest) - 1e-5);
                }
            }
        }
        assert!(found > 50 && tried > 300, "{found} and {tried}");
    }

    #[test]
    fn a_platform_of_any_weight_gets_an_answer() {
        let rig = crate::robot::RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap().rig;
        let matrix = rig.wrench_matrix(&Pose::at(0.3, 0.2, 2.0));
        let (wrench, no_least) = (rig.static_wrench(), TensionLimits { min: 0.0, ..rig.limits });
        let margin = widest_margin(&matrix, &wrench, &no_least).unwrap().signed_margin();
        for power in [-9, -3, 3, 9, 100] {
            let factor = 10f64.powi(power);
            let limits = TensionLimits { min: 0.0, max: rig.limits.max * factor };
            let scaled = widest_margin(&matrix, &(wrench * factor), &limits).unwrap().signed_margin();
            assert!((scaled / factor - margin).abs() < 1e-5, "{factor}: {scaled}");
            // Far too heavy, or next to nothing, within the same limits.
            assert!(widest_margin(&matrix, &(wrench * factor), &rig.limits).unwrap().signed_margin() < 0.0);
        }
    }

    #[test]
    fn nearly_equal_singular_values_lose_no_digits() {
        let rig = crate::robot::RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap().rig;
        for k in 0..4000 {
            let pose = Pose::at(1e-3 * f64::from(k % 20), 1e-3 * f64::from(k / 20), 2.0);
            let solutions = Solutions::new(&rig.wrench_matrix(&pose), &rig.static_wrench()).unwrap();
            let n = &solutions.null_space;
            assert_eq!(n.ncols(), 2);
            assert!((n.tr_mul(n) - DMatrix::identity(2, 2)).amax() < 1e-13);
            assert!((rig.wrench_matrix(&pose) * n).amax() < 1e-13);
        }
    }

    #[test]
    fn a_wrench_that_no_tensions_give_is_infeasible() {
        // Eight cables that all pull the same way through the centre.
        let matrix = Matrix6xX::from_fn(8, |r, _| f64::from(r == 2));
        let sideways = Vector6::new(1.0, 0.0, -8.0, 0.0, 0.0, 0.0);
        let nothing = Distribution::Infeasible { shortfall: f64::INFINITY, weights: vec![] };
        assert_eq!(widest_margin(&matrix, &sideways, &LIMITS).unwrap(), nothing);
        assert_eq!(nearest_mid_range(&matrix, &sideways, &LIMITS).unwrap(), None);
        let along = Vector6::new(0.0, 0.0, 80.0, 0.0, 0.0, 0.0);
        assert!((widest_margin(&matrix, &along, &LIMITS).unwrap().signed_margin() - 9.0).abs() < 1e-6);
    }
}
