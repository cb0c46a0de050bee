//! Convex quadratic and linear programmes with inequalities, posed to clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use thiserror::Error;

/// The solver gave no answer that can be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SolverError {
    /// The problem could not be set up.
    #[error("the programme could not be posed: {0}")]
    Setup(String),
    /// The solver stopped short of a solution or of a proof that there is none.
    #[error("the programme was not solved: {0}")]
    Unsolved(String),
}

/// Where the least value is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimum {
    /// The unknowns.
    pub x: Vec<f64>,
    /// One multiplier a row, 0 or greater: how much the row holds the optimum back.
    pub multipliers: Vec<f64>,
}

/// Minimises Σ (curvature_k x_k²/2 + slope_k x_k) subject to `rows` x ≤ `bounds`; `None` if no x meets the rows.
/// Curvatures are 0 or greater; a row has one coefficient an unknown.
///
/// # Errors
/// [`SolverError`] if clarabel gives no answer, also where the least value is unbounded.
pub fn minimise(
    curvature: &[f64],
    slope: &[f64],
    rows: &[Vec<f64>],
    bounds: &[f64],
) -> Result<Option<Optimum>, SolverError> {
    let unknowns = slope.len();
    let diagonal = CscMatrix::new(
        unknowns,
        unknowns,
        (0..=unknowns).collect(),
        (0..unknowns).collect(),
        curvature.to_vec(),
    );
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let cones = [NonnegativeConeT(bounds.len())];
    let mut solver = DefaultSolver::new(&diagonal, slope, &CscMatrix::from(rows), bounds, &cones, settings)
        .map_err(|error| SolverError::Setup(error.to_string()))?;
    solver.solve();
    let solution = solver.solution;
    match solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => {
            Ok(Some(Optimum { x: solution.x, multipliers: solution.z }))
        }
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
        status => Err(SolverError::Unsolved(format!("{status:?}"))),
    }
}
