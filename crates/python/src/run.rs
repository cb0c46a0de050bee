//! Simulations in a closed loop.

use anyhow::{Result, anyhow};
use cable_robot::sim::scenario::count_steps;
use cable_robot::sim::{Moment, Scenario, Simulation};
use cable_robot_programs::command;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::answers::ControllerOptions;
use crate::rig::Rig;
use crate::{Six, pose, refused};

/// Steps between two looks at whether Python was interrupted.
const LOOK: u64 = 1000;

/// A row at the start and after each step; arrays of doubles as bytes, row by row.
#[derive(IntoPyObject)]
pub struct Run<'py> {
    cables: usize,
    status_names: Vec<String>,
    time: Bound<'py, PyBytes>,
    pose: Bound<'py, PyBytes>,
    set_point: Bound<'py, PyBytes>,
    reference: Bound<'py, PyBytes>,
    goal: Bound<'py, PyBytes>,
    commanded_tension: Bound<'py, PyBytes>,
    measured_tension: Bound<'py, PyBytes>,
    cable_length: Bound<'py, PyBytes>,
    slack: Bound<'py, PyBytes>,
    status: Bound<'py, PyBytes>,
}

/// Numbers of each kind, row by row.
#[derive(Default)]
struct Rows {
    time: Vec<f64>,
    pose: Vec<f64>,
    set_point: Vec<f64>,
    reference: Vec<f64>,
    goal: Vec<f64>,
    commanded: Vec<f64>,
    measured: Vec<f64>,
    length: Vec<f64>,
    slack: Vec<f64>,
    status: Vec<f64>,
}

impl Rows {
    fn push(&mut self, moment: &Moment) {
        let Moment { controller, plant, .. } = moment;
        self.time.push(moment.time);
        self.pose.extend(&plant.encoder_pose.0);
        self.set_point.extend(&controller.set_point.0);
        self.reference.extend(&controller.reference.pose.0);
        self.goal.extend(&moment.controller_inputs.goal_pose.0);
        self.commanded.extend(controller.motor_tension.iter());
        self.measured.extend(plant.measured_tension.iter());
        self.length.extend(plant.cable_length.iter());
        self.slack.extend(plant.slack.iter().map(|slack| f64::from(u8::from(*slack))));
        self.status.push(f64::from(controller.status.number()));
    }

    fn into_run(self, py: Python<'_>, cables: usize) -> Run<'_> {
        let bytes = |numbers: Vec<f64>| {
            PyBytes::new(py, &numbers.iter().flat_map(|number| number.to_ne_bytes()).collect::<Vec<_>>())
        };
        Run {
            cables,
            status_names: cable_robot::plan::Status::ALL.map(|status| status.to_string()).to_vec(),
            time: bytes(self.time),
            pose: bytes(self.pose),
            set_point: bytes(self.set_point),
            reference: bytes(self.reference),
            goal: bytes(self.goal),
            commanded_tension: bytes(self.commanded),
            measured_tension: bytes(self.measured),
            cable_length: bytes(self.length),
            slack: bytes(self.slack),
            status: bytes(self.status),
        }
    }
}

/// A scenario, bundled or of a file, run to its end.
#[pyfunction]
pub fn scenario<'py>(py: Python<'py>, name: &str) -> PyResult<Run<'py>> {
    run(py, &command::named(name, &[]).map_err(refused)?)
}

/// A robot that rests at `start` and is given one goal.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    rig: &Rig,
    start: Six,
    goal: Six,
    times: (f64, f64),
    options: ControllerOptions,
) -> PyResult<Run<'py>> {
    run(py, &of_goal(rig, start, goal, times, &options).map_err(refused)?)
}

fn of_goal(
    rig: &Rig,
    start: Six,
    goal: Six,
    (duration, step): (f64, f64),
    options: &ControllerOptions,
) -> Result<Scenario> {
    let parameters = options.parameters(&rig.file)?;
    let (from, to) = (pose(start), pose(goal));
    count_steps(duration, step)
        .map_err(|right| anyhow!("duration = {duration} s with step = {step} s: {right}"))?;
    command::require_rest(&parameters, "start", &from)?;
    command::require_below(&rig.file.rig, "goal", &to)?;
    Ok(command::of_goal(&rig.file, parameters, (from, to), (duration, step)))
}

/// Ctrl-C ends it: Python is asked every so many steps.
fn run<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<Run<'py>> {
    let cables = scenario.plant.rig.cables.len();
    let steps = count_steps(scenario.duration, scenario.step).map_err(|right| refused(anyhow!(right)))?;
    let mut simulation = Simulation::new(scenario).map_err(refused)?;
    let mut rows = Rows::default();
    rows.push(simulation.moment());
    for step in 1..=steps {
        simulation.step().map_err(refused)?;
        rows.push(simulation.moment());
        if step.is_multiple_of(LOOK) {
            py.check_signals()?;
        }
    }
    Ok(rows.into_run(py, cables))
}
