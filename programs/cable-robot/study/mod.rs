//! `cable-robot study`: the claims about the reachable domains, as figures that anyone can make again.

mod cases;
mod held;
mod liveness;
mod margins;
mod minimum_time;
mod plant;
mod proofs;
mod rigs;
mod soundness;
mod tightness;
mod time;

use anyhow::Result;
use cable_robot::reach::static_workspace;
use cable_robot::robot::RobotParameters;
use clap::Subcommand;
use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::command::Outcome;

#[derive(Subcommand)]
pub enum Study {
    /// Random cases that a domain admits, looked at densely for a tension at or beyond a limit
    #[command(after_help = soundness::EXAMPLE)]
    Soundness(soundness::Soundness),
    /// Share of the truly admissible steps that the bounded and the exact domain accept
    #[command(after_help = tightness::EXAMPLE)]
    Tightness(tightness::Tightness),
    /// Steps accepted with margins, run on the packed plant with everything wrong at once that they allow
    #[command(after_help = margins::EXAMPLE)]
    Margins(margins::Margins),
    /// Commands that are held and late: random rigs, gains, steps and goals in closed loop, and where cables go slack
    #[command(after_help = held::EXAMPLE)]
    Held(held::Held),
    /// Goals that can be reached, and whether they are reached
    #[command(after_help = liveness::EXAMPLE)]
    Liveness(liveness::Liveness),
    /// Every rig of a folder: workspace, planner, and goals through its packed FMUs
    #[command(after_help = rigs::EXAMPLE)]
    Rigs(rigs::Rigs),
    /// Moves in minimum time, and stops on them: tensions by dense samples and by polynomials, times beside the optimum
    #[command(after_help = minimum_time::EXAMPLE)]
    MinimumTime(minimum_time::MinimumTime),
    /// Random problems with their proofs, a line each, for a checker
    #[command(after_help = proofs::EXAMPLE)]
    Proofs(proofs::Proofs),
    /// Time to the goal with each planner
    #[command(after_help = time::EXAMPLE)]
    Time(time::Time),
}

impl Study {
    pub fn run(&self) -> Result<Outcome> {
        match self {
            Study::Soundness(study) => study.run(),
            Study::Tightness(study) => study.run(),
            Study::Margins(study) => study.run(),
            Study::Held(study) => study.run(),
            Study::Liveness(study) => study.run(),
            Study::Rigs(study) => study.run(),
            Study::MinimumTime(study) => study.run(),
            Study::Proofs(study) => study.run(),
            Study::Time(study) => study.run(),
        }
    }
}

/// The random numbers of one batch of a study: others for each batch, and for each batch of another seed.
fn random_of(seed: u64, batch: u64) -> Pcg64 {
    let key: u64 = Pcg64::seed_from_u64(seed).random();
    Pcg64::seed_from_u64(key ^ batch)
}

/// A point at least `inset` (m) inside the border of the static workspace; a negative one lets it lie as far outside.
fn random_point(rng: &mut Pcg64, robot: &RobotParameters, inset: f64) -> Vector2<f64> {
    let facets = static_workspace(robot);
    // Corners of a hexagon lie farther out than its facets.
    let corner = (0.5 * robot.a - inset) * 2.0 / 3f64.sqrt();
    loop {
        let point = Vector2::from_fn(|_, _| rng.random_range(-corner..corner));
        if facets.iter().all(|facet| facet.slack(&point) > inset) {
            return point;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Batch k was drawn from `seed + k`: neighbouring seeds shared all but one batch of a thousand.
    #[test]
    fn neighbouring_seeds_share_no_batch() {
        let first = |seed, batch| random_of(seed, batch).random::<u64>();
        let all = (0..20).flat_map(|seed| (0..1000).map(move |batch| first(seed, batch)));
        assert_eq!(all.collect::<HashSet<_>>().len(), 20 * 1000);
    }
}
