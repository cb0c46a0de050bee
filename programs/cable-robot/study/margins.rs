//! What the certificate promises with margins holds on the packed plant when everything is wrong at once.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use cable_robot::control::{Gains, Reference, lyapunov};
use cable_robot::reach::certificate::{self, Step, Verdict, certify, certify_with_margins};
use cable_robot::robot::{Coordinates, Pose, Rig, RobotParameters, TensionLimits};
use cable_robot_import::Fmu;
use clap::Args;
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::cases::Case;
use super::plant::{ImperfectPlant, Truth};
use super::random_of;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study margins --steps 1000
The plant is the FMU that `cargo fmu build` packs: run this in the project's folder after it, or name the file with --plant. Exit code 1: a cable was slack, or a tension outside what was proved.";

/// What is certified, and what the plants are given at most.
const MARGINS: certificate::Margins = certificate::Margins {
    mass: 0.01,
    centre_of_mass: 3e-5,
    force: 0.05,
    torque: 0.001,
    friction: 0.001,
    // The packed plant has the geometry that is believed.
    law_margin: 0.0,
    accuracy: 0.0,
    sample_period: PERIOD,
    delay: PERIOD,
};
/// A command is held this long, and made from a state this old, s.
const PERIOD: f64 = 1e-3;
/// Periods of a run, and periods after which the disturbance changes.
const PERIODS: u32 = 3000;
const GUST: u32 = 300;

/// Table I with the inertia of a uniform disc.
const DISC: RobotParameters =
    RobotParameters { a: 0.45, b: 0.25, m: 6.0, i1: 0.125, i2: 0.125, i3: 0.25, g: 9.81 };

#[derive(Args)]
pub struct Margins {
    /// Accepted steps to run
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    steps: u64,
    /// The plant FMU, of either version
    #[arg(long, value_name = "FILE", default_value = "target/fmu/fmi3/CableRobotPlant.fmu")]
    plant: PathBuf,
    /// Seed of the random steps and plants
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What was found in some accepted steps.
#[derive(Clone, Copy)]
struct Found {
    /// Steps that are admissible without margins.
    admissible: u64,
    accepted: u64,
    /// With a slack cable.
    slack: u64,
    /// With a tension outside the range proved.
    outside: u64,
    /// Smallest tension commanded or pulled, N.
    smallest: f64,
    /// Smallest distance of a tension from the bounds proved, N.
    nearest: f64,
}

impl Margins {
    pub fn run(&self) -> Result<Outcome> {
        let fmu = Fmu::open(&self.plant).with_context(|| {
            format!(
                "--plant {}: `cargo fmu build` packs this file in the project's folder; name it from elsewhere",
                self.plant.display()
            )
        })?;
        let progress = Progress::new("running", self.steps);
        let one = |k| {
            let found = try_one(&fmu, random_of(self.seed, k));
            progress.done(1);
            found
        };
        let found = (0..self.steps).into_par_iter().map(one).try_reduce_with(|a, b| Ok(a.and(&b)));
        let found = found.context("no step")??;
        drop(progress);
        self.show(&found)?;
        if found.slack + found.outside > 0 {
            bail!("{} runs with a slack cable, {} outside the range proved", found.slack, found.outside);
        }
        Ok(Outcome::Done)
    }

