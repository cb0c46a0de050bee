//! A proof, for any rig and any step in all six coordinates, that no tension leaves its limits on the way.
//!
//! The motion under the law (4) is known in closed form, so the tensions of six cables are known functions of time. They are enclosed,
//! rounding included, over a few spans that cover all time from the step on. More cables may share the load in many ways: one that
//! keeps the limits is shown over each span. `docs/certificate.md` derives the method.

pub mod along;
pub mod margins;
pub mod motion;
pub mod part;
pub mod proof;
pub mod proof_of_motion;
pub mod redundant;
pub mod search;
pub mod section;
mod shown;
pub mod statics;
pub mod taylor;
pub mod timed;

use thiserror::Error;

pub use margins::Margins;
pub use motion::Step;
pub use proof::{Proof, prove};
pub use proof_of_motion::prove_motion;
pub use timed::certify_motion;

use crate::robot::{CableSet, LEAST_CABLES, PerCable, Rig, TensionLimits};
use margins::{Extent, Tube};
use motion::Span;
use proof::{ProvedTube, Record, with_room};
use shown::{OfLaw, look};
use statics::{Cables, Pulling};
use taylor::Taylor;

/// What is known of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Proved: every tension stays strictly within the limits, and between these bounds (N), for ever. With more than six cables: the
    /// tensions can be chosen so.
    Admissible {
        /// A lower bound of all tensions, N.
        least: f64,
        /// An upper bound of all tensions, N.
        greatest: f64,
        /// An upper bound of what the tension of any one cable changes by on the way, N: with more than six cables, whose tensions may be
        /// shared in many ways, of what it can change by within those two bounds.
        change: f64,
    },
    /// Proved: a tension is at or beyond a limit.
    NotAdmissible {
        /// Number of the cable, from 1.
        cable: usize,
        /// When, s after the step.
        time: f64,
        /// Its tension then, N.
        tension: f64,
    },
    /// Proved of more than six cables: at this time a limit is broken however they share the load.
    NoDistribution {
        /// When, s after the step.
        time: f64,
        /// By how much some limit is broken at least, N.
        shortfall: f64,
        /// Numbers, from 1, of the cables whose least tension stands against it: they would have to pull less,
        at_least: CableSet,
        /// and of those whose greatest does: they would have to pull more.
        at_greatest: CableSet,
    },
    /// Neither could be proved.
    Undecided {
        /// About when the doubt stands, s after the step.
        time: f64,
        /// Length of the span that was looked at last, s: 0 at an instant, infinite for all time from then on.
        resolution: f64,
        /// Why.
        cause: Cause,
    },
}

/// Why nothing could be proved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The wrench matrix is singular, or nearly so.
    Singular,
    /// A tension touches its limit, or comes nearer to it than rounding or the margins allow to tell.
    TooClose,
    /// The work that was allowed did not suffice.
    Effort,
    /// An angle may get half a turn away from its set point, where the law turns back the other way round.
    HalfTurn,
    /// The pitch may get a quarter turn away from level, where roll and yaw turn the platform about one and the same axis: the law, which
    /// acts on the angles, cannot impose what it wants there.
    GimbalLock,
}

/// A question that makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CertificateError {
    /// Fewer than six cables hold no platform.
    #[error("the rig has {0} cables: at least 6 are needed")]
    Cables(usize),
    /// A number is out of range.
    #[error("{name} = {value} is not allowed: {allowed}")]
    Value {
        /// What the number is.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What would be right, in words.
        allowed: &'static str,
    },
}

/// Decides whether the whole motion from `step` keeps every tension u within u_min < u < u_max; of more than six cables, whether at every
/// time there are such tensions.
///
/// # Errors
/// [`CertificateError`] for a rig of fewer than six cables and for numbers that make no sense.
pub fn certify(rig: &Rig, step: &Step) -> Result<Verdict, CertificateError> {
    certify_within(rig, &rig.limits(), step, &mut { search::MOST_SPANS })
}

