//! What a proof file says of a rig, a step, margins, a motion and spans.

use cable_robot::reach::certificate::along::Piece;
use cable_robot::reach::certificate::motion::Span;
use cable_robot::reach::certificate::part::Part;
use cable_robot::reach::certificate::proof::{ProvedSpan, ProvedTube};
use cable_robot::reach::certificate::statics::Solved;
use cable_robot::reach::certificate::taylor::Taylor;
use cable_robot::reach::certificate::{Margins, Step};
use cable_robot::robot::{Cable, Coordinates, LEAST_CABLES, Rig};

use super::document::{
    CableEntry, MarginsEntry, MotionEntry, PartEntry, PieceEntry, Polynomial, PulleyEntry, RigEntry,
    SpanEntry, StepEntry, TubeEntry,
};
use super::number::Number;

pub fn rig(rig: &Rig) -> RigEntry {
    RigEntry {
        mass: Number(rig.mass),
        inertia: std::array::from_fn(|k| std::array::from_fn(|j| Number(rig.inertia[(k, j)]))),
        gravity: numbers(rig.gravity),
        disturbance: numbers(rig.disturbance),
        cables: rig.cables.iter().map(cable).collect(),
    }
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

pub fn step(step: &Step) -> StepEntry {
    StepEntry {
        start: numbers(step.start.0),
        rates: numbers(step.rates),
        set_point: numbers(step.set_point.0),
        lambda: Number(step.gains.lambda),
        eta: Number(step.gains.eta),
    }
}

/// What the law keeps from the limits is of more than six `cables`.
pub fn margins(margins: &Margins, cables: usize) -> MarginsEntry {
    let Margins { mass, centre_of_mass, force, torque, friction, law_margin, accuracy, sample_period, delay } =
        *margins;
    MarginsEntry {
        mass: Number(mass),
        centre_of_mass: Number(centre_of_mass),
        force: Number(force),
        torque: Number(torque),
        friction: Number(friction),
        accuracy: Number(accuracy),
        sample_period: Number(sample_period),
        delay: Number(delay),
        law_margin: (cables > LEAST_CABLES).then_some(Number(law_margin)),
    }
}

pub fn tube(ProvedTube { disturbance, extent, intrusion }: &ProvedTube) -> TubeEntry {
    let sideways = Some(extent.sideways).filter(|sideways| sideways.is_finite());
    TubeEntry {
        disturbance: numbers(*disturbance),
        pull: Number(extent.pull),
        shortest: Number(extent.shortest),
        sideways: sideways.map(Number),
        stiffness: extent.stiffness.map(numbers),
        intrusion: intrusion.map(Number),
    }
}

pub fn motion(pieces: &[Piece]) -> MotionEntry {
    MotionEntry { pieces: pieces.iter().map(piece).collect() }
}

fn piece(piece: &Piece) -> PieceEntry {
    PieceEntry {
        duration: Number(piece.duration()),
        offset: numbers(*piece.offset()),
        parts: piece.parts().iter().map(part).collect(),
    }
}

/// The way without zeros at its end.
fn part(Part { section, s, v, a, beta, jerk }: &Part) -> PartEntry {
    let degree = section.coefficients.iter().rposition(|c| *c != Coordinates::zeros()).unwrap_or(0);
    PartEntry {
        way: section.coefficients[..=degree].iter().copied().map(numbers).collect(),
        begin: Number(section.begin),
        s: Number(*s),
        rate: Number(*v),
        acceleration: Number(*a),
        beta: Number(*beta),
        jerk: Number(*jerk),
    }
}

pub fn span(proved: &ProvedSpan) -> SpanEntry {
    let (from, to) = match proved.span {
        Span::Between(from, to) => (from, Some(to)),
        Span::From(from) => (from, None),
    };
    let spread = proved.spread.as_ref();
    let bound = |which: usize| proved.bounds.iter().map(|bounds| Number(bounds[which])).collect();
    SpanEntry {
        piece: None,
        from: Some(Number(from)),
        to: to.map(Number),
        base: spread.map(|spread| spread.base.iter().copied().map(Number).collect()),
        basis: spread.map(|spread| spread.basis.iter().map(|row| row.map(Number)).collect()),
        multipliers: proved.law.map(|law| law.multipliers.map(Number)),
        distance: proved.law.map(|law| Number(law.distance)),
        inverse: inverse(&proved.solved),
        solution: proved.solved.unknowns.map(|unknown| polynomial(&unknown)),
        error: error(&proved.solved),
        least: bound(0),
        greatest: bound(1),
    }
}

pub fn inverse(solved: &Solved) -> [[Number; 6]; 6] {
    std::array::from_fn(|k| std::array::from_fn(|j| Number(solved.inverse[(k, j)])))
}

pub fn error(solved: &Solved) -> [Number; 6] {
    solved.unknowns.map(|unknown| Number(unknown.error))
}

/// Without zeros at its end.
fn polynomial(unknown: &Taylor) -> Polynomial {
    let degree = unknown.coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    Polynomial(unknown.coefficients[..=degree].iter().copied().map(Number).collect())
}

fn numbers<const N: usize>(values: impl Into<[f64; N]>) -> [Number; N] {
    values.into().map(Number)
}
