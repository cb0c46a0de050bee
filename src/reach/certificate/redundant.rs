//! More than six cables: tensions within the limits over a span of time, or a proof that an instant has none.
//!
//! The tension distribution proposes, interval arithmetic decides: no verdict depends on the tolerances of the former.

use nalgebra::{Matrix6, Vector6};

use super::margins::UPWARDS;
use super::motion::{Motion, Span};
use super::search::{Finding, judge};
use super::statics::{Solved, System, solve};
use super::taylor::{Taylor, combination};
use super::{Cause, Verdict};
use crate::control::distribution::{Distribution, STIFFNESS, Solutions, reference};
use crate::robot::{PerCable, Rig, TensionLimits};

/// What rounding leaves of the widest margin.
const LESS: f64 = 1.0 - 1e-9;
/// By how much, as a share of itself, a proof is bent so that rounding does not spoil it.
const AGAINST_ROUNDING: f64 = 1e-12;
/// A tension counts as held by a limit within this share of the weight.
const HELD: f64 = 1e-9;
/// A limit counts as standing against the wrench from this share of all of them on.
const NAMED: f64 = 1e-4;

/// Looks for tensions of all motions in `motion` over `span`, `share` of the way that they can be inside the limits; `inside` is shown those that are
/// within the limits, and what the law has to do with them.
pub fn look(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    motion: &Motion,
    (span, share): (Span, f64),
    inside: impl FnOnce(&System, &Shared, &Law),
) -> Finding {
    let Some(system) = System::new(rig, motion) else {
        return Finding::Untold(Cause::Singular);
    };
    let Some((matrix, solutions, proposed)) = proposal(rig, limits, &system, share) else {
        return Finding::Untold(Cause::Singular);
    };
    match proposed {
        Distribution::Infeasible { weights, .. } => {
            let time = span.time(0.0);
            match refusal(&system, &matrix, &weights, limits, time) {
                Some((verdict, _)) => Finding::Beyond { time, verdict },
                None if is_singular(&system) => Finding::Untold(Cause::Singular),
                None => Finding::Perhaps { time },
            }
        }
        Distribution::Feasible(tensions) => match extended(&system, &tensions) {
            None => Finding::Untold(Cause::Singular),
            Some(shared) => match judge(&shared.tension, limits, span) {
                None => {
                    inside(&system, &shared, &Law { rig, limits: *limits, matrix, solutions });
                    Finding::Inside
                }
                // These tensions leave the limits; others may not.
                Some(Finding::Beyond { time, .. }) => Finding::Perhaps { time },
                Some(finding) => finding,
            },
        },
    }
}

/// y that proves of the instant of `motion` that no tensions keep the limits; `None` where that is not proved.
pub fn multipliers(rig: &Rig, limits: &PerCable<TensionLimits>, motion: &Motion) -> Option<[f64; 6]> {
    let system = System::new(rig, motion)?;
    let (matrix, _, proposed) = proposal(rig, limits, &system, 1.0)?;
    let Distribution::Infeasible { weights, .. } = proposed else { return None };
    refusal(&system, &matrix, &weights, limits, 0.0).map(|(_, multipliers)| multipliers)
}

/// The wrench matrix in the middle of the span, all tensions there, and those that are `share` of the way inside the limits; `None` where the
/// matrix is singular.
fn proposal(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    system: &System,
    share: f64,
) -> Option<(PerCable<Vector6<f64>>, Solutions, Distribution)> {
    let (matrix, wrench) = middle(system);
    let solutions = Solutions::new(&matrix, &wrench, rig.platform_radius())?;
    // Up to what the reference is above the least tension: in the span they change.
    let margin = solutions.widest_margin(limits).min(rig.weight()).max(0.0) * LESS * share;
    let shrunk = limits.map(|limits| limits.shrunk(margin));
    let proposed = solutions.distribute(&shrunk, &reference(rig), 0.0);
    Some((matrix, solutions, proposed))
}