/// The same within other limits than the rig's, one pair for each cable, and looking at no more than `spans` spans of time, which are taken from
/// that number.
///
/// # Errors
/// As [`certify`].
pub fn certify_within(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    step: &Step,
    spans: &mut usize,
) -> Result<Verdict, CertificateError> {
    check(rig, limits, step)?;
    let decided = closed_form(rig, limits, step, spans, &mut Record::default());
    Ok(decided.map_or_else(|no| no, |range| range.admissible()))
}

/// The same of a robot that differs from the model by `margins`: of what is commanded and of what the cables pull. It must have been
/// at rest before the step, or in a motion no faster than the one that follows.
///
/// "Not admissible" is proved of the closed form. Where that is admissible and the margins take too much, the answer is "undecided".
///
/// More than six cables must be shared by (D1), which keeps `margins.law_margin` from the limits: at least `friction` and a ten-thousandth of how far the
/// tensions are from its reference.
///
/// # Errors
/// As [`certify`], and for margins that make no sense.
pub fn certify_with_margins(rig: &Rig, step: &Step, margins: &Margins) -> Result<Verdict, CertificateError> {
    decide(rig, step, margins, &mut Record::default())
}

/// What proves the verdict comes into `record`.
fn decide(
    rig: &Rig,
    step: &Step,
    margins: &Margins,
    record: &mut Record,
) -> Result<Verdict, CertificateError> {
    check(rig, &rig.limits(), step)?;
    check_margins(margins)?;
    let decided = if margins.are_none() {
        closed_form(rig, &rig.limits(), step, &mut { search::MOST_SPANS }, record)
    } else {
        with_margins(rig, step, margins, record)
    };
    Ok(decided.map_or_else(|no| no, |range| range.admissible()))
}

/// The bounds of the tensions, of more than six cables of some that keep the limits.
fn closed_form(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    step: &Step,
    spans: &mut usize,
    record: &mut Record,
) -> Result<Range, Verdict> {
    let tube = Tube::empty();
    if let Some(cause) = margins::lost_angles(step, &tube) {
        return Err(undecided_at_large(cause));
    }
    let mut range = Range::none(rig);
    search::cover(step, spans, |span| {
        look(rig, limits, &step.motion(span, &tube), span, |shown| {
            range.include(shown.tension, 0.0);
            record.add(span, shown);
        })
    })?;
    Ok(range)
}

/// Shows that all motions in a tube keep within the limits. `inside` is shown the cables as the law makes them pull, over spans that cover all time, and
/// of more than six what the law has to do with it.
fn walk(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    (step, tube): (&Step, &Tube),
    spans: &mut usize,
    mut inside: impl FnMut(Span, &Pulling, Option<OfLaw>),
) -> Result<(), Verdict> {
    if rig.cables.len() == LEAST_CABLES {
        let inside = |span, cables: &Cables| inside(span, &cables.pulling(), None);
        return search::walk(rig, step, tube, limits, spans, inside);
    }
    search::cover(step, spans, |span| {
        redundant::look(rig, limits, &step.motion(span, tube), (span, SHARE), |system, shared, law| {
            let tensions = &shared.tension;
            let near = law.nearness(system, tensions);
            let pulling = system.pulling(tensions, &shared.solved, near.distance);
            inside(span, &pulling, Some(OfLaw { shared, near }));
        })
    })
}

/// The tube depends on what the cables come to in it: that is guessed, and the guess shown right or made larger.
fn with_margins(rig: &Rig, step: &Step, margins: &Margins, record: &mut Record) -> Result<Range, Verdict> {
    let limits = limits_of_law(rig, margins);
    closed_form(rig, &rig.limits(), step, &mut { search::MOST_SPANS }, record)?;
    let mut extent = Extent::none();
    let still = (step, &Tube::empty());
    walk(rig, &limits, still, &mut { search::MOST_SPANS }, |_, pulling, _| extent.include(rig, pulling))
        .map_err(Verdict::of_a_tube)?;
    for _ in 0..MOST_GUESSES {
        let guess = extent.enlarged();
        let Some((found, range)) = in_a_tube(rig, step, margins, &guess, record)? else { break };
        extent = found;
        if extent.is_within(&guess) {
            record.replace_where(|roomier| {
                let guess = extent.enlarged();
                let shown = in_a_tube(rig, step, margins, &guess, roomier);
                matches!(shown, Ok(Some((found, _))) if found.is_within(&guess))
            });
            return Ok(range);
        }
    }
    Err(undecided_at_large(Cause::TooClose))
}

