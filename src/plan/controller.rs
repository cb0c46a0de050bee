//! Controller and planner in one: the flow of Fig. 4 around the law (4). Pose in, tensions out.

use serde::{Deserialize, Serialize};

use crate::robot::parameters::require;
use crate::robot::{Coordinates, ParameterError, PerCable, Pose, RobotParameters};

/// How the next set point is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlannerKind {
    /// The paper's reachable domain, Eq. (15).
    Bounded,
}

/// Where the measured pose comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PoseSource {
    /// The input `encoderPose`.
    EncoderPose,
    /// Forward kinematics of the input `cableLength`.
    CableLengths,
}

/// What the controller is doing. The numbers are the FMU's enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// `enable` is false: every motor gets `minTension`.
    Disabled = 1,
    /// At rest short of the goal, waiting for the next planner tick.
    Holding = 2,
    /// On the way to the active set point.
    Moving = 3,
    /// At rest at the goal.
    AtGoal = 4,
    /// The goal cannot be had with the planner in use; the robot goes as far as is admissible and holds there.
    GoalUnreachable = 5,
    /// The measured pose made no sense; gravity is held at the last good pose until `enable` falls and rises again.
    SensorFault = 6,
}

/// Parameters of the controller; the defaults are Tables I and II.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerParameters {
    /// The robot under control.
    pub robot: RobotParameters,
    /// λ₀ of Eq. (2), 1/s.
    pub lambda: f64,
    /// η₀ of Eq. (4), 1/s.
    pub eta: f64,
    /// T_s, seconds between two decisions of the planner.
    pub planner_period: f64,
    /// N of the bisection after Eq. (17).
    pub bisection_steps: i32,
    /// Least tension commanded, N.
    pub min_tension: f64,
    /// Greatest tension commanded, N.
    pub max_tension: f64,
    /// Which reachable domain the planner uses.
    pub planner: PlannerKind,
    /// Which input is the measured pose.
    pub pose_source: PoseSource,
    /// Whether the load cells correct the motors (Section VII).
    pub force_loop: bool,
}

impl Default for ControllerParameters {
    fn default() -> Self {
        Self {
            robot: RobotParameters::default(),
            lambda: 3.0,
            eta: 3.0,
            planner_period: 0.05,
            bisection_steps: 8,
            min_tension: 0.0,
            max_tension: 100.0,
            planner: PlannerKind::Bounded,
            pose_source: PoseSource::EncoderPose,
            force_loop: false,
        }
    }
}

/// What the controller reads in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerInputs {
    /// Measured pose.
    pub encoder_pose: Pose,
    /// Measured cable lengths, m; read if `pose_source` is `CableLengths`.
    pub cable_length: PerCable<f64>,
    /// Load cells, N; read if `force_loop`.
    pub measured_tension: PerCable<f64>,
    /// x_f, may change at any time.
    pub goal_pose: Pose,
    /// Whether the controller may pull.
    pub enable: bool,
}

/// What the controller answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerOutputs {
    /// What the motors shall pull, N.
    pub motor_tension: PerCable<f64>,
    /// The active x_d^i.
    pub set_point: Pose,
    /// i, counted from 0 (the pose at which the controller was enabled).
    pub set_point_index: i32,
    /// Estimate of the pose at the time of the step's inputs.
    pub estimated_pose: Pose,
    /// Estimate of the rates of the six coordinates, m/s and rad/s.
    pub estimated_velocity: Coordinates,
    /// At rest at the active set point.
    pub steady: bool,
    /// At rest at the goal.
    pub at_goal: bool,
    /// Smallest tension of any cable predicted from now on, N.
    pub tension_margin: f64,
    /// What the controller is doing.
    pub status: Status,
}

/// Controller and planner with all their memory: plain data, no heap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Controller {
    outputs: ControllerOutputs,
}

impl ControllerParameters {
    /// Names the first parameter that makes no sense.
    ///
    /// # Errors
    /// [`ParameterError`] with the parameter's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let positive = |name, value: f64| {
            require(value.is_finite() && value > 0.0, name, value, "must be finite and greater than 0")
        };
        self.robot.validate()?;
        positive("lambda", self.lambda)
    }
}

impl Controller {
    /// Starts at `time` at the measured pose of `inputs`; its outputs are valid at once.
    ///
    /// # Errors
    /// [`ParameterError`] for a parameter that makes no sense.
    pub fn new(parameters: ControllerParameters, time: f64, inputs: &ControllerInputs) -> Result<Self, ParameterError> {
        let _ = (parameters, time, inputs);
        todo!()
    }

    /// Reads `inputs` measured at `time` (s, not decreasing) and computes the outputs to hold until the next step.
    pub fn step(&mut self, time: f64, inputs: &ControllerInputs) {
        let _ = (time, inputs);
        todo!()
    }

    /// The outputs of the last step.
    pub fn outputs(&self) -> &ControllerOutputs {
        &self.outputs
    }
}
