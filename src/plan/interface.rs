//! What goes into the controller and what comes out: parameters, inputs, outputs.

use nalgebra::Vector6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fault::Fault;
use super::status::Status;
use super::tuning::Pending;
use crate::control::{DisturbanceObserver, Gains, Reference};
use crate::robot::parameters::require;
use crate::robot::{Coordinates, ParameterError, PerCable, Pose, Rig, RobotParameters, Shape, TensionLimits};

/// How the next set point is found. The numbers are the FMU's enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PlannerKind {
    /// The paper's reachable domain, Eq. (15): steps in x and y from rest.
    Bounded = 1,
    /// Every step that the certificate proves, in all six coordinates and from any state: a set point at every tick.
    Exact = 2,
    /// The fastest motion along the straight way, in all six coordinates.
    MinimumTime = 3,
}

impl PlannerKind {
    /// All there are, in the order of their numbers. The first is of the paper's rig only, the others of any.
    pub const ALL: [Self; 3] = [Self::Bounded, Self::Exact, Self::MinimumTime];

    /// Its name, and what it is, for people.
    pub const fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Bounded => ("Bounded", "The paper's domain, Eq. (15): steps in x and y from rest"),
            Self::Exact => (
                "Exact",
                "Every step that is proved to keep the tensions within their limits, from any state: a set point at every tick",
            ),
            Self::MinimumTime => (
                "MinimumTime",
                "The fastest motion along the straight way that keeps every tension within its limits",
            ),
        }
    }

    /// The [`PlannerKind::key`] of each.
    pub const KEYS: [&'static str; Self::ALL.len()] = {
        let mut keys = [""; Self::ALL.len()];
        let mut k = 0;
        while k < keys.len() {
            keys[k] = Self::ALL[k].key();
            k += 1;
        }
        keys
    };

    /// The one with this number.
    pub fn numbered(number: i32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as i32 == number)
    }

    /// Its name in files and on the command line.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Bounded => "bounded",
            Self::Exact => "exact",
            Self::MinimumTime => "minimum-time",
        }
    }

    /// The one with this [`PlannerKind::key`].
    pub fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.key() == key)
    }
}

/// Where the measured pose comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PoseSource {
    /// The input `encoderPose`.
    EncoderPose,
    /// Forward kinematics of the input `cableLength`.
    CableLengths,
}

/// What the longest step follows from.
pub const OF_LONGEST_STEP: &str = "with the planner Exact (lambda + eta) times step and commandDelay together is at most 1, and no step longer than largestStep";

/// Most cables of a rig for `MinimumTime`: 252 fives; of sixteen there are 4,368, a second of work in one step.
const MOST_CABLES: usize = 10;

/// Largest gain that makes sense, 1/s.
const MAX_GAIN: f64 = 1000.0;

