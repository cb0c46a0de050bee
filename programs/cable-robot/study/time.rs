//! Time to the goal: the paper's planner, the exact domain used from rest only, and from any state.

use anyhow::Result;
use cable_robot::control::Response;
use cable_robot::plan::planner::{Planner, Situation};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Coordinates, Pose, RobotParameters, TensionLimits};
use clap::Args;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::random_point;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study time --pairs 1000
The motion is the closed form (12), (13) from tick to tick of the planner. All planners keep 0.1 N. \"-\": not reached in 60 s.";

/// Tension that every planner keeps, N.
const LEAST: f64 = 0.1;
/// Goals and starts keep this from the border of the static workspace, m.
const INSET: f64 = 0.01;
/// A run is given up after this time, s.
const PATIENCE: f64 = 60.0;

#[derive(Args)]
pub struct Time {
    /// Random pairs of points of the static workspace at z = 1, for each gain
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pairs: u32,
    /// Seed of the random pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Bounded,
    ExactFromRest,
    ExactFromAnyState,
}

/// λ = η, 1/s.
const GAINS: [f64; 3] = [3.0, 5.0, 8.0];
const WAYS: [Way; 3] = [Way::Bounded, Way::ExactFromRest, Way::ExactFromAnyState];

struct Row {
    gain: f64,
    way: Way,
    paper: Option<f64>,
    reached: Vec<f64>,
}

impl Time {
    pub fn run(&self) -> Result<Outcome> {
        let pairs = self.pairs();
        let mut rows = vec![];
        let progress = Progress::new("moving", (GAINS.len() * WAYS.len() * (pairs.len() + 1)) as u64);
        for gain in GAINS {
            for way in WAYS {
                let time = |from: Pose, to: Pose| {
                    let time = time_to_goal(gain, way, from, to);
                    progress.done(1);
                    time
                };
                let mut reached: Vec<f64> =
                    pairs.par_iter().filter_map(|(from, to)| time(*from, *to)).collect();
                reached.sort_by(f64::total_cmp);
                rows.push(Row {
                    gain,
                    way,
                    paper: time(Pose::default(), Pose::at(0.15, 0.15, 1.0)),
                    reached,
                });
            }
        }
        drop(progress);
        self.show(&rows)?;
        Ok(Outcome::Done)
    }

    fn pairs(&self) -> Vec<(Pose, Pose)> {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let robot = RobotParameters::default();
        let mut pose = || {
            let point = random_point(&mut rng, &robot, INSET);
            Pose::at(point.x, point.y, 1.0)
        };
        (0..self.pairs).map(|_| (pose(), pose())).collect()
    }

    fn show(&self, rows: &[Row]) -> Result<()> {
        if self.json {
            let rows: Vec<_> = rows.iter().map(|row| {
                json!({"gain": row.gain, "planner": format!("{:?}", row.way), "paper": row.paper, "reached": row.reached.len(), "mean": row.mean(), "median": row.quantile(0.5), "p95": row.quantile(0.95)})
            }).collect();
            return print_json(&json!({"seed": self.seed, "pairs": self.pairs, "rows": rows}));
        }
        let mut text = format!(
            "seed {}, {} pairs, seconds\nλ = η  planner            paper's move   mean  median    p95  reached\n",
            self.seed, self.pairs
        );
        for row in rows {
            let paper = row.paper.map_or("-".to_owned(), |t| format!("{t:.2}"));
            text += &format!(
                "{:5}  {:<17}  {paper:>12}  {:5.2}  {:6.2}  {:5.2}  {:7}\n",
                row.gain,
                format!("{:?}", row.way),
                row.mean(),
                row.quantile(0.5),
                row.quantile(0.95),
                row.reached.len()
            );
        }
        print(&text)
    }
}

impl Row {
    fn mean(&self) -> f64 {
        self.reached.iter().sum::<f64>() / self.reached.len() as f64
    }

    fn quantile(&self, share: f64) -> f64 {
        let last = self.reached.len().saturating_sub(1);
        self.reached.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }
}

/// Seconds until the robot rests at the goal.
fn time_to_goal(gain: f64, way: Way, from: Pose, goal: Pose) -> Option<f64> {
    let planner = if way == Way::Bounded { PlannerKind::Bounded } else { PlannerKind::Exact };
    // The exact planner keeps 0.1 N of its own (with Table I).
    let min_tension = if way == Way::Bounded { LEAST } else { 0.0 };
    let mut parameters = ControllerParameters { lambda: gain, eta: gain, planner, ..Default::default() };
    parameters.rig = parameters.rig.with_limits(TensionLimits { min: min_tension, max: 100.0 });
    let rest = parameters.rest();
    let (response, planner) =
        (Response::at(&parameters.gains(), parameters.planner_period), Planner::from(parameters));
    let (mut pose, mut rates, mut set_point) = (from, Coordinates::zeros(), from);
    for tick in 0..(PATIENCE / parameters.planner_period) as u32 {
        let now = Situation { pose: &pose, rates: &rates, set_point: &set_point, hold: 0.0, rest };
        let steady = now.is_steady();
        if steady && set_point == goal {
            return Some(f64::from(tick) * parameters.planner_period);
        }
        if let Some(next) =
            planner.next_set_point(&now, &goal).filter(|_| steady || way != Way::ExactFromRest)
        {
            set_point = next;
        }
        (pose, rates, _) = response.motion_of(&pose, &rates, &set_point);
    }
    None
}
