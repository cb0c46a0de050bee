//! Commands that are held for a step and handed on late: random rigs, gains, steps and goals in closed loop, and where cables go slack.

use anyhow::Result;
use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose, Rig};
use cable_robot::sim::{ClosedLoop, Moment, PlantParameters, SimulationError};
use clap::Args;
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::cases::{log_uniform, random_gains_of_held, random_rig_of_held};
use super::random_of;
use crate::command::arguments::planner;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study held --runs 2000
Rigs: Table I, and random ones near the paper's shape. Gains 0.3 to 15 1/s, steps 0.25 to 20 ms, equal or varying, the controller stepped first or both at once (a step
late), up to four goals, turned ones and ones that cannot be reached among them, half of the first given at once.";

/// Upper ends of the classes of (λ + η) h, and of (λ + η) times the delay besides.
const CLASSES: [f64; 6] = [0.01, 0.02, 0.04, 0.08, 0.16, 1.0];
/// A robot this much turned from level and from its set point, rad, or this many radii of the rig from its home, is lost.
const LOST_TURN: f64 = 1.4;
const LOST_WAY: f64 = 20.0;

/// Of imperfect rigs: friction of a cable as a share of the weight, and how far the centre of mass is off as a share of the rig's radius.
const FRICTION: f64 = 0.0034;
const OFF_CENTRE: f64 = 0.0039;

#[derive(Args)]
pub struct Held {
    /// Runs
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Planner
    #[arg(long, value_parser = planner(), default_value = PlannerKind::Exact.key())]
    planner: PlannerKind,
    /// Evaluates the law at the measurement: holdCompensation = false
    #[arg(long)]
    uncompensated: bool,
    /// Besides: mass off by 5 %, centre of mass by 0.39 % of the rig's radius, encoders of 0.1 mm, friction of 0.34 % of the weight (for Table I's rig 2 mm and 0.2 N)
    #[arg(long)]
    imperfect: bool,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What came of the runs of one class.
#[derive(Clone, Copy, Default)]
struct Class {
    runs: u64,
    /// Not started: the controller refused, or the step was too long.
    refused: u64,
    slack: u64,
    lost: u64,
    /// Last goals that can be reached, and those of them that were.
    goals: u64,
    reached: u64,
    /// Smallest tension commanded, as a share of the weight.
    smallest: f64,
    /// By how much `tensionMargin` was larger than the smallest tension commanded then, at most, as a share of the weight.
    exceeded: f64,
    /// The run that slackened a cable or lost the robot with the smallest product.
    first: Option<(f64, u64)>,
}

type Classes = [[Class; CLASSES.len()]; 2];

struct Case {
    parameters: ControllerParameters,
    plant: PlantParameters,
    /// By how much the centre of mass is off, m.
    offset: Vector3<f64>,
    is_late: bool,
    /// Longest step, s, and whether they vary.
    step: f64,
    varies: bool,
    /// Times (s) and goals.
    goals: Vec<(f64, Pose)>,
    /// s; it ends before if the robot rests at the last goal.
    duration: f64,
}

struct End {
    slack: bool,
    lost: bool,
    /// Of the last goal: whether it can be reached, and was.
    possible: bool,
    reached: bool,
    smallest: f64,
    exceeded: f64,
}

impl Held {
    pub fn run(&self) -> Result<Outcome> {
        let progress = Progress::new("running", self.runs);
        let one = |k: u64| -> Result<Classes, SimulationError> {
            let mut rng = random_of(self.seed, k);
            let case = self.draw(&mut rng);
            let product = case.product();
            let class = CLASSES.iter().position(|most| product <= *most).unwrap_or(CLASSES.len() - 1);
            let end = case.parameters.check_step(case.step).is_ok().then(|| case.run(&mut rng));
            progress.done(1);
            let mut classes = Classes::default();
            classes[usize::from(case.is_late)][class] = match end {
                Some(Ok(end)) => Class::of(&end, product, k),
                // What is not known may be too much for the start.
                Some(Err(refused)) if !self.imperfect => return Err(refused),
                _ => Class { refused: 1, ..Class::default() },
            };
            Ok(classes)
        };
        let none = || Ok(Classes::default());
        let both = |a: Result<Classes, SimulationError>, b: Result<Classes, SimulationError>| {
            let (a, b) = (a?, b?);
            Ok(std::array::from_fn(|order| {
                std::array::from_fn(|class| a[order][class].and(&b[order][class]))
            }))
        };
        let classes = (0..self.runs).into_par_iter().map(one).reduce(none, both)?;
        drop(progress);
        self.show(&classes)?;
        Ok(Outcome::Done)
    }