/// Parameters of the controller; the defaults are Tables I and II.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ControllerParameters {
    /// The rig under control.
    pub rig: Rig,
    /// λ₀ of Eq. (2), 1/s.
    pub lambda: f64,
    /// η₀ of Eq. (4), 1/s.
    pub eta: f64,
    /// T_s, seconds between two decisions of the planner.
    pub planner_period: f64,
    /// N of the bisection after Eq. (17).
    pub bisection_steps: i32,
    /// Which reachable domain the planner uses.
    pub planner: PlannerKind,
    /// Which input is the measured pose.
    pub pose_source: PoseSource,
    /// Whether the load cells correct the motors (Section VII).
    pub force_loop: bool,
    /// Distance from a pose, m, and speed, m/s, up to which the robot counts as at rest there; 0 follows the rig's size.
    pub position_tolerance: f64,
    /// The same for each angle, rad and rad/s; 0 for the default.
    pub angle_tolerance: f64,
    /// Whether the law is evaluated for the interval in which the command will act, not for the instant of the measurement.
    #[serde(default = "hold_compensation")]
    pub hold_compensation: bool,
    /// From a measurement to the moment at which its command acts, s; 0 if the controller is stepped before the plant. Used with
    /// `hold_compensation`.
    #[serde(default)]
    pub command_delay: f64,
    /// Largest constant force on the platform that is estimated and made up for, as a share of the weight; the largest torque is that force
    /// at the platform's radius. 0 switches the observer off; `Bounded`, which is the paper's, has none.
    #[serde(default = "observer_bound")]
    pub observer_bound: f64,
    /// By which share the platform's mass may differ from the rig's.
    #[serde(default)]
    pub mass_tolerance: f64,
    /// Smallest change of a cable's length that the encoders see, m.
    #[serde(default)]
    pub encoder_resolution: f64,
    /// Largest force on the platform that is not known, N; the largest torque is that force at the platform's radius. Friction counts as one.
    #[serde(default)]
    pub disturbance_bound: f64,
    /// Greatest speed of the platform's centre of mass on the way to any set point, m/s; 0 for no limit.
    #[serde(default)]
    pub max_speed: f64,
    /// Greatest angular velocity of the platform, rad/s; 0 for no limit.
    #[serde(default)]
    pub max_angular_rate: f64,
    /// Greatest speed of a cable, m/s; 0 for no limit.
    #[serde(default)]
    pub max_cable_speed: f64,
    /// Greatest rate of a cable's commanded tension on the way, N/s; 0 for no limit. `MinimumTime` alone heeds it: a step of the other planners is a jump of the tensions.
    #[serde(default)]
    pub max_tension_rate: f64,
    /// By how much, m, the platform may rise above the straight way to be quicker; 0: not at all. `MinimumTime` alone heeds it.
    #[serde(default)]
    pub lift: f64,
    /// Longest time for which a command may be held, s; 0: as long as the longer of the last two was.
    #[serde(default)]
    pub largest_step: f64,
}

fn hold_compensation() -> bool {
    true
}

/// A tenth of the weight.
fn observer_bound() -> f64 {
    0.1
}

/// How fast an error of the estimated disturbance decays, 1/s: slower than the observer of pose and velocity.
const DISTURBANCE_POLE: f64 = 10.0;
/// The same beside a force loop, which makes up for friction at 20 1/s: friction that changes its sign must not set the two against each
/// other.
const POLE_BESIDE_FORCE_LOOP: f64 = 2.0;

/// What counts as at rest at a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// m, and m/s.
    pub position: f64,
    /// Of each angle: rad, and rad/s.
    pub angle: f64,
}

/// What counts as rest for the paper's rig, m and rad. The first grows with the rig,
const REST_POSITION: f64 = 2e-3;
const REST_ANGLE: f64 = 1e-2;
/// but not beyond this, m.
const WIDEST_REST: f64 = 1e-2;

impl ControllerParameters {
    /// The parameters of Table II for a rig. The planner is `Exact` where the rig is not the paper's, or not known exactly.
    pub fn of(rig: &Rig) -> Self {
        let is_paper = Shape::of(rig).is_ok() && rig.accuracy == 0.0;
        let planner = if is_paper { PlannerKind::Bounded } else { PlannerKind::Exact };
        Self { rig: *rig, planner, ..Self::default() }
    }

    /// What counts as at rest.
    pub fn rest(&self) -> Rest {
        let or = |given: f64, default: f64| if given > 0.0 { given } else { default };
        let position = (REST_POSITION * size(&self.rig)).min(WIDEST_REST);
        Rest { position: or(self.position_tolerance, position), angle: or(self.angle_tolerance, REST_ANGLE) }
    }
}

/// The rig's radius in units of that of the paper's.
pub(super) fn size(rig: &Rig) -> f64 {
    let paper = Rig::paper(&RobotParameters::default(), TensionLimits::default());
    rig.radius() / paper.radius()
}

