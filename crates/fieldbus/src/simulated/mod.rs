//! A lab without hardware: six drives, their load cells and the plant, behind the buses of a rig file.

mod bench;
mod cell;
mod drive;
mod link;
pub mod mishap;
mod node;

pub use bench::Bench;
pub use cell::{CellFault, SimulatedCells};
pub use drive::{DriveFaults, SimulatedDrive};
pub use link::{Link, LinkFaults};
pub use mishap::{Mishap, Script};
pub use node::{NodeFaults, SimulatedNode};

use super::Nanoseconds;
use super::config::Config;
use super::frame::Frame;
use crate::{CABLES, PerCable, six_of};
use cable_robot::robot::ParameterError;
use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

/// Share of its weight that the cables must carry to lift the platform off its stand.
const LIFTS_AT: f64 = 0.98;
/// The floor is so far below the home pose, m.
const FLOOR: f64 = 0.3;
/// Counts of a motor at the home pose, times its cable's number: they mean nothing, so they are not zero.
const COUNTS_AT_HOME: i32 = 10_000;

/// What carries the platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Its stand, at the home pose.
    Stand,
    /// The cables.
    Cables,
    /// The floor: it fell.
    Floor,
}

/// Everything on the buses but the bridge.
#[derive(Clone, Debug)]
pub struct SimulatedRig {
    /// One a cable.
    pub drives: PerCable<SimulatedDrive>,
    /// One a node with load cells.
    pub cells: Vec<SimulatedCells>,
    config: Config,
    home_length: PerCable<f64>,
    plant_parameters: PlantParameters,
    plant: Plant,
    support: Support,
    time: Nanoseconds,
    steps: i32,
    oldest_command: Nanoseconds,
}

impl SimulatedRig {
    /// Switched on at time 0, the platform on its stand. Robot and home pose are those of the rig file; of `imperfections` the rest counts.
    ///
    /// # Errors
    /// [`ParameterError`] for an imperfection that makes no sense.
    pub fn new(config: Config, imperfections: PlantParameters) -> Result<Self, ParameterError> {
        let plant_parameters =
            PlantParameters { rig: config.controller.rig(), initial_pose: config.home, ..imperfections };
        let plant = Plant::new(plant_parameters, &PlantInputs::none(CABLES))?;
        let mut nodes: Vec<_> = config.load_cells.iter().map(|cell| cell.node).collect();
        nodes.dedup();
        let cables = plant_parameters.rig.cables_at(&config.home);
        Ok(Self {
            drives: std::array::from_fn(|i| SimulatedDrive::new(&config, i)),
            cells: nodes.into_iter().map(|node| SimulatedCells::new(&config, node)).collect(),
            home_length: six_of(&cables.length),
            config,
            plant_parameters,
            plant,
            support: Support::Stand,
            time: 0,
            steps: 0,
            oldest_command: 0,
        })
    }

    /// The platform, as it is and as encoders and load cells see it.
    pub fn plant(&self) -> &PlantOutputs {
        self.plant.outputs()
    }

    /// What carries the platform.
    pub fn support(&self) -> Support {
        self.support
    }

    /// What the motors pull, N.
    pub fn motor_tension(&self) -> PerCable<f64> {
        std::array::from_fn(|i| self.drives[i].tension())
    }

    /// The longest that a motor ever pulled without a newer command, until the last [`SimulatedRig::tick`].
    pub fn oldest_command(&self) -> Nanoseconds {
        self.oldest_command
    }

    /// Takes in a frame from a bus at `now`; answers go to `out`.
    pub fn on_frame(&mut self, bus: usize, frame: &Frame, now: Nanoseconds, out: &mut Vec<(usize, Frame)>) {
        let mut answers = vec![];
        for i in 0..CABLES {
            if self.config.drives[i].bus == bus {
                self.drives[i].on_frame(frame, now, &mut answers);
            }
        }
        for cells in &mut self.cells {
            if self.config.load_cells[cells.cells[0].0].bus == bus {
                cells.on_frame(frame, now, &mut answers);
            }
        }
        out.extend(answers.into_iter().map(|frame| (bus, frame)));
    }

    /// Lets time pass until `now`: the platform moves, nodes send what is due to `out`.
    pub fn tick(&mut self, now: Nanoseconds, out: &mut Vec<(usize, Frame)>) {
        self.move_platform(now);
        let seen = *self.plant.outputs();
        for i in 0..CABLES {
            let (mut sent, at_home) = (vec![], COUNTS_AT_HOME * (i as i32 + 1));
            let winch = self.config.drives[i].winch;
            self.drives[i].turn_to(winch.counts(seen.cable_length[i] - self.home_length[i], at_home));
            self.drives[i].tick(now, &mut sent);
            self.oldest_command = self.oldest_command.max(self.drives[i].command_age(now));
            out.extend(sent.into_iter().map(|frame| (self.config.drives[i].bus, frame)));
        }
        for cells in &mut self.cells {
            let (mut sent, bus) = (vec![], self.config.load_cells[cells.cells[0].0].bus);
            cells.feel(&seen.measured_tension);
            cells.tick(now, &mut sent);
            out.extend(sent.into_iter().map(|frame| (bus, frame)));
        }
    }

    fn move_platform(&mut self, now: Nanoseconds) {
        let h = now.saturating_sub(self.time) as f64 * 1e-9;
        self.time = now;
        let inputs = PlantInputs { motor_tension: self.motor_tension().into(), ..PlantInputs::none(CABLES) };
        if self.support == Support::Cables && h > 0.0 {
            let has_fallen = self.plant.step(&inputs, h).is_err()
                || self.plant.outputs().encoder_pose.0[2] > self.config.home.0[2] + FLOOR;
            if has_fallen {
                self.support = Support::Floor;
            }
        } else if self.support == Support::Stand {
            self.stand(&inputs);
        }
    }

    /// At rest at the home pose, whatever the motors pull, until they carry the weight.
    fn stand(&mut self, inputs: &PlantInputs) {
        self.steps = self.steps.wrapping_add(1);
        let noise_seed = self.plant_parameters.noise_seed.wrapping_add(self.steps);
        if let Ok(plant) = Plant::new(PlantParameters { noise_seed, ..self.plant_parameters }, inputs) {
            self.plant = plant;
        }
        let rig = &self.plant_parameters.rig;
        let cables = rig.cables_at(&self.config.home);
        let lift = -cables.wrench(&inputs.motor_tension).0.z;
        if lift >= LIFTS_AT * rig.weight() {
            self.support = Support::Cables;
        }
    }
}