/// What the cables come to in the tube of a guess at that, and the tensions, all within the limits. `None` where there is no tube, or the law intrudes too far on its
/// margin.
fn in_a_tube(
    rig: &Rig,
    step: &Step,
    margins: &Margins,
    guess: &Extent,
    record: &mut Record,
) -> Result<Option<(Extent, Range)>, Verdict> {
    let (limits, friction) = (limits_of_law(rig, margins), margins.friction);
    let Some((disturbance, tube)) = margins::tube(rig, step, margins, guess) else { return Ok(None) };
    record.begin_again(ProvedTube { disturbance, extent: *guess, intrusion: None });
    let (mut extent, mut range, mut intruded) = (Extent::none(), Range::none(rig), 0.0_f64);
    walk(rig, &limits, (step, &tube), &mut { search::MOST_SPANS }, |span, pulling, of_law| {
        extent.include(rig, pulling);
        if let Some(of_law) = &of_law {
            intruded = intruded.max(of_law.near.intrusion);
        }
        record.add_with_room(span, pulling, of_law, &limits);
        range.include(pulling.tension, pulling.apart);
    })
    .map_err(Verdict::of_a_tube)?;
    let is_shared = rig.cables.len() > LEAST_CABLES;
    if is_shared && margins.law_margin <= friction + intruded {
        return Ok(None);
    }
    let intrusion = is_shared.then(|| with_room(intruded, margins.law_margin - friction));
    record.pulled(&limits, friction, intrusion);
    Ok(Some((extent, range.within(&limits, intruded).widened(friction))))
}

/// With what the law keeps from them, and of six cables what friction takes and adds.
fn limits_of_law(rig: &Rig, margins: &Margins) -> PerCable<TensionLimits> {
    let is_one = rig.cables.len() == LEAST_CABLES;
    let kept = if is_one { margins.friction } else { margins.law_margin };
    rig.limits().map(|limits| limits.shrunk(kept))
}

/// How far inside the limits, of how far they can be, tensions of more than six cables are shown: the nearer they are to the law's, the less is lost, and the
/// longer they keep the limits, the fewer spans are looked at.
const SHARE: f64 = 0.2;

/// Guesses at what the cables come to in the tube.
const MOST_GUESSES: usize = 5;

/// Bounds of the tensions seen, N.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    /// Least and greatest of each cable.
    of_cable: PerCable<[f64; 2]>,
}

impl Range {
    fn none(rig: &Rig) -> Self {
        Self { of_cable: rig.cables.map(|_| [f64::INFINITY, f64::NEG_INFINITY]) }
    }

    fn include(&mut self, tensions: &[Taylor], apart: f64) {
        for (seen, tension) in self.of_cable.iter_mut().zip(tensions) {
            let [least, greatest] = tension.range();
            *seen = [seen[0].min(least - apart), seen[1].max(greatest + apart)];
        }
    }

    /// Each cut off at its limits and what is intruded beyond them.
    fn within(mut self, limits: &PerCable<TensionLimits>, intruded: f64) -> Self {
        for (seen, limits) in self.of_cable.iter_mut().zip(limits) {
            *seen = [seen[0].max(limits.min - intruded), seen[1].min(limits.max + intruded)];
        }
        self
    }

    fn widened(self, by: f64) -> Self {
        Self { of_cable: self.of_cable.map(|[least, greatest]| [least - by, greatest + by]) }
    }