impl Default for ControllerParameters {
    /// Tables I and II.
    fn default() -> Self {
        Self {
            rig: Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 }),
            lambda: 3.0,
            eta: 3.0,
            planner_period: 0.05,
            bisection_steps: 8,
            planner: PlannerKind::Bounded,
            pose_source: PoseSource::EncoderPose,
            force_loop: false,
            position_tolerance: 0.0,
            angle_tolerance: 0.0,
            hold_compensation: hold_compensation(),
            command_delay: 0.0,
            observer_bound: observer_bound(),
            mass_tolerance: 0.0,
            encoder_resolution: 0.0,
            disturbance_bound: 0.0,
            max_speed: 0.0,
            max_angular_rate: 0.0,
            max_cable_speed: 0.0,
            max_tension_rate: 0.0,
            lift: 0.0,
            largest_step: 0.0,
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
    /// What the law follows when the command of this step begins to act: the set point, or the motion to it.
    pub reference: Reference,
    /// Estimate of the pose at the time of the step's inputs.
    pub estimated_pose: Pose,
    /// Estimate of the rates of the six coordinates, m/s and rad/s.
    pub estimated_velocity: Coordinates,
    /// At rest at the active set point.
    pub steady: bool,
    /// At rest at the goal.
    pub at_goal: bool,
    /// From the goal to where the planner makes for instead, m; 0 if the goal can be reached. Of the attachment that has the farthest to
    /// go: for translations simply the distance.
    pub goal_distance: f64,
    /// Smallest tension of any cable predicted from now on, N.
    pub tension_margin: f64,
    /// Estimate of what acts on the platform besides cables and weight: (force, torque), N and N m, base frame; zero without observer.
    pub disturbance: Vector6<f64>,
    /// The platform's mass if all of that force is weight, kg: of use at rest.
    pub estimated_mass: f64,
    /// What the controller is doing.
    pub status: Status,
    /// Why, if that is `SensorFault` or `WaitingForPose`.
    pub fault: Fault,
    /// Whether what was tuned last acts.
    pub pending: Pending,
}

impl ControllerOutputs {
    /// At rest at `pose`, which is the set point, with nothing commanded yet.
    pub(super) fn at_rest(pose: &Pose, least: &PerCable<f64>) -> Self {
        Self {
            motor_tension: *least,
            set_point: *pose,
            set_point_index: 0,
            reference: Reference::resting(pose),
            estimated_pose: *pose,
            estimated_velocity: Coordinates::zeros(),
            steady: false,
            at_goal: false,
            goal_distance: 0.0,
            tension_margin: 0.0,
            disturbance: Vector6::zeros(),
            estimated_mass: 0.0,
            status: Status::Disabled,
            fault: Fault::NONE,
            pending: Pending::No,
        }
    }
}

impl ControllerParameters {
    /// λ₀ and η₀.
    pub fn gains(&self) -> Gains {
        Gains { lambda: self.lambda, eta: self.eta }
    }

    /// The observer of a constant disturbance, if there is one. Beside a force loop it estimates no torque: a light platform would be turned
    /// to and fro by friction.
    pub fn observer(&self) -> Option<DisturbanceObserver> {
        let force = self.observer_bound * self.rig.weight();
        let observer = if self.force_loop {
            DisturbanceObserver { pole: POLE_BESIDE_FORCE_LOOP, force, torque: 0.0 }
        } else {
            DisturbanceObserver { pole: DISTURBANCE_POLE, force, torque: force * self.rig.platform_radius() }
        };
        (self.planner != PlannerKind::Bounded && force > 0.0).then_some(observer)
    }

    /// The longest step that may be asked for, s: without bound for `Bounded`, which promises nothing of held commands. For `Exact` (λ + η)(h + d) is at
    /// most 1; derived in docs/exact.md, "What holding the tensions costs".
    pub fn longest_step(&self) -> f64 {
        if self.planner == PlannerKind::Bounded {
            return f64::INFINITY;
        }
        let borne = self.longest_hold();
        if self.largest_step > 0.0 { borne.min(self.largest_step) } else { borne }
    }

