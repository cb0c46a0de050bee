//! The closed loop of the two FMUs, recorded: what `cargo demo` and the tests of the packed files run.

use super::Run;
use super::recording::columns;
use super::table::Table;
use cable_robot_import::{CosimError, Instance, Master, Recorder};

/// The six components of a pose, as the FMUs call them.
const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Controller and plant, connected; the controller steps first, so that it reads the pose of the step's start.
pub struct ClosedLoop {
    cables: usize,
    master: Master,
    recorder: Recorder,
}

impl ClosedLoop {
    /// Connects an instance of `CableRobotController` and one of `CableRobotPlant`, named `controller` and `plant`, sets
    /// the goal's position (m; zero orientation), initialises both and records the first row.
    ///
    /// # Errors
    /// [`CosimError`]: a missing variable, or what the FMUs refuse.
    pub fn new(controller: Instance, plant: Instance, goal: [f64; 3], step: f64) -> Result<Self, CosimError> {
        let is_tension = |name: &&str| name.starts_with("motorTension[");
        let names = controller.description().variables.iter().map(|variable| variable.name.as_str());
        let cables = names.filter(is_tension).count();
        let connections = connections(cables);
        let connections: Vec<_> = connections.iter().map(|(from, to)| (from.as_str(), to.as_str())).collect();
        let mut master = Master::new(vec![controller, plant], &connections, step)?;
        for (axis, value) in POSE.iter().zip(goal) {
            master.set(&format!("controller.goalPose.{axis}"), value)?;
        }
        let mut recorder = Recorder::new(&master, columns(cables))?;
        master.initialize(0.0, None)?;
        recorder.sample(&master)?;
        Ok(Self { cables, master, recorder })
    }

    /// Steps until `stop` (s), or until the robot has rested at the goal for `rest` seconds, and ends the simulation.
    /// `progress` is told the time after each step.
    ///
    /// # Errors
    /// [`CosimError`]: what the FMUs refuse.
    pub fn run(&mut self, stop: f64, rest: f64, mut progress: impl FnMut(f64)) -> Result<(), CosimError> {
        let mut end = stop;
        while self.master.time() < end {
            self.master.step()?;
            self.recorder.sample(&self.master)?;
            if end == stop && self.master.get("controller.atGoal")?.as_f64() != 0.0 {
                end = stop.min(self.master.time() + rest);
            }
            progress(self.master.time());
        }
        self.master.terminate()
    }

    /// Everything recorded.
    pub fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Everything recorded, as a run folder keeps it.
    ///
    /// # Errors
    /// [`CosimError::Setup`] for a column that is not recorded.
    pub fn table(&self) -> Result<Table, CosimError> {
        let names = columns(self.cables);
        let recorded = names.iter().map(|name| self.recorder.column(name)).collect::<Result<Vec<_>, _>>()?;
        let mut table = Table::new(names);
        for (row, time) in self.recorder.times().iter().enumerate() {
            table.push(*time, &recorded.iter().map(|column| column[row]).collect::<Vec<_>>());
        }
        Ok(table)
    }

    /// What the report needs of it.
    ///
    /// # Errors
    /// [`CosimError::Setup`] for a column that is not recorded.
    pub fn recorded_run(&self) -> Result<Run, CosimError> {
        let column = |name: &str| self.recorder.column(name).map(<[f64]>::to_vec);
        let axes = |name: &str| all(|k| column(&format!("{name}.{}", POSE[k])));
        let cables = |name: &str| -> Result<Vec<_>, _> {
            cables(name, self.cables).map(|name| column(&name)).collect()
        };
        Ok(Run {
            times: self.recorder.times().to_vec(),
            position: axes("plant.encoderPose")?,
            set_point: axes("controller.setPoint")?,
            set_point_index: column("controller.setPointIndex")?,
            tension: cables("plant.measuredTension")?,
            slack: cables("plant.slack")?,
            tension_margin: column("controller.tensionMargin")?,
            at_goal: column("controller.atGoal")?,
        })
    }
}

/// An array of columns, or the first error.
fn all<const N: usize>(
    column: impl Fn(usize) -> Result<Vec<f64>, CosimError>,
) -> Result<[Vec<f64>; N], CosimError> {
    let mut columns = std::array::from_fn(|_| Vec::new());
    for (k, place) in columns.iter_mut().enumerate() {
        *place = column(k)?;
    }
    Ok(columns)
}

/// `name.x` to `name.yaw`.
fn pose(name: &str) -> impl Iterator<Item = String> {
    POSE.iter().map(move |axis| format!("{name}.{axis}"))
}

/// `name[1]`, `name[2]` and so on.
fn cables(name: &str, count: usize) -> impl Iterator<Item = String> {
    (1..=count).map(move |i| format!("{name}[{i}]"))
}

/// What flows from one FMU to the other.
fn connections(count: usize) -> Vec<(String, String)> {
    let tensions =
        cables("motorTension", count).map(|name| (format!("controller.{name}"), format!("plant.{name}")));
    let measured =
        pose("encoderPose").chain(cables("cableLength", count)).chain(cables("measuredTension", count));
    tensions.chain(measured.map(|name| (format!("plant.{name}"), format!("controller.{name}")))).collect()
}
