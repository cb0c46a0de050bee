//! The columns of a run folder as poses and rates.

use super::digest::Digest;
use super::{Run, RunFolder, RunInfo, Table, TableError};
use cable_robot::control::Reference;
use cable_robot::plan::Status;
use cable_robot::robot::{Coordinates, Pose, RobotParameters, Shape};

/// The six components of a pose, as the columns call them.
const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

const DISTURBANCES: [&str; 2] = ["plant.disturbanceForce", "plant.disturbanceTorque"];

/// A recorded run, row by row.
pub struct History<'a> {
    /// What was run.
    pub info: &'a RunInfo,
    /// All columns.
    pub table: &'a Table,
    /// The paper's robot, if the plant is that and stands where the paper's does.
    pub paper: Option<RobotParameters>,
    /// Its plain columns.
    pub run: Run,
    /// The platform.
    pub pose: Vec<Pose>,
    /// What the set point was.
    pub set_point: Vec<Pose>,
    /// Where the robot was told to go.
    pub goal: Vec<Pose>,
    /// What the controller believed of pose and rates; `None` if it did not say.
    pub estimate: Option<Vec<(Pose, Coordinates)>>,
    /// What the law followed; `None` if the controller did not say.
    pub reference: Option<Vec<Reference>>,
    /// What force it believed to act besides cables and weight, N; zero if it did not say.
    pub believed_force: Vec<[f64; 3]>,
    /// Numbers of [`Status`]; `None` if the controller did not say.
    pub status: Option<Vec<i32>>,
    /// Greatest disturbing force and torque, N and N m.
    pub disturbance: [f64; 2],
    disturbed: Vec<[f64; 2]>,
}

/// What came of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// The robot rested at it after so many seconds.
    After(f64),
    /// Another goal took its place after so many seconds, before the robot had come to it.
    Replaced(f64),
    /// The run ended before.
    Never,
}

impl<'a> History<'a> {
    /// Reads the columns. A controller from elsewhere may say less than ours; the goal is then the set point.
    ///
    /// # Errors
    /// [`TableError::Missing`]: a column that is needed is not there.
    pub fn new(folder: &'a RunFolder) -> Result<Self, TableError> {
        let table = &folder.table;
        let goal = poses(table, "controller.goalPose")?;
        let says = |name: &str| table.get(&format!("controller.{name}.x")).is_some();
        let estimate = if says("estimatedPose") && says("estimatedVelocity") && says("setPoint") {
            let rates = poses(table, "controller.estimatedVelocity")?.into_iter().map(|rates| rates.0);
            Some(poses(table, "controller.estimatedPose")?.into_iter().zip(rates).collect())
        } else {
            None
        };
        Ok(Self {
            info: &folder.info,
            table,
            paper: Shape::of(&folder.info.plant_parameters.rig)
                .ok()
                .filter(Shape::is_in_place)
                .map(|shape| shape.robot),
            run: folder.run()?,
            pose: poses(table, "plant.encoderPose")?,
            set_point: if says("setPoint") { poses(table, "controller.setPoint")? } else { goal.clone() },
            goal,
            estimate,
            reference: if says("reference") { Some(references(table)?) } else { None },
            believed_force: believed_force(table),
            status: table.get("controller.status").map(|column| column.iter().map(|s| *s as i32).collect()),
            disturbance: DISTURBANCES.map(|name| greatest(table, name)),
            disturbed: disturbed(table, &folder.run()?.times),
        })
    }

    /// Of the rows that a digest has, with what it says of all.
    ///
    /// # Errors
    /// As of [`new`](Self::new).
    pub fn of(digest: &'a Digest) -> Result<Self, TableError> {
        let (disturbance, disturbed) = (digest.disturbance, digest.disturbed_spans.clone());
        Ok(Self { disturbance, disturbed, ..Self::new(&digest.folder)? })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.run.times.len()
    }

    /// Whether the law (4) was at work: neither disabled nor at fault.
    pub fn law_at_work(&self, row: usize) -> bool {
        let idle = [Status::Disabled, Status::SensorFault, Status::WaitingForPose].map(Status::number);
        self.status.as_ref().is_none_or(|status| !idle.contains(&status[row]))
    }

    /// The first row, and each that has another set point than the row before.
    pub fn set_point_rows(&self) -> Vec<usize> {
        let index = &self.run.set_point_index;
        let is_new = |row: usize| {
            row == 0 || index[row] != index[row - 1] || self.set_point[row] != self.set_point[row - 1]
        };
        (0..self.len()).filter(|row| is_new(*row)).collect()
    }

