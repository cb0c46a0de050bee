//! What lengths measured at known poses say of the files.

use std::fmt;

use cable_robot::robot::{PerCable, Pose};

use super::fit::{Fitted, against, fit};
use super::survey::{Accuracy, Survey};
use super::{ALARM, Mistake, Quantity, World};

/// So many quantities may be wrong together.
const TOGETHER: usize = 4;
/// While the lengths are not explained, one more quantity is tried with so many of the best explanations.
const BEST: usize = 3;

/// The platform placed at a pose measured in the base frame, and what the bridge read there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where it was placed.
    pub pose: Pose,
    /// The length of each cable less that at home, m.
    pub lengthening: PerCable<f64>,
}

/// What explains the lengths: the files, if nothing is named.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Explanation {
    /// A whole mistake, if there is one.
    pub mistake: Option<Mistake>,
    /// Quantities that are others.
    pub quantities: Vec<Fitted>,
}

impl Explanation {
    /// Whether nothing is wrong.
    pub fn is_of_files(&self) -> bool {
        self.mistake.is_none() && self.quantities.is_empty()
    }
}

/// Explanations that the lengths do not tell apart, the best first.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Those no more than four standard deviations behind the best.
    pub explanations: Vec<Explanation>,
    /// Whether the best one leaves no more than placing and reading do: if not, more is wrong, or the platform was placed worse than was said.
    pub is_explained: bool,
    /// Of the best one: standard deviations, root of the mean square over all lengths; about 1 if it is right.
    pub residual: f64,
}

impl Verdict {
    /// Of these placements. A mistake alone and a quantity alone come first; only if no such thing explains the lengths, more quantities are taken to be wrong.
    pub fn new(file: &World, placements: &[Placement], accuracy: &Accuracy) -> Self {
        let poses: Vec<_> = placements.iter().map(|placement| placement.pose).collect();
        let cables = file.scale.len();
        let lengths = (cables * poses.len()) as f64;
        let chance = lengths + ALARM * (2.0 * lengths).sqrt();
        let search = Search { file, poses, placements, accuracy };
        let mistakes = Mistake::all(cables).into_iter().map(Some);
        let mut found: Vec<_> =
            [None].into_iter().chain(mistakes).map(|mistake| search.whole(mistake)).collect();
        let of_file = found[0].clone();
        found.extend(search.extended(&of_file));
        by_misfit(&mut found);
        for _ in 1..TOGETHER {
            if found[0].square <= chance {
                break;
            }
            let more: Vec<_> =
                found.iter().take(BEST).flat_map(|candidate| search.extended(candidate)).collect();
            found.extend(more);
            by_misfit(&mut found);
        }
        let least = found[0].misfit;
        found.retain(|candidate| candidate.misfit < least + ALARM * ALARM);
        // The files are believed unless something else explains more.
        if found.iter().any(|candidate| candidate.explanation.is_of_files()) {
            found = vec![of_file];
        }
        Self {
            is_explained: found[0].square <= chance,
            residual: (found[0].square.max(0.0) / lengths).sqrt(),
            explanations: found.into_iter().map(|candidate| candidate.explanation).collect(),
        }
    }

    /// Whether the files may be trusted, as far as these placements tell.
    pub fn is_good(&self) -> bool {
        self.is_explained && self.explanations.iter().all(Explanation::is_of_files)
    }
}

fn by_misfit(found: &mut [Candidate]) {
    found.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
}

/// An explanation, and what it leaves.
#[derive(Clone)]
struct Candidate {
    explanation: Explanation,
    misfit: f64,
    square: f64,
}

struct Search<'a> {
    file: &'a World,
    poses: Vec<Pose>,
    placements: &'a [Placement],
    accuracy: &'a Accuracy,
}

impl Search<'_> {
    fn base(&self, mistake: Option<Mistake>) -> (World, Survey) {
        let base = mistake.map_or(*self.file, |mistake| mistake.truth(self.file));
        (base, Survey::new(&base, &self.poses, self.accuracy))
    }

    /// A mistake alone, or the files.
    fn whole(&self, mistake: Option<Mistake>) -> Candidate {
        let (base, survey) = self.base(mistake);
        let rest = survey.deviation(&against(&base, self.placements));
        let explanation = Explanation { mistake, quantities: vec![] };
        Candidate { explanation, misfit: survey.misfit(&rest), square: survey.product(&rest, &rest) }
    }

    /// With one more quantity. What gains no more than chance does among so many is not blamed.
    fn extended(&self, from: &Candidate) -> Vec<Candidate> {
        let Explanation { mistake, quantities } = &from.explanation;
        let (base, survey) = self.base(*mistake);
        let known: Vec<_> = quantities.iter().map(|fitted| fitted.quantity).collect();
        let with = |quantity: Quantity| {
            let quantities = [&known[..], &[quantity]].concat();
            let (quantities, square) = fit(&base, &quantities, |_| f64::INFINITY, self.placements, &survey)?;
            let gain = from.square - square;
            let explanation = Explanation { mistake: *mistake, quantities };
            (gain > ALARM * ALARM).then_some(Candidate { explanation, misfit: from.misfit - gain, square })
        };
        let others =
            Quantity::all(self.file.scale.len()).into_iter().filter(|quantity| !known.contains(quantity));
        others.filter_map(with).collect()
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_of_files() {
            return write!(f, "as the files say");
        }
        let mistake = self.mistake.iter().map(ToString::to_string);
        let parts: Vec<_> = mistake.chain(self.quantities.iter().map(ToString::to_string)).collect();
        write!(f, "{}", parts.join(", and "))
    }
}
