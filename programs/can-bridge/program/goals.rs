//! Goals of a scenario file, given when their times have come.

use std::path::Path;

use anyhow::{Context, Result};
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::Pose;
use cable_robot::sim::{Goal, ScenarioFile};
use cable_robot_fieldbus::{Config, Nanoseconds, State};
use cable_robot_files::read_text;

/// The goals of the file; nothing else in it is used.
pub fn read(path: &Path, config: &Config) -> Result<Vec<Goal>> {
    let name = || path.display().to_string();
    let text = read_text(path).with_context(|| format!("cannot read {}", name()))?;
    let base = ControllerParameters { rig: config.rig, ..ControllerParameters::default() };
    let scenario = ScenarioFile::parse(&text).and_then(|file| file.scenario(&config.name, config.home, base));
    Ok(scenario.with_context(name)?.goals)
}

/// Goals on their way. They are given once: after the operator let go, the rest is not made up for.
pub struct Timetable {
    goals: Vec<Goal>,
    next: usize,
    /// From Enabled to the controller's tensions.
    lift: Nanoseconds,
    /// When the controller's tensions began.
    since: Option<Nanoseconds>,
}

impl Timetable {
    /// Of these goals in the order of their times.
    pub fn new(goals: Vec<Goal>, config: &Config) -> Self {
        Self { goals, next: 0, lift: config.safe.ramp, since: None }
    }

    /// The goal that is due now.
    pub fn due(&mut self, state: State, now: Nanoseconds) -> Option<Pose> {
        match (state, self.since) {
            (State::Enabled | State::Shadow, None) => {
                self.since = Some(now + if state == State::Enabled { self.lift } else { 0 });
            }
            (State::Enabled | State::Shadow, Some(_)) | (_, None) => {}
            (_, Some(_)) => self.next = self.goals.len(),
        }
        let elapsed = now.checked_sub(self.since?)? as f64 * 1e-9;
        let goal = self.goals.get(self.next).filter(|goal| goal.time <= elapsed)?;
        self.next += 1;
        Some(goal.pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::tests::config;

    #[test]
    fn goals_come_after_the_lift_and_not_again_after_a_release() {
        let goals = [0.0, 1.0, 2.0].map(|time| Goal::new(time, Pose::at(time, 0.0, 1.0)));
        let config = config();
        let mut table = Timetable::new(goals.to_vec(), &config);
        let mut due = |state, ms: u64| table.due(state, ms * 1_000_000).map(|pose| pose.0[0]);
        assert_eq!(due(State::Ready, 0), None);
        assert_eq!(due(State::Enabled, 10_000), None);
        let lift = config.safe.ramp / 1_000_000;
        assert_eq!(due(State::Enabled, 10_000 + lift), Some(0.0));
        assert_eq!(due(State::Enabled, 10_999 + lift), None);
        assert_eq!(due(State::Enabled, 11_000 + lift), Some(1.0));
        assert_eq!(due(State::Safe, 11_500), None);
        assert_eq!(due(State::Enabled, 20_000), None);
    }
}