/// Tensions over a span that give the wrench: of cable i its length times `base`ᵢ + `basis`ᵢ · y.
pub struct Shared {
    /// σ, tensions over lengths in the middle, N/m.
    pub base: PerCable<f64>,
    /// V₀ᵀ.
    pub basis: PerCable<[f64; 6]>,
    /// y.
    pub solved: Solved,
    /// N.
    pub tension: PerCable<Taylor>,
}

/// The law (D1) over a span, where tensions are shown that keep its margin from the rig's limits. Derived in docs/certificate.md, "More than six".
pub struct Law<'a> {
    rig: &'a Rig,
    /// The rig's, with the law's margin kept from them.
    limits: PerCable<TensionLimits>,
    /// In the middle of the span.
    matrix: PerCable<Vector6<f64>>,
    solutions: Solutions,
}

/// How near the law's tensions are to those shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearness {
    /// y that it is proved with.
    pub multipliers: [f64; 6],
    /// All together, N: the norm of the difference.
    pub distance: f64,
    /// By how much they intrude on the law's margin, N.
    pub intrusion: f64,
}

impl Law<'_> {
    /// û `shown`, u the law's: |û - u|² ≤ 2 (F(û) - F(u)), since F, the objective of (D1), is strictly convex and |û - r|²/2 at û. F(u) is
    /// at least its dual value for any y. With c = Wᵀ y that leaves
    ///
    /// ```text
    /// F(û) - F(u) ≤ Σ max over u of (û - u) ((û + u)/2 - r - c),   u in the limits and what is intruded beyond them
    /// ```
    ///
    /// and the maximum is at u = r + c, or at the limit next to it. y is that of the law in the middle of the span.
    pub fn nearness(&self, system: &System, shown: &[Taylor]) -> Nearness {
        let reference = reference(self.rig);
        let intrusion = from(&reference, shown) / STIFFNESS.sqrt() * UPWARDS;
        let y = self.multipliers(&reference);
        let of_cable = |i: usize| {
            let (u, r, limits) = (shown[i], Taylor::constant(reference[i]), self.limits[i]);
            let c = combination(y, system.columns[i].each_ref()) * system.length[i].inverse();
            let off = u - r - c;
            let [from, to] = (r + c).range();
            let at =
                |limit: f64| (u + Taylor::constant(-limit)) * (off - (u + Taylor::constant(-limit)) * 0.5);
            let (least, greatest) = (limits.min - intrusion, limits.max + intrusion);
            let most = if to <= least {
                at(least)
            } else if from >= greatest {
                at(greatest)
            } else {
                off * off * 0.5
            };
            most.range()[1].max(0.0)
        };
        let gap: f64 = (0..shown.len()).map(of_cable).sum();
        Nearness { multipliers: y, distance: (2.0 * gap).sqrt() * UPWARDS, intrusion }
    }

    /// y with (Wᵀ y)ᵢ = uᵢ - rᵢ for the law's tensions u in the middle that no limit holds, nearly.
    fn multipliers(&self, reference: &PerCable<f64>) -> [f64; 6] {
        let tensions = self.solutions.tensions_within(&self.limits, self.rig);
        let (mut normal, mut aim) = (Matrix6::zeros(), Vector6::zeros());
        for (i, column) in self.matrix.iter().enumerate() {
            if self.limits[i].margin(tensions[i]) > HELD * self.rig.weight() {
                normal += column * column.transpose();
                aim += column * (tensions[i] - reference[i]);
            }
        }
        normal.lu().solve(&aim).unwrap_or_default().into()
    }
}

/// An upper bound of |u - r|, N.
fn from(reference: &PerCable<f64>, tensions: &[Taylor]) -> f64 {
    let square = |(u, r): (&Taylor, &f64)| {
        let size = (*u + Taylor::constant(-r)).size();
        size * size
    };
    tensions.iter().zip(reference.iter()).map(square).sum::<f64>().sqrt()
}

