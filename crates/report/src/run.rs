//! A recorded run and what it comes down to.

use std::fmt;

/// A recorded run: a column a quantity, all as long as `times`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// s.
    pub times: Vec<f64>,
    /// x, y, z of the platform's centre, m.
    pub position: [Vec<f64>; 3],
    /// x, y, z of the active set point, m.
    pub set_point: [Vec<f64>; 3],
    /// Number of the active set point.
    pub set_point_index: Vec<f64>,
    /// What the cables pull, N.
    pub tension: Vec<Vec<f64>>,
    /// 1 where a cable is slack.
    pub slack: Vec<Vec<f64>>,
    /// The controller's prediction of the smallest tension to come, N.
    pub tension_margin: Vec<f64>,
    /// 1 at rest at the goal.
    pub at_goal: Vec<f64>,
}

/// A set point and when it became the active one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPoint {
    /// s.
    pub time: f64,
    /// x, y, z, m.
    pub position: [f64; 3],
}

/// The smallest tension of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallestTension {
    /// N.
    pub value: f64,
    /// Cable number, from 1.
    pub cable: usize,
    /// s.
    pub time: f64,
}

impl fmt::Display for SmallestTension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} N in cable {} at {:.3} s", self.value, self.cable, self.time)
    }
}

/// What a run comes down to.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The start, then every set point in its turn.
    pub set_points: Vec<SetPoint>,
    /// `None` if nothing was recorded.
    pub smallest_tension: Option<SmallestTension>,
    /// When the robot first rested at the goal, s.
    pub time_to_goal: Option<f64>,
    /// Every cable that was slack, in the order of the cable numbers.
    pub slack: Vec<Slack>,
}

/// A cable that was slack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack {
    /// Its number, from 1.
    pub cable: usize,
    /// When it went slack for the first time, s.
    pub first: f64,
    /// For how long it was slack in all, s.
    pub duration: f64,
}

impl fmt::Display for Slack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cable, first, duration } = self;
        write!(f, "cable {cable} from {first:.3} s, {duration:.3} s in all")
    }
}

impl Run {
    /// Reads the results off the columns.
    pub fn summary(&self) -> Summary {
        let first = |column: &[f64]| column.iter().position(|value| *value != 0.0).map(|row| self.times[row]);
        Summary {
            set_points: self.set_points(),
            smallest_tension: self.smallest_tension(),
            time_to_goal: first(&self.at_goal),
            slack: (0..self.slack.len()).filter_map(|i| self.slack_of(i)).collect(),
        }
    }

    /// Of a cable, from 0. A row speaks of the time since the one before.
    fn slack_of(&self, i: usize) -> Option<Slack> {
        let (times, column) = (&self.times, &self.slack[i]);
        let first = column.iter().position(|value| *value != 0.0)?;
        let is_slack = |row: &usize| column[*row] != 0.0;
        let duration = (1..times.len()).filter(is_slack).map(|row| times[row] - times[row - 1]).sum();
        Some(Slack { cable: i + 1, first: times[first], duration })
    }

    fn set_points(&self) -> Vec<SetPoint> {
        let is_new = |&row: &usize| row == 0 || self.set_point_index[row] != self.set_point_index[row - 1];
        let at = |row: usize| SetPoint {
            time: self.times[row],
            position: std::array::from_fn(|k| self.set_point[k][row]),
        };
        (0..self.times.len()).filter(is_new).map(at).collect()
    }

    fn smallest_tension(&self) -> Option<SmallestTension> {
        let of_cable = |i: usize| {
            let samples = self.tension[i].iter().zip(&self.times);
            samples.map(move |(value, time)| SmallestTension { value: *value, cable: i + 1, time: *time })
        };
        // Of equals the first.
        let order = |a: &SmallestTension, b: &SmallestTension| {
            a.value.total_cmp(&b.value).then(a.time.total_cmp(&b.time))
        };
        (0..self.tension.len()).flat_map(of_cable).min_by(order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coordinates move, cable 5 comes close to nothing, set point 1 comes at 0.5 s.
    fn run(samples: usize) -> Run {
        let times: Vec<f64> = (0..samples).map(|k| k as f64 / 1000.0).collect();
        let along = |f: fn(f64) -> f64| times.iter().map(|t| f(*t)).collect::<Vec<_>>();
        Run {
            position: [along(|t| 0.01 * t), along(|t| 0.02 * t), along(|_| 1.0)],
            set_point: [along(|t| if t < 0.5 { 0.0 } else { 0.2 }), along(|_| 0.0), along(|_| 1.0)],
            set_point_index: along(|t| if t < 0.5 { 0.0 } else { 1.0 }),
            tension: (0..6)
                .map(|i| along(if i == 4 { |t| 1.0 + (t - 0.7) * (t - 0.7) } else { |t| 10.0 + t.sin() }))
                .collect(),
            slack: vec![vec![0.0; samples]; 6],
            tension_margin: along(|_| 1.0),
            at_goal: along(|t| f64::from(u8::from(t > 0.9))),
            times,
        }
    }

    #[test]
    fn summary_finds_set_points_smallest_tension_and_arrival() {
        let summary = run(1_000).summary();
        let expected = [(0.0, [0.0, 0.0, 1.0]), (0.5, [0.2, 0.0, 1.0])];
        assert_eq!(summary.set_points, expected.map(|(time, position)| SetPoint { time, position }));
        let smallest = summary.smallest_tension.expect("samples");
        assert_eq!((smallest.cable, smallest.time), (5, 0.7));
        assert_eq!((summary.time_to_goal, summary.slack), (Some(0.901), vec![]));
    }

    #[test]
    fn summary_names_every_slack_cable() {
        let mut run = run(1_000);
        run.slack[1][600] = 1.0;
        run.slack[3][400] = 1.0;
        let slack = run.summary().slack;
        assert_eq!(slack.iter().map(|s| (s.cable, s.first)).collect::<Vec<_>>(), [(2, 0.6), (4, 0.4)]);
        assert!((slack[0].duration - 1e-3).abs() < 1e-12, "{slack:?}");
        (run.tension[1][600], run.tension[3][400]) = (0.0, 0.0);
        let smallest = run.summary().smallest_tension.unwrap();
        assert_eq!((smallest.cable, smallest.time), (4, 0.4));
    }

    #[test]
    fn an_empty_run_has_no_results() {
        let nothing =
            Summary { set_points: vec![], smallest_tension: None, time_to_goal: None, slack: vec![] };
        assert_eq!(Run::default().summary(), nothing);
    }
}
