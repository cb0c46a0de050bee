//! Goals of a scenario file, given when their times have come.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::Pose;
use cable_robot::sim::{Goal, ScenarioFile};
use cable_robot_fieldbus::{Config, Nanoseconds, State};
use cable_robot_files::read_text;

/// The goals of the file. What else it says is not used; a planner that is another than the controller's, and an orbit, are refused: goals
/// would be sought that this controller does not go to.
pub fn read(path: &Path, config: &Config, own: &ControllerParameters) -> Result<Vec<Goal>> {
    let name = || path.display().to_string();
    let text = read_text(path).with_context(|| format!("cannot read {}", name()))?;
    let scenario = ScenarioFile::parse(&text).and_then(|file| file.scenario(&config.name, config.home, *own));
    let scenario = scenario.with_context(name)?;
    ensure!(scenario.orbit.is_none(), "{}: an orbit is not driven here, goals are", name());
    let (asked, is) = (scenario.controller.planner, own.planner);
    ensure!(
        asked == is,
        "{}: controller.planner = {asked:?} is not that of the controller here ({is:?}): give planner = \"{asked:?}\" in [controller.parameters] of the fieldbus file, or remove it from the scenario",
        name()
    );
    Ok(scenario.goals)
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
    fn a_scenario_for_another_planner_is_refused_and_not_silently_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scenario.toml");
        let text = |planner: &str| {
            format!(
                "title = \"a\"
duration = 5.0
[controller]
{planner}
[[goals]]
time = 1.0
pose = [0.1, 0.0, 1.0]
"
            )
        };
        let config = config();
        let own = ControllerParameters { rig: config.rig, ..ControllerParameters::default() };
        std::fs::write(&path, text("planner = \"exact\"")).unwrap();
        let error = read(&path, &config, &own).unwrap_err().to_string();
        assert!(
            error.contains("controller.planner = Exact is not that of the controller here (Bounded)"),
            "{error}"
        );
        std::fs::write(&path, text("")).unwrap();
        assert_eq!(read(&path, &config, &own).unwrap().len(), 1);
    }

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
