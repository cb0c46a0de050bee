//! What several tests use.

use std::ops::{Deref, DerefMut};

use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::robot::Pose;
use cable_robot::sim::{self, PlantOutputs, PlantParameters};
use nalgebra::Vector2;
use rand::RngExt;
use rand_pcg::Pcg64;

/// With equal steps.
pub struct ClosedLoop {
    joined: sim::ClosedLoop,
    pub step: f64,
}

impl ClosedLoop {
    pub fn new(controller: ControllerParameters, plant: PlantParameters, goal: Pose, step: f64) -> Self {
        Self { joined: sim::ClosedLoop::new(controller, plant, goal).unwrap(), step }
    }

    pub fn time(&self) -> f64 {
        self.joined.moment().time
    }

    /// One communication step; what the controller answered and what the plant was then.
    pub fn advance(&mut self) -> (ControllerOutputs, PlantOutputs) {
        let before = self.joined.moment().plant;
        let moment = self.joined.step(self.step).unwrap();
        (moment.controller, before)
    }
}

impl Deref for ClosedLoop {
    type Target = sim::ClosedLoop;

    fn deref(&self) -> &sim::ClosedLoop {
        &self.joined
    }
}

impl DerefMut for ClosedLoop {
    fn deref_mut(&mut self) -> &mut sim::ClosedLoop {
        &mut self.joined
    }
}

/// What a controller reads of a plant.
pub fn inputs(plant: &PlantOutputs, goal: Pose, enable: bool) -> ControllerInputs {
    ControllerInputs {
        encoder_pose: plant.encoder_pose,
        cable_length: plant.cable_length,
        measured_tension: plant.measured_tension,
        goal_pose: goal,
        enable,
    }
}

/// A goal at least `margin` m inside the static workspace, at a height around `z`.
pub fn random_goal(rng: &mut Pcg64, z: f64, margin: f64) -> Pose {
    loop {
        let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        let facets = cable_robot::reach::static_workspace(&Default::default());
        if facets.iter().all(|facet| facet.slack(&point) > margin) {
            return Pose::at(point.x, point.y, z * rng.random_range(0.9..1.1));
        }
    }
}
