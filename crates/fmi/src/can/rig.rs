//! Drives, load cells and platform behind the values of an instance.

use super::say;
use crate::log::Log;
use crate::models::node::{SLACK, SUPPORT, SUPPORT_NUMBER, TRUE_POSE, TRUE_TENSION};
use crate::node::Node;
use crate::values::Values;
use cable_robot::robot::ParameterError;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::ls_bus::{RigNode, longest_step};
use cable_robot_fieldbus::simulated::Support;

/// The node, and what makes it again.
pub struct Rig {
    node: RigNode,
    config: Config,
}

impl Rig {
    /// Switched on, without imperfections but those of drives and load cells.
    ///
    /// # Errors
    /// [`ParameterError`] for a rig that the plant refuses.
    pub fn new(config: Config) -> Result<Self, ParameterError> {
        Ok(Self { node: RigNode::new(config.clone(), PlantParameters::default())?, config })
    }
}

impl Node for Rig {
    fn reset(&mut self) {
        // What was made once is made again.
        if let Ok(again) = Self::new(self.config.clone()) {
            *self = again;
        }
    }

    fn longest_step(&self) -> u64 {
        longest_step(&self.config)
    }

    fn step(&mut self, until: u64, values: &mut Values, _: &Log) {
        self.node.step(until);
        self.write(values);
    }

    fn write(&self, values: &mut Values) {
        let plant = self.node.plant();
        values.write(&TRUE_POSE, plant.encoder_pose.0.iter().copied());
        values.write(&TRUE_TENSION, self.node.motor_tension());
        values.write(&SLACK, plant.slack.map(|slack| f64::from(u8::from(slack))));
        let support = match self.node.support() {
            Support::Stand => 1.0,
            Support::Cables => 2.0,
            Support::Floor => 3.0,
        };
        values.write(&SUPPORT, [support]);
        values.write(&SUPPORT_NUMBER, [support]);
    }

    fn fault(&self) -> Option<String> {
        None
    }

    fn receive(&mut self, bus: usize, bytes: &[u8], now: u64, log: &Log) {
        let name = &self.config.buses[bus].name;
        self.node.receive(bus, bytes, now, &mut |notice| say(log, name, notice));
    }

    fn show(&mut self, bus: usize) -> bool {
        self.node.ports()[bus].show()
    }

    fn shown(&mut self, bus: usize) -> &[u8] {
        self.node.ports()[bus].shown()
    }

    fn forget_shown(&mut self, bus: usize) {
        self.node.ports()[bus].forget_shown();
    }
}
