//! The linear programme (17) itself, posed to clarabel: what the bisection approximates.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::Vector2;
use thiserror::Error;

use crate::reach::BoundedDomain;

/// The solver gave no answer that can be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinearProgramError {
    /// The problem could not be set up.
    #[error("the linear programme (17) could not be posed: {0}")]
    Setup(String),
    /// The solver stopped short of a solution or of a proof that there is none.
    #[error("the linear programme (17) was not solved: {0}")]
    Unsolved(String),
}

/// The smallest β in [0, 1] with x_d = x_f + β (x_prev - x_f) in the closed `domain`; `None` if there is none.
///
/// # Errors
/// [`LinearProgramError`] if clarabel gives no answer.
pub fn smallest_beta(
    domain: &BoundedDomain,
    x_prev: &Vector2<f64>,
    x_f: &Vector2<f64>,
) -> Result<Option<f64>, LinearProgramError> {
    let back = x_prev - x_f;
    // Rows `coefficient β ≤ bound`: the half-planes of (15), then β ≤ 1 and -β ≤ 0.
    let (mut coefficient, mut bound): (Vec<f64>, Vec<f64>) =
        domain.half_planes().iter().map(|row| (row.normal.dot(&back), row.slack(x_f))).unzip();
    coefficient.extend([1.0, -1.0]);
    bound.extend([1.0, 0.0]);

    let rows = bound.len();
    let matrix = CscMatrix::new(rows, 1, vec![0, rows], (0..rows).collect(), coefficient);
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let mut solver = DefaultSolver::new(
        &CscMatrix::zeros((1, 1)),
        &[1.0],
        &matrix,
        &bound,
        &[NonnegativeConeT(rows)],
        settings,
    )
    .map_err(|error| LinearProgramError::Setup(error.to_string()))?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(Some(solver.solution.x[0].clamp(0.0, 1.0))),
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
        status => Err(LinearProgramError::Unsolved(format!("{status:?}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Gains;
    use crate::plan::bisection::smallest_admissible;
    use crate::reach::in_static_workspace;
    use crate::robot::RobotParameters;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn bisection_and_linear_programme_agree_within_the_bisections_resolution() {
        let robot = RobotParameters::default();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(17);
        let mut random_point = || Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        let mut parameters = rand_pcg::Pcg64::seed_from_u64(18);
        let (mut cases, mut partial) = (0, 0);
        while cases < 10_000 {
            let (x_prev, x_f) = (random_point(), random_point());
            if !in_static_workspace(&robot, &x_prev) {
                continue;
            }
            cases += 1;
            let gains =
                Gains { lambda: parameters.random_range(1.0..8.0), eta: parameters.random_range(1.0..8.0) };
            let domain = BoundedDomain::new(&robot, &gains, x_prev, parameters.random_range(0.5..2.0));
            let bisection = smallest_admissible(8, |beta| domain.contains(&(x_f + (x_prev - x_f) * beta)));
            let exact = smallest_beta(&domain, &x_prev, &x_f).unwrap().expect("β = 1 is always admissible");
            // The bisection never claims more than is admissible, and is late by one grid step at most; 1e-7 is clarabel's.
            let late = bisection - exact;
            assert!(
                (-1e-7..=1.0 / 256.0 + 1e-7).contains(&late),
                "case {cases}: {bisection} against {exact}"
            );
            partial += usize::from(bisection > 0.0 && bisection < 1.0);
        }
        assert!(partial > 3000, "too few cases between the ends: {partial}");
    }
}
