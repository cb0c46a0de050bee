//! What becomes of a goal: given, reached, refused, unreachable, or given up.

use std::fmt;

use cable_robot::plan::{ControllerOutputs, ControllerParameters, Status};
use cable_robot::robot::{Coordinates, Pose};
use cable_robot_fieldbus::bridge::CycleReport;
use cable_robot_fieldbus::{Nanoseconds, OperatorCommand, State};
use cable_robot_report::facts::{pose_in_words, why_unreachable};

use super::entry::{Entry, Input};
use super::status_line::GoalStatus;

/// What is left of a disturbance after so many time constants is nothing.
const SETTLED: f64 = 10.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Given,
    /// It does not set out: the platform rests beside its set point.
    Waiting,
    Reached,
    Unreachable,
    Refused,
    /// The controller pulls no more.
    GivenUp,
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Given => "given",
            Self::Waiting => "waits",
            Self::Reached => "reached",
            Self::Unreachable => "unreachable",
            Self::Refused => "refused",
            Self::GivenUp => "given up",
        })
    }
}

/// A goal and what became of it.
#[derive(Clone, Debug, PartialEq)]
struct GoalRecord {
    pose: Pose,
    fate: Fate,
    reason: Option<String>,
}

impl fmt::Display for GoalRecord {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "goal {} {}", pose_in_words(&self.pose), self.fate)?;
        self.reason.iter().try_for_each(|reason| write!(f, ": {reason}"))
    }
}

/// Follows the goals of a session.
pub struct Goals {
    parameters: ControllerParameters,
    /// Of the last cycle.
    now: Nanoseconds,
    /// The goal that the bridge took last.
    taken: Option<GoalRecord>,
    /// When.
    since: Nanoseconds,
    /// Since when the platform has been at rest beside its set point.
    rests_since: Option<Nanoseconds>,
    /// What was refused after it.
    refused: Option<GoalRecord>,
}

impl Goals {
    /// Of a controller with these parameters.
    pub fn new(parameters: ControllerParameters) -> Self {
        Self { parameters, now: 0, taken: None, since: 0, rests_since: None, refused: None }
    }

    /// Takes in what happened. What is to be said of it; why a goal is refused is said as of every command.
    pub fn take(&mut self, entry: &Entry) -> Option<String> {
        match entry {
            Entry::Input(Input::Operator(OperatorCommand::Goal(pose)), refusal) => {
                let record = |fate, reason| Some(GoalRecord { pose: *pose, fate, reason });
                if let Some(refusal) = refusal {
                    self.refused = record(Fate::Refused, Some(refusal.to_string()));
                    return None;
                }
                self.refused = None;
                let is_again = |taken: &GoalRecord| taken.pose == *pose && taken.fate != Fate::GivenUp;
                if self.taken.as_ref().is_some_and(is_again) {
                    return None;
                }
                (self.taken, self.since) = (record(Fate::Given, None), self.now);
                self.text()
            }
            Entry::Cycle(cycle) => self.follow(&cycle.report),
            _ => None,
        }
    }

    fn follow(&mut self, report: &CycleReport) -> Option<String> {
        self.now = report.time;
        let waits = self.waits(report);
        let taken = self.taken.as_mut()?;
        let elapsed = (report.time - self.since) as f64 * 1e-9;
        let is_pulled = matches!(report.state, State::Enabled | State::Shadow);
        let (fate, reason) = match (taken.fate, report.controller) {
            (Fate::GivenUp, _) => return None,
            (Fate::Given | Fate::Waiting, _) if !is_pulled => {
                (Fate::GivenUp, format!("after {elapsed:.1} s, the bridge is in {}", report.state))
            }
            // What was reached is not held any more.
            (_, _) if !is_pulled => {
                self.taken = None;
                return None;
            }
            (
                Fate::Given | Fate::Waiting | Fate::Unreachable,
                Some(ControllerOutputs { status: Status::AtGoal, .. }),
            ) => (Fate::Reached, format!("after {elapsed:.1} s")),
            (Fate::Given, _) if waits.is_some() => (Fate::Waiting, waits.unwrap_or_default()),
            // The planner takes a new goal up at its next tick; until then the status is that of the goal before.
            (Fate::Given, Some(answer))
                if answer.status == Status::GoalUnreachable
                    && elapsed > 2.0 * self.parameters.planner_period =>
            {
                let nearest = &answer.set_point;
                (Fate::Unreachable, why_unreachable(&self.parameters, &taken.pose, nearest))
            }
            _ => return None,
        };
        (taken.fate, taken.reason) = (fate, Some(reason));
        // That is newer than what was refused meanwhile.
        self.refused = None;
        self.text()
    }

