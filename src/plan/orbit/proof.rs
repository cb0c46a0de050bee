//! The proof of an orbit: its start, a turn at full size, its stop, and stops begun on the way. Derived in
//! docs/orbit.md.

use std::fmt;

use thiserror::Error;

use super::{Orbit, Trajectory};
use crate::control::{Sensitivity, static_tensions};
use crate::plan::ControllerParameters;
use crate::plan::planner::Planner;
use crate::reach::Curve;
use crate::reach::certificate::along::Seen;
use crate::reach::certificate::{Cause, Verdict, certify_motion};
use crate::robot::{CableSet, Coordinates, ParameterError, PerCable, Rig, TensionLimits};

/// Instants of a turn at which a stop may begin.
const STOPS: u32 = 24;
/// So short the enclosures are sharp.
const SPANS_OF_A_TURN: f64 = 32.0;
/// So many times as many are looked at before giving up.
const MORE_SPANS: f64 = 8.0;
/// Instants on the way up at which a stop may begin, at most.
const EARLY: u32 = 48;
/// Errors are looked at about rest: on the way they cost at most this many times as much, and as many times
/// as the cables pull more.
const BETWEEN: f64 = 2.0;
/// Where errors and held commands cost more than was left for them, an orbit is proved again, with this many
/// times as much.
const MORE: f64 = 1.05;
const PROOFS: usize = 2;
/// Turns.
const LONGEST_TRIED: f64 = 4.0;

/// A proved orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// The motion from rest to rest.
    pub trajectory: Trajectory,
    /// What is kept from the limits for errors, what is not known and held commands, N.
    pub kept: f64,
    /// Every tension is proved to be above this, N, on the way and on every stop (of more than six cables:
    /// there are such tensions), and
    pub least: f64,
    /// below this, N. Proved, not sharp.
    pub greatest: f64,
    /// The longest that it takes from any instant until the robot rests, s.
    pub longest_to_rest: f64,
    /// When the proved stops on the way up begin, s, the last one first.
    early: Vec<f64>,
}

/// Which part of an orbit is not proved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// Growing from the centre.
    Start,
    /// A turn at full size.
    Full,
    /// The stop that begins at this time, s.
    Stop(f64),
}

/// Why an orbit is not proved.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Where.
    pub part: Part,
    /// What was found instead; its time is counted from the start.
    pub verdict: Verdict,
    /// What was to be kept from the limits, N.
    pub kept: f64,
}

/// An orbit that is refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OrbitError {
    /// A number makes no sense.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A limit is broken, or may be.
    #[error("{0}")]
    Refused(Refusal),
}

/// What is asked of the proof.
struct Question<'a> {
    rig: &'a Rig,
    limits: PerCable<TensionLimits>,
    kept: f64,
    /// Span of time, s.
    longest: f64,
    seen: Seen,
}

impl Orbit {
    /// Proves that every tension keeps its limits on the start, a whole turn, the stop, and on a stop from
    /// each of 24 instants of a turn, for a robot that rests in the centre up to `error` (m, rad) and gets a
    /// command every `hold` seconds. Stops on the way up are proved where they can be: from where they
    /// cannot, the robot goes on to the next.
    ///
    /// # Errors
    /// [`OrbitError`]: a number that makes no sense, or the part that is not proved, with cable, time and
    /// tension.
    pub fn prove(
        &self,
        parameters: &ControllerParameters,
        error: &Coordinates,
        hold: f64,
    ) -> Result<Proof, OrbitError> {
        self.validate()?;
        parameters.validate()?;
        let planner = Planner::from(*parameters);
        self.check(parameters, hold)?;
        let (unknown, of_error, at_rest) = self.costs(&planner, error)?;
        let mut spare = planner.allowance().max(BETWEEN * of_error);
        let mut needed = 0.0;
        for _ in 0..PROOFS {
            let (proof, seen) = self.prove_within(&parameters.rig, unknown + spare)?;
            needed = of_error * BETWEEN.max(seen.greatest() / at_rest) + held(parameters, hold, &seen);
            if needed <= spare {
                return Ok(proof);
            }
            spare = MORE * needed;
        }
        let allowed = format!("on this orbit errors and commands held so long cost {needed:.3} N and more");
        Err(ParameterError { name: "step".into(), value: hold, allowed: allowed.into() }.into())
    }

    fn check(&self, parameters: &ControllerParameters, hold: f64) -> Result<(), ParameterError> {
        let longest = parameters.longest_hold();
        if (0.0..=longest).contains(&hold) {
            return Ok(());
        }
        let allowed = format!("must be from 0 to {longest:.3e} (s): 1/(lambda + eta) less commandDelay");
        Err(ParameterError { name: "step".into(), value: hold, allowed: allowed.into() })
    }

