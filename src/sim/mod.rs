//! Section VI: the plant and its integrator, the closed loop, and scenarios for it.

pub mod body;
pub(crate) mod bundled;
pub(crate) mod closed_loop;
pub(crate) mod continuous;
pub(crate) mod integrator;
pub mod plant;
pub mod scenario;
pub mod scenario_file;
pub mod simulation;
pub mod variation;

pub use bundled::BUNDLED;
pub use closed_loop::{ClosedLoop, ControllerModel, ModelError, Moment, PlantModel, SimulationError};
pub use continuous::ContinuousPlant;
pub use plant::{Plant, PlantError, PlantInputs, PlantOutputs, PlantParameters};
pub use scenario::{Disturbance, Goal, Scenario};
pub use scenario_file::{ScenarioFile, ScenarioFileError};
pub use simulation::Simulation;