    /// Why the planner does not let the platform set out, if that lasts: it rests, but not where the law would have it.
    fn waits(&mut self, report: &CycleReport) -> Option<String> {
        let answer = report.controller?;
        let (rest, slow_rate) = (self.parameters.rest(), self.parameters.lambda.min(self.parameters.eta));
        let parts = |coordinates: &Coordinates| {
            (coordinates.fixed_rows::<3>(0).norm(), coordinates.fixed_rows::<3>(3).amax())
        };
        let (off, turned) = parts(&answer.estimated_pose.minus(&answer.set_point));
        let (speed, turning) = parts(&answer.estimated_velocity);
        let is_slow = speed < slow_rate * rest.position && turning < slow_rate * rest.angle;
        let is_beside = off > rest.position || turned > rest.angle;
        if !(is_slow && is_beside && answer.status == Status::Moving) {
            self.rests_since = None;
            return None;
        }
        let since = *self.rests_since.get_or_insert(report.time);
        let lasts = (report.time - since) as f64 * 1e-9 > SETTLED / slow_rate;
        lasts.then(|| {
            format!(
                "the platform rests {:.1} mm and {:.1} mrad from its set point, and the planner waits for {:.1} mm and {:.1} mrad (positionTolerance, angleTolerance): load cells, geometry or mass are not as the files say, or the gains are small",
                1e3 * off, 1e3 * turned, 1e3 * rest.position, 1e3 * rest.angle
            )
        })
    }

    /// What became of the last goal; nothing if there was none.
    pub fn text(&self) -> Option<String> {
        self.last().map(GoalRecord::to_string)
    }

    /// The same for machines.
    pub fn status(&self) -> Option<GoalStatus> {
        self.last().map(|goal| GoalStatus {
            pose: goal.pose.0.into(),
            fate: goal.fate.to_string(),
            reason: goal.reason.clone(),
        })
    }

    fn last(&self) -> Option<&GoalRecord> {
        self.refused.as_ref().or(self.taken.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use cable_robot::sim::PlantParameters;
    use cable_robot_fieldbus::Config;
    use cable_robot_fieldbus::simulated::Bench;

    use super::*;
    use crate::program::entry::Cycle;
    use crate::program::tests::config;

    /// The simulated rig up to the controller's tensions, and what is said of goals.
    struct Shown {
        bench: Bench,
        goals: Goals,
        said: Vec<String>,
    }

    impl Shown {
        fn start() -> Self {
            Self::start_as(config())
        }

        /// On a rig that is as `truth` says.
        fn start_as(truth: Config) -> Self {
            let mut bench = Bench::believing(truth, config(), PlantParameters::default()).unwrap();
            assert!(bench.start(), "{:?}", bench.events.last());
            let parameters = ControllerParameters { rig: config().rig, ..Default::default() };
            Self { bench, goals: Goals::new(parameters), said: vec![] }
        }

        fn give(&mut self, x: f64, y: f64, z: f64) {
            let command = OperatorCommand::Goal(Pose::at(x, y, z));
            let refusal = self.bench.bridge.operator(command, self.bench.now).err();
            self.said.extend(self.goals.take(&Entry::Input(Input::Operator(command), refusal)));
        }

        fn fate(&self) -> String {
            self.goals.status().unwrap().fate
        }

        fn run(&mut self, seconds: f64) {
            let period = self.bench.bridge.config().period as f64 * 1e-9;
            for _ in 0..(seconds / period) as usize {
                let report = self.bench.cycle();
                let cycle = Cycle { report, lateness: 0, latency: None, missed: 0 };
                self.said.extend(self.goals.take(&Entry::Cycle(cycle)));
            }
        }
    }

    #[test]
    fn why_a_platform_does_not_set_out_is_said() {
        let mut truth = config();
        truth.load_cells[4].cell.scale *= 1.003;
        let mut shown = Shown::start_as(truth);
        shown.run(3.0);
        shown.give(0.05, 0.0, 1.0);
        shown.run(8.0);
        assert_eq!(shown.said.len(), 2, "{:?}", shown.said);
        println!("{}", shown.said[1]);
        assert!(
            shown.said[1].starts_with("goal (0.05, 0, 1) m waits: the platform rests "),
            "{:?}",
            shown.said
        );
        assert!(shown.said[1].contains("for 2.0 mm and 10.0 mrad (positionTolerance"), "{:?}", shown.said);
        assert_eq!(shown.fate(), "waits");
    }

    #[test]
    fn what_becomes_of_a_goal_is_said_once_with_the_reason() {
        let mut shown = Shown::start();
        assert!(shown.goals.text().is_none() && shown.goals.status().is_none());
        shown.run(3.0);
        shown.give(0.05, 0.0, 1.0);
        shown.run(0.5);
        shown.give(0.05, 0.0, 1.0);
        shown.run(5.0);
        assert_eq!(shown.said[0], "goal (0.05, 0, 1) m given");
        assert!(shown.said[1].starts_with("goal (0.05, 0, 1) m reached: after "), "{:?}", shown.said);
        assert_eq!(shown.said.len(), 2, "{:?}", shown.said);

        // In the box, but where a cable would have to push.
        shown.give(0.0, 0.4, 1.0);
        shown.run(2.0);
        let last = shown.said.last().unwrap();
        assert!(last.contains("(0, 0.4, 1) m unreachable: at rest at the goal cable "), "{last}");

        // What was given before still stands, but the last word is of the last goal.
        shown.give(9.0, 0.0, 1.0);
        assert_eq!(shown.fate(), "refused");
        assert!(
            shown.goals.text().unwrap().contains("refused: the goal is outside of limits.space: x = 9 m")
        );

        shown.give(-0.05, 0.0, 1.0);
        shown.run(0.1);
        _ = shown.bench.bridge.operator(OperatorCommand::Release, shown.bench.now);
        shown.run(0.1);
        let last = shown.said.last().unwrap();
        assert!(last.contains("(-0.05, 0, 1) m given up: after 0.1 s, the bridge is in Stopping"), "{last}");
        assert_eq!(shown.fate(), "given up");
    }
}
