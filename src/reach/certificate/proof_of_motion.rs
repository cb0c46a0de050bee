//! Why a motion in pieces keeps the limits: what a checker needs that trusts nobody (docs/proof.md).

use super::along::Piece;
use super::motion::{Motion, Span};
use super::proof::ProvedSpan;
use super::search::{Finding, MOST_SPANS};
use super::shown::look;
use super::taylor::Taylor;
use crate::robot::{PerCable, Rig, TensionLimits};

/// What proves that pieces, one after the other from rest to rest, and rest after them keep the limits.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedMotion {
    /// Of each piece spans that cover it, in their order; they count its time.
    pub spans: Vec<Vec<ProvedSpan>>,
    /// Of rest where the last piece ends.
    pub rest: ProvedSpan,
    /// By how much coordinates (m, rad) and rates (m/s, rad/s) jump at most where pieces join, and rates at both ends.
    pub jump: [f64; 2],
}

/// The proof within the rig's limits; `None` where there is none, or no piece. It allocates.
pub fn prove_motion(rig: &Rig, pieces: &[Piece]) -> Option<ProvedMotion> {
    let limits = rig.limits();
    let spans = pieces.iter().map(|piece| spans_of(rig, &limits, piece)).collect::<Option<_>>()?;
    let rest = rest_after(rig, &limits, pieces.last()?)?;
    Some(ProvedMotion { spans, rest, jump: jump(pieces) })
}

fn spans_of(rig: &Rig, limits: &PerCable<TensionLimits>, piece: &Piece) -> Option<Vec<ProvedSpan>> {
    let mut spans = vec![];
    let is_covered = piece.is_covered(rig, limits, &mut { MOST_SPANS }, |(from, to), shown| {
        spans.push(ProvedSpan::of(Span::Between(from, to), shown));
    });
    is_covered.then_some(spans)
}

fn rest_after(rig: &Rig, limits: &PerCable<TensionLimits>, last: &Piece) -> Option<ProvedSpan> {
    let nothing = [Taylor::ZERO; 6];
    let end = last.motion(last.duration, 0.0);
    let (rest, span) = (Motion { rates: nothing, accelerations: nothing, ..end }, Span::From(0.0));
    let mut proved = None;
    let found = look(rig, limits, &rest, span, |shown| proved = Some(ProvedSpan::of(span, shown)));
    proved.filter(|_| matches!(found, Finding::Inside))
}

fn jump(pieces: &[Piece]) -> [f64; 2] {
    let begins = || pieces.iter().map(|piece| piece.motion(0.0, 0.0));
    let ends = || pieces.iter().map(|piece| piece.motion(piece.duration, 0.0));
    let mut most = [0.0f64; 2];
    for (end, begin) in ends().zip(begins().skip(1)) {
        for k in 0..6 {
            most[0] = most[0].max((end.coordinates[k] - begin.coordinates[k]).size());
            most[1] = most[1].max((end.rates[k] - begin.rates[k]).size());
        }
    }
    let at_rest = begins().take(1).chain(ends().skip(pieces.len() - 1));
    most[1] = at_rest.flat_map(|motion| motion.rates).fold(most[1], |most, rate| most.max(rate.size()));
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::minimum_time::Course;
    use crate::plan::through::Through;
    use crate::plan::{ControllerParameters, Planner, PlannerKind};
    use crate::robot::{Coordinates, Pose, RigFile};

    /// Straight in closed form and turned, bent, with ramps, by a way point, and of eight cables.
    fn courses() -> Vec<(Rig, Course)> {
        let RigFile { rig: six, .. } = RigFile::default();
        let RigFile { rig: eight, home, .. } =
            RigFile::parse(include_str!("../../../rigs/eight.toml")).unwrap();
        let of = |rig: &Rig| ControllerParameters {
            planner: PlannerKind::MinimumTime,
            ..ControllerParameters::of(rig)
        };
        let from_rest = |parameters: ControllerParameters, from: &Pose, to: Coordinates| {
            let course = Planner::from(parameters).course_from_rest(from, &Pose(from.0 + to)).unwrap();
            (parameters.rig, course)
        };
        let (start, level) = (Pose::default(), Coordinates::new(0.12, 0.1, 0.0, 0.0, 0.0, 0.0));
        let turned = Coordinates::new(0.1, 0.0, 0.05, 0.0, 0.05, 0.1);
        let through = [start, Pose::at(0.06, 0.03, 0.98), Pose::at(0.12, 0.0, 1.0)];
        vec![
            from_rest(of(&six), &start, level),
            from_rest(of(&six), &start, turned),
            from_rest(ControllerParameters { lift: 0.1, ..of(&six) }, &start, level),
            from_rest(ControllerParameters { max_tension_rate: 300.0, ..of(&six) }, &start, level),
            (six, Through::new(&of(&six), &through).unwrap().course),
            from_rest(of(&eight), &home, Coordinates::new(0.5, 0.3, 0.0, 0.0, 0.0, 0.1)),
        ]
    }

    fn at(numbers: &[Taylor; 6]) -> Coordinates {
        Coordinates::from_fn(|k, _| numbers[k].coefficients[0])
    }

    #[test]
    fn a_proof_of_a_motion_covers_what_the_planner_leads_through() {
        for (rig, course) in courses() {
            let pieces: Vec<_> = course.pieces().unwrap().collect();
            let ProvedMotion { spans, rest, jump } = prove_motion(&rig, &pieces).unwrap();
            assert_eq!(spans.len(), pieces.len());
            let mut begin = 0.0;
            for (piece, spans) in pieces.iter().zip(&spans) {
                let mut covered = 0.0;
                for proved in spans {
                    let Span::Between(from, to) = proved.span else { panic!("{:?}", proved.span) };
                    assert!(from == covered && to > from);
                    covered = to;
                }
                assert_eq!(covered, piece.duration);
                for share in [0.0, 0.3, 0.999] {
                    let motion = piece.motion(share * piece.duration, 0.0);
                    let led = course.at(begin + share * piece.duration);
                    assert!((at(&motion.coordinates) - led.pose.0).amax() < 1e-9);
                    assert!((at(&motion.rates) - led.rates).amax() < 1e-7);
                }
                begin += piece.duration;
            }
            assert!((begin - course.end()).abs() < 1e-9 && jump.iter().all(|jump| *jump < 1e-7), "{jump:?}");
            for proved in spans.iter().flatten().chain([&rest]) {
                for (bounds, cable) in proved.bounds.iter().zip(&rig.cables) {
                    assert!(cable.limits.min < bounds[0] && bounds[1] < cable.limits.max);
                }
            }
            assert_eq!(rest.span, Span::From(0.0));
        }
    }

    #[test]
    fn a_gap_between_pieces_is_a_jump_and_what_breaks_a_limit_is_not_proved() {
        let (rig, course) = courses().swap_remove(0);
        let mut pieces: Vec<_> = course.pieces().unwrap().collect();
        let [_, whole] = jump(&pieces);
        pieces.remove(0);
        assert!(whole < 1e-9 && jump(&pieces)[1] > 0.01, "{whole}");
        assert_eq!(prove_motion(&rig, &[]), None);
        let slack = rig.with_limits(TensionLimits { min: 0.0, max: 15.0 });
        assert_eq!(prove_motion(&slack, &pieces), None);
    }
}