    /// What is not known costs, N, where it costs most of eight places of a turn; what an error costs at the
    /// centre, N; the greatest tension there, N.
    fn costs(&self, planner: &Planner, error: &Coordinates) -> Result<(f64, f64, f64), OrbitError> {
        let turning = self.endless();
        let place = |k: u32| turning.at(self.start + self.period() * f64::from(k) / 8.0).pose;
        let unknown =
            (0..4).map(|k| planner.unknown_on_the_way(&place(k), &place(k + 4))).fold(0.0, f64::max);
        let rig = &planner.parameters.rig;
        let rest = static_tensions(rig, &self.centre, planner.allowance());
        let (Some(rest), Some(sensitivity)) = (rest, Sensitivity::new(rig, &self.centre)) else {
            let verdict = Verdict::Undecided { time: 0.0, resolution: 0.0, cause: Cause::Singular };
            return Err(OrbitError::Refused(Refusal { part: Part::Start, verdict, kept: 0.0 }));
        };
        let gains = planner.parameters.gains();
        let of_cables = sensitivity.of_error(error, &Coordinates::zeros(), &gains);
        let of_cable = |[b, c]: [f64; 2]| {
            let extremes = Curve { a: 0.0, b, c, d: 0.0 }.extremes(&gains);
            extremes.max.max(-extremes.min)
        };
        let of_error = of_cables.into_iter().map(of_cable).fold(0.0, f64::max);
        Ok((unknown, of_error, rest.into_iter().fold(0.0, f64::max)))
    }

    fn prove_within(&self, rig: &Rig, kept: f64) -> Result<(Proof, Seen), OrbitError> {
        let limits = rig.limits().map(|limits| limits.shrunk(kept));
        let longest = self.period() / SPANS_OF_A_TURN;
        let mut question = Question { rig, limits, kept, longest, seen: Seen::none(rig) };
        let endless = self.endless();
        let (start, period) = (self.start, self.period());
        question.shows(&endless, [start, start + period], Part::Full)?;
        question.shows(&endless, [0.0, start], Part::Start)?;
        let trajectory = self.trajectory();
        question.stops(&trajectory)?;
        for k in 0..STOPS {
            question.stops(&endless.stopped(start + self.interval() * f64::from(k)))?;
        }
        let early = self.early().filter(|begin| question.stops(&endless.stopped(*begin)).is_ok()).collect();
        let [least, greatest] = question.seen.extremes();
        let mut proof = Proof { trajectory, kept, least, greatest, longest_to_rest: 0.0, early };
        proof.longest_to_rest = proof.longest_to_rest();
        Ok((proof, question.seen))
    }

    /// Between two instants at which a stop may begin, s.
    fn interval(&self) -> f64 {
        self.period() / f64::from(STOPS)
    }

    /// When a stop on the way up may begin, s, the last one first: whole intervals before full size.
    fn early(&self) -> impl Iterator<Item = f64> {
        let (start, interval) = (self.start, self.interval());
        let count = (start / interval).floor() as u32;
        let step = count.div_ceil(EARLY).max(1);
        (1..=count / step).map(move |k| start - interval * f64::from(k * step))
    }

    /// The longest start that is tried, s.
    pub fn longest_start(&self) -> f64 {
        LONGEST_TRIED * self.period()
    }

    /// The shortest start of those tried, down from four turns to an eighth of one, with which the orbit is
    /// proved.
    pub fn with_shortest_start(&self, parameters: &ControllerParameters, hold: f64) -> Option<Self> {
        let start = |k: i32| self.longest_start() * libm::exp2(-0.125 * f64::from(k));
        let tried = (0..=40).rev().map(|k| Self { start: start(k), ..*self });
        // What is not proved at full size is not with any start.
        let mut tried = tried.map(|orbit| (orbit, orbit.prove(parameters, &Coordinates::zeros(), hold)));
        let (orbit, found) = tried.find(|(_, found)| found.is_ok() || !depends_on_start(found))?;
        found.is_ok().then_some(orbit)
    }

    /// The quickest from rest to rest, with the shortest start of each, of those at its own rate and at lower
    /// ones, down to half of it.
    pub fn quickest(&self, parameters: &ControllerParameters, hold: f64) -> Option<Self> {
        let slower = (0..=8).map(|k| Self { rate: self.rate * libm::exp2(-0.125 * f64::from(k)), ..*self });
        let proved = slower.filter_map(|orbit| orbit.with_shortest_start(parameters, hold));
        let duration = |orbit: &Self| orbit.trajectory().end();
        proved.min_by(|a, b| duration(a).total_cmp(&duration(b)))
    }

