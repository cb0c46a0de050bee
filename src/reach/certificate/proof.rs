//! Why a verdict is right: what a checker needs that trusts nobody (docs/proof.md).

use super::margins::{Extent, Margins, Tube};
use super::motion::{Span, Step};
use super::redundant;
use super::shown::{OfLaw, Shown};
use super::statics::{Pulling, Solved, cables};
use super::taylor::Taylor;
use super::{CertificateError, Verdict, decide};
use crate::robot::{Coordinates, PerCable, Rig, TensionLimits};

/// By which share of themselves claims about a tube are wider than what proves them here: other arithmetic encloses it in another way, and cuts do not make it narrower.
const ROOM: f64 = 0.25;
/// What a few sums of tensions are off by, as a share of these.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// What proves a verdict.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// Of all motions in a tube where there are margins, else of the closed form.
    Admissible {
        /// Cover all time, in their order; the last has no end.
        spans: Vec<ProvedSpan>,
        /// Of a rig with margins.
        tube: Option<ProvedTube>,
    },
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
    /// Of more than six cables with margins: the law's tensions beside those of the unknowns.
    pub law: Option<NearLaw>,
    /// Least and greatest tension of each cable, N: with margins those that it may pull.
    pub bounds: PerCable<[f64; 2]>,
}

/// How far the tensions of the law (D1) are from others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearLaw {
    /// Of the wrench matrix's rows, as of (D1).
    pub multipliers: [f64; 6],
    /// The norm of the difference at most, N.
    pub distance: f64,
}

/// Tension over length of cable i is `base`ᵢ + `basis`ᵢ · y, with six unknowns y.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// N/m.
    pub base: PerCable<f64>,
    /// Of any unit: y has what makes it N/m.
    pub basis: PerCable<[f64; 6]>,
}

/// What shows how far a robot that differs from the rig may be from the closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedTube {
    /// Bounds of the accelerations that the model does not know: those that come about are smaller. m/s² and rad/s².
    pub disturbance: Coordinates,
    /// What the cables come to in the tube, at most.
    pub extent: Extent,
    /// Of more than six cables: by how much the law may intrude on its margin, N.
    pub intrusion: Option<f64>,
}

/// What is shown on the way to a verdict, where a proof is wanted; by default none is, and nothing is allocated.
#[derive(Default)]
pub(super) struct Record {
    spans: Option<Vec<ProvedSpan>>,
    tube: Option<ProvedTube>,
}

impl Record {
    fn wanted() -> Self {
        Self { spans: Some(vec![]), tube: None }
    }

    pub fn add(&mut self, span: Span, shown: &Shown) {
        if let Some(spans) = &mut self.spans {
            spans.push(ProvedSpan::of(span, shown));
        }
    }

    /// Of motions in a tube, with tensions within `limits`.
    pub fn add_with_room(
        &mut self,
        span: Span,
        pulling: &Pulling,
        of_law: Option<OfLaw>,
        limits: &PerCable<TensionLimits>,
    ) {
        if let Some(spans) = &mut self.spans {
            let shared = of_law.as_ref().map(|of_law| of_law.shared);
            let shown = Shown { tension: pulling.tension, solved: pulling.solved, shared };
            let law = of_law.map(|OfLaw { near, .. }| NearLaw {
                multipliers: near.multipliers,
                distance: near.distance * (1.0 + ROOM),
            });
            spans.push(ProvedSpan { law, ..ProvedSpan::of(span, &shown).with_room(pulling.tension, limits) });
        }
    }

    /// From the tensions shown to those that are pulled: of more than six cables the law's, which keep within `limits` but for `intrusion` (N), and then within `friction` (N)
    /// of these.
    pub fn pulled(&mut self, limits: &PerCable<TensionLimits>, friction: f64, intrusion: Option<f64>) {
        for span in self.spans.iter_mut().flatten() {
            span.bounds = span.pulled(limits, friction, intrusion);
        }
        if let Some(tube) = &mut self.tube {
            tube.intrusion = intrusion;
        }
    }

