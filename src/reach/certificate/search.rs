//! The walk along the motion, span by span, until a verdict is proved.

use super::margins::Tube;
use super::motion::{Span, Step};
use super::statics::{Cables, cables};
use super::taylor::Taylor;
use super::{Cause, Verdict};
use crate::robot::{PerCable, Rig, TensionLimits};

/// First span, in time constants of the faster gain.
const FIRST: f64 = 0.5;
/// Spans shorter than this many time constants of the faster gain are not cut again.
const SHORTEST: f64 = 1e-9;
/// Time constants of the slower gain after which the robot is looked at as arrived, in one span without end,
const ARRIVED: f64 = 40.0;
/// and after which that is tried for the first time; later when it fails.
const FIRST_ARRIVAL: f64 = 4.0;
/// Spans looked at before giving up; a case takes ten or twenty.
pub const MOST_SPANS: usize = 400;

/// What one span shows.
pub enum Finding {
    /// All tensions within the limits.
    Inside,
    /// The limits are broken at this time, where most of all: the verdict.
    Beyond {
        /// s after the step.
        time: f64,
        /// "Not admissible", once the span is an instant.
        verdict: Verdict,
    },
    /// The limits may be broken, most of all at this time (s after the step).
    Perhaps {
        /// s after the step.
        time: f64,
    },
    /// No tensions can be told, and why.
    Untold(Cause),
}

/// Shows that all motions in `tube` keep strictly within `limits`, or else gives the verdict why not. `inside` is shown the cables over
/// spans that cover all time.
///
/// # Errors
/// A [`Verdict`] that is not "admissible". "Not admissible" speaks of all motions in the tube.
pub fn walk(
    rig: &Rig,
    step: &Step,
    tube: &Tube,
    limits: &PerCable<TensionLimits>,
    spans: &mut usize,
    mut inside: impl FnMut(Span, &Cables),
) -> Result<(), Verdict> {
    cover(step, spans, |span| match cables(rig, &step.motion(span, tube)) {
        Some(cables) => match judge(&cables.tension, limits, span) {
            Some(finding) => finding,
            None => {
                inside(span, &cables);
                Finding::Inside
            }
        },
        None => Finding::Untold(Cause::Singular),
    })
}

/// Covers all time from the step on with spans of which `look` says that they are inside; looks at no more than `spans` of them, and takes
/// those from it.
///
/// # Errors
/// As [`walk`].
pub fn cover(step: &Step, spans: &mut usize, mut look: impl FnMut(Span) -> Finding) -> Result<(), Verdict> {
    let end = ARRIVED / step.slow_rate();
    let undecided = |time, resolution, cause| Verdict::Undecided { time, resolution, cause };
    if !matches!(look(Span::From(end)), Finding::Inside) {
        let at_end = look(Span::Between(end, end));
        return Err(refusal(at_end, end).unwrap_or(undecided(end, f64::INFINITY, Cause::TooClose)));
    }
    let mut arrival = FIRST_ARRIVAL / step.slow_rate();
    let (mut time, mut width, mut cause) = (0.0, FIRST / step.fast_rate(), Cause::TooClose);
    while *spans > 0 {
        *spans -= 1;
        if time >= end {
            return Ok(());
        }
        if time >= arrival {
            if matches!(look(Span::From(time)), Finding::Inside) {
                return Ok(());
            }
            arrival = 1.5 * time;
        }
        let (doubtful, why) = match look(Span::Between(time, time + width)) {
            Finding::Inside => {
                time += width;
                width *= 2.0;
                continue;
            }
            Finding::Beyond { time, .. } | Finding::Perhaps { time } => (time, Cause::TooClose),
            Finding::Untold(cause) => (time + 0.5 * width, cause),
        };
        cause = why;
        // Cutting the span helps only if that very time is free of doubt.
        if let Some(verdict) = refusal(look(Span::Between(doubtful, doubtful)), doubtful) {
            return Err(verdict);
        }
        width *= 0.5;
        if width * step.fast_rate() < SHORTEST {
            return Err(undecided(doubtful, width, Cause::Singular));
        }
    }
    Err(undecided(time, width, cause))
}

/// The verdict of what an instant (s) shows; `None` where all is inside.
pub fn refusal(shown: Finding, instant: f64) -> Option<Verdict> {
    let undecided = |time, cause| Verdict::Undecided { time, resolution: 0.0, cause };
    match shown {
        Finding::Inside => None,
        Finding::Beyond { verdict, .. } => Some(verdict),
        Finding::Perhaps { time } => Some(undecided(time, Cause::TooClose)),
        Finding::Untold(cause) => Some(undecided(instant, cause)),
    }
}

/// The worst of the tensions; `None` where all are within the limits.
pub fn judge(tensions: &[Taylor], limits: &[TensionLimits], span: Span) -> Option<Finding> {
    let mut worst = 0.0;
    let mut finding = None;
    for (i, tension) in tensions.iter().enumerate() {
        let [least, greatest] = tension.range();
        let limits = &limits[i];
        if least > limits.min && greatest < limits.max {
            continue;
        }
        let (below, above) = (limits.min - least, greatest - limits.max);
        if finding.is_none() || below.max(above) > worst {
            worst = below.max(above);
            let time = span.time(tension.extremes()[usize::from(above > below)]);
            let beyond = greatest <= limits.min || least >= limits.max;
            let tension = 0.5 * (least + greatest);
            finding = Some(if beyond {
                Finding::Beyond { time, verdict: Verdict::NotAdmissible { cable: i + 1, time, tension } }
            } else {
                Finding::Perhaps { time }
            });
        }
    }
    finding
}
