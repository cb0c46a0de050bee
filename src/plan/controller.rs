//! Controller and planner in one: the flow of Fig. 4 around the law (4). Pose in, tensions out.

mod acting;
mod memory;
mod planning;
mod sensing;

use arrayvec::ArrayVec;
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use planning::Refused;

use super::aim::Search;
use super::interface::{ControllerInputs, ControllerOutputs, ControllerParameters, PlannerKind};
use super::minimum_time::Course;
use super::planner::{Planner, Situation};
use super::prediction::Prediction;
use super::status::Status;
use super::stop::Stop;
use super::through::MOST_WAY_POINTS;
use super::tuning::Tuning;
use crate::control::{Commands, DelayWatch, Estimator, ForceLoop, Reference};
use crate::robot::memory::are_finite;
use crate::robot::parameters::require;
use crate::robot::{Coordinates, ParameterError, PerCable, Pose, Rig};

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
    refused: Option<Refused>,
    /// What the next motion leads through.
    way_points: ArrayVec<Pose, MOST_WAY_POINTS>,
    /// The motion to the set point or, after a fault, to a stop; without one the set point rests.
    course: Option<Course>,
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
        let outputs = ControllerOutputs::at_rest(&inputs.encoder_pose, &planner.rig().least_tensions());
        let estimator = Estimator::at_rest(inputs.encoder_pose);
        let state = (&estimator.pose, &estimator.rates);
        let prediction = planning::prediction(&planner, state, &outputs.set_point, time, 0.0);
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
            course: None,
            refused: None,
            way_points: ArrayVec::new(),
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
            Mode::Disabled | Mode::Waiting(_) => {
                (self.course, self.refused) = (None, None);
                self.take_tuning(|_, _| true);
            }
            Mode::Faulted(_) => {}
        }
        self.act(inputs, dt);
    }

    /// The motion that the planner decides on next leads through these poses, without a stop where that is proved, else from one to the next. Those given before are
    /// forgotten.
    ///
    /// # Errors
    /// [`ParameterError`] with a planner other than `MinimumTime`, for more than [`MOST_WAY_POINTS`], and for the first coordinate of a pose at which no platform can be.
    pub fn pass_through(&mut self, way_points: &[Pose]) -> Result<(), ParameterError> {
        let (count, kind) = (way_points.len() as f64, self.planner.parameters.planner);
        let allowed = "no way points are taken but with the planner MinimumTime (3)";
        require(way_points.is_empty() || kind == PlannerKind::MinimumTime, "way points", count, allowed)?;
        let taken = ArrayVec::try_from(way_points);
        let allowed = "at most 7 way points are taken";
        require(taken.is_ok(), "way points", count, allowed)?;
        for (i, pose) in way_points.iter().enumerate() {
            let allowed = "must be finite, and below an anchor";
            let is_good = self.planner.rig().can_be_at(pose);
            require(is_good, format!("way point {}, z", i + 1), pose.0[2], allowed)?;
        }
        (self.way_points, self.refused) = (taken.unwrap_or_default(), None);
        Ok(())
    }

    /// Starts where the robot is, or waits there to be enabled.
    fn begin(&mut self, inputs: &ControllerInputs) {
        self.mode = Mode::Disabled;
        // A pose that cannot be leaves the one known before.
        if self.encoder_pose(inputs).is_ok() {
            self.estimator = Estimator::at_rest(inputs.encoder_pose);
        }
        self.outputs = ControllerOutputs::at_rest(&self.estimator.pose, &self.planner.rig().least_tensions());
        self.aim = inputs.goal_pose;
        self.start_here();
        self.sense(inputs, 0.0);
        self.act(inputs, 0.0);
    }

    /// The parameters it was started with.
    pub fn parameters(&self) -> &ControllerParameters {
        &self.planner.parameters
    }

    /// How much later than `commandDelay` commands act, s, once measurements have shown that; less than 0 if earlier.
    pub fn late(&self) -> Option<f64> {
        self.delay.late()
    }

    /// The outputs of the last step.
    pub fn outputs(&self) -> &ControllerOutputs {
        &self.outputs
    }

    /// What the estimated disturbance accelerates the coordinates by.
    fn disturbing(&self) -> Coordinates {
        match self.planner.parameters.observer() {
            Some(_) => self.estimator.disturbing(self.planner.rig()),
            None => Coordinates::zeros(),
        }
    }

    /// The measured pose becomes the set point, and the planner's clock starts.
    fn start_here(&mut self) {
        self.estimator.disturbance = Vector6::zeros();
        self.estimator.unexplained = self.estimator.rates;
        self.planner.parameters.rig.disturbance = Vector6::zeros();
        self.outputs.set_point = self.estimator.pose;
        self.course = None;
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

    /// What the law follows at a time, s.
    fn reference(&self, time: f64) -> Reference {
        match &self.course {
            Some(course) if time < course.end() => course.at(time),
            _ => Reference::resting(&self.outputs.set_point),
        }
    }

    fn is_steady(&self) -> bool {
        self.situation().is_steady() && !self.is_under_way()
    }

    /// Whether the law leads the robot on.
    fn is_under_way(&self) -> bool {
        self.course.as_ref().is_some_and(|course| self.time < course.end())
    }

    /// Tensions that may be commanded in the place of those that cannot: of numbers that overflow, or none.
    fn limited_or_least(&self, tension: Option<PerCable<f64>>) -> PerCable<f64> {
        let rig = self.planner.rig();
        rig.clamped(&tension.filter(are_numbers).unwrap_or(rig.least_tensions()))
    }

    fn report(&mut self, goal: &Pose) {
        // Once at rest, noise does not end it at once.
        let [of_pose, of_rates] = if self.outputs.steady { STILL_AT_REST } else { [1.0; 2] };
        let steady = self.mode == Mode::Active
            && self.situation().is_steady_within(of_pose, of_rates)
            && !self.is_under_way();
        let at_goal = steady && !self.unreachable && !self.planner.is_worth_it(&self.outputs.set_point, goal);
        self.outputs.estimated_pose = self.estimator.pose;
        self.outputs.estimated_velocity = self.estimator.rates;
        let begins = self.time + self.foreseen_delay();
        self.outputs.reference = match (self.mode, &self.course) {
            (Mode::Faulted(_), Some(course)) => course.at(begins),
            (Mode::Faulted(stop), None) => Reference::resting(&stop.at),
            _ => self.reference(begins),
        };
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

fn are_numbers(tension: &PerCable<f64>) -> bool {
    are_finite(tension)
}

/// The platform's mass if the disturbance is weight, kg.
fn estimated_mass(rig: &Rig) -> f64 {
    let gravity = rig.gravity.norm_squared();
    let force = rig.disturbance.fixed_rows::<3>(0);
    if gravity > 0.0 { rig.mass + force.dot(&rig.gravity) / gravity } else { rig.mass }
}
