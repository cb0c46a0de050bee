//! The walk along the motion, span by span, until a verdict is proved.

use super::margins::Tube;
use super::motion::{Span, Step};
use super::statics::tensions;
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
const MOST_SPANS: usize = 4000;

/// What one span shows.
enum Finding {
    /// All tensions within the limits: the least and the greatest.
    Inside([f64; 2]),
    /// A tension wholly beyond a limit, this at the time where it is farthest.
    Beyond { cable: usize, time: f64, tension: f64 },
    /// A tension that may be beyond, most of all at this time.
    Perhaps { time: f64 },
    /// No tensions can be told.
    Singular,
}

/// Decides whether all motions in `tube` keep strictly within `limits`. Only with an empty tube may the answer be "not admissible".
pub fn walk(rig: &Rig, step: &Step, tube: &Tube, limits: &TensionLimits) -> Verdict {
    let look = |span| look(rig, step, tube, limits, span);
    let end = ARRIVED / step.slow_rate();
    let undecided = |time, resolution, cause| Verdict::Undecided { time, resolution, cause };
    let refusal = |doubtful: f64| match look(Span::Between(doubtful, doubtful)) {
        Finding::Inside(_) => None,
        Finding::Beyond { cable, time, tension } => Some(Verdict::NotAdmissible { cable, time, tension }),
        Finding::Perhaps { time } => Some(undecided(time, 0.0, Cause::TooClose)),
        Finding::Singular => Some(undecided(doubtful, 0.0, Cause::Singular)),
    };
    let mut found = match look(Span::From(end)) {
        Finding::Inside(range) => range,
        _ => return refusal(end).unwrap_or(undecided(end, f64::INFINITY, Cause::TooClose)),
    };
    let admissible = |[least, greatest]: [f64; 2]| Verdict::Admissible { least, greatest };
    let mut arrival = FIRST_ARRIVAL / step.slow_rate();
    let (mut time, mut width) = (0.0, FIRST / step.fast_rate());
    for _ in 0..MOST_SPANS {
        if time >= end {
            return admissible(found);
        }
        if time >= arrival {
            if let Finding::Inside(range) = look(Span::From(time)) {
                return admissible(hull(found, range));
            }
            arrival = 1.5 * time;
        }
        let doubtful = match look(Span::Between(time, time + width)) {
            Finding::Inside(range) => {
                found = hull(found, range);
                time += width;
                width *= 2.0;
                continue;
            }
            Finding::Beyond { time, .. } | Finding::Perhaps { time } => time,
            Finding::Singular => time + 0.5 * width,
        };
        // Cutting the span helps only if that very time is free of doubt.
        if let Some(verdict) = refusal(doubtful) {
            return verdict;
        }
        width *= 0.5;
        if width * step.fast_rate() < SHORTEST {
            return undecided(doubtful, width, Cause::Singular);
        }
    }
    undecided(time, width, Cause::TooClose)
}

fn look(rig: &Rig, step: &Step, tube: &Tube, limits: &TensionLimits, span: Span) -> Finding {
    match tensions(rig, &step.motion(span, tube)) {
        Some(tensions) => judge(&tensions, limits, span),
        None => Finding::Singular,
    }
}

/// The worst of the six tensions.
fn judge(tensions: &PerCable<Taylor>, limits: &TensionLimits, span: Span) -> Finding {
    let mut all = [f64::INFINITY, f64::NEG_INFINITY];
    let mut worst = (f64::NEG_INFINITY, Finding::Singular);
    for (i, tension) in tensions.iter().enumerate() {
        let [least, greatest] = tension.range();
        if least > limits.min && greatest < limits.max {
            all = hull(all, [least, greatest]);
            continue;
        }
        let beyond = |[least, greatest]: [f64; 2]| greatest <= limits.min || least >= limits.max;
        let (excess, side) = if limits.min - least >= greatest - limits.max {
            (limits.min - least, 0)
        } else {
            (greatest - limits.max, 1)
        };
        if excess > worst.0 {
            let time = span.time(tension.extremes()[side]);
            let finding = if beyond([least, greatest]) {
                Finding::Beyond { cable: i + 1, time, tension: 0.5 * (least + greatest) }
            } else {
                Finding::Perhaps { time }
            };
            worst = (excess, finding);
        }
    }
    match worst {
        (f64::NEG_INFINITY, _) if all[0] > limits.min => Finding::Inside(all),
        (_, finding) => finding,
    }
}

fn hull(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}
