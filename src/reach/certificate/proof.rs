//! Why a verdict is right: what a checker needs that trusts nobody (docs/proof.md).

use super::margins::Tube;
use super::motion::{Span, Step};
use super::redundant::{self, Shared};
use super::search::MOST_SPANS;
use super::statics::{Solved, cables};
use super::taylor::Taylor;
use super::{CertificateError, Verdict, check, closed_form};
use crate::robot::{PerCable, Rig};

/// What proves a verdict.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// Spans that cover all time, in their order; the last has no end.
    Admissible(Vec<ProvedSpan>),
    /// Of six cables: one is at or beyond a limit.
    NotAdmissible {
        /// Number of the cable, from 1.
        cable: usize,
        /// When, s after the step.
        time: f64,
        /// Tensions over lengths then, N/m.
        solved: Box<Solved>,
        /// Bounds of this cable's tension then, N.
        bounds: [f64; 2],
    },
    /// Of more than six cables: no tensions within the limits give the wrench.
    NoDistribution {
        /// When, s after the step.
        time: f64,
        /// Farkas' vector.
        multipliers: [f64; 6],
        /// By how much some limit is broken at least, N.
        shortfall: f64,
    },
}

/// What shows that the tensions are within their limits in a span.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedSpan {
    /// Seconds after the step.
    pub span: Span,
    /// Of more than six cables: how tensions over lengths depend on the six unknowns; of six they are these.
    pub spread: Option<Spread>,
    /// The six unknowns.
    pub solved: Solved,
    /// Least and greatest tension of each cable, N.
    pub bounds: PerCable<[f64; 2]>,
}

/// Tension over length of cable i is `base`ᵢ + `basis`ᵢ · y, with six unknowns y.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// N/m.
    pub base: PerCable<f64>,
    /// Of any unit: y has what makes it N/m.
    pub basis: PerCable<[f64; 6]>,
}

/// What shows that a span is proved.
pub(super) struct Shown<'a> {
    pub tension: &'a [Taylor],
    pub solved: &'a Solved,
    /// Of more than six cables.
    pub shared: Option<&'a Shared>,
}

/// As [`certify`](super::certify), with the proof where there is one; it allocates.
///
/// # Errors
/// As [`certify`](super::certify).
pub fn prove(rig: &Rig, step: &Step) -> Result<(Verdict, Option<Proof>), CertificateError> {
    check(rig, &rig.limits(), step)?;
    let mut spans = Vec::new();
    let shown = |span, shown: Shown| spans.push(ProvedSpan::of(span, &shown));
    let decided = closed_form(rig, &rig.limits(), step, &mut { MOST_SPANS }, shown);
    let verdict = decided.map_or_else(|no| no, |range| range.admissible());
    let proof = match verdict {
        Verdict::Admissible { .. } => Some(Proof::Admissible(in_order(spans))),
        Verdict::NotAdmissible { cable, time, .. } => beyond(rig, step, cable, time),
        Verdict::NoDistribution { time, shortfall, .. } => none_keeps(rig, step, time, shortfall),
        Verdict::Undecided { .. } => None,
    };
    Ok((verdict, proof))
}

impl ProvedSpan {
    fn of(span: Span, shown: &Shown) -> Self {
        let spread = shown.shared.map(|shared| Spread { base: shared.base, basis: shared.basis });
        let bounds = PerCable::from_fn(shown.tension.len(), |i| shown.tension[i].range());
        Self { span, spread, solved: *shown.solved, bounds }
    }
}

/// The spans one after another, without the instants that the walk looks at on its way, and of those without end the last, which is the longest.
fn in_order(spans: Vec<ProvedSpan>) -> Vec<ProvedSpan> {
    let is_endless = |proved: &ProvedSpan| matches!(proved.span, Span::From(_));
    let (endless, mut ordered): (Vec<_>, Vec<_>) = spans.into_iter().partition(is_endless);
    ordered.retain(|proved| matches!(proved.span, Span::Between(from, to) if from < to));
    ordered.extend(endless.into_iter().last());
    ordered
}

fn beyond(rig: &Rig, step: &Step, cable: usize, time: f64) -> Option<Proof> {
    let cables = cables(rig, &step.motion(Span::Between(time, time), &Tube::empty()))?;
    let bounds = cables.tension[cable - 1].range();
    Some(Proof::NotAdmissible { cable, time, solved: Box::new(cables.solved), bounds })
}

fn none_keeps(rig: &Rig, step: &Step, time: f64, shortfall: f64) -> Option<Proof> {
    let motion = step.motion(Span::Between(time, time), &Tube::empty());
    let multipliers = redundant::multipliers(rig, &rig.limits(), &motion)?;
    Some(Proof::NoDistribution { time, multipliers, shortfall })
}

#[cfg(test)]
mod tests {
    use super::super::certify;
    use super::super::statics::System;
    use super::*;
    use crate::control::Gains;
    use crate::robot::{Coordinates, Pose, RigFile};
    use rand::{RngExt, SeedableRng};

