//! Proof files: docs/proof.md says what they hold, and what must be seen of them.

mod document;
mod layout;
mod number;

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use cable_robot::reach::certificate::motion::Span;
use cable_robot::reach::certificate::proof::ProvedSpan;
use cable_robot::reach::certificate::statics::Solved;
use cable_robot::reach::certificate::taylor::Taylor;
use cable_robot::reach::certificate::{Proof, Step, Verdict, prove};
use cable_robot::robot::rig_file::without_null;
use cable_robot::robot::{Cable, Rig};
use cable_robot_report::files::write_whole;
use schemars::{Schema, schema_for};
use sha2::{Digest, Sha256};

pub use document::Document;
use document::{
    ADMISSIBLE, CableEntry, FORMAT, InstantEntry, NOT_ADMISSIBLE, Polynomial, Problem, PulleyEntry, RigEntry,
    SpanEntry, StepEntry, VERSION,
};
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
pub fn write(path: &Path, rig: &Rig, step: &Step) -> Result<Verdict> {
    let (verdict, proof) = prove(rig, step)?;
    match proof {
        Some(proof) => {
            let document = document(rig, step, &proof)?;
            let text = laid_out(&document)?;
            write_whole(path, |writer| writer.write_all(&text))?;
            say(format_args!("{}: proof of the problem with SHA-256 {}", path.display(), document.sha256));
        }
        None => say(format_args!("{} is not written: nothing is proved", path.display())),
    }
    Ok(verdict)
}

/// What proves the verdict about a step.
pub fn document(rig: &Rig, step: &Step, proof: &Proof) -> serde_json::Result<Document> {
    let problem = problem(rig, step);
    let sha256 = digest(&problem)?;
    let verdict = if matches!(proof, Proof::Admissible(_)) { ADMISSIBLE } else { NOT_ADMISSIBLE };
    let mut document = Document {
        format: FORMAT,
        version: VERSION,
        problem,
        sha256,
        verdict,
        least: None,
        greatest: None,
        spans: None,
        instant: None,
    };
    match proof {
        Proof::Admissible(spans) => {
            let bounds = || spans.iter().flat_map(|proved| proved.bounds);
            document.least = Some(Number(bounds().map(|[least, _]| least).fold(f64::INFINITY, f64::min)));
            document.greatest =
                Some(Number(bounds().map(|[_, greatest]| greatest).fold(f64::NEG_INFINITY, f64::max)));
            document.spans = Some(spans.iter().map(span).collect());
        }
        Proof::NotAdmissible { cable, time, solved, bounds: [least, greatest] } => {
            document.instant = Some(InstantEntry::OfCable {
                time: Number(*time),
                cable: *cable,
                inverse: Box::new(inverse(solved)),
                solution: solved.unknowns.map(|unknown| [Number(unknown.coefficients[0])]),
                error: error(solved),
                least: Number(*least),
                greatest: Number(*greatest),
            });
        }
        Proof::NoDistribution { time, multipliers, shortfall } => {
            document.instant = Some(InstantEntry::OfAll {
                time: Number(*time),
                multipliers: multipliers.map(Number),
                shortfall: Number(*shortfall),
            });
        }
    }
    Ok(document)
}

/// Of the text with sorted keys and no white space: a map of JSON values sorts its keys.
fn digest(problem: &Problem) -> serde_json::Result<String> {
    let canonical = serde_json::to_value(problem)?.to_string();
    Ok(Sha256::digest(canonical).iter().map(|byte| format!("{byte:02x}")).collect())
}

fn problem(rig: &Rig, step: &Step) -> Problem {
    let inertia = std::array::from_fn(|k| std::array::from_fn(|j| Number(rig.inertia[(k, j)])));
    Problem {
        rig: RigEntry {
            mass: Number(rig.mass),
            inertia,
            gravity: numbers(rig.gravity),
            disturbance: numbers(rig.disturbance),
            cables: rig.cables.iter().map(cable).collect(),
        },
        step: StepEntry {
            start: numbers(step.start.0),
            rates: numbers(step.rates),
            set_point: numbers(step.set_point.0),
            lambda: Number(step.gains.lambda),
            eta: Number(step.gains.eta),
        },
    }
}

fn numbers<const N: usize>(values: impl Into<[f64; N]>) -> [Number; N] {
    values.into().map(Number)
}

fn cable(cable: &Cable) -> CableEntry {
    CableEntry {
        anchor: numbers(cable.anchor),
        attachment: numbers(cable.attachment),
        least: Number(cable.limits.min),
        greatest: Number(cable.limits.max),
        pulley: cable
            .pulley
            .map(|pulley| PulleyEntry { radius: Number(pulley.radius), axis: numbers(pulley.axis) }),
    }
}

