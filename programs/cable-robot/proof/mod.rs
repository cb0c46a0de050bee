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
use cable_robot::robot::{Cable, Rig};
use cable_robot_report::files::write_whole;
use schemars::{Schema, schema_for};
use sha2::{Digest, Sha256};

use document::{
    ADMISSIBLE, CableEntry, Document, FORMAT, InstantEntry, NOT_ADMISSIBLE, Polynomial, Problem, PulleyEntry,
    RigEntry, SpanEntry, StepEntry, VERSION,
};
use layout::laid_out;
use number::Number;

use crate::say;

/// A proof file, to be written.
struct File {
    text: Vec<u8>,
    /// Of the problem.
    sha256: String,
}

/// JSON Schema of proof files.
pub fn schema() -> Schema {
    schema_for!(Document)
}

/// Decides a step, writes what proves the verdict and says so; or that nothing is proved.
pub fn write(path: &Path, rig: &Rig, step: &Step) -> Result<Verdict> {
    let (verdict, proof) = prove(rig, step)?;
    match proof {
        Some(proof) => {
            let File { text, sha256 } = file(rig, step, &proof)?;
            write_whole(path, |writer| writer.write_all(&text))?;
            say(format_args!("{}: proof of the problem with SHA-256 {sha256}", path.display()));
        }
        None => say(format_args!("{} is not written: nothing is proved", path.display())),
    }
    Ok(verdict)
}

/// What proves the verdict about a step.
fn file(rig: &Rig, step: &Step, proof: &Proof) -> serde_json::Result<File> {
    let problem = problem(rig, step);
    let sha256 = digest(&problem)?;
    let verdict = if matches!(proof, Proof::Admissible(_)) { ADMISSIBLE } else { NOT_ADMISSIBLE };
    let mut document = Document {
        format: FORMAT,
        version: VERSION,
        problem,
        sha256: sha256.clone(),
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
                inverse: inverse(solved),
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
    Ok(File { text: laid_out(&document)?, sha256 })
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
