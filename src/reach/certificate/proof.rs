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
        solved: Solved,
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
    Some(Proof::NotAdmissible { cable, time, solved: cables.solved, bounds })
}

fn none_keeps(rig: &Rig, step: &Step, time: f64, shortfall: f64) -> Option<Proof> {
    let motion = step.motion(Span::Between(time, time), &Tube::empty());
    let multipliers = redundant::multipliers(rig, &rig.limits(), &motion)?;
    Some(Proof::NoDistribution { time, multipliers, shortfall })
}