    /// s.
    pub(super) fn longest_hold(&self) -> f64 {
        1.0 / (self.lambda + self.eta) - self.command_delay
    }

    /// Whether a command may be held for `step` s.
    ///
    /// # Errors
    /// [`ParameterError`] with the longest step that may be.
    pub fn check_step(&self, step: f64) -> Result<(), ParameterError> {
        let longest = self.longest_step();
        // A sum of steps is rounded.
        if step <= longest * (1.0 + 1e-6) {
            return Ok(());
        }
        let allowed = format!("must be at most {longest:.3e} (s): {OF_LONGEST_STEP}");
        Err(ParameterError { name: "step".into(), value: step, allowed: allowed.into() })
    }

    /// What says how far the truth may be from the rig.
    pub(super) fn unknowns(&self) -> [(&'static str, f64); 4] {
        [
            ("accuracy", self.rig.accuracy),
            ("massTolerance", self.mass_tolerance),
            ("encoderResolution", self.encoder_resolution),
            ("disturbanceBound", self.disturbance_bound),
        ]
    }

    /// What the planner `Exact` alone heeds; each is 0 where it asks for nothing.
    pub(super) fn heeded_by_exact(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let others = [
            ("maxSpeed", self.max_speed),
            ("maxAngularRate", self.max_angular_rate),
            ("maxCableSpeed", self.max_cable_speed),
            ("largestStep", self.largest_step),
        ];
        self.unknowns().into_iter().chain(others)
    }

    /// Names the first parameter that makes no sense.
    ///
    /// # Errors
    /// [`ParameterError`] with the parameter's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.rig.validate()?;
        self.check_settings()?;
        if self.planner == PlannerKind::Bounded
            && let Err(other) = Shape::of(&self.rig)
        {
            let allowed = format!("Bounded knows the paper's rig only, and {other}: choose Exact (2)");
            return Err(ParameterError { name: "planner".into(), value: 1.0, allowed: allowed.into() });
        }
        let cables = self.rig.cables.len();
        if self.planner == PlannerKind::MinimumTime && cables > MOST_CABLES {
            let allowed = format!(
                "MinimumTime looks at every five cables, of {MOST_CABLES} at most, and the rig has {cables}: choose Exact (2)"
            );
            return Err(ParameterError { name: "planner".into(), value: 3.0, allowed: allowed.into() });
        }
        Ok(())
    }

