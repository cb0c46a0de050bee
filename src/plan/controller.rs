//! Controller and planner in one: the flow of Fig. 4 around the law (4). Pose in, tensions out.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::aim::{Search, WORK};
use super::fault::{Check, Fault, check_pose, jump, pose_of_lengths};
use super::interface::{ControllerInputs, ControllerOutputs, ControllerParameters, PoseSource, Status};
use super::planner::{Planner, Situation};
use super::prediction::{Motion, Prediction};
use super::stop::Stop;
use super::tuning::{Pending, Tuning};
use crate::control::estimator::SETTLING;
use crate::control::{Commands, DelayWatch, Estimator, ForceLoop, Response, lyapunov, static_tensions};
use crate::robot::{Coordinates, ParameterError, PerCable, Pose, Rig, dynamics};

/// `steady` ends when the tolerances of rest are exceeded this many times over, those of the pose and those of the rates: what encoders jump by
/// makes the estimated rates jump by 37/s of it.
const STILL_AT_REST: [f64; 2] = [5.0, 10.0];

/// A start counts as one in motion beyond the tolerances of rest this many times over.
const IN_MOTION: f64 = 15.0;

/// Poses that are zero in all six coordinates, from the first step on, which are taken for poses that were never set. Connected models hand on a pose
/// a step late each; where the origin is the robot's place, it starts so many steps later.
const UNSET_POSES: u8 = 5;

/// Controller and planner with all their memory: plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Controller {
    planner: Planner,
    mode: Mode,
    /// Whether no step was made yet.
    is_fresh: bool,
    /// How many more poses of zeros are taken for poses that were never set.
    unset: u8,
    /// Time of the last step, s.
    time: f64,
    /// For how long the command of the last step is held, and that of the one before, s.
    hold: [f64; 2],
    /// When the planner was started, s, and how often it was asked since.
    started: f64,
    ticks: u64,
    estimator: Estimator,
    /// What the law imposes, and from when on; and what it imposed on average in the step just past.
    commands: Commands,
    acceleration: Coordinates,
    delay: DelayWatch,
    force_loop: ForceLoop,
    prediction: Prediction,
    unreachable: bool,
    /// Where the planner makes for, and the goal for which that was found.
    aim: Pose,
    aimed_for: Option<Pose>,
    /// The search for where to make for instead of a new goal.
    search: Option<Search>,
    /// What was tuned and does not act yet.
    wanted: Option<Tuning>,
    outputs: ControllerOutputs,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Mode {
    Disabled,
    Active,
    /// No pose made sense since the start: with the tensions held until one does.
    Waiting(PerCable<f64>),
    /// Comes to rest, and holds gravity there, until `enable` falls.
    Faulted(Stop),
}

impl Controller {
    /// Starts at `time` (s) at the measured pose of `inputs`; its outputs are valid at once and hold the robot there.
    ///
    /// With `poseSource` CableLengths, `encoderPose` tells near which pose the lengths are to be understood at the start.
    ///
    /// # Errors
    /// [`ParameterError`] for a parameter that makes no sense.
    pub fn new(
        parameters: ControllerParameters,
        time: f64,
        inputs: &ControllerInputs,
    ) -> Result<Self, ParameterError> {
        parameters.validate()?;
        parameters.check_start(&inputs.encoder_pose)?;
        let planner = Planner::from(parameters);
        let outputs = ControllerOutputs::at_rest(&inputs.encoder_pose, &least(&planner));
        let estimator = Estimator::at_rest(inputs.encoder_pose);
        let state = (&estimator.pose, &estimator.rates);
        let prediction = prediction(&planner, state, &outputs.set_point, time, 0.0);
        let mut controller = Self {
            planner,
            mode: Mode::Disabled,
            is_fresh: true,
            unset: UNSET_POSES,
            time,
            hold: [0.0; 2],
            started: time,
            ticks: 0,
            estimator,
            commands: Commands::none(),
            acceleration: Coordinates::zeros(),
            delay: DelayWatch::new(),
            force_loop: ForceLoop::new(&parameters.rig),
            prediction,
            unreachable: false,
            aim: inputs.goal_pose,
            aimed_for: None,
            search: None,
            wanted: None,
            outputs,
        };
        controller.begin(inputs);
        Ok(controller)
    }

