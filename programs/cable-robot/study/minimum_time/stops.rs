//! A stop on the way in closed loop: another goal is given while the robot moves, and it stops and goes there.

use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::Pose;
use cable_robot::sim::{ClosedLoop, PlantParameters};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::super::cases::{log_uniform, random_gains_of_held};
use super::moves::Move;

/// Time for the way back, beside that for the way there, in the slower of the gains' time constants: as in `study held`.
const PATIENCE: f64 = 25.0;

/// What came of some runs.
#[derive(Clone, Copy)]
pub struct Runs {
    pub runs: u64,
    /// Not begun: too near the limits for what the controller keeps, or too long a step for the gains.
    pub refused: u64,
    pub slack: u64,
    /// Ended at rest where they began.
    pub returned: u64,
    /// Smallest distance of a tension commanded from a limit, as a share of the weight.
    pub smallest: f64,
}

impl Runs {
    pub fn none() -> Self {
        Self { runs: 0, refused: 0, slack: 0, returned: 0, smallest: f64::INFINITY }
    }

    pub fn and(self, other: Self) -> Self {
        Self {
            runs: self.runs + other.runs,
            refused: self.refused + other.refused,
            slack: self.slack + other.slack,
            returned: self.returned + other.returned,
            smallest: self.smallest.min(other.smallest),
        }
    }

    /// From one end of a move straight to the other, and back from a random instant on the way on.
    pub fn of(planned: &Move, rng: &mut Pcg64) -> Self {
        let arcs = planned.timing.arcs();
        let (Some(first), Some(last)) = (arcs.first(), arcs.last()) else { return Self::none() };
        let ends = [planned.section(first).pose(0.0), planned.section(last).pose(planned.end())];
        there_and_back(planned, &ends, rng).unwrap_or(Self { refused: 1, ..Self::none() })
    }
}

fn there_and_back(planned: &Move, [start, goal]: &[Pose; 2], rng: &mut Pcg64) -> Option<Runs> {
    let (gains, step) = (random_gains_of_held(rng), log_uniform(rng, 0.25e-3, 10e-3));
    let parameters = ControllerParameters {
        planner: PlannerKind::MinimumTime,
        lambda: gains.lambda,
        eta: gains.eta,
        ..ControllerParameters::of(&planned.rig)
    };
    parameters.check_step(step).ok()?;
    let course = Planner::from(parameters).course_from_rest(start, goal)?;
    let plant = PlantParameters { rig: planned.rig, initial_pose: *start, ..Default::default() };
    let mut run = ClosedLoop::new(parameters, plant, *goal).ok()?;
    let turned = rng.random_range(0.0..1.0) * course.end() + parameters.planner_period;
    let most = turned + course.end() + PATIENCE / gains.lambda.min(gains.eta);
    let mut found = Runs { runs: 1, ..Runs::none() };
    while run.moment().time < most {
        let is_back = run.moment().time >= turned;
        run.goal = if is_back { *start } else { *goal };
        let Ok(moment) = run.step(step) else { break };
        let margins = moment.controller.motor_tension.iter().zip(&planned.rig.cables);
        let margin = margins.map(|(u, cable)| cable.limits.margin(*u)).fold(f64::INFINITY, f64::min);
        found.smallest = found.smallest.min(margin / planned.rig.weight());
        found.slack |= u64::from(moment.plant.slack.contains(&true));
        let is_decided = moment.time > turned + parameters.planner_period + step;
        if is_decided && moment.controller.status == Status::AtGoal {
            found.returned = 1;
            break;
        }
    }
    Some(found)
}