fn span(proved: &ProvedSpan) -> SpanEntry {
    let (from, to) = match proved.span {
        Span::Between(from, to) => (from, Some(to)),
        Span::From(from) => (from, None),
    };
    let spread = proved.spread.as_ref();
    let bound = |which: usize| proved.bounds.iter().map(|bounds| Number(bounds[which])).collect();
    SpanEntry {
        from: Number(from),
        to: to.map(Number),
        base: spread.map(|spread| spread.base.iter().copied().map(Number).collect()),
        basis: spread.map(|spread| spread.basis.iter().map(|row| row.map(Number)).collect()),
        inverse: inverse(&proved.solved),
        solution: proved.solved.unknowns.map(|unknown| polynomial(&unknown)),
        error: error(&proved.solved),
        least: bound(0),
        greatest: bound(1),
    }
}

fn inverse(solved: &Solved) -> [[Number; 6]; 6] {
    std::array::from_fn(|k| std::array::from_fn(|j| Number(solved.inverse[(k, j)])))
}

fn error(solved: &Solved) -> [Number; 6] {
    solved.unknowns.map(|unknown| Number(unknown.error))
}

/// Without zeros at its end.
fn polynomial(unknown: &Taylor) -> Polynomial {
    let degree = unknown.coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    Polynomial(unknown.coefficients[..=degree].iter().copied().map(Number).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use cable_robot::control::Gains;
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

    fn text(rig: &Rig, step: &Step) -> String {
        let proof = prove(rig, step).unwrap().1.unwrap();
        String::from_utf8(laid_out(&document(rig, step, &proof).unwrap()).unwrap()).unwrap()
    }

    /// Of six and eight cables, admissible and not: the examples of docs/proof.md, bit for bit.
    #[test]
    fn proofs_that_are_checked_in_are_written_again() {
        let (six, eight) = (RigFile::default().rig, RigFile::parse(EIGHT).unwrap().rig);
        for (rig, step, there) in [
            (
                six,
                step([0.0, 0.0, 1.0], [0.1, 0.05, 0.9, 0.05, 0.0, 0.1]),
                include_str!("../../../docs/proofs/six-admissible.json"),
            ),
            (
                six,
                step([0.0, 0.0, 1.0], [0.3, 0.0, 1.0, 0.0, 0.0, 0.0]),
                include_str!("../../../docs/proofs/six-refused.json"),
            ),
            (
                eight,
                step([0.0, 0.0, 2.0], [0.5, 0.3, 1.8, 0.0, 0.1, 0.2]),
                include_str!("../../../docs/proofs/eight-admissible.json"),
            ),
            (
                eight,
                step([0.0, 0.0, 2.0], [1.8, 1.4, 1.0, 0.0, 0.0, 0.0]),
                include_str!("../../../docs/proofs/eight-refused.json"),
            ),
        ] {
            assert!(text(&rig, &step) == there, "{step:?}");
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
    fn the_hash_changes_with_each_number_of_rig_and_step() {
        let mut rig = RigFile::default().rig;
        rig.cables[1].pulley = Some(Pulley { radius: 0.05, axis: nalgebra::Vector3::z() });
        let step = step([0.0, 0.0, 1.0], [0.1, 0.05, 0.9, 0.05, 0.0, 0.1]);
        let mut hashes = BTreeSet::from([hash(&rig, &step)]);
        let mut count = 1;
        let mut see = |rig: &Rig, step: &Step| {
            count += 1;
            hashes.insert(hash(rig, step));
        };
        for number in 0..numbers_of(&mut { rig }, &mut { step }).len() {
            let (mut rig, mut step) = (rig, step);
            let value = &mut numbers_of(&mut rig, &mut step)[number];
            **value = value.next_up();
            see(&rig, &step);
        }
        rig.cables[1].pulley = None;
        see(&rig, &step);
        rig.cables.swap(2, 3);
        see(&rig, &step);
        assert_eq!(count, 1 + 19 + 6 * 8 + 4 + 20 + 2);
        assert_eq!(hashes.len(), count);
    }

    fn hash(rig: &Rig, step: &Step) -> String {
        digest(&problem(rig, step)).unwrap()
    }

    /// All but the `accuracy` of a rig, which is for margins.
    fn numbers_of<'a>(rig: &'a mut Rig, step: &'a mut Step) -> Vec<&'a mut f64> {
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
        all
    }
}