    /// Steps of the paper's rig and of the eight cables, about half of them admissible.
    fn random_problems(count: usize) -> impl Iterator<Item = (Rig, Step)> {
        let eight = RigFile::parse(include_str!("../../../rigs/eight.toml")).unwrap();
        let rigs = [RigFile::default(), eight];
        let mut rng = rand_pcg::Pcg64::seed_from_u64(15);
        (0..count).map(move |case| {
            let file = &rigs[case % 2];
            let size = file.rig.radius() * 0.5;
            let mut any = |size: f64| rng.random_range(-size..size);
            let mut pose = || {
                let turned = [0.15; 3].map(&mut any);
                let moved = [size; 3].map(&mut any);
                Pose(file.home.0 + Coordinates::from_iterator(moved.into_iter().chain(turned)))
            };
            let (start, set_point) = (pose(), pose());
            let rates = Coordinates::from_fn(|_, _| any(0.2));
            let gains = Gains { lambda: 2.5 + any(1.5), eta: 2.5 + any(1.5) };
            (file.rig, Step { start, rates, set_point, gains })
        })
    }

    fn at(unknowns: &[Taylor; 6], tau: f64) -> [f64; 6] {
        unknowns.map(|unknown| unknown.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c))
    }

    #[test]
    fn a_verdict_is_the_same_with_and_without_its_proof() {
        let (mut proved, mut refused) = (0, 0);
        for (rig, step) in random_problems(200) {
            let (verdict, proof) = prove(&rig, &step).unwrap();
            assert_eq!(format!("{verdict:?}"), format!("{:?}", certify(&rig, &step).unwrap()));
            match proof {
                Some(Proof::Admissible(_)) => proved += 1,
                Some(_) => refused += 1,
                None => assert!(matches!(verdict, Verdict::Undecided { .. })),
            }
        }
        assert!(proved > 50 && refused > 50, "{proved} and {refused}");
    }

    #[test]
    fn spans_of_a_proof_cover_all_time_within_the_limits() {
        for (rig, step) in random_problems(100) {
            let Some(Proof::Admissible(spans)) = prove(&rig, &step).unwrap().1 else { continue };
            let (last, others) = spans.split_last().unwrap();
            let mut covered = 0.0;
            for proved in others {
                let Span::Between(from, to) = proved.span else {
                    panic!("{:?} is not the last", proved.span)
                };
                assert!(from <= covered && to > from);
                covered = to;
            }
            assert!(
                matches!(last.span, Span::From(from) if from <= covered && from * step.slow_rate() >= 1.0)
            );
            for proved in &spans {
                for (bounds, cable) in proved.bounds.iter().zip(&rig.cables) {
                    assert!(cable.limits.min < bounds[0] && bounds[1] < cable.limits.max);
                }
            }
        }
    }

    /// With the error of the file, not with one that is found again.
    #[test]
    fn unknowns_of_a_proof_solve_the_equations_at_all_instants() {
        for (rig, step) in random_problems(60) {
            let Some(Proof::Admissible(spans)) = prove(&rig, &step).unwrap().1 else { continue };
            for proved in spans {
                for tau in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                    let time = proved.span.time(tau);
                    let motion = step.motion(Span::Between(time, time), &Tube::empty());
                    let system = System::new(&rig, &motion).unwrap();
                    let (near, error) =
                        (at(&proved.solved.unknowns, tau), proved.solved.unknowns.map(|y| y.error));
                    let spread =
                        |i: usize, values: [f64; 6], base: f64, size: fn(f64) -> f64| match &proved.spread {
                            None => values[i],
                            Some(spread) => {
                                let of_basis = (0..6).map(|k| size(spread.basis[i][k]) * values[k]);
                                base * spread.base[i] + of_basis.sum::<f64>()
                            }
                        };
                    for k in 0..6 {
                        let (mut lacking, mut room) = (system.wrench[k].coefficients[0], 1e-9);
                        for i in 0..rig.cables.len() {
                            let column = system.columns[i][k].coefficients[0];
                            lacking -= column * spread(i, near, 1.0, |b| b);
                            room += column.abs() * spread(i, error, 0.0, f64::abs);
                        }
                        assert!(lacking.abs() <= room, "{lacking} of {room} at {time}");
                    }
                }
            }
        }
    }

    #[test]
    fn refusals_are_proved_of_the_instant_that_is_named() {
        let (mut of_cable, mut of_all) = (0, 0);
        for (rig, step) in random_problems(100) {
            match prove(&rig, &step).unwrap() {
                (
                    Verdict::NotAdmissible { cable, .. },
                    Some(Proof::NotAdmissible { bounds: [least, greatest], .. }),
                ) => {
                    let limits = rig.cables[cable - 1].limits;
                    assert!(greatest <= limits.min || least >= limits.max);
                    of_cable += 1;
                }
                (
                    Verdict::NoDistribution { .. },
                    Some(Proof::NoDistribution { time, multipliers, shortfall }),
                ) => {
                    let motion = step.motion(Span::Between(time, time), &Tube::empty());
                    let system = System::new(&rig, &motion).unwrap();
                    let product = |values: &[Taylor; 6]| {
                        (0..6).map(|k| multipliers[k] * values[k].coefficients[0]).sum::<f64>()
                    };
                    let (mut gap, mut sum) = (product(&system.wrench), 0.0);
                    for (i, cable) in rig.cables.iter().enumerate() {
                        let c = product(&system.columns[i]) / system.length[i].coefficients[0];
                        gap -= (c * cable.limits.min).max(c * cable.limits.max);
                        sum += c.abs();
                    }
                    assert!(shortfall > 0.0 && (gap / sum - shortfall).abs() < 1e-6 * (1.0 + shortfall));
                    of_all += 1;
                }
                (Verdict::Admissible { .. }, Some(Proof::Admissible(_)))
                | (Verdict::Undecided { .. }, None) => {}
                other => panic!("{other:?}"),
            }
        }
        assert!(of_cable > 10 && of_all > 10, "{of_cable} and {of_all}");
    }
}
