//! What the loop tells the journal: plain data through a queue without locks.

use cable_robot_fieldbus::bridge::{CycleReport, Event, Refusal, TransportError};
use cable_robot_fieldbus::{Frame, Nanoseconds, OperatorCommand};
use rtrb::Producer;

/// Something that happened. Times are since the program's start, in whole microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a box would be an allocation a cycle")]
pub enum Entry {
    /// A frame that entered the bridge.
    Received(OnBus),
    /// What else entered it, before the cycle that follows, and why a command was not taken.
    Input(Input, Option<Refusal>),
    /// A frame that was put on the bus.
    Sent(OnBus),
    /// A cycle, after its frames.
    Cycle(Cycle),
    /// What the bridge had to say.
    Event(Nanoseconds, Event),
    /// A command that it did not take, said once of those that are given again and again.
    Refused(Nanoseconds, Refusal),
    /// What the program has to say.
    Note(Nanoseconds, &'static str),
    /// So many entries are missing here: the queue was full.
    Lost(u64),
}

/// A frame, its bus and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnBus {
    /// Place of the bus in the fieldbus file.
    pub bus: usize,
    /// When.
    pub time: Nanoseconds,
    /// What.
    pub frame: Frame,
}

/// What enters the bridge beside frames and times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A command, also one that is refused.
    Operator(OperatorCommand),
    /// What a link could not do, and the frame that it did not send.
    Transport {
        /// Place of the bus in the fieldbus file.
        bus: usize,
        /// Why.
        error: TransportError,
        /// `None` if it could not receive.
        frame: Option<Frame>,
    },
}

/// A cycle, and how punctual it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// What the bridge reports.
    pub report: CycleReport,
    /// From the time it was due to the time it began.
    pub lateness: Nanoseconds,
    /// From the first encoder's frame of the cycle to the last torque's.
    pub latency: Option<Nanoseconds>,
    /// Cycles before it that never came.
    pub missed: u64,
}

/// The loop's end of the queue.
pub struct Teller {
    queue: Producer<Entry>,
    /// So far, and of these the ones that nobody was told of.
    lost: u64,
    untold: u64,
}

impl Teller {
    /// Into this queue.
    pub fn new(queue: Producer<Entry>) -> Self {
        Self { queue, lost: 0, untold: 0 }
    }

    /// Tells something; if there is no room, the next that finds some is preceded by what was lost.
    pub fn tell(&mut self, entry: Entry) {
        if self.untold > 0 && self.queue.push(Entry::Lost(self.untold)).is_ok() {
            self.untold = 0;
        }
        if self.untold > 0 || self.queue.push(entry).is_err() {
            (self.lost, self.untold) = (self.lost + 1, self.untold + 1);
        }
    }

    /// How many entries found no room.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use rtrb::RingBuffer;

    use super::*;

    #[test]
    fn what_found_no_room_is_counted_at_its_place() {
        let (producer, mut consumer) = RingBuffer::new(3);
        let mut teller = Teller::new(producer);
        (0..5).for_each(|k| teller.tell(Entry::Note(k, "")));
        assert_eq!(std::iter::from_fn(|| consumer.pop().ok()).count(), 3);
        teller.tell(Entry::Note(9, ""));
        let rest: Vec<_> = std::iter::from_fn(|| consumer.pop().ok()).collect();
        assert_eq!((rest, teller.lost()), (vec![Entry::Lost(2), Entry::Note(9, "")], 2));
    }
}
