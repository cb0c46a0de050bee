//! The plant: a rigid body on its cables, with the imperfections of a real rig if asked for.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::body::{self, Body, State};
use super::integrator::integrate;
use crate::robot::memory::expect;
use crate::robot::parameters::require;
use crate::robot::{
    Cables, Coordinates, MemoryError, ParameterError, PerCable, Pose, Rig, RobotParameters, TensionLimits,
    forward_kinematics,
};

/// Speed of a cable at which friction has turned over, m/s.
pub(super) const FRICTION_TURNOVER: f64 = 1e-3;

/// Parameters of the plant; all imperfections are zero by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct PlantParameters {
    /// The rig simulated; its limits of tension are the controller's affair.
    pub rig: Rig,
    /// Where the platform hangs, at rest, when the simulation starts.
    pub initial_pose: Pose,
    /// Coulomb friction between motor and platform, N a cable: the platform feels less while the motor hauls in, more while it
    /// pays out.
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
            rig: Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 }),
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantInputs {
    /// Commanded tensions of the motors, N; negative pulls with zero.
    pub motor_tension: PerCable<f64>,
    /// Force on the platform's centre of mass, N.
    pub disturbance_force: Vector3<f64>,
    /// Torque on the platform, N m.
    pub disturbance_torque: Vector3<f64>,
}

impl PlantInputs {
    /// Nothing pulls and nothing disturbs.
    pub fn none(cables: usize) -> Self {
        let none = Vector3::zeros();
        Self {
            motor_tension: PerCable::filled(cables, 0.0),
            disturbance_force: none,
            disturbance_torque: none,
        }
    }
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

impl PlantOutputs {
    /// The first that is no finite number; numbers far beyond any rig overflow.
    fn infinite(&self) -> Option<(String, f64)> {
        let cable = |name, values: PerCable<f64>| {
            let found = values.iter().position(|value| !value.is_finite())?;
            Some((format!("{name}[{}]", found + 1), values[found]))
        };
        let whole = |name: &str, values: &[f64]| {
            let value = values.iter().find(|value| !value.is_finite())?;
            Some((name.to_owned(), *value))
        };
        whole("encoderPose", self.encoder_pose.0.as_slice())
            .or_else(|| whole("velocity", self.velocity.as_slice()))
            .or_else(|| whole("angularVelocity", self.angular_velocity.as_slice()))
            .or_else(|| cable("cableLength", self.cable_length))
            .or_else(|| cable("measuredTension", self.measured_tension))
    }
}

/// A step that could not be computed; the plant is as it was before it.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "the motion cannot be followed past {time} s after the start of the step: {cause} (largest motorTension {tension} N)"
)]
pub struct PlantError {
    /// Seconds after the start of the step.
    pub time: f64,
    /// Why.
    pub cause: &'static str,
    /// The largest tension commanded, N.
    pub tension: f64,
}

/// The plant with all its memory: plain data, no heap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    parameters: PlantParameters,
    state: State,
    /// What the motors pull, N.
    motor: PerCable<f64>,
    noise: Pcg64,
    outputs: PlantOutputs,
}

impl PlantParameters {
    /// Names the first parameter that makes no sense.
    ///
    /// # Errors
    /// [`ParameterError`] with the parameter's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.rig.validate()?;
        for (axis, value) in
            ["x", "y", "z", "roll", "pitch", "yaw"].into_iter().zip(self.initial_pose.0.iter())
        {
            require(value.is_finite(), format!("initialPose.{axis}"), *value, "must be finite")?;
        }
        let allowed = "no cable could pull against gravity there: the platform must hang below an anchor (m)";
        require(self.rig.can_be_at(&self.initial_pose), "initialPose.z", self.initial_pose.0[2], allowed)?;
        for (name, value) in [
            ("friction", self.friction),
            ("motorLag", self.motor_lag),
            ("encoderResolution", self.encoder_resolution),
            ("loadCellNoise", self.load_cell_noise),
        ] {
            require(value.is_finite() && value >= 0.0, name, value, "must be finite and 0 or greater")?;
        }
        Ok(())
    }
}