    /// Reads `inputs` measured at `time` (s, not decreasing) and computes the outputs, which the motors then hold for `hold` (s): the planner
    /// reckons with it.
    pub fn step(&mut self, time: f64, hold: f64, inputs: &ControllerInputs) {
        if self.is_fresh && time == self.time {
            // The inputs of the first step are those of the start: what was known before may have been a start value only.
            self.begin(inputs);
        }
        let dt = time - self.time;
        self.acceleration = self.commands.mean(self.time, time) + self.disturbing();
        self.time = time;
        self.hold = [hold, self.hold[0]];
        self.sense(inputs, dt);
        self.is_fresh = false;
        self.unset =
            if inputs.encoder_pose.0 == Coordinates::zeros() { self.unset.saturating_sub(1) } else { 0 };
        match self.mode {
            Mode::Active => self.plan(&inputs.goal_pose),
            Mode::Disabled | Mode::Waiting(_) => self.take_tuning(|_, _| true),
            Mode::Faulted(_) => {}
        }
        self.act(inputs, dt);
    }

    /// Starts where the robot is, or waits there to be enabled.
    fn begin(&mut self, inputs: &ControllerInputs) {
        self.mode = Mode::Disabled;
        // A pose that cannot be leaves the one known before.
        if self.encoder_pose(inputs).is_ok() {
            self.estimator = Estimator::at_rest(inputs.encoder_pose);
        }
        self.outputs = ControllerOutputs::at_rest(&self.estimator.pose, &least(&self.planner));
        self.aim = inputs.goal_pose;
        self.start_here();
        self.sense(inputs, 0.0);
        self.act(inputs, 0.0);
    }

    /// The parameters it was started with.
    pub fn parameters(&self) -> &ControllerParameters {
        &self.planner.parameters
    }

    /// What may change while it runs, as it was tuned last.
    pub fn tuning(&self) -> Tuning {
        self.wanted.unwrap_or_else(|| self.planner.parameters.tuning())
    }

    /// Changes gains, limits and tolerances: with the next step while no motion is planned, else at the first decision of the planner at which the motion under way
    /// is proved to go on with them ([`Pending`]). Until then it goes on as before.
    ///
    /// # Errors
    /// [`ParameterError`] for what makes no sense; then all stays as it was.
    pub fn tune(&mut self, tuning: &Tuning) -> Result<(), ParameterError> {
        let tuned = self.planner.tuned(tuning).parameters;
        tuned.rig.validate_limits()?;
        tuned.check_settings()?;
        self.wanted = (*tuning != self.planner.parameters.tuning()).then_some(*tuning);
        self.outputs.pending = if self.wanted.is_some() { Pending::Undecided } else { Pending::No };
        Ok(())
    }

    /// Takes over what was tuned, if the planner with it `can_go_on`.
    fn take_tuning(&mut self, can_go_on: impl FnOnce(&Planner, &Situation) -> bool) {
        let Some(tuning) = self.wanted else { return };
        let planner = self.planner.tuned(&tuning);
        let (pose, rates) = self.when_it_begins_to_act();
        let then = Situation { pose: &pose, rates: &rates, rest: planner.rest, ..self.situation() };
        if can_go_on(&planner, &then) {
            self.planner = planner;
            // Where it made for followed from the limits before.
            (self.wanted, self.search, self.aimed_for) = (None, None, None);
            self.outputs.pending = Pending::No;
        } else {
            self.outputs.pending = Pending::NotProved;
        }
    }

    /// How much later than `commandDelay` commands act, s, once measurements have shown that; less than 0 if earlier.
    pub fn late(&self) -> Option<f64> {
        self.delay.late()
    }

