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
#[derive(Clone, Debug, Default, PartialEq)]
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
        let mut summary = Summary::default();
        summary.add(self, 0);
        summary
    }
}

impl Summary {
    /// Adds a part of a run, of which the first row is known already (1) or none is (0): the last row of the part before is the first of the next.
    pub fn add(&mut self, run: &Run, known: usize) {
        self.add_set_points(run, known);
        let smallest = smallest_tension(run, known);
        if let Some(found) =
            smallest.filter(|u| self.smallest_tension.is_none_or(|known| u.value < known.value))
        {
            self.smallest_tension = Some(found);
        }
        let arrived = || (known..run.times.len()).find(|row| run.at_goal[*row] != 0.0);
        self.time_to_goal = self.time_to_goal.or_else(|| arrived().map(|row| run.times[row]));
        (0..run.slack.len()).for_each(|i| self.add_slack(run, i, known));
    }

    fn add_set_points(&mut self, run: &Run, known: usize) {
        let is_new = |&row: &usize| row == 0 || run.set_point_index[row] != run.set_point_index[row - 1];
        let at = |row: usize| SetPoint {
            time: run.times[row],
            position: std::array::from_fn(|k| run.set_point[k][row]),
        };
        self.set_points.extend((known..run.times.len()).filter(is_new).map(at));
    }

    /// Of a cable, from 0. A row speaks of the time since the one before.
    fn add_slack(&mut self, run: &Run, i: usize, known: usize) {
        let (times, column) = (&run.times, &run.slack[i]);
        let place = self.slack.partition_point(|slack| slack.cable <= i);
        for row in (known..times.len()).filter(|row| column[*row] != 0.0) {
            if self.slack.get(place).is_none_or(|slack| slack.cable != i + 1) {
                self.slack.insert(place, Slack { cable: i + 1, first: times[row], duration: 0.0 });
            }
            if row > 0 {
                self.slack[place].duration += times[row] - times[row - 1];
            }
        }
    }
}

/// Of the rows from `known` on; of equals the first.
fn smallest_tension(run: &Run, known: usize) -> Option<SmallestTension> {
    let of_cable = |i: usize| {
        let samples = run.tension[i].iter().zip(&run.times).skip(known);
        samples.map(move |(value, time)| SmallestTension { value: *value, cable: i + 1, time: *time })
    };
    let order = |a: &SmallestTension, b: &SmallestTension| {
        a.value.total_cmp(&b.value).then(a.time.total_cmp(&b.time))
    };
    (0..run.tension.len()).flat_map(of_cable).min_by(order)
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
        assert_eq!(Run::default().summary(), Summary::default());
    }

    #[test]
    fn parts_of_a_run_come_to_what_the_whole_does() {
        let mut whole = run(1_000);
        for (cable, row) in [(3, 400), (1, 300), (1, 301), (1, 600)] {
            whole.slack[cable][row] = 1.0;
        }
        let part = |rows: std::ops::Range<usize>| {
            let of = |column: &Vec<f64>| column[rows.clone()].to_vec();
            Run {
                times: of(&whole.times),
                position: whole.position.each_ref().map(of),
                set_point: whole.set_point.each_ref().map(of),
                set_point_index: of(&whole.set_point_index),
                tension: whole.tension.iter().map(of).collect(),
                slack: whole.slack.iter().map(of).collect(),
                tension_margin: of(&whole.tension_margin),
                at_goal: of(&whole.at_goal),
            }
        };
        for length in [1, 7, 100, 300, 500, 999, 1000] {
            let mut summary = Summary::default();
            for start in (0..1_000).step_by(length) {
                let known = usize::from(start > 0);
                summary.add(&part(start - known..(start + length).min(1_000)), known);
            }
            assert_eq!(summary, whole.summary(), "parts of {length}");
        }
    }
}
