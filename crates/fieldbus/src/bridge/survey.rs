//! Lengths read with the platform at a pose that a person measured, for [`crate::commission`].

use cable_robot::robot::{PerCable, Pose};

use super::weigh::Stand;
use super::{Bridge, Event, Refusal};

impl Bridge {
    /// The cables are taut at the pretension, and at rest if none moves faster than what an encoder may freeze from.
    pub(super) fn note_placing(&mut self, pose: Pose) -> Result<(), Refusal> {
        if !pose.0.iter().all(|x| x.is_finite()) {
            return Err(Refusal::Goal(pose));
        }
        let moving = |i: &usize| self.drives[*i].encoder.rate.abs() > self.config.limits.freeze_speed;
        if let Some(i) = (0..self.cables()).find(moving) {
            return Err(Refusal::Moving { cable: i + 1, speed: self.drives[i].encoder.rate.abs() });
        }
        let lengths = self.lengths();
        let lengthening = PerCable::from_fn(self.cables(), |i| lengths[i] - self.home_length[i]);
        self.placed = Some(Stand { pose, length: lengths });
        self.events.push(self.time, Event::Placed(pose, lengthening));
        Ok(())
    }
}
