//! What a simulation came to, for people and for machines.

use cable_robot::plan::Status;
use cable_robot::robot::Pose;
use cable_robot::sim::Scenario;
use cable_robot::sim::scenario::Goal;
use cable_robot_report::facts::slack_in_words;
use cable_robot_report::{RunFolder, RunInfo, SetPoint, Table, TableError};

use super::answer::{Answer, AnswerGoal, AnswerSetPoint, AnswerSlack, AnswerTension};
use crate::command::metres;

/// Set points shown at either end of a long list.
const SHOWN: usize = 5;

/// Rows that are added up at once.
const PART: usize = 1_000;

/// What a run comes to, and the scenario that led to it. A controller from elsewhere may tell less: what it does not tell is left out.
pub struct Summary<'a> {
    scenario: &'a Scenario,
    /// The newest rows, of which the first is added up already, unless it is the first of all.
    recent: RunFolder,
    known: usize,
    /// Of the rows that are added up.
    came_to: cable_robot_report::Summary,
    /// Roll, pitch and yaw of the set points, rad.
    angles: Vec<[f64; 3]>,
    /// When the robot first rested at each goal, s.
    reached: Vec<Option<f64>>,
    lacking: Option<TableError>,
}

impl<'a> Summary<'a> {
    /// Of no rows yet, of `time` and these columns.
    pub fn new(scenario: &'a Scenario, info: RunInfo, names: impl Iterator<Item = String>) -> Self {
        Self {
            scenario,
            recent: RunFolder { info, table: Table::new(names) },
            known: 0,
            came_to: Default::default(),
            angles: vec![],
            reached: vec![None; scenario.goals.len()],
            lacking: None,
        }
    }

    /// Names of the columns, `time` first.
    pub fn names(&self) -> &[String] {
        self.recent.table.names()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.recent.table.rows() == 0
    }

    /// Adds a row, in the order of the names. A column that lacks is said by [`finish`](Self::finish).
    pub fn add(&mut self, row: &[f64]) {
        self.recent.table.push(row[0], &row[1..]);
        if self.recent.table.rows() > PART {
            self.lacking = self.add_up().err().or(self.lacking.take());
            self.recent.table.keep_last();
            self.known = 1;
        }
    }

    /// Adds up the last rows.
    ///
    /// # Errors
    /// [`TableError::Missing`]: a column that is needed is not there.
    pub fn finish(&mut self) -> Result<(), TableError> {
        self.lacking.take().map_or(Ok(()), Err)?;
        self.add_up()
    }

    fn add_up(&mut self) -> Result<(), TableError> {
        let run = self.recent.run()?;
        let before = self.came_to.set_points.len();
        self.came_to.add(&run, self.known);
        let columns = ["roll", "pitch", "yaw"]
            .map(|axis| self.recent.table.get(&format!("controller.setPoint.{axis}")));
        for point in &self.came_to.set_points[before..] {
            let row = run.times.partition_point(|time| *time < point.time);
            self.angles.push(columns.map(|column| column.map_or(0.0, |angle| angle[row])));
        }
        for k in 0..self.reached.len() {
            let (from, until) = (self.scenario.goals[k].time, self.end_of(k));
            let after = |time: f64| run.times.partition_point(|t| *t <= time).max(self.known);
            let mut rows = after(from)..after(until);
            let found = rows.find(|row| run.at_goal[*row] != 0.0).map(|row| run.times[row]);
            self.reached[k] = self.reached[k].or(found);
        }
        Ok(())
    }

    /// Whether a cable was slack.
    pub fn is_slack(&self) -> bool {
        !self.came_to.slack.is_empty()
    }

    /// For people.
    pub fn as_text(&self) -> String {
        let summary = &self.came_to;
        let mut text = format!("{}\n", self.scenario.title);
        if self.tells_of_set_points() {
            text += &set_points(&summary.set_points, &self.angles);
        }
        if let Some(smallest) = summary.smallest_tension {
            text += &format!("smallest tension: {smallest}\n");
        }
        if self.tells_of_goals() {
            text += &self.goals();
        }
        text += &format!("slack cables: {}\n", slack_in_words(&summary.slack));
        let status = self.status().map(|status| status.to_string());
        let left = self.left().map(|(distance, turn)| {
            format!("{} m from the goal, turned by {turn:.4} rad from it", metres(distance).trim())
        });
        match [status, left].into_iter().flatten().collect::<Vec<_>>().as_slice() {
            [] => text,
            parts => text + &format!("at the end, {:.3} s: {}\n", self.end(), parts.join(", ")),
        }
    }

