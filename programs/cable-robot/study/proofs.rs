//! Random problems with their proofs, a line each, for a checker; and what a proof costs.

use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cable_robot::reach::certificate::{Margins, Proof, certify_with_margins, prove};
use clap::Args;

use super::cases::{any_margins, any_problem};
use super::random_of;
use crate::command::proof::{document, laid_out};
use crate::command::{Outcome, say};

pub const EXAMPLE: &str = "\
Example: cable-robot study proofs --cases 1000 > proofs.jsonl
Each line is a proof file (docs/proof.md). Half the problems are of six cables and half of eight, a quarter have pulleys, and half margins. What it costs
goes to stderr.";

/// Problems of one seed's random numbers.
const BATCH: u64 = 1000;

#[derive(Args)]
pub struct Proofs {
    /// Random problems
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    cases: u64,
    /// Seed of the random problems
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// What the cases of one verdict come to.
#[derive(Default)]
struct Seen {
    bytes: Vec<usize>,
    finding: Vec<Duration>,
    /// Finding, once more, and writing.
    proving: Vec<Duration>,
}

impl Proofs {
    pub fn run(&self) -> Result<Outcome> {
        let (mut admissible, mut in_a_tube, mut refused) =
            (Seen::default(), Seen::default(), Seen::default());
        let mut undecided = 0;
        let mut out = std::io::stdout().lock();
        for batch in 0..self.cases.div_ceil(BATCH) {
            let mut rng = random_of(self.seed, batch);
            for case in 0..BATCH.min(self.cases - batch * BATCH) {
                let (rig, step) = any_problem(&mut rng, case);
                let margins =
                    if case % 4 < 2 { any_margins(&mut rng, &rig, &step) } else { Margins::default() };
                let begin = Instant::now();
                certify_with_margins(&rig, &step, &margins)?;
                let found = Instant::now();
                let (_, proof) = prove(&rig, &step, &margins)?;
                let Some(proof) = proof else {
                    undecided += 1;
                    continue;
                };
                let seen = match proof {
                    Proof::Admissible { tube: None, .. } => &mut admissible,
                    Proof::Admissible { tube: Some(_), .. } => &mut in_a_tube,
                    Proof::NotAdmissible { .. } | Proof::NoDistribution { .. } => &mut refused,
                };
                let document = document(&rig, &step, &margins, &proof)?;
                seen.bytes.push(laid_out(&document)?.len());
                seen.proving.push(found.elapsed());
                seen.finding.push(found - begin);
                let line = serde_json::to_string(&document)?;
                writeln!(out, "{line}").context("cannot write to stdout")?;
            }
        }
        say(format_args!("admissible: {}", admissible.in_words()));
        say(format_args!("admissible with margins: {}", in_a_tube.in_words()));
        say(format_args!("not admissible: {}", refused.in_words()));
        say(format_args!("undecided, so without a proof: {undecided}"));
        Ok(Outcome::Done)
    }
}

impl Seen {
    fn in_words(mut self) -> String {
        let Some(most) = self.bytes.iter().max().copied() else { return "none".to_owned() };
        let [finding, proving] =
            [&mut self.finding, &mut self.proving].map(|times| 1e6 * median(times).as_secs_f64());
        format!(
            "{} proofs, {:.1} kB in the median, {:.1} kB at most; finding {finding:.0} µs, finding and writing {proving:.0} µs in the median",
            self.bytes.len(),
            1e-3 * median(&mut self.bytes) as f64,
            1e-3 * most as f64,
        )
    }
}

fn median<T: Ord + Copy>(values: &mut [T]) -> T {
    let middle = values.len() / 2;
    *values.select_nth_unstable(middle).1
}
