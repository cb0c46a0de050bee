//! More than six cables: tensions within the limits over a span of time, or a proof that an instant has none.
//!
//! The tension distribution proposes, interval arithmetic decides: no verdict depends on the tolerances of the former.

use nalgebra::{Matrix6, Vector6};

use super::margins::Tube;
use super::motion::{Span, Step};
use super::search::{Finding, judge};
use super::statics::{System, solve};
use super::taylor::{Taylor, combination};
use super::{Cause, Verdict};
use crate::control::distribution::{Distribution, Solutions, reference};
use crate::robot::{PerCable, Rig, TensionLimits};

/// What rounding leaves of the widest margin.
const LESS: f64 = 1.0 - 1e-9;
/// By how much, as a share of itself, a proof is bent so that rounding does not spoil it.
const AGAINST_ROUNDING: f64 = 1e-12;
/// A limit counts as standing against the wrench from this share of all of them on.
const NAMED: f64 = 1e-4;

/// Looks for tensions of the closed form over `span`; `inside` is shown those that are within the limits.
pub fn look(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    step: &Step,
    span: Span,
    inside: impl FnOnce(&[Taylor]),
) -> Finding {
    let Some(system) = System::new(rig, &step.motion(span, &Tube::empty())) else {
        return Finding::Untold(Cause::Singular);
    };
    let (matrix, wrench) = middle(&system);
    let Some(solutions) = Solutions::new(&matrix, &wrench, rig.platform_radius()) else {
        return Finding::Untold(Cause::Singular);
    };
    // As far inside as can be, up to what the reference is above the least tension: in the span they change.
    let margin = solutions.widest_margin(limits).min(rig.weight()).max(0.0) * LESS;
    let shrunk = limits.map(|limits| limits.shrunk(margin));
    match solutions.distribute(&shrunk, &reference(rig), 0.0) {
        Distribution::Infeasible { weights, .. } => {
            let time = span.time(0.0);
            match refusal(&system, &matrix, &weights, limits, time) {
                Some(verdict) => Finding::Beyond { time, verdict },
                None if is_singular(&system) => Finding::Untold(Cause::Singular),
                None => Finding::Perhaps { time },
            }
        }
        Distribution::Feasible(tensions) => match extended(&system, &tensions) {
            None => Finding::Untold(Cause::Singular),
            Some(tensions) => match judge(&tensions, limits, span) {
                None => {
                    inside(&tensions);
                    Finding::Inside
                }
                // These tensions leave the limits; others may not.
                Some(Finding::Beyond { time, .. }) => Finding::Perhaps { time },
                Some(finding) => finding,
            },
        },
    }
}

/// The wrench matrix and the wrench in the middle of the span, nearly.
fn middle(system: &System) -> (PerCable<Vector6<f64>>, Vector6<f64>) {
    let matrix = PerCable::from_fn(system.columns.len(), |i| {
        Vector6::from(system.columns[i].map(|v| v.coefficients[0])) / system.length[i].coefficients[0]
    });
    (matrix, system.wrench.map(|component| component.coefficients[0]).into())
}

/// Tensions that give the wrench in all the span and are near `tensions` in its middle; `None` where the wrench matrix is singular or too
/// near to it to tell.
///
/// With V the matrix whose columns are `length` times too long, V₀ it in the middle and σ the tensions over lengths there, u/l is
/// σ + V₀ᵀ y, where (V V₀ᵀ) y = w - V σ: six equations for six unknowns.
fn extended(system: &System, tensions: &[f64]) -> Option<PerCable<Taylor>> {
    let cables = tensions.len();
    let per_length = PerCable::from_fn(cables, |i| tensions[i] / system.length[i].coefficients[0]);
    let basis = system.columns.map(|column| column.map(|v| v.coefficients[0]));
    let mut matrix = [[Taylor::ZERO; 6]; 6];
    let mut lacking = system.wrench;
    for i in 0..cables {
        for k in 0..6 {
            let v = system.columns[i][k];
            lacking[k] = lacking[k] - v * per_length[i];
            for j in 0..6 {
                matrix[k][j] = matrix[k][j] + v * basis[i][j];
            }
        }
    }
    let y = solve(&matrix, &lacking)?;
    let tension = |i: usize| {
        let correction = combination(basis[i], y.each_ref());
        (correction + Taylor::constant(per_length[i])) * system.length[i]
    };
    Some(PerCable::from_fn(cables, tension))
}

/// Whether there is a wrench in the span that no tensions give, or may be.
fn is_singular(system: &System) -> bool {
    extended(system, &system.length.map(|_| 0.0)).is_none()
}