    /// With a tube, of which nothing is shown yet.
    pub fn begin_again(&mut self, tube: ProvedTube) {
        if let Some(spans) = &mut self.spans {
            spans.clear();
            self.tube = Some(tube);
        }
    }

    /// By another in which all is shown anew, where a proof is wanted and it is shown: of a larger guess, which leaves room for other arithmetic.
    pub fn replace_where(&mut self, is_shown: impl FnOnce(&mut Self) -> bool) {
        let mut other = Self::wanted();
        if self.spans.is_some() && is_shown(&mut other) {
            *self = other;
        }
    }

    fn admissible(self) -> Option<Proof> {
        Some(Proof::Admissible { spans: in_order(self.spans?), tube: self.tube })
    }
}

/// What is `found`, with room for other arithmetic: at most half way to what is `allowed`.
pub(super) fn with_room(found: f64, allowed: f64) -> f64 {
    (found * (1.0 + ROOM)).min(0.5 * (found + allowed))
}

/// As [`certify_with_margins`](super::certify_with_margins), with the proof where there is one; it allocates.
///
/// # Errors
/// As [`certify_with_margins`](super::certify_with_margins).
pub fn prove(
    rig: &Rig,
    step: &Step,
    margins: &Margins,
) -> Result<(Verdict, Option<Proof>), CertificateError> {
    let mut record = Record::wanted();
    let verdict = decide(rig, step, margins, &mut record)?;
    let proof = match verdict {
        Verdict::Admissible { .. } => record.admissible(),
        Verdict::NotAdmissible { cable, time, .. } => beyond(rig, step, cable, time),
        Verdict::NoDistribution { time, shortfall, .. } => none_keeps(rig, step, time, shortfall),
        Verdict::Undecided { .. } => None,
    };
    Ok((verdict, proof))
}

impl ProvedSpan {
    pub(super) fn of(span: Span, shown: &Shown) -> Self {
        let spread = shown.shared.map(|shared| Spread { base: shared.base, basis: shared.basis });
        let bounds = PerCable::from_fn(shown.tension.len(), |i| shown.tension[i].range());
        Self { span, spread, solved: *shown.solved, law: None, bounds }
    }

    /// Wider by [`ROOM`], or by less where that takes half of what is left to the limits.
    fn with_room(mut self, tension: &[Taylor], limits: &PerCable<TensionLimits>) -> Self {
        let allowed = |i: usize| {
            let [least, greatest] = self.bounds[i];
            0.25 * limits[i].margin(least).min(limits[i].margin(greatest)) / tension[i].error
        };
        let room = (0..tension.len()).map(allowed).fold(ROOM, f64::min);
        for unknown in &mut self.solved.unknowns {
            unknown.error *= 1.0 + room;
        }
        // What is added to the unknowns' errors, and as much again.
        for ([least, greatest], tension) in self.bounds.iter_mut().zip(tension) {
            let by = 2.0 * room * tension.error;
            (*least, *greatest) = (*least - by, *greatest + by);
        }
        self
    }

    /// Bounds of what is pulled where `bounds` are those of the tensions shown.
    fn pulled(
        &self,
        limits: &PerCable<TensionLimits>,
        friction: f64,
        intrusion: Option<f64>,
    ) -> PerCable<[f64; 2]> {
        let (apart, intrusion) = (self.law.map_or(0.0, |law| law.distance), intrusion.unwrap_or(0.0));
        PerCable::from_fn(self.bounds.len(), |i| {
            let ([least, greatest], limits) = (self.bounds[i], limits[i]);
            let rounding = ROUNDING * (greatest + apart + friction);
            let least = (least - apart).max(limits.min - intrusion) - friction;
            let greatest = (greatest + apart).min(limits.max + intrusion) + friction;
            [least - rounding, greatest + rounding]
        })
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
    use super::super::margins::tube;
    use super::super::motion::Motion;
    use super::super::statics::System;
    use super::super::{certify, certify_with_margins};
    use super::*;
    use crate::control::Gains;
    use crate::control::distribution::share;
    use crate::robot::{Coordinates, LEAST_CABLES, Pose, RigFile};
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

    /// Of six and eight cables, each margin there or not, in the size of what the paper's rig bears.
    fn random_problems_with_margins(count: usize) -> impl Iterator<Item = (Rig, Step, Margins)> {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(16);
        random_problems(count).map(move |(mut rig, step)| {
            if rig.cables.len() == LEAST_CABLES {
                // A uniform disc: stiffer than Table I's.
                rig.inertia = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(0.125, 0.125, 0.25));
            }
            let step = Step { set_point: Pose(step.start.0.lerp(&step.set_point.0, 0.4)), ..step };
            let mut any = |size: f64| if rng.random_bool(0.4) { rng.random_range(0.0..size) } else { 0.0 };
            let margins = Margins {
                mass: any(0.01),
                centre_of_mass: any(3e-5),
                force: any(0.1),
                torque: any(1e-3),
                friction: any(1e-2),
                law_margin: 0.0017 * rig.weight(),
                accuracy: any(3e-5),
                sample_period: any(1e-3),
                delay: any(1e-3),
            };
            (rig, step, margins)
        })
    }

