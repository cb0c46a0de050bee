//! The controller of an orbit: the law with a moving reference, and the stop that it carries for when a pose
//! makes no sense.

use super::{Orbit, OrbitError, Proof, Trajectory};
use crate::control::{Commands, Estimator, ForceLoop, Reference, Response, lyapunov};
use crate::plan::fault::{Fault, check_pose, jump, pose_of_lengths};
use crate::plan::planner::{Planner, Situation};
use crate::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, PoseSource, Status};
use crate::robot::{Coordinates, LEAST_CABLES, ParameterError, PerCable, Pose};

/// Leads the robot along a proved orbit, once. Heeds gains, limits, `pose_source`, `force_loop` and
/// `command_delay` of the parameters; there is no planner, no observer of disturbances, and the goal is not
/// read.
#[derive(Clone, Debug, PartialEq)]
pub struct Follower {
    planner: Planner,
    proof: Proof,
    /// What it follows: the orbit, after a fault with another stop.
    trajectory: Trajectory,
    mode: Mode,
    /// The longest time for which a command may be held, s.
    hold: f64,
    /// The smallest tension that it comes to, at least, N.
    predicted: f64,
    /// When the orbit began, and the time of the last step, s.
    begun: f64,
    time: f64,
    estimator: Estimator,
    commands: Commands,
    force_loop: ForceLoop,
    outputs: ControllerOutputs,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Following,
    /// A pose made no sense: a stop is made.
    Stopping,
    /// `enable` has fallen.
    Off,
}

impl Follower {
    /// Proves the orbit for commands held for `hold` (s) and begins it at `time` (s), from rest at the
    /// measured pose.
    ///
    /// # Errors
    /// [`OrbitError`], also where the measured pose is not that of the centre.
    pub fn new(
        orbit: &Orbit,
        parameters: &ControllerParameters,
        (time, hold): (f64, f64),
        inputs: &ControllerInputs,
    ) -> Result<Self, OrbitError> {
        let pose = inputs.encoder_pose;
        let error = pose.minus(&orbit.centre);
        check_start(parameters, &error)?;
        let proof = orbit.prove(parameters, &error, hold)?;
        let least = parameters.rig.least_tensions();
        // More than six cables are shared otherwise than in the proof, within the limits.
        let shown = if least.len() == LEAST_CABLES { proof.least - proof.kept } else { f64::NEG_INFINITY };
        let mut follower = Self {
            predicted: least.iter().copied().fold(f64::MAX, f64::min).max(shown),
            planner: Planner::from(*parameters),
            trajectory: proof.trajectory,
            proof,
            mode: if inputs.enable { Mode::Following } else { Mode::Off },
            hold,
            begun: time,
            time,
            estimator: Estimator::at_rest(pose),
            commands: Commands::none(),
            force_loop: ForceLoop::new(&parameters.rig),
            outputs: ControllerOutputs::at_rest(&orbit.centre, &least),
        };
        follower.act(inputs, 0.0, 0.0);
        Ok(follower)
    }

