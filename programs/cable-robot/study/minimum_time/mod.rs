//! No motion of the planner `MinimumTime`, and no stop on one, takes a tension outside its limits.

mod look;
mod moves;
mod polynomial;
#[cfg(test)]
mod sample;
mod stops;

use anyhow::{Result, bail};
use clap::Args;
use rand::RngExt;
use rayon::prelude::*;
use serde_json::{Value, json};

use self::look::{Found, INSTANTS, ROUNDING, excess};
use self::moves::{Kind, Way};
use self::stops::Runs;
use super::random_of;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study minimum-time --moves 1000000 --stops 10000
Moves are planned right up to the limits. Tensions are solved from the inverse dynamics of all six coordinates at five instants of each arc; where the rig is the paper's and level, polynomials besides
say for every instant whether they keep the limits. Exit code 1: one did not.";

/// Stops on each plan, of which every so many runs one in closed loop.
const STOPS: u32 = 10;
const RUN: u64 = 10;
/// Every so many lines one is compared with the optimum on a grid of so many cells.
const COMPARED: u64 = 200;
const CELLS: u32 = 4000;

#[derive(Args)]
pub struct MinimumTime {
    /// Planned moves to look at: of a hundred 88 lines, 3 on the grid, 3 turned, 1 of eight cables, 2 bent upwards, 3 by way points
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    moves: u64,
    /// Planned moves, of all kinds alike, with stops from ten random instants of each; every tenth is run in closed loop, too
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(0..=1_000_000_000))]
    stops: u64,
    /// Seed of the random moves
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// Of one kind of moves.
#[derive(Clone, Copy)]
struct Row {
    /// Between random ends; those without a plan included.
    tried: u64,
    plans: Found,
    stops: Found,
    /// Instants from which no stop is proved that ends before the motion does, which then goes on.
    gone_on: u64,
    runs: Runs,
    /// Lines that were compared with the optimum, and by which share the slowest takes longer.
    compared: u64,
    excess: f64,
    /// Seed's number of the first move that is broken.
    first: Option<u64>,
}

type Rows = [Row; Kind::ALL.len()];

impl MinimumTime {
    pub fn run(&self) -> Result<Outcome> {
        let moves = self.in_parallel("looking at moves", self.moves, |k| self.moved(k));
        let stops = self.in_parallel("looking at stops", self.stops, |k| self.stopped(k));
        let rows = both(moves, stops);
        self.show(&rows)?;
        let broken: u64 = rows.iter().map(|row| row.plans.broken + row.stops.broken + row.runs.slack).sum();
        if broken > 0 {
            bail!("{broken} motions with a tension outside its limits, or that are not whole");
        }
        Ok(Outcome::Done)
    }

    fn in_parallel(&self, what: &'static str, count: u64, one: impl Fn(u64) -> (Kind, Row) + Sync) -> Rows {
        let progress = Progress::new(what, count);
        let one = |k: u64| {
            let (kind, row) = one(k);
            progress.done(1);
            Kind::ALL.map(|other| if other == kind { row } else { Row::none() })
        };
        (0..count).into_par_iter().map(one).reduce(|| [Row::none(); Kind::ALL.len()], both)
    }

    /// Move `k`.
    fn moved(&self, k: u64) -> (Kind, Row) {
        let (kind, mut rng, mut row) = (Kind::of_move(k), random_of(self.seed, k), Row::none());
        let planned = row.draw(kind, &mut rng);
        row.plans = Found::in_motion(&planned, &planned.timing);
        if let Way::Line { line, .. } = &planned.way
            && k.is_multiple_of(COMPARED)
        {
            // Where the robot cannot rest on the grid there is no plan either: it would be a violation.
            row.excess = excess(&planned, line, CELLS).unwrap_or(f64::INFINITY);
            row.compared = 1;
        }
        row.first = (row.plans.broken > 0).then_some(k);
        (kind, row)
    }

    /// Plan `k` of those with stops; other random numbers than those of the moves.
    fn stopped(&self, k: u64) -> (Kind, Row) {
        let (kind, mut rng) = (Kind::ALL[(k % Kind::ALL.len() as u64) as usize], random_of(!self.seed, k));
        let mut row = Row::none();
        let planned = row.draw(kind, &mut rng);
        row.tried = 0;
        for _ in 0..STOPS {
            let [s, v, _] = planned.timing.at(rng.random_range(0.0..planned.timing.duration));
            match planned.stop(s, v) {
                Some(stop) => row.stops = row.stops.and(Found::in_motion(&planned, &stop)),
                None => row.gone_on += 1,
            }
        }
        // The controller goes straight from one goal to the next, and so do these kinds.
        if (k / Kind::ALL.len() as u64).is_multiple_of(RUN) && kind != Kind::Through && kind != Kind::Lift {
            row.runs = Runs::of(&planned, &mut rng);
        }
        row.first = (row.stops.broken + row.runs.slack > 0).then_some(k);
        (kind, row)
    }