    /// All but the rig; allocates for an error only.
    pub(super) fn check_settings(&self) -> Result<(), ParameterError> {
        for (name, value) in [("lambda", self.lambda), ("eta", self.eta)] {
            let ok = value > 0.0 && value <= MAX_GAIN;
            require(ok, name, value, "must be greater than 0 and at most 1000 (1/s)")?;
        }
        let period = self.planner_period;
        require(period.is_finite() && period > 0.0, "plannerPeriod", period, "must be greater than 0 (s)")?;
        let steps = self.bisection_steps;
        require((1..=52).contains(&steps), "bisectionSteps", steps.into(), "must be from 1 to 52")?;
        for (name, value) in
            [("positionTolerance", self.position_tolerance), ("angleTolerance", self.angle_tolerance)]
        {
            let ok = value.is_finite() && value >= 0.0;
            require(ok, name, value, "must be greater than 0, or 0 to follow the rig's size")?;
        }
        let delay = self.command_delay;
        require(
            delay.is_finite() && delay >= 0.0,
            "commandDelay",
            delay,
            "must be finite and 0 or greater (s)",
        )?;
        let share = self.mass_tolerance;
        require((0.0..1.0).contains(&share), "massTolerance", share, "must be 0 or greater and below 1")?;
        // Those of the rig, and the share of its mass, are found good.
        for (name, value) in self.heeded_by_exact() {
            require(value.is_finite() && value >= 0.0, name, value, "must be finite and 0 or greater")?;
        }
        let allowed =
            "must be 0, or finite and greater with the planner MinimumTime (3), which alone heeds it";
        for (name, value) in [("lift", self.lift), ("maxTensionRate", self.max_tension_rate)] {
            let heeds = self.planner == PlannerKind::MinimumTime && value.is_finite() && value > 0.0;
            require(value == 0.0 || heeds, name, value, allowed)?;
        }
        let bound = self.observer_bound;
        let allowed = "must be from 0 to 1 (share of the weight)";
        require((0.0..=1.0).contains(&bound), "observerBound", bound, allowed)?;
        self.check_planner()?;
        if self.planner == PlannerKind::Bounded {
            return Ok(());
        }
        let borne = self.longest_hold();
        let allowed = "must be less than 1/(lambda + eta) (s) with the planner Exact";
        require(borne > 0.0, "commandDelay", delay, allowed)?;
        let step = self.largest_step;
        if step > borne {
            let allowed = format!("must be at most {borne:.3e} (s): 1/(lambda + eta) less commandDelay");
            return Err(ParameterError { name: "largestStep".into(), value: step, allowed: allowed.into() });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// "At rest" was 2 mm for a rig of 1 mm, and would have been a metre on a telescope.
    #[test]
    fn what_counts_as_rest_follows_the_size_of_the_rig() {
        let rest = |a: f64| {
            let robot = RobotParameters { a, b: 0.5 * a, ..RobotParameters::default() };
            ControllerParameters::of(&Rig::paper(&robot, TensionLimits::default())).rest().position
        };
        assert_eq!(ControllerParameters::default().rest(), Rest { position: 2e-3, angle: 1e-2 });
        assert!((rest(0.001) - 2e-3 / 450.0).abs() < 1e-12);
        assert_eq!(rest(250.0), 1e-2);
    }

    #[test]
    fn each_bad_parameter_is_named() {
        let broken = |change: fn(&mut ControllerParameters)| {
            let mut parameters = ControllerParameters::default();
            change(&mut parameters);
            parameters.validate().unwrap_err().to_string()
        };
        assert!(broken(|p| p.rig.mass = -1.0).contains("parameter mass = -1"));
        assert!(broken(|p| p.rig.cables[4].anchor.y = f64::NAN).contains("parameter anchor[5].y = NaN"));
        let bent = broken(|p| p.rig.cables[4].anchor.y += 0.02);
        assert!(bent.contains("parameter planner = 1") && bent.contains("of cable 5 is"), "{bent}");
        let many = broken(|p| {
            p.planner = PlannerKind::MinimumTime;
            let cables: Vec<_> = p.rig.cables.iter().copied().collect();
            p.rig.cables = PerCable::from_fn(11, |i| cables[i % 6]);
        });
        assert!(many.contains("parameter planner = 3") && many.contains("the rig has 11"), "{many}");
        assert!(broken(|p| p.lambda = 0.0).contains("parameter lambda = 0"));
        assert!(broken(|p| p.eta = -2.0).contains("parameter eta = -2"));
        assert!(broken(|p| p.bisection_steps = 0).contains("parameter bisectionSteps = 0"));
        assert!(broken(|p| p.planner_period = 0.0).contains("parameter plannerPeriod = 0"));
        assert!(
            broken(|p| p.rig = p.rig.with_limits(TensionLimits { min: -1.0, max: 1.0 }))
                .contains("parameter minTension = -1")
        );
        assert!(broken(|p| p.rig.cables[2].limits.min = 200.0).contains("parameter maxTension[3] = 100"));
        assert!(broken(|p| p.position_tolerance = -1.0).contains("parameter positionTolerance = -1"));
        assert_eq!(ControllerParameters::default().validate(), Ok(()));
    }
}