    /// The same, begun at 0 s where the robot is said to be.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn anew(&self, inputs: &ControllerInputs) -> Result<Self, OrbitError> {
        Self::new(&self.trajectory.orbit, &self.planner.parameters, (0.0, self.hold), inputs)
    }

    /// Whether a command may be held for `step` s.
    ///
    /// # Errors
    /// [`ParameterError`] with the longest that the orbit is proved for.
    pub fn check_step(&self, step: f64) -> Result<(), ParameterError> {
        // A sum of steps is rounded.
        if step <= self.hold * (1.0 + 1e-6) {
            return Ok(());
        }
        let allowed = format!("must be at most {:.3e} (s), with which the orbit is proved", self.hold);
        Err(ParameterError { name: "step".into(), value: step, allowed: allowed.into() })
    }

    /// The proof that it goes by.
    pub fn proof(&self) -> &Proof {
        &self.proof
    }

    /// The outputs of the last step.
    pub fn outputs(&self) -> &ControllerOutputs {
        &self.outputs
    }

    /// Reads `inputs` measured at `time` (s, not decreasing) and computes the outputs, which the motors then
    /// hold for `hold` (s).
    pub fn step(&mut self, time: f64, hold: f64, inputs: &ControllerInputs) {
        let dt = time - self.time;
        let acceleration = self.commands.mean(self.time, time);
        self.time = time;
        if !inputs.enable {
            self.mode = Mode::Off;
        }
        let measured = self.measured(inputs, dt);
        if let (Err(fault), Mode::Following) = (measured, self.mode) {
            self.lose(fault);
        }
        // What is not measured is predicted.
        let Estimator { pose, rates, .. } = &self.estimator;
        let predicted = Pose(pose.0 + rates * dt + acceleration * (0.5 * dt * dt));
        self.estimator.update(&measured.unwrap_or(predicted), &acceleration, dt, None);
        self.act(inputs, dt, hold);
    }

    /// The measured pose, if it makes sense.
    fn measured(&self, inputs: &ControllerInputs, dt: f64) -> Result<Pose, Fault> {
        let rig = &self.planner.parameters.rig;
        let pose = match self.planner.parameters.pose_source {
            PoseSource::EncoderPose => inputs.encoder_pose,
            PoseSource::CableLengths => pose_of_lengths(rig, &inputs.cable_length, &self.estimator, dt)?,
        };
        let pose = check_pose(rig, pose)?;
        jump(&pose, &self.estimator, dt, self.planner.size).map_or(Ok(pose), Err)
    }

    /// From now on the first proved stop is made that can be begun, on predicted poses until one makes sense
    /// again.
    fn lose(&mut self, fault: Fault) {
        self.mode = Mode::Stopping;
        self.outputs.fault = fault;
        self.trajectory = self.proof.stopped(self.acts() - self.begun);
    }

    /// When the command of this step begins to act, s.
    fn acts(&self) -> f64 {
        self.time + self.planner.parameters.command_delay
    }

    fn act(&mut self, inputs: &ControllerInputs, dt: f64, hold: f64) {
        self.outputs.motor_tension = match self.law(hold) {
            _ if self.mode == Mode::Off => self.planner.rig().least_tensions(),
            Some((tension, imposed)) => {
                self.commands.send(self.time, self.acts(), imposed);
                let is_measured = self.planner.parameters.force_loop;
                let corrected =
                    is_measured.then(|| self.force_loop.command(&tension, &inputs.measured_tension, dt));
                self.planner.rig().clamped(&corrected.unwrap_or(tension))
            }
            // The wrench matrix is singular, which it is nowhere near the motion.
            None => self.outputs.motor_tension,
        };
        self.report();
    }

    /// The tensions of the law (4) for the interval in which they act, within the limits, and the
    /// accelerations that they give.
    fn law(&self, hold: f64) -> Option<(PerCable<f64>, Coordinates)> {
        let (gains, rig) = (self.planner.parameters.gains(), &self.planner.parameters.rig);
        let Estimator { pose, rates, .. } = &self.estimator;
        let state = self.commands.carry((pose, rates), &Coordinates::zeros(), self.time, self.acts());
        let followed = self.followed(hold);
        let middle = Response::at(&gains, 0.5 * hold);
        let (pose, rates) = middle.carry(state, &self.reference(self.acts()), &followed);
        let margin = self.planner.allowance();
        let wanted = lyapunov::tension_command(rig, &gains, &pose, &rates, &followed, margin)?;
        let tension = rig.clamped(&wanted);
        let imposed = lyapunov::imposed(rig, &gains, (&pose, &rates), &followed, [&wanted, &tension]);
        Some((tension, imposed))
    }

    fn reference(&self, time: f64) -> Reference {
        self.trajectory.at(time - self.begun)
    }

    /// The reference in the middle of the interval in which a command acts, with the mean of its
    /// accelerations there.
    fn followed(&self, hold: f64) -> Reference {
        let begin = self.acts();
        Reference::held(|time| self.reference(time), begin + 0.5 * hold, begin, hold)
    }

    fn report(&mut self) {
        let Estimator { pose, rates, .. } = &self.estimator;
        let set_point = &self.outputs.set_point;
        let now = Situation { pose, rates, set_point, hold: 0.0, rest: self.planner.rest };
        let has_ended = self.time - self.begun >= self.trajectory.end();
        self.outputs.steady = self.mode == Mode::Following && has_ended && now.is_steady();
        self.outputs.at_goal = self.outputs.steady;
        self.outputs.reference = self.reference(self.acts());
        self.outputs.estimated_pose = self.estimator.pose;
        self.outputs.estimated_velocity = self.estimator.rates;
        self.outputs.estimated_mass = self.planner.parameters.rig.mass;
        self.outputs.tension_margin = if self.mode == Mode::Off {
            self.outputs.motor_tension.iter().copied().fold(f64::MAX, f64::min)
        } else {
            self.predicted
        };
        self.outputs.status = match self.mode {
            Mode::Off => Status::Disabled,
            Mode::Stopping => Status::SensorFault,
            Mode::Following if self.outputs.at_goal => Status::AtGoal,
            Mode::Following => Status::Moving,
        };
    }
}

/// An orbit begins in its centre.
fn check_start(parameters: &ControllerParameters, error: &Coordinates) -> Result<(), ParameterError> {
    let rest = parameters.rest();
    let [away, turned] = [0, 3].map(|k| error.fixed_rows::<3>(k).norm());
    let refused = |value: f64, most: f64, unit: &str| ParameterError {
        name: "encoderPose".into(),
        value,
        allowed: format!("the start must be within {most} {unit} of the orbit's centre").into(),
    };
    if away.is_nan() || away > rest.position {
        return Err(refused(away, rest.position, "m"));
    }
    if turned.is_nan() || turned > rest.angle {
        return Err(refused(turned, rest.angle, "rad"));
    }
    Ok(())
}