impl Plant {
    /// At rest at the initial pose, the motors already pulling what `inputs` say.
    ///
    /// # Errors
    /// [`ParameterError`] for a parameter that makes no sense.
    pub fn new(parameters: PlantParameters, inputs: &PlantInputs) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let mut plant = Self {
            parameters,
            state: body::at_rest(&parameters.initial_pose),
            motor: inputs.motor_tension.map(pull_only),
            noise: Pcg64::seed_from_u64(i64::from(parameters.noise_seed) as u64),
            outputs: PlantOutputs {
                encoder_pose: parameters.initial_pose,
                velocity: Vector3::zeros(),
                angular_velocity: Vector3::zeros(),
                cable_length: parameters.rig.cables.map(|_| 0.0),
                measured_tension: parameters.rig.cables.map(|_| 0.0),
                slack: parameters.rig.cables.map(|_| false),
            },
        };
        plant.measure();
        if let Some((name, value)) = plant.outputs.infinite() {
            let allowed = "must be finite: base, platform, initialPose or loadCellNoise is too large";
            require(false, name, value, allowed)?;
        }
        Ok(plant)
    }

    /// The same plant, moving with these rates of the six coordinates (m/s, rad/s).
    #[must_use]
    pub fn moving(mut self, rates: &Coordinates) -> Self {
        self.state = body::moving(&self.parameters.initial_pose, rates);
        self.measure();
        self
    }

    /// At rest at a pose, where something else than the cables carries the platform, the motors pulling what `inputs` say.
    pub fn stand(&mut self, at: &Pose, inputs: &PlantInputs) {
        self.state = body::at_rest(at);
        self.motor = inputs.motor_tension.map(pull_only);
        self.measure();
    }

    /// Integrates over `h` seconds with `inputs` held.
    ///
    /// # Errors
    /// [`PlantError`] when the motion cannot be followed; the plant is then unchanged.
    pub fn step(&mut self, inputs: &PlantInputs, h: f64) -> Result<(), PlantError> {
        let command = inputs.motor_tension.map(pull_only);
        let Self { parameters, motor, .. } = &*self;
        let platform = Body::new(&parameters.rig);
        let disturbance = (&inputs.disturbance_force, &inputs.disturbance_torque);
        let end = integrate(&self.state, h, |t, state| {
            let pull = lagged(motor, &command, parameters.motor_lag, t);
            let tension = |cables: &Cables| platform_tension(parameters.friction, &pull, cables, state);
            body::derivative(&platform, state, tension, disturbance)
        });
        let end = end.map_err(|stopped| PlantError {
            time: stopped.time,
            cause: stopped.cause,
            tension: greatest(&command),
        })?;
        let mut next = Self { state: body::normalised(end), ..self.clone() };
        next.motor = lagged(motor, &command, parameters.motor_lag, h);
        next.measure();
        if next.outputs.infinite().is_some() {
            let cause = "what the encoders or load cells see is no finite number";
            return Err(PlantError { time: h, cause, tension: greatest(&command) });
        }
        *self = next;
        Ok(())
    }

    /// Whether a run can have left this memory: before one that was saved somewhere is taken up.
    ///
    /// # Errors
    /// [`MemoryError`] for the first part that makes no sense.
    pub fn check(&self) -> Result<(), MemoryError> {
        self.parameters.validate()?;
        let cables = self.parameters.rig.cables.len();
        let seen = &self.outputs;
        expect(body::is_sound(&self.state), "state", "13 finite numbers, with a quaternion of length 1")?;
        let pulls = self.motor.len() == cables
            && self.motor.iter().all(|tension| tension.is_finite() && *tension >= 0.0);
        expect(pulls, "motors' tensions", "one a cable, finite and 0 or greater (N)")?;
        let lengths = [seen.cable_length.len(), seen.measured_tension.len(), seen.slack.len()];
        expect(lengths == [cables; 3] && seen.infinite().is_none(), "outputs", "finite, one a cable")
    }

    /// The parameters it was started with.
    pub fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// The outputs after the last step.
    pub fn outputs(&self) -> &PlantOutputs {
        &self.outputs
    }

    /// What encoders and load cells see of the state.
    fn measure(&mut self) {
        let rotation = body::rotation(&self.state);
        let position = body::position(&self.state);
        let cables = self.parameters.rig.cables(&position, &rotation);
        let tension = platform_tension(self.parameters.friction, &self.motor, &cables, &self.state);
        let pose = Pose::from_parts(&position, &rotation);
        let resolution = self.parameters.encoder_resolution;
        let (encoder_pose, cable_length) = if resolution > 0.0 {
            let seen = cables.length.map(|l| (l / resolution).round() * resolution);
            // Lengths rounded so coarsely that they belong to no pose leave the last one standing.
            let found = forward_kinematics(&self.parameters.rig, &seen, &pose);
            (found.map_or(self.outputs.encoder_pose, |found| found.pose), seen)
        } else {
            (pose, cables.length)
        };
        self.outputs = PlantOutputs {
            encoder_pose,
            velocity: body::velocity(&self.state),
            angular_velocity: body::angular_velocity(&self.state),
            cable_length,
            measured_tension: tension.map(|u| u + self.load_cell_noise()),
            slack: tension.map(|u| u <= 0.0),
        };
    }

    fn load_cell_noise(&mut self) -> f64 {
        let deviation = self.parameters.load_cell_noise;
        if deviation == 0.0 {
            return 0.0;
        }
        // Box and Muller's; the logarithm's argument is above zero.
        let [share, turn]: [f64; 2] = [self.noise.random(), self.noise.random()];
        deviation * (-2.0 * libm::log1p(-share)).sqrt() * libm::cos(std::f64::consts::TAU * turn)
    }
}

fn greatest(tension: &PerCable<f64>) -> f64 {
    tension.iter().copied().fold(0.0, f64::max)
}

/// Cables cannot push: a negative command pulls with zero.
pub(super) fn pull_only(command: f64) -> f64 {
    command.max(0.0)
}

/// What motors with a first order lag pull `t` seconds after they pulled `start`, N.
fn lagged(start: &PerCable<f64>, command: &PerCable<f64>, lag: f64, t: f64) -> PerCable<f64> {
    if lag == 0.0 {
        return *command;
    }
    let left = libm::exp(-t / lag);
    PerCable::from_fn(start.len(), |i| command[i] + (start[i] - command[i]) * left)
}

/// What friction adds to a cable's tension while its length changes at this rate (m/s), N.
pub(super) fn held_back(friction: f64, rate: f64) -> f64 {
    friction * libm::tanh(rate / FRICTION_TURNOVER)
}

/// What the platform feels of the motors' pull after friction, N.
fn platform_tension(friction: f64, pull: &PerCable<f64>, cables: &Cables, state: &State) -> PerCable<f64> {
    if friction == 0.0 {
        return *pull;
    }
    let rates = cables.length_rates(&body::twist(state));
    PerCable::from_fn(pull.len(), |i| pull_only(pull[i] + held_back(friction, rates[i])))
}