/// "Not admissible", if it is proved that no tensions within the limits give the wrench.
///
/// Any y will do: W u = w means cᵀ u = yᵀ w with c = Wᵀ y. If that is more than cᵀ u can be within the limits, there is no such u; and
/// widening all limits by s adds s Σ|c| at most.
fn refusal(
    system: &System,
    matrix: &PerCable<Vector6<f64>>,
    weights: &[f64],
    limits: &PerCable<TensionLimits>,
    time: f64,
) -> Option<Verdict> {
    let aim: Vector6<f64> = matrix.iter().zip(weights).map(|(column, weight)| column * *weight).sum();
    let normal: Matrix6<f64> = matrix.iter().map(|column| column * column.transpose()).sum();
    let mut y: [f64; 6] = normal.lu().solve(&aim)?.into();
    // Where nothing limits the tensions of cables that pull against the weight, rounding must not leave their c above 0.
    if limits.iter().any(|limits| limits.max == f64::INFINITY) {
        let weight = system.wrench.map(|component| component.coefficients[0]);
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let tilt = AGAINST_ROUNDING * most(&y) / most(&weight[..3]);
        (0..3).for_each(|k| y[k] -= tilt * weight[k]);
    }
    let mut gap = combination(y, system.wrench.each_ref());
    let mut sum = Taylor::ZERO;
    for (i, (column, length)) in system.columns.iter().zip(&system.length).enumerate() {
        let c = combination(y, column.each_ref()) * length.inverse();
        let greatest = c.range()[1];
        let limit = if greatest > 0.0 { limits[i].max } else { limits[i].min };
        gap = gap - Taylor::constant(greatest) * limit;
        sum = sum + Taylor::constant(c.size());
    }
    let shortfall = (gap * (1.0 / sum.size())).range()[0];
    let named =
        |sign: f64| (0..weights.len()).filter(move |i| sign * weights[*i] > NAMED).map(|i| i + 1).collect();
    let (at_least, at_greatest) = (named(-1.0), named(1.0));
    (gap.range()[0] > 0.0).then_some(Verdict::NoDistribution { time, shortfall, at_least, at_greatest })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Gains;
    use crate::robot::{Coordinates, Pose, RigFile};
    use rand::{RngExt, SeedableRng};

    fn eight() -> Rig {
        RigFile::parse(include_str!("../../../rigs/eight.toml")).unwrap().rig
    }

    const STEP: Step = Step {
        start: Pose(Coordinates::new(0.3, -0.4, 2.1, 0.1, -0.2, 0.1)),
        rates: Coordinates::new(0.1, 0.2, -0.1, 0.2, -0.1, 0.3),
        set_point: Pose(Coordinates::new(0.0, 0.5, 1.9, -0.1, 0.1, -0.2)),
        gains: Gains { lambda: 2.0, eta: 4.0 },
    };

    fn system(rig: &Rig, step: &Step, span: Span) -> System {
        System::new(rig, &step.motion(span, &Tube::empty())).unwrap()
    }

    #[test]
    fn extended_tensions_give_the_wrench_in_all_the_span() {
        let (rig, span) = (eight(), Span::Between(0.2, 0.4));
        let over = system(&rig, &STEP, span);
        // Any tensions in the middle will do, also such as do not give the wrench there.
        let found = extended(&over, &[40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0]).unwrap();
        for tau in [-1.0, -0.5, 0.0, 0.3, 1.0] {
            let time = span.time(tau);
            let (matrix, wrench) = middle(&system(&rig, &STEP, Span::Between(time, time)));
            let value = |u: &Taylor| u.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c);
            let given: Vector6<f64> = matrix.iter().zip(&found).map(|(column, u)| column * value(u)).sum();
            let lacking = given - wrench;
            let errors: Vector6<f64> =
                matrix.iter().zip(&found).map(|(column, u)| column.abs() * u.error).sum();
            for k in 0..6 {
                assert!(lacking[k].abs() <= errors[k] + 1e-11, "{k} at {tau}: {lacking} {errors}");
            }
            assert!(errors.amax() < 1.0, "{errors}");
        }
    }

    #[test]
    fn no_weights_refuse_what_tensions_within_the_limits_give() {
        let rig = eight();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(86);
        let (mut feasible, mut refused) = (0, 0);
        for _ in 0..500 {
            let q = [2.2, 1.7, 0.9, 0.3, 0.3, 0.3].map(|size| rng.random_range(-size..size));
            let pose = Pose(Coordinates::from(q) + Coordinates::z() * 2.0);
            let rest = Step { start: pose, rates: Coordinates::zeros(), set_point: pose, ..STEP };
            let system = system(&rig, &rest, Span::Between(0.0, 0.0));
            let (matrix, wrench) = middle(&system);
            let refuse = |weights: &[f64]| refusal(&system, &matrix, weights, &rig.limits(), 0.0);
            let solutions = Solutions::new(&matrix, &wrench, rig.platform_radius()).unwrap();
            match solutions.distribute(&rig.limits(), &reference(&rig), 0.0) {
                Distribution::Feasible(_) => {
                    feasible += 1;
                    for _ in 0..20 {
                        let weights: Vec<_> = (0..8).map(|_| rng.random_range(-1.0..1.0)).collect();
                        assert_eq!(refuse(&weights), None);
                    }
                }
                Distribution::Infeasible { weights, .. } => {
                    refused += 1;
                    assert!(refuse(&weights).is_some());
                    let turned: Vec<_> = weights.iter().map(|c| -c).collect();
                    assert_eq!(refuse(&turned), None);
                }
            }
        }
        assert!(feasible > 100 && refused > 100, "{feasible} and {refused}");
    }
}