    fn admissible(&self) -> Verdict {
        let least = self.of_cable.iter().map(|seen| seen[0]).fold(f64::INFINITY, f64::min);
        let greatest = self.of_cable.iter().map(|seen| seen[1]).fold(f64::NEG_INFINITY, f64::max);
        Verdict::Admissible { least, greatest, change: self.change() }
    }

    /// What the tension of any one cable changes by, as the verdict says it.
    fn change(&self) -> f64 {
        if self.of_cable.len() == LEAST_CABLES {
            return self.of_cable.iter().map(|[least, greatest]| greatest - least).fold(0.0, f64::max);
        }
        let least = self.of_cable.iter().map(|seen| seen[0]).fold(f64::INFINITY, f64::min);
        let greatest = self.of_cable.iter().map(|seen| seen[1]).fold(f64::NEG_INFINITY, f64::max);
        greatest - least
    }
}

impl Verdict {
    /// That all motions in a tube leave the limits does not say which of them happens; nor does a tube so wide that it holds a singular pose
    /// make the motion itself singular.
    fn of_a_tube(self) -> Self {
        match self {
            Self::NotAdmissible { time, .. } | Self::NoDistribution { time, .. } => {
                Self::Undecided { time, resolution: 0.0, cause: Cause::TooClose }
            }
            Self::Undecided { time, resolution, cause: Cause::Singular } => {
                Self::Undecided { time, resolution, cause: Cause::TooClose }
            }
            other => other,
        }
    }
}

fn undecided_at_large(cause: Cause) -> Verdict {
    Verdict::Undecided { time: 0.0, resolution: f64::INFINITY, cause }
}

fn check(rig: &Rig, limits: &PerCable<TensionLimits>, step: &Step) -> Result<(), CertificateError> {
    let count = rig.cables.len();
    if count < LEAST_CABLES {
        return Err(CertificateError::Cables(count));
    }
    let finite = |name, values: &[f64]| {
        values.iter().try_for_each(|v| require(v.is_finite(), name, *v, "must be finite"))
    };
    let positive = |name, value: f64| {
        require(value.is_finite() && value > 0.0, name, value, "must be finite and greater than 0")
    };
    for (cable, limits) in rig.cables.iter().zip(limits) {
        finite("a coordinate of an anchor", cable.anchor.as_slice())?;
        finite("a coordinate of an attachment", cable.attachment.as_slice())?;
        require(limits.min >= 0.0, "limits.min", limits.min, "a cable cannot push: 0 or greater")?;
        require(limits.max > limits.min, "limits.max", limits.max, "must be greater than limits.min")?;
    }
    positive("mass", rig.mass)?;
    (0..3).try_for_each(|k| positive("inertia", rig.inertia[(k, k)]))?;
    finite("a component of gravity", rig.gravity.as_slice())?;
    finite("a component of the disturbance", rig.disturbance.as_slice())?;
    finite("a coordinate of the start", step.start.0.as_slice())?;
    finite("a rate of the start", step.rates.as_slice())?;
    finite("a coordinate of the set point", step.set_point.0.as_slice())?;
    positive("lambda", step.gains.lambda)?;
    positive("eta", step.gains.eta)
}

fn check_margins(margins: &Margins) -> Result<(), CertificateError> {
    require(margins.mass < 1.0, "margins.mass", margins.mass, "a relative error below 1")?;
    for (name, value) in [
        ("margins.mass", margins.mass),
        ("margins.centre_of_mass", margins.centre_of_mass),
        ("margins.force", margins.force),
        ("margins.torque", margins.torque),
        ("margins.friction", margins.friction),
        ("margins.law_margin", margins.law_margin),
        ("margins.accuracy", margins.accuracy),
        ("margins.sample_period", margins.sample_period),
        ("margins.delay", margins.delay),
    ] {
        require(value.is_finite() && value >= 0.0, name, value, "must be finite and 0 or greater")?;
    }
    Ok(())
}

fn require(ok: bool, name: &'static str, value: f64, allowed: &'static str) -> Result<(), CertificateError> {
    if ok { Ok(()) } else { Err(CertificateError::Value { name, value, allowed }) }
}