    /// The outputs of the last step.
    pub fn outputs(&self) -> &ControllerOutputs {
        &self.outputs
    }

    /// Takes in the measured pose and the operator's `enable`, and settles the mode.
    fn sense(&mut self, inputs: &ControllerInputs, dt: f64) {
        let measured = self.measured_pose(inputs, dt);
        let jump = measured.ok().and_then(|pose| jump(&pose, &self.estimator, dt, self.planner.size));
        let was = self.mode;
        self.mode = match (inputs.enable, was, measured, jump) {
            (false, ..) => Mode::Disabled,
            (true, Mode::Faulted(stop), ..) => Mode::Faulted(stop),
            (true, Mode::Active, Ok(_), Some(fault)) | (true, Mode::Active, Err(fault), _) => {
                self.fault(fault, self.time - dt)
            }
            (true, _, Err(fault), _) if self.is_fresh || matches!(was, Mode::Waiting(_)) => {
                Mode::Waiting(self.hold_still(fault))
            }
            (true, _, Err(fault), _) => self.fault(fault, self.time - dt),
            (true, _, Ok(_), _) => Mode::Active,
        };
        match (measured, jump) {
            (Ok(pose), Some(_)) => self.estimator = Estimator::at_rest(pose),
            // The pose before was not measured.
            (Ok(pose), None) if matches!(was, Mode::Waiting(_)) => self.estimator = Estimator::at_rest(pose),
            (Ok(pose), None) => self.estimate(&pose, dt, was),
            (Err(_), _) => {}
        }
        if self.mode == Mode::Active && was != Mode::Active {
            self.start_here();
        }
        if self.mode == Mode::Active && self.has_started_in_motion() {
            self.outputs.set_point = self.planner.stop(&self.situation());
            self.predict();
        }
        if matches!(self.mode, Mode::Active | Mode::Disabled) {
            self.outputs.fault = Fault::NONE;
        }
    }

    /// Takes in a measured pose. What disturbs is estimated only while it is known what the cables do.
    fn estimate(&mut self, measured: &Pose, dt: f64, was: Mode) {
        let is_known = was == Mode::Active && self.mode == Mode::Active;
        let observer = self.planner.parameters.observer().filter(|_| is_known);
        let observer = observer.as_ref().map(|observer| (self.planner.rig(), observer));
        let expected = self.estimator.rates + self.acceleration * dt;
        self.estimator.update(measured, &self.acceleration, dt, observer);
        if is_known && dt > 0.0 {
            let correction = (self.estimator.rates - expected) / dt;
            self.delay.update(&self.acceleration, &correction, dt, self.planner.rig().platform_radius());
        }
        self.planner.parameters.rig.disturbance = self.estimator.disturbance;
    }

    /// What the estimated disturbance accelerates the coordinates by.
    fn disturbing(&self) -> Coordinates {
        match self.planner.parameters.observer() {
            Some(_) => self.estimator.disturbing(self.planner.rig()),
            None => Coordinates::zeros(),
        }
    }

    /// The pose measured, if it makes sense.
    fn measured_pose(&self, inputs: &ControllerInputs, dt: f64) -> Result<Pose, Fault> {
        let rig = self.planner.rig();
        match self.planner.parameters.pose_source {
            PoseSource::EncoderPose => self.encoder_pose(inputs),
            PoseSource::CableLengths => pose_of_lengths(rig, &inputs.cable_length, &self.estimator, dt)
                .and_then(|pose| check_pose(rig, pose)),
        }
    }

    fn encoder_pose(&self, inputs: &ControllerInputs) -> Result<Pose, Fault> {
        let pose = inputs.encoder_pose;
        if self.unset > 0 && pose.0 == Coordinates::zeros() {
            return Err(Fault::new(Check::NotSet, 0.0, 0.0, &pose));
        }
        check_pose(self.planner.rig(), pose)
    }

