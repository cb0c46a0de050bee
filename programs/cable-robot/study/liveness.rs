//! Whether every goal is reached that can be: the straight way to it can be rested at throughout with the margin that the planner leaves.

use anyhow::Result;
use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, Rig};
use cable_robot::sim::{ClosedLoop, PlantParameters, SimulationError};
use clap::Args;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::cases::{log_uniform, random_gains_of_held, random_rig_of_held};
use super::random_of;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study liveness --goals 1000
Rigs, gains and steps as in `study held`, from rest at home, planner Exact, controller stepped first. A goal counts as one that can be reached if the robot can rest, with
twice what the planner leaves at rest, at 200 points of the straight way to it. Exit code 3: one of them was not reached.";

/// Points looked at on the way.
const POINTS: u32 = 200;
/// Time constants of the slower gain, and besides ticks of the planner, after which a goal counts as not reached: with high gains steps are short, and there is
/// one a tick.
const PATIENCE: f64 = 150.0;
const TICKS: f64 = 3000.0;

#[derive(Args)]
pub struct Liveness {
    /// Goals that can be rested at, half of them level
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    goals: u64,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What came of the goals of one kind.
#[derive(Clone, Copy, Default)]
struct Kind {
    goals: u64,
    reached: u64,
    /// Called unreachable.
    unreachable: u64,
    slack: u64,
    /// Longest time, s.
    longest: f64,
    /// The first that was not reached.
    first: Option<u64>,
}

/// Level goals and turned ones; the straight way to which can be rested at, and not.
type Kinds = [[Kind; 2]; 2];

const LEVEL: [&str; 2] = ["level", "turned"];
const WAY: [&str; 2] = ["can be rested at", "cannot"];

impl Liveness {
    pub fn run(&self) -> Result<Outcome> {
        let progress = Progress::new("running", self.goals);
        let one = |k: u64| -> Result<Kinds, SimulationError> {
            let mut rng = random_of(self.seed, k);
            let kinds = run(&mut rng, k);
            progress.done(1);
            kinds
        };
        let both = |a: Result<Kinds, SimulationError>, b: Result<Kinds, SimulationError>| {
            let (a, b) = (a?, b?);
            Ok(std::array::from_fn(|i| std::array::from_fn(|j| a[i][j].and(&b[i][j]))))
        };
        let none = || Ok(Kinds::default());
        let kinds = (0..self.goals).into_par_iter().map(one).reduce(none, both)?;
        drop(progress);
        self.show(&kinds)?;
        let all = kinds.iter().all(|kind| kind[0].reached == kind[0].goals);
        Ok(if all { Outcome::Done } else { Outcome::NotReachable })
    }

    fn show(&self, kinds: &Kinds) -> Result<()> {
        let rows = || (0..2).flat_map(|level| (0..2).map(move |way| (level, way)));
        if self.json {
            let rows: Vec<_> = rows()
                .map(|(level, way)| {
                    let k = &kinds[level][way];
                    json!({"goals": LEVEL[level], "way": WAY[way], "count": k.goals, "reached": k.reached,
                        "unreachable": k.unreachable, "slack": k.slack, "longest": k.longest, "first": k.first})
                })
                .collect();
            return print_json(&json!({"seed": self.seed, "kinds": rows}));
        }
        let mut text = format!(
            "seed {}, {} goals\ngoals   straight way       count  reached  unreachable  neither  slack  longest (s)  first not reached\n",
            self.seed, self.goals
        );
        for (level, way) in rows() {
            let k = &kinds[level][way];
            let neither = k.goals - k.reached - k.unreachable;
            let first = k.first.map_or("-".to_owned(), |run| run.to_string());
            text += &format!(
                "{:<7} {:<17} {:>6}  {:>7}  {:>11}  {neither:>7}  {:>5}  {:>11.1}  {first}\n",
                LEVEL[level], WAY[way], k.goals, k.reached, k.unreachable, k.slack, k.longest
            );
        }
        print(&text)
    }
}

impl Kind {
    fn and(&self, other: &Self) -> Self {
        Self {
            goals: self.goals + other.goals,
            reached: self.reached + other.reached,
            unreachable: self.unreachable + other.unreachable,
            slack: self.slack + other.slack,
            longest: self.longest.max(other.longest),
            first: [self.first, other.first].into_iter().flatten().min(),
        }
    }
}

/// A goal at which the robot can rest, and what becomes of it.
fn run(rng: &mut Pcg64, k: u64) -> Result<Kinds, SimulationError> {
    let (rig, home) = random_rig_of_held(rng);
    let gains = random_gains_of_held(rng);
    let step = log_uniform(rng, 0.25e-3, 20e-3);
    let parameters = ControllerParameters {
        planner: PlannerKind::Exact,
        lambda: gains.lambda,
        eta: gains.eta,
        ..ControllerParameters::of(&rig)
    };
    let planner = Planner::from(parameters);
    let rests = |pose: &Pose| {
        static_margin(&rig, pose) > 2.0 * planner.allowance()
            && planner.is_firm(pose)
            && pose.0[4].abs() < LARGEST_PITCH
    };
    let is_level = rng.random_bool(0.5);
    let goal = random_goal(rng, &rig, &home, is_level, &rests);
    let can_be_had =
        (0..=POINTS).all(|p| rests(&Pose(home.0 + goal.minus(&home) * (f64::from(p) / f64::from(POINTS)))));
    let plant = PlantParameters { rig, initial_pose: home, ..Default::default() };
    let mut joined = ClosedLoop::new(parameters, plant, goal)?;
    let slow = gains.lambda.min(gains.eta);
    let mut kind = Kind { goals: 1, ..Kind::default() };
    let mut status = Status::Moving;
    let patience = PATIENCE / slow + TICKS * parameters.planner_period;
    let (mut holds, begun) = (false, 2.0 * parameters.planner_period);
    while joined.moment().time < patience && kind.reached == 0 && !holds {
        let moment = joined.step(step)?;
        kind.slack |= u64::from(moment.plant.slack.contains(&true));
        status = moment.controller.status;
        kind.reached = u64::from(status == Status::AtGoal);
        // Where it holds it goes no farther.
        holds = status == Status::GoalUnreachable && moment.controller.steady && moment.time > begun;
    }
    kind.longest = if kind.reached == 1 { joined.moment().time } else { 0.0 };
    kind.unreachable = u64::from(status == Status::GoalUnreachable);
    kind.first = (kind.reached == 0).then_some(k);
    let mut kinds = Kinds::default();
    kinds[usize::from(!is_level)][usize::from(!can_be_had)] = kind;
    Ok(kinds)
}

/// Of goals at this pitch the angles tell the orientation well.
const LARGEST_PITCH: f64 = 1.4;

/// Where the robot can rest, up to 0.6 radii of the rig from home; turned by up to 0.5 rad and 3 rad of yaw.
fn random_goal(
    rng: &mut Pcg64,
    rig: &Rig,
    home: &Pose,
    is_level: bool,
    rests: &impl Fn(&Pose) -> bool,
) -> Pose {
    let (size, tilt) = (0.6 * rig.radius(), if is_level { 0.0 } else { 0.5 });
    let wide = Coordinates::new(size, size, 0.4 * home.0[2], tilt, tilt, 6.0 * tilt);
    loop {
        let goal = Pose(home.0 + wide.map(|most| most * rng.random_range(-1.0..=1.0)));
        if rests(&goal) {
            return goal;
        }
    }
}