    /// For machines.
    pub fn answer(&self) -> Answer {
        let summary = &self.came_to;
        let set_point = |(point, angles): (&SetPoint, &[f64; 3])| AnswerSetPoint {
            time: point.time,
            position: point.position,
            angles: *angles,
        };
        let goal = |(goal, reached): (&Goal, &Option<f64>)| AnswerGoal {
            time: goal.time,
            position: goal.pose.position().into(),
            angles: goal.pose.angles().into(),
            reached: *reached,
        };
        let set_points = summary.set_points.iter().zip(&self.angles).map(set_point);
        Answer {
            title: self.scenario.title.clone(),
            end_time: self.end(),
            set_points: self.tells_of_set_points().then(|| set_points.collect()),
            goals: self.scenario.goals.iter().zip(&self.reached).map(goal).collect(),
            smallest_tension: summary.smallest_tension.map(|u| AnswerTension {
                cable: u.cable,
                tension: u.value,
                time: u.time,
            }),
            slack: summary
                .slack
                .iter()
                .map(|slack| AnswerSlack { cable: slack.cable, first: slack.first, duration: slack.duration })
                .collect(),
            goal_distance: self.left().map(|(distance, _)| distance),
            goal_turn: self.left().map(|(_, turn)| turn),
            status: self.status().map(|status| status.to_string()),
        }
    }

    /// What the controller said last; `None` if it has no status.
    pub fn status(&self) -> Option<Status> {
        let number = *self.recent.table.get("controller.status")?.last()?;
        Some(Status::of(number as i32))
    }

    /// How far the platform is from the last goal at the end, m, and how much it is turned from it, rad; `None` without a goal or an end.
    fn left(&self) -> Option<(f64, f64)> {
        let goal = self.scenario.goals.iter().rfind(|goal| goal.time <= self.end())?;
        let coordinate = |axis| self.recent.table.get(&format!("plant.encoderPose.{axis}"))?.last().copied();
        let mut end = Pose::default();
        for (k, axis) in ["x", "y", "z", "roll", "pitch", "yaw"].into_iter().enumerate() {
            end.0[k] = coordinate(axis)?;
        }
        let turn = end.rotation().rotation_to(&goal.pose.rotation()).angle();
        Some(((end.position() - goal.pose.position()).norm(), turn))
    }

    fn tells_of_set_points(&self) -> bool {
        self.recent.table.get("controller.setPointIndex").is_some()
    }

    fn tells_of_goals(&self) -> bool {
        self.recent.table.get("controller.atGoal").is_some()
    }

    /// A line each, the middle of a long list left out.
    fn goals(&self) -> String {
        let count = self.scenario.goals.len();
        let line = |k: usize| match left_out(k, count) {
            None => self.goal(k),
            Some(0) => format!("... {} more goals\n", count - 2 * SHOWN),
            Some(_) => String::new(),
        };
        (0..count).map(line).collect()
    }

    /// When and whether goal `k` was reached.
    fn goal(&self, k: usize) -> String {
        let goal = &self.scenario.goals[k];
        let given = format!("goal {} given at {} s:", place(&goal.pose), goal.time);
        match self.reached[k] {
            Some(time) => format!("{given} reached after {:.3} s\n", time - goal.time),
            None if self.end() < goal.time => format!("{given} the run ended before\n"),
            None => format!("{given} not reached by {:.3} s\n", self.end_of(k).min(self.end())),
        }
    }

    /// When the next goal is given, s.
    fn end_of(&self, k: usize) -> f64 {
        self.scenario.goals.get(k + 1).map_or(self.scenario.duration, |next| next.time)
    }

    /// Time of the last row, s.
    fn end(&self) -> f64 {
        self.recent.table.get("time").and_then(|times| times.last().copied()).unwrap_or(0.0)
    }
}

/// x, y, z, and the angles if there are any.
pub fn place(pose: &Pose) -> String {
    let shown = if pose.angles().amax() > 0.0 { 6 } else { 3 };
    format!("({})", pose.0.iter().take(shown).map(f64::to_string).collect::<Vec<_>>().join(", "))
}

/// In the middle of a list that is too long: the place there, from 0.
fn left_out(i: usize, count: usize) -> Option<usize> {
    let is_long = count > 2 * SHOWN + 1;
    (is_long && (SHOWN..count - SHOWN).contains(&i)).then(|| i - SHOWN)
}

/// A table of them, the middle of a long one left out; angles only where there are any.
fn set_points(points: &[SetPoint], angles: &[[f64; 3]]) -> String {
    let turned = angles.iter().flatten().any(|angle| *angle != 0.0);
    let mut text = String::from("set points\n  i   from (s)    x (m)    y (m)    z (m)");
    text += if turned { " roll (rad)  pitch      yaw\n" } else { "\n" };
    let count = points.len();
    for (i, (point, angles)) in points.iter().zip(angles).enumerate() {
        text += &match left_out(i, count) {
            None => {
                let [x, y, z] = point.position.map(metres);
                let angles = if turned { angles.map(metres).concat() } else { String::new() };
                format!("  {i:<3} {:8.3}{x}{y}{z}{angles}\n", point.time)
            }
            Some(0) => format!("  ... {} more\n", count - 2 * SHOWN),
            Some(_) => String::new(),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_lose_their_middle() {
        let points = |count| vec![SetPoint { time: 0.0, position: [0.0, -1e-9, 1.0] }; count];
        let level = |count: usize| set_points(&points(count), &vec![[0.0; 3]; count]);
        assert_eq!(level(11).lines().count(), 13);
        let long = level(100);
        assert!(long.contains("  4   ") && long.contains("... 90 more\n  95  "), "{long}");
        assert!(!long.contains("-0.0"), "{long}");
    }
}
