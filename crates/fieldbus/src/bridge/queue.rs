//! What a cycle sends: frames in their order, no more than fit.

use crate::frame::Frame;

/// The frames of one cycle. The next cycle empties it: a transport that could not send some must not send them later.
#[derive(Clone, Debug)]
pub struct FrameQueue {
    frames: [(usize, Frame); FrameQueue::CAPACITY],
    length: usize,
}

impl FrameQueue {
    /// More frames than a cycle ever has.
    pub const CAPACITY: usize = 64;

    /// Nothing.
    pub fn new() -> Self {
        Self { frames: [(0, Frame::data(0, [])); Self::CAPACITY], length: 0 }
    }

    /// Appends a frame for a bus; false if there is no room.
    pub fn push(&mut self, bus: usize, frame: Frame) -> bool {
        let place = self.frames.get_mut(self.length);
        let is_room = place.is_some();
        if let Some(place) = place {
            *place = (bus, frame);
            self.length += 1;
        }
        is_room
    }

    /// The place of the bus in the fieldbus file, and the frame.
    pub fn frames(&self) -> &[(usize, Frame)] {
        &self.frames[..self.length]
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.length = 0;
    }
}

impl Default for FrameQueue {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_the_rest_stands() {
        let mut queue = FrameQueue::new();
        let fitted = (0..100).filter(|k| queue.push(1, Frame::data(*k, []))).count();
        const CAPACITY: usize = FrameQueue::CAPACITY;
        assert_eq!((fitted, queue.frames().len()), (CAPACITY, CAPACITY));
        assert_eq!(queue.frames()[CAPACITY - 1], (1, Frame::data(CAPACITY as u16 - 1, [])));
        queue.clear();
        assert!(queue.frames().is_empty());
    }
}