    fn at(unknowns: &[Taylor; 6], tau: f64) -> [f64; 6] {
        unknowns.map(|unknown| unknown.coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c))
    }

    #[test]
    fn a_verdict_is_the_same_with_and_without_its_proof() {
        let (mut proved, mut refused) = (0, 0);
        for (rig, step) in random_problems(200) {
            let (verdict, proof) = prove(&rig, &step, &Margins::default()).unwrap();
            assert_eq!(format!("{verdict:?}"), format!("{:?}", certify(&rig, &step).unwrap()));
            match proof {
                Some(Proof::Admissible { .. }) => proved += 1,
                Some(_) => refused += 1,
                None => assert!(matches!(verdict, Verdict::Undecided { .. })),
            }
        }
        assert!(proved > 50 && refused > 50, "{proved} and {refused}");
    }

    #[test]
    fn a_verdict_with_margins_is_the_same_with_and_without_its_proof() {
        let mut counts = [0; 3];
        for (rig, step, margins) in random_problems_with_margins(200) {
            let (verdict, proof) = prove(&rig, &step, &margins).unwrap();
            let without = certify_with_margins(&rig, &step, &margins).unwrap();
            assert_eq!(format!("{verdict:?}"), format!("{without:?}"));
            counts[match proof {
                Some(Proof::Admissible { tube, .. }) => {
                    assert_eq!(tube.is_some(), !margins.are_none());
                    0
                }
                Some(_) => 1,
                None => 2,
            }] += 1;
        }
        assert!(counts[0] > 20 && counts[1] > 20, "{counts:?}");
    }

    /// Of motions anywhere in the tube, with what friction takes and adds.
    #[test]
    fn a_proof_with_margins_speaks_of_all_motions_in_the_tube() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(17);
        let (mut seen, mut nearest) = (0, f64::INFINITY);
        let of_six = random_problems_with_margins(120).filter(|(rig, ..)| rig.cables.len() == LEAST_CABLES);
        for (rig, step, margins) in of_six {
            let Some(Proof::Admissible { spans, tube: Some(proved) }) =
                prove(&rig, &step, &margins).unwrap().1
            else {
                continue;
            };
            let (bound, tube) = tube(&rig, &step, &margins, &proved.extent).unwrap();
            assert_eq!(bound, proved.disturbance);
            for proved in spans {
                for (bounds, cable) in proved.bounds.iter().zip(&rig.cables) {
                    assert!(cable.limits.min < bounds[0] && bounds[1] < cable.limits.max);
                }
                for tau in [-1.0, -0.2, 0.6, 1.0] {
                    let time = proved.span.time(tau);
                    let there = cables(&rig, &at_an_end(&step, &tube, time, &mut rng)).unwrap();
                    let near = at(&proved.solved.unknowns, tau);
                    for i in 0..6 {
                        let u = there.tension[i].coefficients[0];
                        let [least, greatest] = proved.bounds[i];
                        nearest = nearest.min((u - least).min(greatest - u) - margins.friction);
                        let off = (there.solved.unknowns[i].coefficients[0] - near[i]).abs();
                        assert!(off <= proved.solved.unknowns[i].error, "{off} of cable {i} at {time}");
                    }
                    seen += 1;
                }
            }
        }
        assert!(seen > 200 && nearest > 0.0, "{seen}, {nearest} N");
    }

    /// A motion at this time that is as far from the closed form as the tube allows.
    fn at_an_end(step: &Step, tube: &Tube, time: f64, rng: &mut rand_pcg::Pcg64) -> Motion {
        let mut motion = step.motion(Span::Between(time, time), &Tube::empty());
        for (values, radii) in [
            (&mut motion.coordinates, &tube.coordinates),
            (&mut motion.rates, &tube.rates),
            (&mut motion.accelerations, &tube.accelerations),
        ] {
            for (value, radius) in values.iter_mut().zip(radii.iter()) {
                value.coefficients[0] += if rng.random_bool(0.5) { *radius } else { -radius };
            }
        }
        motion
    }

    /// Of eight cables the law's, as near to those of the unknowns as is said, anywhere in the tube.
    #[test]
    fn a_proof_with_margins_bounds_the_laws_tensions_of_more_than_six_cables() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(18);
        let (mut seen, mut nearest) = (0, f64::INFINITY);
        let of_more = random_problems_with_margins(240).filter(|(rig, ..)| rig.cables.len() > LEAST_CABLES);
        for (rig, step, margins) in of_more {
            let Some(Proof::Admissible { spans, tube: Some(proved) }) =
                prove(&rig, &step, &margins).unwrap().1
            else {
                continue;
            };
            let tube = tube(&rig, &step, &margins, &proved.extent).unwrap().1;
            for span in spans {
                let (law, spread) = (span.law.unwrap(), span.spread.unwrap());
                for tau in [-1.0, -0.3, 0.5, 1.0] {
                    let motion = at_an_end(&step, &tube, span.span.time(tau), &mut rng);
                    let system = System::new(&rig, &motion).unwrap();
                    let (matrix, wrench) = redundant::middle(&system);
                    let pulled = share(&rig, &matrix, &wrench, margins.law_margin).unwrap();
                    let near = at(&span.solved.unknowns, tau);
                    let mut square = 0.0;
                    for (i, u) in pulled.iter().enumerate() {
                        let [least, greatest] = span.bounds[i];
                        nearest = nearest.min((u - least).min(greatest - u) - margins.friction);
                        let length = system.length[i].coefficients[0];
                        let of_basis: f64 = (0..6).map(|k| spread.basis[i][k] * near[k]).sum();
                        let unsure: f64 =
                            (0..6).map(|k| spread.basis[i][k].abs() * span.solved.unknowns[k].error).sum();
                        let off = (u - length * (spread.base[i] + of_basis)).abs() - length * unsure;
                        square += off.max(0.0).powi(2);
                    }
                    assert!(square.sqrt() <= law.distance, "{} of {}", square.sqrt(), law.distance);
                    seen += 1;
                }
            }
        }
        assert!(seen > 200 && nearest > 0.0, "{seen}, {nearest} N");
    }

    #[test]
    fn spans_of_a_proof_cover_all_time_within_the_limits() {
        let plain = random_problems(100).map(|(rig, step)| (rig, step, Margins::default()));
        for (rig, step, margins) in plain.chain(random_problems_with_margins(50)) {
            let Some(Proof::Admissible { spans, .. }) = prove(&rig, &step, &margins).unwrap().1 else {
                continue;
            };
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
            let Some(Proof::Admissible { spans, .. }) = prove(&rig, &step, &Margins::default()).unwrap().1
            else {
                continue;
            };
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
            match prove(&rig, &step, &Margins::default()).unwrap() {
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
                (Verdict::Admissible { .. }, Some(Proof::Admissible { .. }))
                | (Verdict::Undecided { .. }, None) => {}
                other => panic!("{other:?}"),
            }
        }
        assert!(of_cable > 10 && of_all > 10, "{of_cable} and {of_all}");
    }
}
