//! What shows that the tensions of a motion keep the limits over a span of time.

use super::Cause;
use super::motion::{Motion, Span};
use super::redundant::{self, Nearness, Shared};
use super::search::{Finding, judge};
use super::statics::{Solved, cables};
use super::taylor::Taylor;
use crate::robot::{LEAST_CABLES, PerCable, Rig, TensionLimits};

/// What shows that a span is proved.
pub(super) struct Shown<'a> {
    pub tension: &'a [Taylor],
    pub solved: &'a Solved,
    /// Of more than six cables.
    pub shared: Option<&'a Shared>,
}

/// Of more than six cables in a tube: the tensions shown, and how near to them the law's are.
pub(super) struct OfLaw<'a> {
    pub shared: &'a Shared,
    pub near: Nearness,
}

/// Looks at the tensions of `motion` over `span`, of more than six cables at some; `inside` is shown those that are within the limits.
pub(super) fn look(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    motion: &Motion,
    span: Span,
    inside: impl FnOnce(&Shown),
) -> Finding {
    if rig.cables.len() > LEAST_CABLES {
        return redundant::look(rig, limits, motion, (span, 1.0), |_, shared, _| {
            inside(&Shown { tension: &shared.tension, solved: &shared.solved, shared: Some(shared) });
        });
    }
    let Some(cables) = cables(rig, motion) else {
        return Finding::Untold(Cause::Singular);
    };
    judge(&cables.tension, limits, span).unwrap_or_else(|| {
        inside(&Shown { tension: &cables.tension, solved: &cables.solved, shared: None });
        Finding::Inside
    })
}
