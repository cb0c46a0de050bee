//! Proof files: docs/proof.md says what they hold, and what must be seen of them.

mod document;
mod entries;
mod layout;
mod number;

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use cable_robot::reach::certificate::along::Piece;
use cable_robot::reach::certificate::proof::ProvedSpan;
use cable_robot::reach::certificate::proof_of_motion::ProvedMotion;
use cable_robot::reach::certificate::{Margins, Proof, Step, Verdict, prove, prove_motion};
use cable_robot::robot::Rig;
use cable_robot::robot::rig_file::without_null;
use cable_robot_report::files::write_whole;
use schemars::{Schema, schema_for};
use sha2::{Digest, Sha256};

pub use document::Document;
use document::{ADMISSIBLE, FORMAT, InstantEntry, NOT_ADMISSIBLE, Problem, VERSION};
pub use layout::laid_out;
use number::Number;

use crate::command::say;

/// JSON Schema of proof files.
pub fn schema() -> Schema {
    let mut schema = schema_for!(Document);
    without_null(&mut schema);
    schema
}

/// Decides a step, writes what proves the verdict and says so; or that nothing is proved.
pub fn write(path: &Path, rig: &Rig, step: &Step, margins: &Margins) -> Result<Verdict> {
    let (verdict, proof) = prove(rig, step, margins)?;
    let document = proof.map(|proof| document(rig, step, margins, &proof)).transpose()?;
    write_document(path, document)?;
    Ok(verdict)
}

fn write_document(path: &Path, document: Option<Document>) -> Result<()> {
    let Some(document) = document else {
        say(format_args!("{} is not written: nothing is proved", path.display()));
        return Ok(());
    };
    let text = laid_out(&document)?;
    write_whole(path, |writer| writer.write_all(&text))?;
    say(format_args!("{}: proof of the problem with SHA-256 {}", path.display(), document.sha256));
    Ok(())
}

/// Writes what proves a motion in pieces and says so; or that nothing is proved.
pub fn write_motion(path: &Path, rig: &Rig, pieces: &[Piece]) -> Result<()> {
    let proved = prove_motion(rig, pieces);
    write_document(path, proved.map(|proved| document_of_motion(rig, pieces, &proved)).transpose()?)
}

/// What proves a motion in pieces.
pub fn document_of_motion(
    rig: &Rig,
    pieces: &[Piece],
    proved: &ProvedMotion,
) -> serde_json::Result<Document> {
    let numbered =
        || proved.spans.iter().zip(1..).flat_map(|(spans, piece)| spans.iter().map(move |_| piece));
    let mut document =
        admissible(problem_of_motion(rig, pieces), proved.spans.iter().flatten().chain([&proved.rest]))?;
    for (span, piece) in document.spans.iter_mut().flatten().zip(numbered().map(Some).chain([None])) {
        span.piece = piece;
        span.from = span.from.filter(|_| piece.is_some());
    }
    document.jump = Some(proved.jump.map(Number));
    Ok(document)
}

/// What proves the verdict about a step.
pub fn document(rig: &Rig, step: &Step, margins: &Margins, proof: &Proof) -> serde_json::Result<Document> {
    let problem = problem(rig, step, margins);
    match proof {
        Proof::Admissible { spans, tube } => {
            let mut document = admissible(problem, spans.iter())?;
            document.tube = tube.as_ref().map(entries::tube);
            Ok(document)
        }
        Proof::NotAdmissible { cable, time, solved, bounds: [least, greatest] } => refused(
            problem,
            InstantEntry::OfCable {
                time: Number(*time),
                cable: *cable,
                inverse: Box::new(entries::inverse(solved)),
                solution: solved.unknowns.map(|unknown| [Number(unknown.coefficients[0])]),
                error: entries::error(solved),
                least: Number(*least),
                greatest: Number(*greatest),
            },
        ),
        Proof::NoDistribution { time, multipliers, shortfall } => refused(
            problem,
            InstantEntry::OfAll {
                time: Number(*time),
                multipliers: multipliers.map(Number),
                shortfall: Number(*shortfall),
            },
        ),
    }
}

fn problem(rig: &Rig, step: &Step, margins: &Margins) -> Problem {
    Problem {
        rig: entries::rig(rig),
        step: Some(entries::step(step)),
        margins: (!margins.are_none()).then(|| entries::margins(margins, rig.cables.len())),
        motion: None,
    }
}

fn problem_of_motion(rig: &Rig, pieces: &[Piece]) -> Problem {
    Problem { rig: entries::rig(rig), step: None, margins: None, motion: Some(entries::motion(pieces)) }
}

