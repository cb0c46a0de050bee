//! Section VI's move in the closed loop, as the bundled scenarios `paper` and `experiment` have it.

use anyhow::Result;
use cable_robot::robot::triangles::SIX;
use cable_robot::robot::{PerCable, Pose};
use cable_robot::sim::{Moment, Scenario, Simulation};

/// The goal of Section VI, m.
pub const GOAL: [f64; 3] = [0.15, 0.15, 1.0];
/// So many samples are drawn as their first, least and greatest: 25 ms in the bundled scenarios.
const DRAWN_TOGETHER: usize = 25;

/// The robot at one instant.
pub struct Sample {
    /// s.
    pub time: f64,
    /// As the encoders see it.
    pub pose: Pose,
    /// As the load cells see them, N.
    pub tension: PerCable<f64>,
}

/// A set point and when it was given.
pub struct SetPoint {
    /// s.
    pub time: f64,
    /// m.
    pub position: [f64; 3],
}

/// What came of the move.
pub struct Run {
    /// At every step.
    pub samples: Vec<Sample>,
    /// The start, then each set point in its turn.
    pub set_points: Vec<SetPoint>,
    /// s.
    pub duration: f64,
    /// When the robot first rested at the goal, s.
    pub at_goal: Option<f64>,
    /// The smallest tension that a load cell saw at any step, N, and its cable from 1.
    pub smallest: (f64, usize),
    /// When each cable was first slack, s.
    pub slack: [Option<f64>; SIX],
}

/// Runs a scenario.
pub fn run(scenario: &Scenario) -> Result<Run> {
    let mut simulation = Simulation::new(scenario)?;
    let mut run = Run {
        samples: vec![],
        set_points: vec![SetPoint { time: 0.0, position: place(&scenario.plant.initial_pose) }],
        duration: scenario.duration,
        at_goal: None,
        smallest: (f64::INFINITY, 0),
        slack: [None; SIX],
    };
    let steps = (scenario.duration / scenario.step).round() as u64;
    for k in 0..=steps {
        run.record(k, scenario.step, simulation.moment());
        simulation.step()?;
    }
    Ok(run)
}

impl Run {
    fn record(&mut self, k: u64, step: f64, moment: &Moment) {
        let Moment { time, controller, plant, .. } = moment;
        // The controller answered at the start of the step that led here.
        let asked = k.saturating_sub(1) as f64 * step;
        if controller.set_point_index as usize == self.set_points.len() {
            self.set_points.push(SetPoint { time: asked, position: place(&controller.set_point) });
        }
        if controller.at_goal {
            self.at_goal.get_or_insert(asked);
        }
        for i in 0..SIX {
            if plant.measured_tension[i] < self.smallest.0 {
                self.smallest = (plant.measured_tension[i], i + 1);
            }
            if plant.slack[i] {
                self.slack[i].get_or_insert(*time);
            }
        }
        self.samples.push(Sample { time: *time, pose: plant.encoder_pose, tension: plant.measured_tension });
    }

    /// One coordinate over time.
    pub fn coordinate(&self, k: usize) -> Vec<[f64; 2]> {
        drawn(self.samples.iter().map(|sample| [sample.time, sample.pose.0[k]]).collect())
    }

    /// One coordinate of the set points over time, with their steps.
    pub fn set_point(&self, k: usize) -> Vec<[f64; 2]> {
        let ends = self.set_points.iter().skip(1).map(|next| next.time).chain([self.duration]);
        let both_ends = self.set_points.iter().zip(ends);
        both_ends.flat_map(|(s, end)| [[s.time, s.position[k]], [end, s.position[k]]]).collect()
    }

    /// The tension of cable `i`, from 0, over time.
    pub fn tension(&self, i: usize) -> Vec<[f64; 2]> {
        drawn(self.samples.iter().map(|sample| [sample.time, sample.tension[i]]).collect())
    }

    /// The robot at the end.
    pub fn last(&self) -> &Sample {
        &self.samples[self.samples.len() - 1]
    }

    /// A line for each set point.
    pub fn set_point_lines(&self) -> Vec<String> {
        let line = |(i, s): (usize, &SetPoint)| {
            format!("set point {i}: ({:.4}, {:.4}) from {:.2} s on", s.position[0], s.position[1], s.time)
        };
        self.set_points.iter().enumerate().skip(1).map(line).collect()
    }

    /// Whether the goal was reached, and when.
    pub fn arrival_text(&self) -> String {
        match self.at_goal {
            Some(time) => format!("at rest at the goal after {time:.2} s"),
            None => format!("not at rest at the goal within {} s", self.duration),
        }
    }

    /// The smallest tension, and the first cable that was slack.
    pub fn smallest_text(&self) -> String {
        let (tension, cable) = self.smallest;
        let slack = (0..SIX).filter_map(|i| self.slack[i].map(|time| (time, i + 1)));
        let slack = match slack.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((time, cable)) => format!("cable {cable} is slack at {time:.3} s"),
            None => "no cable is ever slack".to_owned(),
        };
        format!("smallest tension {tension:.3} N, in cable {cable}; {slack}")
    }
}

/// What is drawn of a curve: no dip or peak is lost.
pub fn drawn(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let last = points.last().copied();
    let of_chunk = |chunk: &[[f64; 2]]| {
        let order = |a: &usize, b: &usize| chunk[*a][1].total_cmp(&chunk[*b][1]);
        let mut kept = [Some(0), (0..chunk.len()).min_by(order), (0..chunk.len()).max_by(order)]
            .map(Option::unwrap_or_default)
            .to_vec();
        kept.sort_unstable();
        kept.dedup();
        kept.into_iter().map(|k| chunk[k]).collect::<Vec<_>>()
    };
    let mut kept: Vec<_> = points.chunks(DRAWN_TOGETHER).flat_map(of_chunk).collect();
    kept.extend(last.filter(|last| kept.last() != Some(last)));
    kept
}

fn place(pose: &Pose) -> [f64; 3] {
    pose.position().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2.907 N, one sample in 25 showed 3.25.
    #[test]
    fn a_dip_of_one_sample_is_drawn() {
        let curve = |k: usize| [k as f64, if k == 333 { -5.0 } else { (k as f64 * 0.01).sin() }];
        let points: Vec<_> = (0..1000).map(curve).collect();
        let drawn = drawn(points.clone());
        assert!(drawn.contains(&[333.0, -5.0]) && drawn.len() < 150, "{}", drawn.len());
        assert!(drawn.is_sorted_by(|a, b| a[0] < b[0]));
        assert_eq!((drawn[0], drawn.last()), (points[0], points.last()));
    }
}
