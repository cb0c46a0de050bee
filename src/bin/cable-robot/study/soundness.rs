//! No step that the exact domain admits slackens a cable: random rigs, states and set points against dense sampling.

use anyhow::{Result, bail};
use cable_robot::control::{Gains, Response};
use cable_robot::reach::ExactDomain;
use cable_robot::reach::exact::NEVER_SLACK;
use cable_robot::robot::{Coordinates, Geometry, Pose, RobotParameters, tensions};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use crate::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study soundness --cases 10000000
Tensions are solved from the 6x6 inverse dynamics, not from the formulae under test. Exit code 1: a slack cable was found.";

/// Cases that one random generator makes; its seed is the study's plus the number of the batch.
const BATCH: u64 = 1000;
/// Instants looked at, denser at the start.
const INSTANTS: u32 = 64;
/// Tension below which a cable counts as slack, as a part of the weight: the rounding of the 6x6 solve.
const ROUNDING: f64 = 1e-9;

#[derive(Args)]
pub struct Soundness {
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
    slack: u64,
    /// Smallest tension as a part of the weight.
    smallest: f64,
}

struct Case {
    robot: RobotParameters,
    gains: Gains,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    x_d: Vector3<f64>,
}

impl Soundness {
    pub fn run(&self) -> Result<Outcome> {
        let batches = self.cases.div_ceil(BATCH);
        let bar = ProgressBar::new(batches * BATCH);
        bar.set_style(ProgressStyle::with_template("{bar:40} {human_pos} of {human_len} cases, {eta} left")?);
        let found = (0..batches)
            .into_par_iter()
            .map(|batch| {
                let found = look_at(self.seed.wrapping_add(batch));
                bar.inc(BATCH);
                found
            })
            .reduce(|| Found { tried: 0, admitted: 0, slack: 0, smallest: f64::INFINITY }, Found::and);
        bar.finish_and_clear();
        self.show(&found)?;
        if found.slack > 0 {
            bail!("{} of {} admitted cases have a slack cable", found.slack, found.admitted);
        }
        Ok(Outcome::Done)
    }

    fn show(&self, found: &Found) -> Result<()> {
        let Found { tried, admitted, slack, smallest } = *found;
        if self.json {
            return print_json(&json!({
                "seed": self.seed, "tried": tried, "admitted": admitted, "slack": slack, "smallest_per_weight": smallest,
            }));
        }
        print(&format!(
            "seed {}: {tried} random cases, {admitted} admitted, {slack} with a slack cable in {INSTANTS} instants each\n\
             smallest tension: {smallest:.2e} of the weight\n",
            self.seed
        ))
    }
}

/// Draws cases until a batch of them is admitted.
fn look_at(seed: u64) -> Found {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut found = Found { tried: 0, admitted: 0, slack: 0, smallest: f64::INFINITY };
    while found.admitted < BATCH {
        let case = Case::random(&mut rng);
        found.tried += 1;
        let domain = ExactDomain::new(&case.robot, &case.gains, NEVER_SLACK, case.position, case.velocity);
        if domain.contains(&case.x_d) {
            let smallest = case.smallest_tension() / (case.robot.m * case.robot.g);
            found.admitted += 1;
            found.slack += u64::from(smallest <= -ROUNDING);
            found.smallest = found.smallest.min(smallest);
        }
    }
    found
}

impl Found {
    fn and(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            admitted: self.admitted + other.admitted,
            slack: self.slack + other.slack,
            smallest: self.smallest.min(other.smallest),
        }
    }
}

impl Case {
    /// A third with equal gains, half from rest, a third at constant height.
    fn random(rng: &mut Pcg64) -> Self {
        let a = rng.random_range(0.2..2.0);
        let robot = RobotParameters {
            a,
            b: rng.random_range(0.1..0.95) * a,
            m: rng.random_range(0.5..50.0),
            g: rng.random_range(1.6..10.0),
            ..Default::default()
        };
        let lambda = rng.random_range(0.5..10.0);
        let eta = if rng.random_range(0..3) == 0 { lambda } else { rng.random_range(0.5..10.0) };
        let speed = if rng.random_range(0..2) == 0 { 0.0 } else { rng.random_range(0.0..1.0) * a };
        let position = point(rng, a);
        let mut x_d = point(rng, a);
        let mut velocity = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * speed;
        if rng.random_range(0..3) == 0 {
            (x_d.z, velocity.z) = (position.z, 0.0);
        }
        Self { robot, gains: Gains { lambda, eta }, position, velocity, x_d }
    }

    fn smallest_tension(&self) -> f64 {
        let geometry = Geometry::new(&self.robot);
        let horizon = 12.0 / self.gains.lambda.min(self.gains.eta);
        let instants = (0..INSTANTS).map(|k| horizon * (f64::from(k) / f64::from(INSTANTS - 1)).powi(2));
        instants.map(|t| self.tension_at(&geometry, t)).fold(f64::INFINITY, f64::min)
    }

    /// Smallest tension `t` seconds after the start, N; a singular wrench matrix counts as slack.
    fn tension_at(&self, geometry: &Geometry, t: f64) -> f64 {
        let response = Response::at(&self.gains, t);
        let [x, y, z]: [[f64; 3]; 3] =
            std::array::from_fn(|i| response.motion(self.position[i], self.velocity[i], self.x_d[i]));
        let derivative = |k: usize| Coordinates::new(x[k], y[k], z[k], 0.0, 0.0, 0.0);
        let u = tensions(&self.robot, geometry, &Pose(derivative(0)), &derivative(1), &derivative(2));
        u.map_or(f64::NEG_INFINITY, |u| u.into_iter().fold(f64::INFINITY, f64::min))
    }
}

fn point(rng: &mut Pcg64, a: f64) -> Vector3<f64> {
    let mut across = || rng.random_range(-0.6..0.6) * a;
    let (x, y) = (across(), across());
    Vector3::new(x, y, rng.random_range(0.5..4.0) * a)
}