    /// The largest radius with which it is proved, to a thousandth of its own, if a smaller one is.
    pub fn with_largest_radius(&self, parameters: &ControllerParameters, hold: f64) -> Option<Self> {
        let resized =
            |share: f64| Self { figure: self.figure.with_radius(share * self.figure.radius()), ..*self };
        let (mut proved, mut refused) = (0.0, 1.0);
        for _ in 0..10 {
            let share = 0.5 * (proved + refused);
            let is_proved = resized(share).prove(parameters, &Coordinates::zeros(), hold).is_ok();
            *(if is_proved { &mut proved } else { &mut refused }) = share;
        }
        (proved > 0.0).then(|| resized(proved))
    }
}

fn depends_on_start(found: &Result<Proof, OrbitError>) -> bool {
    matches!(found, Err(OrbitError::Refused(Refusal { part: Part::Start | Part::Stop(_), .. })))
}

/// What holding commands costs, N: docs/minimum-time.md, without what jumps of the tensions cost, for there
/// are none.
fn held(parameters: &ControllerParameters, hold: f64, seen: &Seen) -> f64 {
    let gains = parameters.gains();
    let (span, sum) = (hold * (hold + parameters.command_delay), gains.lambda + gains.eta);
    span * (sum * seen.first / 8.0 + (1.0 + 2.0 * gains.z_m()) * seen.second / 24.0)
}

impl Question<'_> {
    fn shows(&mut self, trajectory: &Trajectory, span: [f64; 2], part: Part) -> Result<(), OrbitError> {
        let motion = |middle: f64, half: f64| trajectory.enclosed(middle, half);
        let mut spans = (MORE_SPANS * (1.0 + (span[1] - span[0]) / self.longest)) as usize;
        certify_motion(self.rig, &self.limits, span, motion, self.longest, &mut spans, &mut self.seen)
            .map_err(|verdict| OrbitError::Refused(Refusal { part, verdict, kept: self.kept }))
    }

    /// The stop of a trajectory.
    fn stops(&mut self, trajectory: &Trajectory) -> Result<(), OrbitError> {
        let [_, _, stop] = trajectory.pieces();
        self.shows(trajectory, stop, Part::Stop(stop[0]))
    }
}

impl Proof {
    /// The motion with the first proved stop that begins at a time (s) or later.
    pub fn stopped(&self, time: f64) -> Trajectory {
        let orbit = &self.trajectory.orbit;
        let after = ((time - orbit.start) / orbit.interval()).ceil().max(0.0);
        let at_full_size = orbit.start + orbit.interval() * after;
        let early = self.early.iter().take_while(|begin| **begin >= time).last();
        self.trajectory.stopped(*early.unwrap_or(&at_full_size))
    }

    /// From just after an instant at which a stop begins the next one is waited for; the same in every turn.
    fn longest_to_rest(&self) -> f64 {
        let orbit = &self.trajectory.orbit;
        let after = |begin: f64| self.stopped(begin + 0.5 * orbit.interval()).end() - begin;
        self.early.iter().copied().chain([0.0, orbit.start]).map(after).fold(0.0, f64::max)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.part {
            Part::Start => write!(f, "the start: ")?,
            Part::Full => write!(f, "at full size: ")?,
            Part::Stop(begin) => write!(f, "the stop begun {begin:.3} s after the start: ")?,
        }
        let kept = self.kept;
        match self.verdict {
            Verdict::NotAdmissible { cable, time, tension } => {
                write!(f, "cable {cable} would pull {tension:.3} N after {time:.3} s")?;
            }
            Verdict::NoDistribution { time, shortfall, at_least, at_greatest } => {
                write!(
                    f,
                    "after {time:.3} s no tensions keep the limits, at best they break them by {shortfall:.3} N"
                )?;
                let held = [(at_least, "less"), (at_greatest, "more")];
                for (cables, way) in held.into_iter().filter(|(cables, _)| !cables.is_empty()) {
                    write!(f, "; {} would have to pull {way}", named(cables))?;
                }
            }
            Verdict::Undecided { time, cause, .. } => {
                let why = match cause {
                    Cause::Singular => "the wrench matrix is singular, or nearly so",
                    Cause::Effort => "the work that is allowed did not suffice",
                    _ => "a tension comes too near to its limit to tell",
                };
                write!(f, "undecided about {time:.3} s: {why}")?;
            }
            Verdict::Admissible { .. } => {}
        }
        write!(f, " ({kept:.3} N are kept from every limit)")
    }
}

fn named(cables: CableSet) -> String {
    let numbers: Vec<_> = cables.numbers().map(|number| number.to_string()).collect();
    format!("{} {}", if numbers.len() == 1 { "cable" } else { "cables" }, numbers.join(", "))
}
