//! The proof over a span of time of any motion that can be enclosed.

use super::along::Seen;
use super::motion::{Motion, Span};
use super::search::{Finding, refusal};
use super::shown;
use super::taylor::Taylor;
use super::{Cause, Verdict};
use crate::robot::{PerCable, Rig, TensionLimits};

/// Halvings of the whole before a span counts as not to be told.
const MOST_HALVINGS: i32 = 30;

/// Shows that every tension is strictly within `limits` from one time until another (s); of more than six
/// cables, that it can be. `motion` encloses what is within a half span of a time. Looks at spans no longer
/// than `longest` (s), the shorter the sharper the bounds added to `seen`, and at no more than `spans`, which
/// are taken from that number.
///
/// # Errors
/// A [`Verdict`] that is not "admissible"; its time is that of the motion.
pub fn certify_motion(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    [from, to]: [f64; 2],
    motion: impl Fn(f64, f64) -> Motion,
    longest: f64,
    spans: &mut usize,
    seen: &mut Seen,
) -> Result<(), Verdict> {
    let shortest = libm::scalbn(to - from, -MOST_HALVINGS);
    let (mut time, mut width) = (from, longest.min(to - from));
    while time < to {
        let undecided = |resolution, cause| Verdict::Undecided { time, resolution, cause };
        if *spans == 0 {
            return Err(undecided(width, Cause::Effort));
        }
        *spans -= 1;
        let end = if time + width >= to - shortest { to } else { time + width };
        let inside = |tensions: &[Taylor], half| seen.include(tensions, half);
        let (doubtful, cause) = match look(rig, limits, &motion, (time, end), inside) {
            Finding::Inside => {
                (time, width) = (end, longest.min(2.0 * width));
                continue;
            }
            Finding::Beyond { time, .. } | Finding::Perhaps { time } => (time, Cause::TooClose),
            Finding::Untold(cause) => (0.5 * (time + end), cause),
        };
        // Cutting the span helps only if that very time is free of doubt.
        let instant = look(rig, limits, &motion, (doubtful, doubtful), |_, _| ());
        if let Some(verdict) = refusal(instant, doubtful) {
            return Err(verdict);
        }
        width = 0.5 * (end - time);
        if width < shortest {
            return Err(undecided(width, cause));
        }
    }
    Ok(())
}

/// What the motion shows from one time until another, s; `inside` is told the tensions that are within the
/// limits, and half the span.
fn look(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    motion: impl Fn(f64, f64) -> Motion,
    (from, to): (f64, f64),
    inside: impl FnOnce(&[Taylor], f64),
) -> Finding {
    let middle = 0.5 * (from + to);
    let half = (to - middle).max(middle - from);
    let span = Span::Between(from, to);
    shown::look(rig, limits, &motion(middle, half), span, |shown| inside(shown.tension, half))
}