fn admissible<'a>(
    problem: Problem,
    spans: impl Iterator<Item = &'a ProvedSpan> + Clone,
) -> serde_json::Result<Document> {
    let bounds = || spans.clone().flat_map(|proved| proved.bounds);
    let mut document = stated(problem, ADMISSIBLE)?;
    document.least = Some(Number(bounds().map(|[least, _]| least).fold(f64::INFINITY, f64::min)));
    document.greatest = Some(Number(bounds().map(|[_, most]| most).fold(f64::NEG_INFINITY, f64::max)));
    document.spans = Some(spans.map(entries::span).collect());
    Ok(document)
}

fn refused(problem: Problem, instant: InstantEntry) -> serde_json::Result<Document> {
    Ok(Document { instant: Some(instant), ..stated(problem, NOT_ADMISSIBLE)? })
}

/// A verdict, not yet proved.
fn stated(problem: Problem, verdict: &'static str) -> serde_json::Result<Document> {
    let sha256 = digest(&problem)?;
    Ok(Document {
        format: FORMAT,
        version: VERSION,
        problem,
        sha256,
        verdict,
        least: None,
        greatest: None,
        spans: None,
        tube: None,
        jump: None,
        instant: None,
    })
}

/// Of the text with sorted keys and no white space: a map of JSON values sorts its keys.
fn digest(problem: &Problem) -> serde_json::Result<String> {
    let canonical = serde_json::to_value(problem)?.to_string();
    Ok(Sha256::digest(canonical).iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use cable_robot::control::Gains;
    use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
    use cable_robot::reach::certificate::part::Part;
    use cable_robot::reach::certificate::section::Section;
    use cable_robot::robot::{Coordinates, Pose, Pulley, RigFile};

    use super::*;

    const EIGHT: &str = include_str!("../../../rigs/eight.toml");

    fn step(start: [f64; 3], set_point: [f64; 6]) -> Step {
        let [x, y, z] = start;
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        Step {
            start: Pose::at(x, y, z),
            rates: Coordinates::zeros(),
            set_point: Pose(set_point.into()),
            gains,
        }
    }

    fn of_step(rig: &Rig, step: &Step, margins: &Margins) -> Document {
        let proof = prove(rig, step, margins).unwrap().1.unwrap();
        document(rig, step, margins, &proof).unwrap()
    }

    /// In minimum time, straight and level.
    fn of_motion(rig: &Rig, to: &Pose) -> Document {
        let planner = PlannerKind::MinimumTime;
        let planner = Planner::from(ControllerParameters { planner, ..ControllerParameters::of(rig) });
        let course = planner.course_from_rest(&Pose::default(), to).unwrap();
        let pieces: Vec<_> = course.pieces().unwrap().collect();
        document_of_motion(rig, &pieces, &prove_motion(rig, &pieces).unwrap()).unwrap()
    }

    /// The examples of docs/proof.md, bit for bit: of six and eight cables, admissible and not, and with margins; of a motion.
    #[test]
    fn proofs_that_are_checked_in_are_written_again() {
        let (six, eight) = (RigFile::default().rig, RigFile::parse(EIGHT).unwrap().rig);
        let none = Margins::default();
        let some = Margins { mass: 0.005, force: 0.1, sample_period: 0.001, ..none };
        let law_margin = Planner::from(ControllerParameters::of(&eight)).allowance();
        let of_law = Margins { force: 1.0, friction: 0.01, law_margin, ..none };
        let moved = step([0.0, 0.0, 1.0], [0.1, 0.05, 0.9, 0.05, 0.0, 0.1]);
        for (document, there) in [
            (of_step(&six, &moved, &none), include_str!("../../../docs/proofs/six-admissible.json")),
            (
                of_step(&six, &step([0.0, 0.0, 1.0], [0.3, 0.0, 1.0, 0.0, 0.0, 0.0]), &none),
                include_str!("../../../docs/proofs/six-refused.json"),
            ),
            (
                of_step(&six, &step([0.0, 0.0, 1.0], [0.06, 0.03, 1.0, 0.0, 0.0, 0.0]), &some),
                include_str!("../../../docs/proofs/six-margins.json"),
            ),
            (
                of_step(&eight, &step([0.0, 0.0, 2.0], [0.5, 0.3, 1.8, 0.0, 0.1, 0.2]), &none),
                include_str!("../../../docs/proofs/eight-admissible.json"),
            ),
            (
                of_step(&eight, &step([0.0, 0.0, 2.0], [0.3, 0.2, 1.9, 0.0, 0.05, 0.1]), &of_law),
                include_str!("../../../docs/proofs/eight-margins.json"),
            ),
            (
                of_step(&eight, &step([0.0, 0.0, 2.0], [1.8, 1.4, 1.0, 0.0, 0.0, 0.0]), &none),
                include_str!("../../../docs/proofs/eight-refused.json"),
            ),
            (
                of_motion(&six, &Pose::at(0.15, 0.15, 1.0)),
                include_str!("../../../docs/proofs/motion-six.json"),
            ),
        ] {
            let text = String::from_utf8(laid_out(&document).unwrap()).unwrap();
            assert!(text == there, "{}", document.sha256);
        }
    }

    #[test]
    fn the_schema_that_is_checked_in_is_that_of_the_file() {
        let there: serde_json::Value =
            serde_json::from_str(include_str!("../../../docs/proof.schema.json")).unwrap();
        let drifted = "drifted: `cargo run -- schema proof > docs/proof.schema.json`";
        assert!(there == schema().to_value(), "{drifted}");
    }

    /// In the last bit, of every number.
    #[test]
    fn the_hash_changes_with_each_number_of_rig_step_and_margins() {
        let mut rig = RigFile::default().rig;
        rig.cables[1].pulley = Some(Pulley { radius: 0.05, axis: nalgebra::Vector3::z() });
        let step = step([0.0, 0.0, 1.0], [0.1, 0.05, 0.9, 0.05, 0.0, 0.1]);
        let margins = Margins { mass: 0.01, ..Margins::default() };
        let hash = |rig: &Rig, step: &Step, margins: &Margins| digest(&problem(rig, step, margins)).unwrap();
        let mut hashes = BTreeSet::from([hash(&rig, &step, &margins)]);
        let mut count = 1;
        let mut see = |rig: &Rig, step: &Step, margins: &Margins| {
            count += 1;
            hashes.insert(hash(rig, step, margins));
        };
        for number in 0..numbers_of(&mut { rig }, &mut { step }, &mut { margins }).len() {
            let (mut rig, mut step, mut margins) = (rig, step, margins);
            let value = &mut numbers_of(&mut rig, &mut step, &mut margins)[number];
            **value = value.next_up();
            see(&rig, &step, &margins);
        }
        see(&rig, &step, &Margins::default());
        let eight = RigFile::parse(EIGHT).unwrap().rig;
        see(&eight, &step, &margins);
        see(&eight, &step, &Margins { law_margin: 1.0, ..margins });
        rig.cables[1].pulley = None;
        see(&rig, &step, &margins);
        rig.cables.swap(2, 3);
        see(&rig, &step, &margins);
        assert_eq!(count, 1 + 19 + 6 * 8 + 4 + 20 + 8 + 5);
        assert_eq!(hashes.len(), count);
    }

    /// All but the `accuracy` of a rig, which is for margins, and what the law keeps from the limits of more than six cables.
    fn numbers_of<'a>(rig: &'a mut Rig, step: &'a mut Step, margins: &'a mut Margins) -> Vec<&'a mut f64> {
        let Gains { lambda, eta } = &mut step.gains;
        let mut all = vec![&mut rig.mass, lambda, eta];
        all.extend(rig.inertia.iter_mut().chain(rig.gravity.iter_mut()).chain(rig.disturbance.iter_mut()));
        all.extend(step.start.0.iter_mut().chain(step.rates.iter_mut()).chain(step.set_point.0.iter_mut()));
        for cable in rig.cables.iter_mut() {
            all.extend(cable.anchor.iter_mut().chain(cable.attachment.iter_mut()));
            all.extend([&mut cable.limits.min, &mut cable.limits.max]);
            if let Some(pulley) = &mut cable.pulley {
                all.push(&mut pulley.radius);
                all.extend(pulley.axis.iter_mut());
            }
        }
        let Margins { mass, centre_of_mass, force, torque, friction, accuracy, sample_period, delay, .. } =
            margins;
        all.extend([mass, centre_of_mass, force, torque, friction, accuracy, sample_period, delay]);
        all
    }

    #[test]
    fn the_hash_changes_with_each_number_of_a_motion() {
        /// Of a duration, an offset, and two parts of 24 coefficients and six numbers.
        const NUMBERS: usize = 1 + 6 + 2 * 30;
        let rig = RigFile::default().rig;
        let hash = |numbers: &[f64; NUMBERS]| {
            let coordinates = |from: usize| Coordinates::from_fn(|k, _| numbers[from + k]);
            let [first, second] = [7, 37].map(|from| {
                let coefficients = [0, 6, 12, 18].map(|k| coordinates(from + k));
                let [begin, s, v, a, beta, jerk]: [f64; 6] = coordinates(from + 24).into();
                Part { section: Section { begin, coefficients }, s, v, a, beta, jerk }
            });
            let piece = Piece::new(first, numbers[0]).and(second, &Pose(coordinates(1))).unwrap();
            digest(&problem_of_motion(&rig, &[piece])).unwrap()
        };
        let plain: [f64; NUMBERS] = std::array::from_fn(|k| 1.0 + k as f64);
        let changed = (0..NUMBERS).map(|k| {
            let mut numbers = plain;
            numbers[k] = numbers[k].next_up();
            hash(&numbers)
        });
        let hashes: BTreeSet<_> = changed.chain([hash(&plain)]).collect();
        assert_eq!(hashes.len(), NUMBERS + 1);
    }
}