    fn draw(&self, rng: &mut Pcg64) -> Case {
        let (rig, home) = random_rig_of_held(rng);
        let (gains, step) = (random_gains_of_held(rng), log_uniform(rng, 0.25e-3, 20e-3));
        let is_late = rng.random_bool(0.5);
        let mut parameters = ControllerParameters::of(&rig);
        parameters.planner = self.planner;
        (parameters.lambda, parameters.eta) = (gains.lambda, gains.eta);
        parameters.hold_compensation = !self.uncompensated;
        parameters.command_delay = if is_late { step } else { 0.0 };
        let slow = gains.lambda.min(gains.eta);
        let (duration, patience) = ((10.0 / slow).clamp(1.0, 6.0), 25.0 / slow);
        let mut goals: Vec<_> = (0..rng.random_range(1..=4))
            .map(|_| (rng.random_range(0.0..1.0) * duration, random_goal(rng, &rig, &home)))
            .collect();
        goals.sort_by(|a, b| a.0.total_cmp(&b.0));
        if rng.random_bool(0.5) {
            goals[0].0 = 0.0;
        }
        let mut plant = PlantParameters { rig, initial_pose: home, ..PlantParameters::default() };
        let mut offset = Vector3::zeros();
        if self.imperfect {
            parameters.mass_tolerance = 0.05;
            parameters.encoder_resolution = 1e-4;
            let of_friction = FRICTION * rig.cables.len() as f64;
            parameters.disturbance_bound =
                rig.weight() * (of_friction + OFF_CENTRE * rig.radius() / rig.platform_radius());
            plant.rig.mass *= 1.0 + rng.random_range(-0.05..0.05);
            plant.friction = FRICTION * rig.weight();
            plant.encoder_resolution = 1e-4;
            offset = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize()
                * (OFF_CENTRE * rig.radius() * rng.random_range(0.0..1.0));
            plant.rig.cables.iter_mut().for_each(|cable| cable.attachment -= offset);
            let centre = home.position() + home.rotation() * offset;
            plant.initial_pose.0.fixed_rows_mut::<3>(0).copy_from(&centre);
        }
        // The delay of a late command is that of the step before: equal steps only.
        let varies = !is_late && rng.random_bool(0.5);
        Case {
            parameters,
            plant,
            offset,
            is_late,
            step,
            varies,
            duration: goals[goals.len() - 1].0 + patience,
            goals,
        }
    }

    fn show(&self, classes: &Classes) -> Result<()> {
        let orders = ["controller first", "one step late"];
        if self.json {
            let rows: Vec<_> = (0..2)
                .flat_map(|order| (0..CLASSES.len()).map(move |class| (order, class)))
                .map(|(order, class)| {
                    let c = &classes[order][class];
                    json!({"order": orders[order], "most": CLASSES[class], "runs": c.runs, "refused": c.refused, "slack": c.slack, "lost": c.lost,
                        "goals": c.goals, "reached": c.reached, "smallest_per_weight": if c.runs > 0 { c.smallest } else { 0.0 }, "margin_exceeds_per_weight": c.exceeded,
                        "first": c.first.map(|(product, run)| json!({"product": product, "run": run}))})
                })
                .collect();
            return print_json(&json!({"seed": self.seed, "runs": self.runs, "classes": rows}));
        }
        let mut text = format!(
            "seed {}, {} runs\norder             (λ+η)(h+d) up to    runs  refused  slack   lost  goals  reached  smallest tension / weight  margin exceeds / weight  least product that failed (run)\n",
            self.seed, self.runs
        );
        for (order, row) in orders.iter().zip(classes) {
            for (most, c) in CLASSES.iter().zip(row) {
                let first = c.first.map_or("-".to_owned(), |(product, run)| format!("{product:.4} ({run})"));
                text += &format!(
                    "{order:<16}  {most:>16}  {:>6}   {:>6} {:>6} {:>6} {:>6}  {:>7}  {:>25.5}  {:>23.5}  {first}\n",
                    c.runs, c.refused, c.slack, c.lost, c.goals, c.reached, c.smallest, c.exceeded
                );
            }
        }
        print(&text)
    }
}

impl Class {
    fn of(end: &End, product: f64, run: u64) -> Self {
        let failed = end.slack || end.lost;
        Self {
            runs: 1,
            refused: 0,
            slack: u64::from(end.slack),
            lost: u64::from(end.lost),
            goals: u64::from(end.possible),
            reached: u64::from(end.possible && end.reached),
            smallest: end.smallest,
            exceeded: end.exceeded,
            first: failed.then_some((product, run)),
        }
    }

