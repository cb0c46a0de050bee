//! What happens in a simulation: goals and disturbances over time, robot, controller and imperfections.

use nalgebra::Vector3;

use super::PlantParameters;
use crate::plan::ControllerParameters;
use crate::plan::orbit::Orbit;
use crate::robot::Pose;

/// Steps that a simulation may have.
pub const MOST_STEPS: f64 = 1e6;
/// What is due at a time is not missed for the rounding of `k * step`, s.
pub(super) const ROUNDING: f64 = 1e-9;

/// A simulation, before it is run. Times are counted from its start.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What it shows, in a line.
    pub title: String,
    /// Name of the rig.
    pub rig: String,
    /// The controller, with the robot it believes in.
    pub controller: ControllerParameters,
    /// The plant: robot, start and imperfections.
    pub plant: PlantParameters,
    /// Instead of goals: the orbit that the controller leads the robot along from the start on.
    pub orbit: Option<Orbit>,
    /// Goals in the order of their times.
    pub goals: Vec<Goal>,
    /// Disturbances; where several act at once they add up.
    pub disturbances: Vec<Disturbance>,
    /// Simulated time, s.
    pub duration: f64,
    /// Time between two steps of the controller, s.
    pub step: f64,
}

/// A goal and when it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// s.
    pub time: f64,
    /// x_f.
    pub pose: Pose,
    /// Way points, passed without a stop where that is proved.
    pub through: Vec<Pose>,
}

impl Goal {
    /// Straight on.
    pub fn new(time: f64, pose: Pose) -> Self {
        Self { time, pose, through: vec![] }
    }
}

/// A force and a torque on the platform, both in the base frame, that act from one time until another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// First instant, s.
    pub from: f64,
    /// First instant after it, s; infinite if it lasts.
    pub until: f64,
    /// On the centre of mass, N.
    pub force: Vector3<f64>,
    /// N m.
    pub torque: Vector3<f64>,
}

/// How many steps make the duration (both in s).
///
/// # Errors
/// What would be right, where it is none, no whole number, or more than [`MOST_STEPS`].
pub fn count_steps(duration: f64, step: f64) -> Result<u64, String> {
    let steps = (duration / step).round();
    if !(0.0..=MOST_STEPS).contains(&steps) {
        return Err(format!("in steps of {step:?} s it must make 1 to {MOST_STEPS} steps"));
    }
    if (steps * step - duration).abs() > ROUNDING * duration || steps == 0.0 {
        let fewer = (duration / step).floor();
        let instead = [fewer, fewer + 1.0].map(|steps| steps * step);
        let [less, more] = instead.map(|duration| (duration * 1e9).round() / 1e9);
        let less = if fewer > 0.0 { format!("{less:?} or ") } else { String::new() };
        return Err(format!("it must be a whole number of steps of {step:?} s, such as {less}{more:?} s"));
    }
    Ok(steps as u64)
}

impl Scenario {
    /// The goal at `time` (s): before the first one is given, the start.
    pub fn goal_at(&self, time: f64) -> Pose {
        self.given_at(time).last().map_or(self.plant.initial_pose, |goal| goal.pose)
    }

    /// The goals given until `time` (s).
    pub fn given_at(&self, time: f64) -> &[Goal] {
        let given = self.goals.iter().take_while(|goal| goal.time <= time + ROUNDING).count();
        &self.goals[..given]
    }

    /// Force (N) and torque (N m) on the platform in the step that begins at `time` (s).
    pub fn disturbance_at(&self, time: f64) -> (Vector3<f64>, Vector3<f64>) {
        let now = time + ROUNDING;
        let acting = self.disturbances.iter().filter(|d| d.from <= now && now < d.until);
        let nothing = (Vector3::zeros(), Vector3::zeros());
        acting.fold(nothing, |(force, torque), d| (force + d.force, torque + d.torque))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario() -> Scenario {
        let gust = |from, until, x| Disturbance {
            from,
            until,
            force: Vector3::new(x, 0.0, 0.0),
            torque: Vector3::new(0.0, 0.0, 0.1 * x),
        };
        Scenario {
            title: String::new(),
            rig: String::new(),
            controller: ControllerParameters::default(),
            plant: PlantParameters::default(),
            orbit: None,
            goals: [(0.3, 0.1), (0.7, 0.2)].map(|(time, x)| Goal::new(time, Pose::at(x, 0.0, 1.0))).to_vec(),
            disturbances: vec![gust(0.3, 0.7, 1.0), gust(0.6, f64::INFINITY, 2.0)],
            duration: 1.0,
            step: 0.1,
        }
    }

    #[test]
    fn goals_come_at_the_step_of_their_time() {
        let scenario = scenario();
        let x = |k: u32| scenario.goal_at(f64::from(k) * 0.1).0[0];
        assert_eq!([0, 2, 3, 6, 7, 10].map(x), [0.0, 0.0, 0.1, 0.1, 0.2, 0.2]);
        assert_eq!(scenario.goal_at(0.0), Pose::default());
        let late = Scenario { goals: vec![Goal::new(0.9, Pose::at(0.1, 0.0, 1.0))], ..scenario };
        assert!(3.0 * 0.3 < 0.9 && late.goal_at(3.0 * 0.3) != Pose::default(), "rounding delays nothing");
    }

    #[test]
    fn disturbances_act_for_whole_steps_and_add_up() {
        let scenario = scenario();
        let x = |k: u32| scenario.disturbance_at(f64::from(k) * 0.1).0.x;
        assert_eq!([0, 2, 3, 5, 6, 7, 10].map(x), [0.0, 0.0, 1.0, 1.0, 3.0, 2.0, 2.0]);
        assert!((scenario.disturbance_at(0.6).1.z - 0.3).abs() < 1e-15);
    }

    #[test]
    fn steps_are_counted_and_limited() {
        assert_eq!(count_steps(12.0, 1e-3), Ok(12_000));
        assert_eq!(count_steps(0.3, 0.1), Ok(3));
        assert_eq!(count_steps(1000.0, 1e-3), Ok(1_000_000));
        for (duration, step) in [(0.0, 0.1), (1.0, 10.0), (1e9, 0.1), (f64::NAN, 0.1), (1.0, 0.0)] {
            assert!(count_steps(duration, step).is_err(), "{duration} {step}");
        }
        assert!(count_steps(1.0, 0.3).unwrap_err().ends_with("such as 0.9 or 1.2 s"));
        assert!(count_steps(1.0, 2.0).unwrap_err().ends_with("such as 2.0 s"));
    }
}