    fn show(&self, found: &Found) -> Result<()> {
        let Found { admissible, accepted, slack, outside, smallest, nearest } = *found;
        if self.json {
            return print_json(&json!({
                "seed": self.seed, "admissible": admissible, "accepted": accepted, "slack": slack, "outside": outside,
                "smallest": smallest, "nearest": nearest,
            }));
        }
        print(&format!(
            "seed {}: {accepted} steps accepted of {admissible} admissible without margins\n\
             runs of the plant with a slack cable: {slack}, with a tension outside the range proved: {outside}\n\
             smallest tension: {smallest:.3} N; nearest to a bound proved: {nearest:.3} N\n",
            self.seed
        ))
    }
}

impl Found {
    fn and(&self, other: &Self) -> Self {
        Self {
            admissible: self.admissible + other.admissible,
            accepted: self.accepted + other.accepted,
            slack: self.slack + other.slack,
            outside: self.outside + other.outside,
            smallest: self.smallest.min(other.smallest),
            nearest: self.nearest.min(other.nearest),
        }
    }
}

/// Draws steps and plants until the certificate accepts one, and runs that.
fn try_one(fmu: &Fmu, mut rng: Pcg64) -> Result<Found> {
    let mut admissible = 0;
    loop {
        let (case, truth) = random_case(&mut rng);
        admissible += u64::from(matches!(certify(&case.rig, &case.step)?, Verdict::Admissible { .. }));
        if let Verdict::Admissible { least, greatest, .. } =
            certify_with_margins(&case.rig, &case.step, &MARGINS)?
        {
            let (range, slack) = run(fmu, &mut rng, &case.step, &case.rig, &truth)?;
            let nearest = (range[0] - least).min(greatest - range[1]);
            return Ok(Found {
                admissible,
                accepted: 1,
                slack: u64::from(slack),
                outside: u64::from(nearest < 0.0),
                smallest: range[0],
                nearest,
            });
        }
    }
}

/// A step from rest in all six coordinates, and a plant whose numbers are wrong.
fn random_case(rng: &mut Pcg64) -> (Case, Truth) {
    let mut pose = || {
        let q = Coordinates::from_fn(|_, _| rng.random_range(-1.0..1.0));
        Pose(q.component_mul(&Coordinates::new(0.1, 0.1, 0.2, 0.02, 0.02, 0.02)) + Coordinates::z())
    };
    let (start, set_point) = (pose(), pose());
    let gains = Gains { lambda: rng.random_range(2.0..5.0), eta: rng.random_range(2.0..5.0) };
    let step = Step { start, rates: Coordinates::zeros(), set_point, gains };

    let mut wrong = |value: f64| value * (1.0 + rng.random_range(-1.0..=1.0) * MARGINS.mass);
    let (m, i1, i2, i3) = (wrong(DISC.m), wrong(DISC.i1), wrong(DISC.i2), wrong(DISC.i3));
    let offset = random_vector(rng, MARGINS.centre_of_mass);
    let robot = RobotParameters { m, i1, i2, i3, ..DISC };
    let mut rig = Rig::paper(&DISC, TensionLimits { min: 0.0, max: 100.0 });
    rig.cables.iter_mut().for_each(|cable| cable.attachment -= offset);
    (Case { rig, step }, Truth { robot, offset, friction: MARGINS.friction })
}

/// Least and greatest tension commanded or pulled on the way, N, and whether a cable was slack. The law knows the rig and sees
/// states one period old.
fn run(fmu: &Fmu, rng: &mut Pcg64, step: &Step, rig: &Rig, truth: &Truth) -> Result<([f64; 2], bool)> {
    let law = |(pose, rates): &(Pose, Coordinates)| {
        lyapunov::tension_command(rig, &step.gains, pose, rates, &Reference::resting(&step.set_point), 0.0)
            .context("the law met a singular pose")
    };
    let mut told = (step.start, step.rates);
    let plant = ImperfectPlant::new(fmu, truth, &step.start, &law(&told)?)?;
    let (mut range, mut slackened) = ([f64::INFINITY, 0.0_f64], false);
    for k in 0..PERIODS {
        if k % GUST == 0 {
            plant.disturb(&random_vector(rng, MARGINS.force), &random_vector(rng, MARGINS.torque))?;
        }
        let command = law(&told)?;
        told = plant.state()?; // used one period later
        let (pulled, slack) = plant.step(&command, f64::from(k) * PERIOD, PERIOD)?;
        slackened |= slack;
        for u in command.into_iter().chain(pulled) {
            range = [range[0].min(u), range[1].max(u)];
        }
    }
    Ok((range, slackened))
}

fn random_vector(rng: &mut Pcg64, length: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64)).normalize() * length
}
