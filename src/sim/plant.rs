//! The plant: a rigid body on six cables, with the imperfections of a real rig if asked for.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::robot::{ParameterError, PerCable, Pose, RobotParameters};

/// Parameters of the plant; all imperfections are zero by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantParameters {
    /// The robot simulated.
    pub robot: RobotParameters,
    /// Where the platform hangs, at rest, when the simulation starts.
    pub initial_pose: Pose,
    /// Coulomb friction between motor and platform, a cable, N.
    pub friction: f64,
    /// Time constant of the motors' torque, s.
    pub motor_lag: f64,
    /// Smallest change of cable length that the encoders see, m.
    pub encoder_resolution: f64,
    /// Standard deviation of the load cells' noise, N.
    pub load_cell_noise: f64,
    /// Seed of that noise.
    pub noise_seed: i32,
}

impl Default for PlantParameters {
    fn default() -> Self {
        Self {
            robot: RobotParameters::default(),
            initial_pose: Pose::default(),
            friction: 0.0,
            motor_lag: 0.0,
            encoder_resolution: 0.0,
            load_cell_noise: 0.0,
            noise_seed: 1,
        }
    }
}

/// What the plant reads in a step; held over the step. Vectors are in the base frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantInputs {
    /// What the motors are told to pull, N; negative pulls with zero.
    pub motor_tension: PerCable<f64>,
    /// Force on the platform's centre of mass, N.
    pub disturbance_force: Vector3<f64>,
    /// Torque on the platform, N m.
    pub disturbance_torque: Vector3<f64>,
}

/// What the plant shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantOutputs {
    /// Pose as the encoders see it.
    pub encoder_pose: Pose,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in the base frame, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Cable lengths as the encoders see them, m.
    pub cable_length: PerCable<f64>,
    /// Tensions as the load cells see them, N.
    pub measured_tension: PerCable<f64>,
    /// Whether a cable pulls with nothing.
    pub slack: PerCable<bool>,
}

/// A step that could not be computed; the plant is as it was before it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlantError {
    /// The motion is beyond what the integrator can follow.
    #[error("the motion cannot be integrated past {time} s after the step's start: {cause}")]
    Integration {
        /// Seconds after the start of the step.
        time: f64,
        /// Why.
        cause: &'static str,
    },
}

/// The plant with all its memory: plain data, no heap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    outputs: PlantOutputs,
}

impl Plant {
    /// At rest at the initial pose, the motors already pulling what `inputs` say.
    ///
    /// # Errors
    /// [`ParameterError`] for a parameter that makes no sense.
    pub fn new(parameters: PlantParameters, inputs: &PlantInputs) -> Result<Self, ParameterError> {
        let _ = (parameters, inputs);
        todo!()
    }

    /// Integrates over `h` seconds with `inputs` held.
    ///
    /// # Errors
    /// [`PlantError`] when the motion cannot be followed; the plant is then unchanged.
    pub fn step(&mut self, inputs: &PlantInputs, h: f64) -> Result<(), PlantError> {
        let _ = (inputs, h);
        todo!()
    }

    /// The outputs after the last step.
    pub fn outputs(&self) -> &PlantOutputs {
        &self.outputs
    }
}