    /// The first row, and each that has another goal than the row before.
    pub fn goal_rows(&self) -> Vec<usize> {
        (0..self.len()).filter(|row| *row == 0 || self.goal[*row] != self.goal[*row - 1]).collect()
    }

    /// For each goal the row in which it was given, and what came of it. To hold the start is no goal.
    pub fn goals(&self) -> Vec<(usize, Arrival)> {
        let holds_start = |row: &usize| *row == 0 && self.goal[0] == self.info.plant_parameters.initial_pose;
        let given: Vec<_> = self.goal_rows().into_iter().filter(|row| !holds_start(row)).collect();
        let ends = given.iter().skip(1).copied().chain([self.len()]);
        let arrival = |start: usize, end: usize| match (start..end).find(|row| self.run.at_goal[*row] != 0.0)
        {
            Some(row) => Arrival::After(self.run.times[row] - self.run.times[start]),
            None if end < self.len() => Arrival::Replaced(self.run.times[end] - self.run.times[start]),
            None => Arrival::Never,
        };
        given.iter().zip(ends).map(|(start, end)| (*start, arrival(*start, end))).collect()
    }

    /// From when to when the platform was disturbed, s.
    pub fn disturbed_spans(&self) -> &[[f64; 2]] {
        &self.disturbed
    }

    /// What the controller said last; `None` if it did not say.
    pub fn last_status(&self) -> Option<Status> {
        let number = *self.status.as_ref()?.last()?;
        Some(Status::of(number))
    }

    /// Whether any cable is slack.
    pub fn is_slack(&self, row: usize) -> bool {
        self.run.slack.iter().any(|cable| cable[row] != 0.0)
    }
}

fn references(table: &Table) -> Result<Vec<Reference>, TableError> {
    let of = |name: &str| poses(table, &format!("controller.{name}"));
    let (rates, accelerations) = (of("referenceVelocity")?, of("referenceAcceleration")?);
    let motion = rates.into_iter().zip(accelerations);
    let all = of("reference")?.into_iter().zip(motion);
    Ok(all
        .map(|(pose, (rates, accelerations))| Reference {
            pose,
            rates: rates.0,
            accelerations: accelerations.0,
        })
        .collect())
}

fn poses(table: &Table, name: &str) -> Result<Vec<Pose>, TableError> {
    let mut poses = vec![Pose(Coordinates::zeros()); table.rows()];
    for (k, axis) in POSE.iter().enumerate() {
        let column = table.column(&format!("{name}.{axis}"))?;
        poses.iter_mut().zip(column).for_each(|(pose, value)| pose.0[k] = *value);
    }
    Ok(poses)
}

/// From when to when a component of a disturbance is not zero, s. A row speaks of the time since the one before.
fn disturbed(table: &Table, times: &[f64]) -> Vec<[f64; 2]> {
    let components =
        DISTURBANCES.iter().flat_map(|name| ["x", "y", "z"].map(|axis| format!("{name}.{axis}")));
    let columns: Vec<_> = components.filter_map(|name| table.get(&name)).collect();
    let mut spans: Vec<[f64; 2]> = vec![];
    for row in (0..times.len()).filter(|row| columns.iter().any(|column| column[*row] != 0.0)) {
        let begun = times[row.saturating_sub(1)];
        match spans.last_mut() {
            Some(last) if last[1] >= begun => last[1] = times[row],
            _ => spans.push([begun, times[row]]),
        }
    }
    spans
}

/// The controller's estimate of a disturbing force, row by row.
fn believed_force(table: &Table) -> Vec<[f64; 3]> {
    let columns = ["x", "y", "z"].map(|axis| table.get(&format!("controller.disturbanceForce.{axis}")));
    let rows = table.get("time").map_or(0, |times| times.len());
    (0..rows).map(|row| columns.map(|column| column.map_or(0.0, |column| column[row]))).collect()
}

/// The greatest length of a vector in the table; 0 if it is not there.
fn greatest(table: &Table, name: &str) -> f64 {
    let columns = ["x", "y", "z"].map(|axis| table.get(&format!("{name}.{axis}")).unwrap_or_default());
    let rows = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let length = |row: usize| columns.iter().map(|column| column[row] * column[row]).sum::<f64>().sqrt();
    (0..rows).map(length).fold(0.0, f64::max)
}
