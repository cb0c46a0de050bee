//! Which columns a run has, and how a simulation fills them.

use thiserror::Error;

use super::table::Table;
use cable_robot::sim::Moment;
use cable_robot_fmi::Model;
use cable_robot_fmi::models::{controller, plant};
use cable_robot_fmi::values::Values;
use cable_robot_fmi::variables::{Causality, Row};

/// The columns of a run after `time`: every output of plant and controller and the inputs that come from outside, by the
/// names of the FMUs' variables (`plant.encoderPose.x`, `controller.setPoint.x`, ...), for so many cables.
pub fn columns(cables: usize) -> Vec<String> {
    variables(cables).into_iter().map(|(model, name, _)| column(model, &name)).collect()
}

/// The column of a model's variable.
pub fn column(model: Model, variable: &str) -> String {
    match model {
        Model::Plant | Model::PlantExchange => format!("plant.{variable}"),
        Model::Controller => format!("controller.{variable}"),
        Model::Node(_) => variable.to_owned(),
    }
}

/// Model, name and value reference of what is recorded.
fn variables(cables: usize) -> Vec<(Model, String, u32)> {
    let recorded = |row: &&&Row| {
        let outside = row.name == "goalPose" || row.name.starts_with("disturbance");
        row.causality == Causality::Output || row.causality == Causality::Input && outside
    };
    let of = |model: Model, rows: &'static [&'static Row]| {
        // Outputs first.
        let mut rows: Vec<_> = rows.iter().filter(recorded).collect();
        rows.sort_by_key(|row| row.causality != Causality::Output);
        rows.into_iter().flat_map(move |row| {
            (0..row.count(cables)).map(move |k| (model, row.scalar_name(k), row.reference(k)))
        })
    };
    of(Model::Plant, plant::ROWS).chain(of(Model::Controller, controller::ROWS)).collect()
}

/// A value that no file can hold and nobody can draw.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{column} = {value} at {time} s is not a finite number")]
pub struct NotFinite {
    /// Its column.
    pub column: String,
    /// What it is.
    pub value: f64,
    /// s.
    pub time: f64,
}

/// Takes down the moments of a simulation.
pub struct Recording {
    variables: Vec<(Model, String, u32)>,
    /// Of controller and plant.
    values: [Values; 2],
    table: Table,
}

impl Recording {
    /// Nothing taken down yet, of a rig with so many cables.
    pub fn new(cables: usize) -> Self {
        let values = [controller::ROWS, plant::ROWS].map(|rows| Values::zero(rows, cables));
        Self { variables: variables(cables), values, table: Table::new(columns(cables)) }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`NotFinite`]; the row is not added then.
    pub fn push(&mut self, moment: &Moment) -> Result<(), NotFinite> {
        let row = self.finite(moment)?;
        self.table.push(moment.time, &row);
        Ok(())
    }

    /// A moment's values as of [`row`](Self::row), without taking it down.
    ///
    /// # Errors
    /// [`NotFinite`].
    pub fn finite(&mut self, moment: &Moment) -> Result<Vec<f64>, NotFinite> {
        let row = self.row(moment);
        match row.iter().position(|value| !value.is_finite()) {
            Some(k) => {
                let (column, value) = (self.table.names()[k + 1].clone(), row[k]);
                Err(NotFinite { column, value, time: moment.time })
            }
            None => Ok(row),
        }
    }

    /// The columns, `time` first.
    pub fn names(&self) -> &[String] {
        self.table.names()
    }

    /// A moment's values in the order of [`columns`], without taking it down.
    pub fn row(&mut self, moment: &Moment) -> Vec<f64> {
        let [of_controller, of_plant] = &mut self.values;
        controller::write_inputs(&moment.controller_inputs, of_controller);
        controller::write(&moment.controller, of_controller);
        plant::write_inputs(&moment.plant_inputs, of_plant);
        plant::write(&moment.plant, of_plant);
        let value = |(model, _, reference): &(Model, String, u32)| {
            self.values[usize::from(*model != Model::Controller)].at(*reference)
        };
        self.variables.iter().map(value).collect()
    }

    /// What was taken down.
    pub fn into_table(self) -> Table {
        self.table
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cable_robot::robot::Pose;
    use cable_robot::sim::{Goal, PlantParameters, Scenario, Simulation};

    /// A second at rest in ten steps, with a goal.
    fn resting() -> Scenario {
        Scenario {
            title: String::new(),
            rig: String::new(),
            controller: Default::default(),
            plant: PlantParameters::default(),
            orbit: None,
            goals: vec![Goal::new(0.0, Pose::at(0.05, 0.0, 1.0))],
            disturbances: vec![],
            duration: 1.0,
            step: 0.1,
        }
    }

    #[test]
    fn what_is_not_finite_is_not_taken_down() {
        let scenario = resting();
        let mut moment = *Simulation::new(&scenario).unwrap().moment();
        moment.plant.encoder_pose.0[1] = f64::INFINITY;
        let mut recording = Recording::new(6);
        let said = recording.push(&moment).unwrap_err().to_string();
        assert_eq!(said, "plant.encoderPose.y = inf at 0 s is not a finite number");
        assert_eq!(recording.into_table().rows(), 0);
    }

    #[test]
    fn the_columns_are_the_variables_of_the_fmus() {
        let columns = columns(6);
        assert_eq!(columns[..2], ["plant.encoderPose.x", "plant.encoderPose.y"]);
        for name in
            ["plant.disturbanceTorque.z", "plant.slack[6]", "controller.goalPose.yaw", "controller.status"]
        {
            assert!(columns.iter().any(|column| column == name), "{name}");
        }
        assert!(!columns.iter().any(|column| column == "plant.motorTension[1]"), "comes from the controller");
    }

    #[test]
    fn a_row_holds_what_controller_and_plant_said() {
        let scenario = resting();
        let mut simulation = Simulation::new(&scenario).unwrap();
        let mut recording = Recording::new(6);
        recording.push(simulation.moment()).unwrap();
        simulation.step().unwrap();
        recording.push(simulation.moment()).unwrap();
        let (table, moment) = (recording.into_table(), simulation.moment());
        let last = |name: &str| *table.column(name).unwrap().last().unwrap();
        assert_eq!((table.rows(), last("time"), last("controller.goalPose.x")), (2, 0.1, 0.05));
        assert_eq!(last("controller.motorTension[6]"), moment.controller.motor_tension[5]);
        assert_eq!(last("plant.measuredTension[1]"), moment.plant.measured_tension[0]);
        assert_eq!(last("controller.status"), f64::from(moment.controller.status.number()));
    }
}
