//! What a person looks at: a run folder, and one HTML file of it, which opens offline by double click.
//!
//! `page/` holds the page's text, style and scripts; what they draw is reckoned in `data` and lies in the page as JSON.

mod compare;
mod data;
mod digest;
mod domains;
pub mod events;
mod explanation;
#[cfg(feature = "export")]
pub mod export;
pub mod facts;
pub mod files;
mod history;
mod limits;
mod page;
pub mod recording;
mod run;
pub mod run_folder;
mod table;
mod thinning;
mod workspace;

pub use compare::{CompareError, compare};
pub use digest::Digest;
pub use page::html;
pub use recording::Recording;
pub use run::{Run, SetPoint, Slack, SmallestTension, Summary};
pub use run_folder::{GrowingRun, RunFolder, RunFolderError, RunInfo};
pub use table::{Rows, Table, TableError};

#[cfg(test)]
mod tests {
    use super::run_folder::{FORMAT, Model};
    use super::*;
    use cable_robot::plan::{ControllerParameters, PlannerKind};
    use cable_robot::robot::Pose;
    use cable_robot::sim::{Goal, PlantParameters, Scenario, Simulation};

    /// From (0, 0, 1) to (0.1, 0.1, 1) and on to (-0.1, 0.05, 1), on an ideal rig or a noisy one.
    pub(super) fn run(planner: PlannerKind, duration: f64, noise: f64) -> RunFolder {
        let controller = ControllerParameters { planner, ..Default::default() };
        let plant = PlantParameters { load_cell_noise: noise, ..Default::default() };
        let goal = |time: f64, x: f64, y: f64| Goal::new(time, Pose::at(x, y, 1.0));
        let scenario = Scenario {
            title: "A & B </script>".to_owned(),
            rig: "Table I".to_owned(),
            controller,
            plant,
            orbit: None,
            goals: vec![goal(0.0, 0.1, 0.1), goal(0.75 * duration, -0.1, 0.05)],
            disturbances: vec![],
            duration,
            step: 1e-3,
        };
        record(&scenario)
    }

    pub(super) fn record(scenario: &Scenario) -> RunFolder {
        let mut simulation = Simulation::new(scenario).unwrap();
        let mut recording = Recording::new(scenario.plant.rig.cables.len());
        recording.push(simulation.moment()).unwrap();
        for _ in 0..(scenario.duration / scenario.step).round() as usize {
            simulation.step().unwrap();
            recording.push(simulation.moment()).unwrap();
        }
        let info = RunInfo {
            format: FORMAT,
            program_version: "0.1.0".to_owned(),
            title: scenario.title.clone(),
            scenario: None,
            controller: Model::Library,
            plant: Model::Library,
            rig: scenario.rig.clone(),
            orbit: scenario.orbit,
            step: scenario.step,
            controller_parameters: scenario.controller,
            plant_parameters: scenario.plant,
        };
        RunFolder { info, table: recording.into_table() }
    }
}