    fn show(&self, rows: &Rows) -> Result<()> {
        let named = || Kind::ALL.iter().map(|kind| kind.name()).zip(rows);
        if self.json {
            let rows: Vec<Value> = named().map(|(name, row)| row.as_json(name)).collect();
            return print_json(
                &json!({"seed": self.seed, "moves": self.moves, "stops": self.stops, "kinds": rows}),
            );
        }
        let mut text = format!(
            "seed {}, {} moves, {INSTANTS} instants an arc; outside: by more than {ROUNDING:.0e} of the weight, or not whole\n\
             plans                    tried    plans  outside     instants  nearest / weight      pieces  undecided  outside\n",
            self.seed, self.moves
        );
        for (name, row) in named() {
            text += &format!("{name:<20}  {:>8} {}\n", row.tried, columns(&row.plans));
        }
        text += &format!(
            "stops from {STOPS} instants of {} plans\n                       gone on    stops  outside     instants  nearest / weight      pieces  undecided  outside\n",
            self.stops
        );
        for (name, row) in named() {
            text += &format!("{name:<20}  {:>8} {}\n", row.gone_on, columns(&row.stops));
        }
        text += "stops in closed loop      runs  refused    slack  returned  nearest / weight\n";
        for (name, Row { runs, .. }) in named().filter(|(_, row)| row.runs.runs > 0) {
            text += &format!(
                "{name:<20}  {:>8} {:>8} {:>8} {:>9} {:>17.5}\n",
                runs.runs, runs.refused, runs.slack, runs.returned, runs.smallest
            );
        }
        let [lines, ..] = rows;
        text += &format!(
            "{} lines beside the optimum on {CELLS} cells: at most {:.4} % longer\n",
            lines.compared,
            100.0 * lines.excess
        );
        for (name, row) in named() {
            if let Some(first) = row.first {
                text += &format!("{name}: outside first in number {first}\n");
            }
        }
        print(&text)
    }
}

fn columns(found: &Found) -> String {
    let Found { motions, broken, instants, smallest, pieces, undecided, refuted, .. } = *found;
    format!(
        "{motions:>8} {broken:>8} {instants:>12} {smallest:>17.1e} {pieces:>11} {undecided:>10} {refuted:>8}"
    )
}

fn both(a: Rows, b: Rows) -> Rows {
    std::array::from_fn(|kind| a[kind].and(b[kind]))
}

impl Row {
    fn none() -> Self {
        Self {
            tried: 0,
            plans: Found::none(),
            stops: Found::none(),
            gone_on: 0,
            runs: Runs::none(),
            compared: 0,
            excess: f64::NEG_INFINITY,
            first: None,
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            plans: self.plans.and(other.plans),
            stops: self.stops.and(other.stops),
            gone_on: self.gone_on + other.gone_on,
            runs: self.runs.and(other.runs),
            compared: self.compared + other.compared,
            excess: self.excess.max(other.excess),
            first: [self.first, other.first].into_iter().flatten().min(),
        }
    }

    /// Draws until there is a plan.
    fn draw(&mut self, kind: Kind, rng: &mut rand_pcg::Pcg64) -> moves::Move {
        loop {
            self.tried += 1;
            if let Some(planned) = kind.draw(rng) {
                return planned;
            }
        }
    }

    fn as_json(&self, name: &str) -> Value {
        let found = |found: &Found| {
            json!({"motions": found.motions, "broken": found.broken, "arcs": found.arcs, "instants": found.instants, "smallest_per_weight": finite(found.smallest),
                "pieces": found.pieces, "undecided": found.undecided, "refuted": found.refuted})
        };
        let Runs { runs, refused, slack, returned, smallest } = self.runs;
        json!({"kind": name, "tried": self.tried, "plans": found(&self.plans), "stops": found(&self.stops), "gone_on": self.gone_on,
            "runs": {"runs": runs, "refused": refused, "slack": slack, "returned": returned, "smallest_per_weight": finite(smallest)},
            "compared": self.compared, "excess": finite(self.excess), "first": self.first})
    }
}

/// JSON knows no infinite numbers: 0 of nothing.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
