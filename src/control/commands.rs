//! Commands on their way to the plant: what each imposes, and from when on.

use serde::{Deserialize, Serialize};

use crate::robot::memory::are_finite;
use crate::robot::{Coordinates, Pose};

/// Commands remembered: a delay may span two steps less.
const REMEMBERED: usize = 16;

/// A command holds from its time until that of the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Command {
    /// s.
    from: f64,
    /// Of the six coordinates, m/s² and rad/s².
    acceleration: Coordinates,
}

/// The commands of the last steps, the oldest first. Before the first nothing accelerates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commands {
    sent: [Command; REMEMBERED],
    count: usize,
}

impl Commands {
    /// At rest, with nothing on its way.
    pub fn none() -> Self {
        Self { sent: [Command { from: 0.0, acceleration: Coordinates::zeros() }; REMEMBERED], count: 0 }
    }

    /// A command at time `now` that acts from `from` on (s, not before the one sent last). Those that no longer act are forgotten.
    pub fn send(&mut self, now: f64, from: f64, acceleration: Coordinates) {
        let count = self.sent().len();
        let acts = (1..count).take_while(|k| self.sent[*k].from <= now).count();
        let forgotten = if count - acts == REMEMBERED { acts + 1 } else { acts };
        self.sent.copy_within(forgotten..count, 0);
        self.count = count - forgotten;
        self.sent[self.count] = Command { from, acceleration };
        self.count += 1;
    }

    fn sent(&self) -> &[Command] {
        &self.sent[..self.count]
    }

    /// Whether a run can have left this: no more than are remembered.
    pub fn is_sound(&self) -> bool {
        self.count <= REMEMBERED
            && self.sent().iter().all(|sent| sent.from.is_finite() && are_finite(&sent.acceleration))
    }

    /// The parts of a span of time in which one command acts: how long, s, and what it imposes.
    fn pieces(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, &Coordinates)> {
        let sent = self.sent();
        (0..sent.len()).filter_map(move |k| {
            let begin = sent[k].from.max(from);
            let end = sent.get(k + 1).map_or(to, |next| next.from.min(to));
            (end > begin).then_some((end - begin, &sent[k].acceleration))
        })
    }

    /// What they impose on average over a span of time (s).
    pub fn mean(&self, from: f64, to: f64) -> Coordinates {
        if let Some(only) = self.sent().last().filter(|last| last.from <= from) {
            return only.acceleration;
        }
        let sum: Coordinates = self.pieces(from, to).map(|(time, acceleration)| acceleration * time).sum();
        if to > from { sum / (to - from) } else { Coordinates::zeros() }
    }

    /// Pose and rates at `to` of a platform that is at these at `from` (s), under what is on its way and `besides`.
    pub fn carry(
        &self,
        (pose, rates): (&Pose, &Coordinates),
        besides: &Coordinates,
        from: f64,
        to: f64,
    ) -> (Pose, Coordinates) {
        let (mut at, mut rates, mut left) = (pose.0, *rates, to - from);
        // Before the first command acts nothing accelerates.
        let idle = self.sent().first().map_or(left, |first| (first.from - from).clamp(0.0, left));
        at += rates * idle;
        left -= idle;
        for (time, acceleration) in self.pieces(from, to) {
            let acceleration = acceleration + besides;
            at += rates * time + acceleration * (0.5 * time * time);
            rates += acceleration * time;
            left -= time;
        }
        (Pose(at + rates * left.max(0.0)), rates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_x(acceleration: f64) -> Coordinates {
        Coordinates::new(acceleration, 0.0, 0.0, 0.0, 0.0, 0.0)
    }

    #[test]
    fn a_late_command_acts_when_it_is_due_and_is_averaged_over_the_step() {
        let mut commands = Commands::none();
        commands.send(0.0, 1.0, along_x(1.0));
        commands.send(1.0, 2.0, along_x(-3.0));
        assert_eq!(commands.mean(0.0, 1.0)[0], 0.0);
        assert_eq!(commands.mean(0.5, 1.5)[0], 0.5);
        assert_eq!(commands.mean(1.0, 3.0)[0], -1.0);
        let (start, none) = (Pose::at(0.0, 0.0, 1.0), Coordinates::zeros());
        let (pose, rates) = commands.carry((&start, &along_x(2.0)), &none, 0.0, 3.0);
        // 2 m/s for 1 s, then 1 m/s² for 1 s, then -3 m/s² for 1 s.
        assert!((pose.0[0] - (2.0 + 2.5 + 1.5)).abs() < 1e-12 && rates[0].abs() < 1e-12, "{pose:?} {rates}");
    }

    #[test]
    fn a_command_at_once_is_the_only_one_and_gives_its_bits() {
        let mut commands = Commands::none();
        for k in 0..100 {
            let time = 0.1 * f64::from(k);
            commands.send(time, time, along_x(0.1 + f64::from(k)));
            assert_eq!(commands.mean(time, time + 0.1)[0], 0.1 + f64::from(k));
        }
        assert!(commands.count <= 2);
    }

    #[test]
    fn more_than_are_remembered_lose_the_oldest() {
        let mut commands = Commands::none();
        (0..40).for_each(|k| commands.send(0.0, 100.0 + f64::from(k), along_x(f64::from(k))));
        assert_eq!(commands.mean(139.0, 140.0)[0], 39.0);
    }
}