    fn and(&self, other: &Self) -> Self {
        let smallest = match (self.runs, other.runs) {
            (0, _) => other.smallest,
            (_, 0) => self.smallest,
            _ => self.smallest.min(other.smallest),
        };
        let first = [self.first, other.first].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            runs: self.runs + other.runs,
            refused: self.refused + other.refused,
            slack: self.slack + other.slack,
            lost: self.lost + other.lost,
            goals: self.goals + other.goals,
            reached: self.reached + other.reached,
            smallest,
            exceeded: self.exceeded.max(other.exceeded),
            first,
        }
    }
}

impl Case {
    /// (λ + η) times how long after its measurement a command acts at most.
    fn product(&self) -> f64 {
        let delay = if self.is_late { self.step } else { 0.0 };
        (self.parameters.lambda + self.parameters.eta) * (self.step + delay)
    }

    fn goal(&self, time: f64) -> Pose {
        let given = self.goals.iter().rfind(|(from, _)| *from <= time);
        given.map_or(self.centre(&self.plant.initial_pose), |(_, goal)| *goal)
    }

    /// The point that the controller takes for the centre of mass.
    fn centre(&self, pose: &Pose) -> Pose {
        let mut seen = *pose;
        let centre = pose.position() - pose.rotation() * self.offset;
        seen.0.fixed_rows_mut::<3>(0).copy_from(&centre);
        seen
    }

    fn run(&self, rng: &mut Pcg64) -> Result<End, SimulationError> {
        let rig = &self.parameters.rig;
        let mut run = ClosedLoop::new(self.parameters, self.plant, self.goal(0.0))?;
        run.is_late = self.is_late;
        let mut end = End {
            slack: false,
            lost: false,
            possible: false,
            reached: false,
            smallest: f64::INFINITY,
            exceeded: 0.0,
        };
        let last = self.goals[self.goals.len() - 1].0;
        while run.moment().time < self.duration && !end.lost {
            let h = if self.varies { self.step * rng.random_range(0.05..=1.0) } else { self.step };
            run.goal = self.goal(run.moment().time);
            let stepped = run.step_seeing(h, |seen| seen.encoder_pose = self.centre(&seen.encoder_pose));
            let Ok(Moment { time, controller, plant, .. }) = stepped else {
                end.lost = true;
                break;
            };
            let smallest = controller.motor_tension.iter().copied().fold(f64::INFINITY, f64::min);
            end.smallest = end.smallest.min(smallest / rig.weight());
            end.exceeded = end.exceeded.max((controller.tension_margin - smallest) / rig.weight());
            end.slack |= plant.slack.contains(&true);
            let pose = &plant.encoder_pose;
            let way = (pose.position() - self.plant.initial_pose.position()).norm();
            let status = controller.status;
            if status == Status::AtGoal && *time > last + self.parameters.planner_period + h {
                break;
            }
            end.lost = status == Status::SensorFault
                || [Pose::default(), controller.set_point].iter().all(|at| is_turned(pose, at))
                || way > LOST_WAY * rig.radius();
        }
        let status = run.controller.outputs().status;
        end.reached = status == Status::AtGoal;
        end.possible = status != Status::GoalUnreachable;
        Ok(end)
    }
}

/// Whether roll or pitch differ by more than those of a robot that is not lost.
fn is_turned(pose: &Pose, from: &Pose) -> bool {
    pose.minus(from).fixed_rows::<2>(3).amax() > LOST_TURN
}

/// Level where the platform can rest, or turned, or anywhere: then it is mostly out of reach.
fn random_goal(rng: &mut Pcg64, rig: &Rig, home: &Pose) -> Pose {
    let (size, kind) = (0.6 * rig.radius(), rng.random_range(0.0..1.0));
    loop {
        let tilt = if kind < 0.55 { 0.0 } else { 0.5 };
        let wide = Coordinates::new(size, size, 0.4 * home.0[2], tilt, tilt, 3.0 * tilt);
        let goal = Pose(home.0 + wide.map(|most| most * rng.random_range(-1.0..=1.0)));
        if kind > 0.85 || static_margin(rig, &goal) > 0.0 {
            return goal;
        }
    }
}
