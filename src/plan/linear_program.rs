//! The linear programme (17) itself, posed to clarabel: what the bisection approximates.

use nalgebra::Vector2;

use crate::reach::BoundedDomain;
use crate::reach::quadratic_program::{SolverError, minimise};

/// The smallest β in [0, 1] with x_d = x_f + β (x_prev - x_f) in the closed `domain`; `None` if there is none.
///
/// # Errors
/// [`SolverError`] if clarabel gives no answer.
pub fn smallest_beta(
    domain: &BoundedDomain,
    x_prev: &Vector2<f64>,
    x_f: &Vector2<f64>,
) -> Result<Option<f64>, SolverError> {
    let back = x_prev - x_f;
    // Rows `coefficient β ≤ bound`: the half-planes of (15), then β ≤ 1 and -β ≤ 0.
    let of_domain = domain.half_planes().map(|row| (vec![row.normal.dot(&back)], row.slack(x_f)));
    let ends = [(vec![1.0], 1.0), (vec![-1.0], 0.0)];
    let (rows, bounds): (Vec<_>, Vec<_>) = of_domain.into_iter().chain(ends).unzip();
    let optimum = minimise(&[0.0], &[1.0], &rows, &bounds)?;
    Ok(optimum.map(|optimum| optimum.x[0].clamp(0.0, 1.0)))
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