/// The wrench matrix and the wrench in the middle of the span, nearly.
pub(super) fn middle(system: &System) -> (PerCable<Vector6<f64>>, Vector6<f64>) {
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
fn extended(system: &System, tensions: &[f64]) -> Option<Shared> {
    let cables = tensions.len();
    let base = PerCable::from_fn(cables, |i| tensions[i] / system.length[i].coefficients[0]);
    let basis = system.columns.map(|column| column.map(|v| v.coefficients[0]));
    let mut matrix = [[Taylor::ZERO; 6]; 6];
    let mut lacking = system.wrench;
    for i in 0..cables {
        for k in 0..6 {
            let v = system.columns[i][k];
            lacking[k] = lacking[k] - v * base[i];
            for j in 0..6 {
                matrix[k][j] = matrix[k][j] + v * basis[i][j];
            }
        }
    }
    let solved = solve(&matrix, &lacking)?;
    let tension = PerCable::from_fn(cables, |i| {
        let correction = combination(basis[i], solved.unknowns.each_ref());
        (correction + Taylor::constant(base[i])) * system.length[i]
    });
    Some(Shared { base, basis, solved, tension })
}

/// Whether there is a wrench in the span that no tensions give, or may be.
fn is_singular(system: &System) -> bool {
    extended(system, &system.length.map(|_| 0.0)).is_none()
}

/// "Not admissible", and the y it is proved with, if it is proved that no tensions within the limits give the wrench.
///
/// Any y will do: W u = w means cᵀ u = yᵀ w with c = Wᵀ y. If that is more than cᵀ u can be within the limits, there is no such u; and
/// widening all limits by s adds s Σ|c| at most.
fn refusal(
    system: &System,
    matrix: &PerCable<Vector6<f64>>,
    weights: &[f64],
    limits: &PerCable<TensionLimits>,
    time: f64,
) -> Option<(Verdict, [f64; 6])> {
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
    let verdict = Verdict::NoDistribution { time, shortfall, at_least, at_greatest };
    (gap.range()[0] > 0.0).then_some((verdict, y))
}

#[cfg(test)]
mod tests {
    use super::super::margins::Tube;
    use super::super::motion::Step;
    use super::*;
    use crate::control::Gains;
    use crate::control::distribution::share;
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
        let found = extended(&over, &[40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0]).unwrap().tension;
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

    /// Also where the law's margin holds some of the tensions.
    #[test]
    fn the_law_is_as_near_to_the_tensions_shown_as_is_said() {
        let rig = eight();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(91);
        let (mut shown, mut held) = (0, 0);
        for case in 0..400 {
            let mut any = |size: f64| rng.random_range(-size..size);
            let start = Pose(Coordinates::new(any(1.9), any(1.4), 2.0, any(0.2), any(0.2), any(0.2)));
            let step = Step { start, rates: Coordinates::zeros(), ..STEP };
            let kept = 30.0 * f64::from(case % 2);
            let limits = rig.limits().map(|limits| limits.shrunk(kept));
            let span = Span::Between(0.1, 0.1 + any(0.05).abs());
            look(&rig, &limits, &step.motion(span, &Tube::empty()), (span, 0.2), |over, shared, law| {
                let tensions = &shared.tension;
                let near = law.nearness(over, tensions);
                shown += 1;
                for tau in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                    let time = span.time(tau);
                    let (matrix, wrench) = middle(&system(&rig, &step, Span::Between(time, time)));
                    // In the platform's frame: the rotation changes no tension.
                    let pulled = share(&rig, &matrix, &wrench, kept).unwrap();
                    let value = |u: &Taylor| u.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c);
                    let apart =
                        tensions.iter().zip(&pulled).map(|(u, p)| (value(u) - p).powi(2)).sum::<f64>().sqrt();
                    let most = near.distance + tensions.iter().map(|u| u.error).sum::<f64>() + 1e-9;
                    assert!(apart <= most, "{apart} N, not {most} N");
                    held += usize::from(pulled.iter().any(|u| *u < 5.0 + kept + 0.01));
                    assert!(pulled.iter().all(|u| *u > 5.0 + kept - near.intrusion - 1e-9));
                }
            });
        }
        assert!(shown > 200 && held > 50, "{shown} and {held}");
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
