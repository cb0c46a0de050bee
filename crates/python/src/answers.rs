//! Plans and certificates.

use anyhow::anyhow;
use cable_robot::control::Gains;
use cable_robot::plan::sequence::Sequence;
use cable_robot::plan::through::Through;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::reach::certificate::{Margins, Step, Verdict, certify_with_margins};
use cable_robot::robot::{Coordinates, RigFile};
use cable_robot_programs::command;
use pyo3::prelude::*;

use crate::rig::Rig;
use crate::{Six, pose, refused};

/// λ and η, 1/s, where they are not the rig file's.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ControllerOptions {
    planner: Option<String>,
    lambda: Option<f64>,
    eta: Option<f64>,
    lift: f64,
    max_tension_rate: f64,
}

impl ControllerOptions {
    /// The controller for a rig.
    pub fn parameters(&self, file: &RigFile) -> anyhow::Result<ControllerParameters> {
        let file = RigFile {
            lambda: self.lambda.unwrap_or(file.lambda),
            eta: self.eta.unwrap_or(file.eta),
            ..file.clone()
        };
        let kind = self.planner.as_deref().map(planner).transpose()?;
        let parameters = ControllerParameters {
            lift: self.lift,
            max_tension_rate: self.max_tension_rate,
            ..command::controller(&file, kind)?
        };
        parameters.validate()?;
        Ok(parameters)
    }
}

fn planner(name: &str) -> anyhow::Result<PlannerKind> {
    let known = PlannerKind::ALL.into_iter().find(|kind| kind.key() == name);
    known.ok_or_else(|| anyhow!("planner = {name:?} is none of {}", PlannerKind::KEYS.join(", ")))
}

/// The set points to a goal, or when each way point is passed without a stop (s).
#[derive(IntoPyObject)]
pub struct Plan {
    set_points: Vec<Six>,
    times: Option<Vec<f64>>,
    duration: Option<f64>,
    smallest_tension: Option<f64>,
    reachable: Option<bool>,
    nearest: Option<Six>,
    barrier_cable: Option<usize>,
    planner: &'static str,
}

/// From rest at `start` to rest at `goal`.
#[pyfunction]
pub fn plan(
    py: Python,
    rig: &Rig,
    start: Six,
    goal: Six,
    through: Vec<Six>,
    options: ControllerOptions,
) -> PyResult<Plan> {
    let parameters = options.parameters(&rig.file).map_err(refused)?;
    let (from, to) = (pose(start), pose(goal));
    command::require_rest(&parameters, "start", &from).map_err(refused)?;
    command::require_below(&parameters.rig, "goal", &to).map_err(refused)?;
    let kind = parameters.planner.key();
    if through.is_empty() {
        let found = py.detach(|| Sequence::new(&parameters, &from, &to)).map_err(refused)?;
        let obstacle = found.obstacle.as_ref();
        return Ok(Plan {
            set_points: found.set_points.iter().map(|pose| pose.0.into()).collect(),
            times: None,
            duration: found.duration,
            smallest_tension: found.smallest.map(|(_, at)| at.tension),
            reachable: (!found.given_up).then_some(found.is_complete()),
            nearest: obstacle.and_then(|obstacle| Some(obstacle.nearest?.0.into())),
            barrier_cable: obstacle.and_then(|obstacle| Some(obstacle.barrier?.0.cable)),
            planner: kind,
        });
    }
    let poses: Vec<_> = [from].into_iter().chain(through.into_iter().map(pose)).chain([to]).collect();
    let found = py.detach(|| Through::new(&parameters, &poses)).map_err(refused)?;
    let ends = found.course.end();
    Ok(Plan {
        set_points: poses[1..].iter().map(|pose| pose.0.into()).collect(),
        times: Some(found.course.passes().chain([ends]).collect()),
        duration: Some(ends),
        smallest_tension: Some(found.smallest.tension),
        reachable: Some(true),
        nearest: None,
        barrier_cable: None,
        planner: kind,
    })
}

/// Bounds of what the controller does not know, as `cable_robot.certify` has them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MarginOptions {
    mass_error: f64,
    centre_of_mass_error: f64,
    force: f64,
    torque: f64,
    friction: f64,
    accuracy: Option<f64>,
    sample_period: f64,
    delay: f64,
}

/// A verdict, with the numbers that it has.
#[derive(IntoPyObject, Default)]
pub struct Certificate {
    verdict: &'static str,
    least: Option<f64>,
    greatest: Option<f64>,
    time: Option<f64>,
    cable: Option<usize>,
    tension: Option<f64>,
    shortfall: Option<f64>,
    cause: Option<String>,
}

/// Of the step from `start`, moving with `rates`, to the set point `goal`.
#[pyfunction]
pub fn certify(
    py: Python,
    rig: &Rig,
    start: Six,
    goal: Six,
    rates: Six,
    gains: (Option<f64>, Option<f64>),
    margins: MarginOptions,
) -> PyResult<Certificate> {
    let RigFile { rig, lambda, eta, .. } = &rig.file;
    let gains = Gains { lambda: gains.0.unwrap_or(*lambda), eta: gains.1.unwrap_or(*eta) };
    let step = Step { start: pose(start), rates: Coordinates::from(rates), set_point: pose(goal), gains };
    let margins = Margins {
        mass: margins.mass_error,
        centre_of_mass: margins.centre_of_mass_error,
        force: margins.force,
        torque: margins.torque,
        friction: margins.friction,
        law_margin: Planner::from(ControllerParameters::of(rig)).allowance(),
        accuracy: margins.accuracy.unwrap_or(rig.accuracy),
        sample_period: margins.sample_period,
        delay: margins.delay,
    };
    let verdict = py.detach(|| certify_with_margins(rig, &step, &margins)).map_err(refused)?;
    let none = Certificate::default();
    Ok(match command::earliest(rig, &step, verdict) {
        Verdict::Admissible { least, greatest, .. } => {
            Certificate { verdict: "admissible", least: Some(least), greatest: Some(greatest), ..none }
        }
        Verdict::NotAdmissible { cable, time, tension } => Certificate {
            verdict: "not admissible",
            time: Some(time),
            cable: Some(cable),
            tension: Some(tension),
            ..none
        },
        Verdict::NoDistribution { time, shortfall, .. } => {
            Certificate { verdict: "not admissible", time: Some(time), shortfall: Some(shortfall), ..none }
        }
        Verdict::Undecided { time, cause, .. } => {
            Certificate { verdict: "undecided", time: Some(time), cause: Some(format!("{cause:?}")), ..none }
        }
    })
}
