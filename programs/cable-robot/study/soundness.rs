//! No step that a domain admits takes a tension to its limit: random rigs, states and set points against dense sampling.

use anyhow::{Result, bail};
use clap::Args;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::cases::{Case, Domain};
use super::random_of;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study soundness --domain certificate --cases 10000000
Tensions are solved from the 6x6 inverse dynamics, not from the formulae under test. Exit code 1: one was at or beyond a limit.";

/// Cases that one random generator makes.
const BATCH: u64 = 1000;
/// Instants looked at, denser at the start.
const INSTANTS: usize = 64;

#[derive(Args)]
pub struct Soundness {
    /// What admits the cases
    #[arg(long, value_enum, default_value_t = Domain::Exact)]
    domain: Domain,
    /// Admissible cases to look at, rounded up to thousands
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    cases: u64,
    /// Seed of the random cases
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What was found in some cases.
#[derive(Clone, Copy)]
struct Found {
    tried: u64,
    admitted: u64,
    /// With a tension at or beyond a limit.
    broken: u64,
    /// Smallest distance of a tension from a limit as a part of the weight.
    smallest: f64,
}

impl Soundness {
    pub fn run(&self) -> Result<Outcome> {
        let batches = self.cases.div_ceil(BATCH);
        let progress = Progress::new("looking", batches * BATCH);
        let found = (0..batches)
            .into_par_iter()
            .map(|batch| {
                let found = look_at(self.domain, random_of(self.seed, batch));
                progress.done(BATCH);
                found
            })
            .reduce(Found::none, Found::and);
        drop(progress);
        self.show(&found)?;
        if found.broken > 0 {
            bail!(
                "{} of {} admitted cases have a tension at or beyond a limit",
                found.broken,
                found.admitted
            );
        }
        Ok(Outcome::Done)
    }

    fn show(&self, found: &Found) -> Result<()> {
        let Found { tried, admitted, broken, smallest } = *found;
        if self.json {
            return print_json(&json!({
                "seed": self.seed, "tried": tried, "admitted": admitted, "broken": broken, "smallest_per_weight": smallest,
            }));
        }
        print(&format!(
            "seed {}: {tried} random cases, {admitted} admitted, {broken} with a tension at or beyond a limit in {INSTANTS} instants each\n\
             smallest distance from a limit: {smallest:.2e} of the weight\n",
            self.seed
        ))
    }
}

/// Draws cases until a batch of them is admitted.
fn look_at(domain: Domain, mut rng: Pcg64) -> Found {
    let mut found = Found::none();
    while found.admitted < BATCH {
        found = found.and(domain.draw(&mut rng).map_or(Found::refused(), |case| Found::in_case(&case)));
    }
    found
}

impl Found {
    fn none() -> Self {
        Self { tried: 0, admitted: 0, broken: 0, smallest: f64::INFINITY }
    }

    fn refused() -> Self {
        Self { tried: 1, ..Self::none() }
    }

    fn in_case(case: &Case) -> Self {
        let margin = case.smallest_margin(INSTANTS);
        let weight = case.rig.weight();
        Self { tried: 1, admitted: 1, broken: u64::from(margin <= 0.0), smallest: margin / weight }
    }

    fn and(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            admitted: self.admitted + other.admitted,
            broken: self.broken + other.broken,
            smallest: self.smallest.min(other.smallest),
        }
    }
}