    /// From now on the robot brakes from the last good state, known at `since` (s), and gravity is held where that ends.
    fn fault(&mut self, fault: Fault, since: f64) -> Mode {
        self.outputs.fault = fault;
        let Estimator { pose, rates, .. } = self.estimator;
        Mode::Faulted(Stop { pose, rates, since, at: self.planner.stop(&self.situation()) })
    }

    /// Takes note of a fault, and gives the tensions that hold gravity at the last good pose.
    fn hold_still(&mut self, fault: Fault) -> PerCable<f64> {
        self.outputs.fault = fault;
        let held = static_tensions(self.planner.rig(), &self.estimator.pose, self.planner.allowance());
        self.limited(held.unwrap_or(least(&self.planner)))
    }

    /// Whether it turns out that the robot did not rest at the start. The planner's first set point presumed that it did.
    fn has_started_in_motion(&self) -> bool {
        let (unexplained, rest) = (&self.estimator.unexplained, &self.planner.rest);
        self.time - self.started <= SETTLING
            && (unexplained.fixed_rows::<3>(0).norm() > IN_MOTION * rest.position
                || unexplained.fixed_rows::<3>(3).amax() > IN_MOTION * rest.angle)
    }

    /// The measured pose becomes the set point, and the planner's clock starts.
    fn start_here(&mut self) {
        self.estimator.disturbance = Vector6::zeros();
        self.estimator.unexplained = self.estimator.rates;
        self.planner.parameters.rig.disturbance = Vector6::zeros();
        self.outputs.set_point = self.estimator.pose;
        self.outputs.set_point_index = 0;
        self.started = self.time;
        self.ticks = 0;
        self.unreachable = false;
        self.aim = self.estimator.pose;
        self.aimed_for = None;
        self.outputs.goal_distance = 0.0;
        self.search = None;
        self.delay = DelayWatch::new();
        self.force_loop = ForceLoop::new(self.planner.rig());
        self.commands = Commands::none();
        self.acceleration = Coordinates::zeros();
        self.predict();
    }

    /// Fig. 4: every T_s the next set point, if there is one; a new goal is taken up at the next of these ticks.
    fn plan(&mut self, goal: &Pose) {
        if let Some(search) = &mut self.search {
            self.planner.advance(search, WORK);
        }
        let period = self.planner.parameters.planner_period;
        let elapsed = (self.time - self.started) / period;
        // A tick is not missed for the rounding of communication points.
        if elapsed < self.ticks as f64 - 1e-6 {
            return;
        }
        self.ticks = ((elapsed + 1e-6).floor() as u64).saturating_add(1);
        self.take_tuning(Planner::can_go_on);
        let set_point = self.outputs.set_point;
        let goal = &self.take_goal(goal);
        // A new set point changes the motion only from where its first command acts.
        let (pose, rates) = self.when_it_begins_to_act();
        let then = Situation { pose: &pose, rates: &rates, ..self.situation() };
        let next = self.planner.next_set_point(&then, &self.aim);
        let stuck = self.is_steady()
            && next.is_none()
            && set_point != self.aim
            && !self.planner.waits(&self.situation(), &self.aim);
        self.unreachable = stuck || self.aim != *goal || !self.planner.is_reachable(&set_point, goal);
        let instead = if stuck { set_point } else { self.aim };
        self.outputs.goal_distance =
            if self.unreachable { self.planner.distance(&instead, goal) } else { 0.0 };
        if let Some(next) = next {
            self.outputs.set_point = next;
            self.outputs.set_point_index += 1;
            self.outputs.steady = false;
        }
        self.predict();
    }

    /// The goal, or the one before if it differs by so little that no step is worth it. The search for where the planner makes for takes a
    /// few steps, in which the robot goes on as before.
    fn take_goal(&mut self, goal: &Pose) -> Pose {
        let known = self.search.map(|search| search.goal).or(self.aimed_for);
        let goal = known.filter(|known| !self.planner.is_worth_it(known, goal)).unwrap_or(*goal);
        if known != Some(goal) {
            let mut search = self.planner.search(&self.outputs.set_point, &goal);
            self.planner.advance(&mut search, WORK);
            self.search = Some(search);
        }
        match self.search {
            Some(search) if search.has_ended() => {
                (self.aim, self.aimed_for, self.search) = (search.at, Some(goal), None);
                goal
            }
            // Until it has ended, the goal before stands.
            Some(_) => self.aimed_for.unwrap_or(self.aim),
            None => goal,
        }
    }

