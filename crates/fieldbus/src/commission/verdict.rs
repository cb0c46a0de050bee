//! What lengths measured at known poses say of the files.

use std::fmt;

use cable_robot::robot::{PerCable, Pose};

use super::survey::{Accuracy, Survey};
use super::{ALARM, Mistake, Quantity, World};

/// A quantity off by more than this share of [`Quantity::size`] is a whole mistake.
const LARGEST: f64 = 0.3;
/// A fit ends at this share of a standard deviation, or fails after so many steps.
const CLOSE: f64 = 0.01;
const STEPS: usize = 20;

/// The platform placed at a pose measured in the base frame, and what the bridge read there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where it was placed.
    pub pose: Pose,
    /// The length of each cable less that at home, m.
    pub lengthening: PerCable<f64>,
}

/// Something that explains the lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// The files are right.
    Files,
    /// A whole mistake.
    Mistake(Mistake),
    /// A quantity is another.
    Quantity {
        /// Which.
        quantity: Quantity,
        /// More than the file says by this, m, rad or a share.
        amount: f64,
        /// Its standard deviation.
        deviation: f64,
    },
}

/// Explanations that the lengths do not tell apart, the best first.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Those whose misfit is less than the square of [`ALARM`] above the least.
    pub explanations: Vec<Explanation>,
    /// Whether the best one leaves no more than placing and reading do: if not, more than one thing is wrong, or the platform was placed worse than was said.
    pub is_explained: bool,
    /// Of the best one: standard deviations, root of the mean square over all lengths; about 1 if it is right.
    pub residual: f64,
}

impl Verdict {
    /// Of these placements.
    pub fn new(file: &World, placements: &[Placement], accuracy: &Accuracy) -> Self {
        let poses: Vec<_> = placements.iter().map(|placement| placement.pose).collect();
        let cables = file.scale.len();
        let survey = Survey::new(file, &poses, accuracy);
        let measured = survey.deviation(&against(file, placements));
        let misfit = survey.misfit(&measured);
        let of_file = Candidate {
            explanation: Explanation::Files,
            misfit,
            square: survey.product(&measured, &measured),
        };
        let mut found = vec![of_file];
        for mistake in Mistake::all(cables) {
            let truth = mistake.truth(file);
            let survey = Survey::new(&truth, &poses, accuracy);
            let rest = survey.deviation(&against(&truth, placements));
            let explanation = Explanation::Mistake(mistake);
            found.push(Candidate {
                explanation,
                misfit: survey.misfit(&rest),
                square: survey.product(&rest, &rest),
            });
        }
        for quantity in Quantity::all(cables) {
            let fitted = fit(quantity, file, placements, &survey);
            // What is no more than chance among so many is not blamed, nor what is no small amount.
            let is_small = |fitted: &Fitted| fitted.amount.abs() <= LARGEST * quantity.size(file);
            let gain = |fitted: &Fitted| of_file.square - fitted.square;
            if let Some(fitted) = fitted.filter(|fitted| is_small(fitted) && gain(fitted) > ALARM * ALARM) {
                let Fitted { amount, deviation, square } = fitted;
                let explanation = Explanation::Quantity { quantity, amount, deviation };
                found.push(Candidate { explanation, misfit: misfit - gain(&fitted), square });
            }
        }
        found.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
        let best = found[0];
        let lengths = (cables * poses.len()) as f64;
        let chance = lengths + ALARM * (2.0 * lengths).sqrt();
        found.retain(|candidate| candidate.misfit < best.misfit + ALARM * ALARM);
        // The files are believed unless something else explains more.
        if found.iter().any(|candidate| candidate.explanation == Explanation::Files) {
            found.truncate(1);
            found[0] = of_file;
        }
        Self {
            is_explained: found[0].square <= chance,
            residual: (found[0].square.max(0.0) / lengths).sqrt(),
            explanations: found.into_iter().map(|candidate| candidate.explanation).collect(),
        }
    }

    /// Whether the files may be trusted, as far as these placements tell.
    pub fn is_good(&self) -> bool {
        self.is_explained && self.explanations == [Explanation::Files]
    }
}

#[derive(Clone, Copy)]
struct Candidate {
    explanation: Explanation,
    misfit: f64,
    square: f64,
}

/// The amount of a quantity that explains the lengths best.
struct Fitted {
    amount: f64,
    deviation: f64,
    /// What it leaves: the square of the standard deviations.
    square: f64,
}

/// By the method of Gauss and Newton; `None` where it does not end, or lengths make no sense any more.
fn fit(quantity: Quantity, file: &World, placements: &[Placement], survey: &Survey) -> Option<Fitted> {
    let mut amount = 0.0;
    for _ in 0..STEPS {
        let change: Vec<_> =
            placements.iter().map(|placement| quantity.change(file, amount, &placement.pose)).collect();
        let (change, rest) = (
            survey.deviation(&change),
            survey.deviation(&against(&quantity.truth(file, amount), placements)),
        );
        let size = survey.product(&change, &change);
        let step = survey.product(&change, &rest) / size;
        let deviation = size.sqrt().recip();
        amount += step;
        if step.abs() < CLOSE * deviation {
            return Some(Fitted { amount, deviation, square: survey.product(&rest, &rest) });
        }
    }
    None
}

/// What was read, less what `world` would have read, m.
fn against(world: &World, placements: &[Placement]) -> Vec<PerCable<f64>> {
    let less = |placement: &Placement| {
        let expected = world.lengthening(&placement.pose);
        PerCable::from_fn(expected.len(), |i| placement.lengthening[i] - expected[i])
    };
    placements.iter().map(less).collect()
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Files => write!(f, "as the files say"),
            Self::Mistake(mistake) => mistake.fmt(f),
            Self::Quantity { quantity, amount, deviation } => {
                let (unit, factor) = quantity.unit();
                let (amount, deviation) = (factor * amount, factor * deviation);
                write!(f, "{quantity}: {amount:+.1} {unit} (standard deviation {deviation:.1})")
            }
        }
    }
}