    fn situation(&self) -> Situation<'_> {
        let Estimator { pose, rates, .. } = &self.estimator;
        Situation {
            pose,
            rates,
            set_point: &self.outputs.set_point,
            // A step that is shorter than the others tells nothing of those to come.
            hold: self.hold[0].max(self.hold[1]).max(self.planner.parameters.largest_step),
            rest: self.planner.rest,
        }
    }

    fn is_steady(&self) -> bool {
        self.situation().is_steady()
    }

    fn predict(&mut self) {
        let (pose, rates) = self.when_it_begins_to_act();
        let begins = self.time + self.foreseen_delay();
        let hold = self.situation().hold;
        self.prediction = prediction(&self.planner, (&pose, &rates), &self.outputs.set_point, begins, hold);
    }

    /// The law (4), or what stands for it when the controller may not or cannot act.
    fn act(&mut self, inputs: &ControllerInputs, dt: f64) {
        if self.mode == Mode::Active {
            let state = self.when_it_acts();
            match self.law(&state) {
                Some(tension) => self.pull(&tension, &state, inputs, dt),
                None => {
                    let fault = Fault::new(Check::Singular, 0.0, 0.0, &{ self.estimator.pose });
                    self.mode = self.fault(fault, self.time);
                }
            }
        }
        match self.mode {
            Mode::Active => {}
            Mode::Disabled => self.outputs.motor_tension = least(&self.planner),
            Mode::Waiting(held) => self.outputs.motor_tension = held,
            Mode::Faulted(stop) => self.outputs.motor_tension = self.braking(&stop),
        }
        self.report(&inputs.goal_pose);
    }

    /// The tensions of a stop in the middle of the interval in which they act.
    fn braking(&self, stop: &Stop) -> PerCable<f64> {
        let parameters = &self.planner.parameters;
        let middle = self.time + parameters.command_delay + 0.5 * self.hold[0];
        let tension = self.planner.tensions_of(stop, middle);
        self.limited(tension.unwrap_or(least(&self.planner)))
    }

    fn law(&self, (pose, rates): &(Pose, Coordinates)) -> Option<PerCable<f64>> {
        let gains = self.planner.parameters.gains();
        let margin = self.planner.allowance();
        lyapunov::tension_command(self.planner.rig(), &gains, pose, rates, &self.outputs.set_point, margin)
    }

    /// Pose and rates when the command of this step begins to act: with `holdCompensation` the estimate carried through the commands that are on
    /// their way, else the estimate.
    fn when_it_begins_to_act(&self) -> (Pose, Coordinates) {
        let Estimator { pose, rates, .. } = self.estimator;
        if !self.planner.parameters.hold_compensation {
            return (pose, rates);
        }
        let acts = self.time + self.foreseen_delay();
        self.commands.carry((&pose, &rates), &self.disturbing(), self.time, acts)
    }

    /// Pose and rates for which the command of this step is computed: with `holdCompensation` what the closed form makes of those when it begins
    /// to act in the middle of the interval in which it does.
    fn when_it_acts(&self) -> (Pose, Coordinates) {
        let (pose, rates) = self.when_it_begins_to_act();
        let parameters = &self.planner.parameters;
        if !parameters.hold_compensation {
            return (pose, rates);
        }
        let middle = Response::at(&parameters.gains(), 0.5 * self.hold[0]);
        let (pose, rates, _) = middle.motion_of(&pose, &rates, &self.outputs.set_point);
        (pose, rates)
    }

    fn pull(
        &mut self,
        tension: &PerCable<f64>,
        state: &(Pose, Coordinates),
        inputs: &ControllerInputs,
        dt: f64,
    ) {
        let desired = self.limited(*tension);
        let command = if self.planner.parameters.force_loop {
            self.force_loop.command(&desired, &inputs.measured_tension, dt)
        } else {
            desired
        };
        self.outputs.motor_tension = self.limited(command);
        let imposed = self.imposed(state, &desired, desired != *tension) - self.disturbing();
        self.commands.send(self.time, self.time + self.foreseen_delay(), imposed);
    }

    /// How much later than its measurement a command is reckoned to act, s.
    fn foreseen_delay(&self) -> f64 {
        let parameters = &self.planner.parameters;
        if parameters.hold_compensation { parameters.command_delay } else { 0.0 }
    }

    /// The accelerations of the coordinates that the command gives: those of the law, unless the limits have `clipped` its tensions.
    fn imposed(
        &self,
        (pose, rates): &(Pose, Coordinates),
        pulled: &PerCable<f64>,
        is_clipped: bool,
    ) -> Coordinates {
        if is_clipped {
            return dynamics::accelerations(self.planner.rig(), pose, rates, pulled);
        }
        lyapunov::acceleration(&self.planner.parameters.gains(), pose, rates, &self.outputs.set_point)
    }

    fn limited(&self, tension: PerCable<f64>) -> PerCable<f64> {
        let rig = self.planner.rig();
        PerCable::from_fn(tension.len(), |i| {
            let limits = rig.cables[i].limits;
            tension[i].clamp(limits.min, limits.max)
        })
    }

    fn report(&mut self, goal: &Pose) {
        // Once at rest, noise does not end it at once.
        let [of_pose, of_rates] = if self.outputs.steady { STILL_AT_REST } else { [1.0; 2] };
        let steady = self.mode == Mode::Active && self.situation().is_steady_within(of_pose, of_rates);
        let at_goal = steady && !self.unreachable && !self.planner.is_worth_it(&self.outputs.set_point, goal);
        self.outputs.estimated_pose = self.estimator.pose;
        self.outputs.estimated_velocity = self.estimator.rates;
        self.outputs.disturbance = self.estimator.disturbance;
        self.outputs.estimated_mass = estimated_mass(self.planner.rig());
        self.outputs.steady = steady;
        self.outputs.at_goal = at_goal;
        self.outputs.status = match self.mode {
            Mode::Disabled => Status::Disabled,
            Mode::Faulted(_) => Status::SensorFault,
            Mode::Waiting(_) => Status::WaitingForPose,
            Mode::Active if self.unreachable => Status::GoalUnreachable,
            Mode::Active if at_goal => Status::AtGoal,
            Mode::Active if steady => Status::Holding,
            Mode::Active => Status::Moving,
        };
        self.outputs.tension_margin = match self.mode {
            Mode::Active => self.prediction.smallest_from(self.time),
            Mode::Disabled | Mode::Waiting(_) | Mode::Faulted(_) => {
                self.outputs.motor_tension.iter().copied().fold(f64::MAX, f64::min)
            }
        };
    }
}

/// The platform's mass if the disturbance is weight, kg.
fn estimated_mass(rig: &Rig) -> f64 {
    let gravity = rig.gravity.norm_squared();
    let force = rig.disturbance.fixed_rows::<3>(0);
    if gravity > 0.0 { rig.mass + force.dot(&rig.gravity) / gravity } else { rig.mass }
}

/// The least tension of each cable, N.
fn least(planner: &Planner) -> PerCable<f64> {
    planner.rig().limits().map(|limits| limits.min)
}

fn prediction(
    planner: &Planner,
    state: (&Pose, &Coordinates),
    set_point: &Pose,
    time: f64,
    hold: f64,
) -> Prediction {
    let motion = Motion { pose: state.0, rates: state.1, set_point, gains: planner.parameters.gains() };
    Prediction::new(planner.rig(), &motion, time, planner.allowance(), planner.share_of_holding(hold))
}
