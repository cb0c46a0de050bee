//! From what drives and load cells send to lengths and tensions, and what is wrong with them.

use super::fault::Fault;
use crate::Nanoseconds;
use crate::cia402::Winch;
use crate::config::Limits;
use crate::load_cell::{Reading, ReadingError};

/// The encoder of one cable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Encoder {
    /// The newest value since the last cycle.
    arrived: Option<i32>,
    /// The last one believed, when it was read, and the length it meant.
    counts: Option<i32>,
    time: Nanoseconds,
    true_length: f64,
    /// Counts at which the cable has its length at home.
    reference: i32,
    home_length: f64,
    /// m; carried on at `rate` while values are missing.
    pub length: f64,
    /// m/s, between the last two values believed.
    pub rate: f64,
    /// Cycles since the last value believed.
    pub missed: u32,
    is_frozen: bool,
    /// Whether the value that came in this cycle is another than the one before; nothing where none came.
    pub has_changed: Option<bool>,
    /// Whether what it says cannot be believed any more.
    pub has_failed: bool,
}

impl Encoder {
    /// Takes in a value; the newest of a cycle counts.
    pub fn receive(&mut self, counts: i32) {
        self.arrived = Some(counts);
    }

    /// The cable has this length (m) now.
    pub fn home(&mut self, length: f64) {
        self.reference = self.counts.unwrap_or(0);
        (self.home_length, self.length, self.true_length, self.rate) = (length, length, length, 0.0);
        self.has_failed = false;
    }

    /// Whether a value came in time.
    pub fn is_alive(&self, limits: &Limits) -> bool {
        self.counts.is_some() && self.missed <= limits.lost_cycles
    }

    /// Whether its length can be believed now.
    pub fn is_sound(&self, limits: &Limits) -> bool {
        self.is_alive(limits) && !self.has_failed
    }

    /// m, and m/s while values come; nothing is carried on.
    pub fn last_measured(&self) -> (f64, f64) {
        (self.true_length, if self.missed == 0 { self.rate } else { 0.0 })
    }

    /// Once a cycle. `cable` counts from 1.
    pub fn update(
        &mut self,
        cable: usize,
        winch: &Winch,
        limits: &Limits,
        now: Nanoseconds,
    ) -> Result<(), Fault> {
        let result = self.take_in(cable, winch, limits, now);
        self.has_failed |= !matches!(result, Ok(()) | Err(Fault::EncoderSilent { .. }));
        result
    }

    /// One that was silent for so long may have counted from elsewhere since.
    pub fn give_up(&mut self, now: Nanoseconds, patience: Nanoseconds) {
        self.has_failed |= now.saturating_sub(self.time) > patience;
    }

    fn take_in(
        &mut self,
        cable: usize,
        winch: &Winch,
        limits: &Limits,
        now: Nanoseconds,
    ) -> Result<(), Fault> {
        let arrived = self.arrived.take();
        let dt = now.saturating_sub(self.time).max(1) as f64 * 1e-9;
        self.has_changed = arrived.map(|counts| Some(counts) != self.counts);
        self.is_frozen = self.has_changed == Some(false) && self.rate.abs() > limits.freeze_speed;
        let believed = arrived.filter(|_| !self.is_frozen);
        let Some(counts) = believed else {
            self.missed = self.missed.saturating_add(1);
            self.length = self.true_length + self.rate * dt;
            return match (self.missed > limits.lost_cycles, self.is_frozen) {
                (false, _) => Ok(()),
                (true, true) => Err(Fault::EncoderFrozen { cable }),
                (true, false) => Err(Fault::EncoderSilent { cable }),
            };
        };
        let length = self.home_length + winch.lengthening(counts, self.reference);
        let speed = if self.counts.is_some() { (length - self.true_length) / dt } else { 0.0 };
        (self.counts, self.time, self.missed) = (Some(counts), now, 0);
        (self.length, self.true_length, self.rate) = (length, length, speed);
        if speed.abs() <= limits.cable_speed { Ok(()) } else { Err(Fault::EncoderJump { cable, speed }) }
    }
}

/// The load cell of one cable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellMonitor {
    arrived: Option<Result<Reading, ReadingError>>,
    /// The last good reading.
    reading: Option<Reading>,
    /// A reading that could not be, N.
    absurd: Option<f64>,
    /// The tension commanded when the reading last changed, N.
    commanded: f64,
    /// Cycles in which the reading should have changed.
    stuck: u32,
    /// Cycles in which it disagreed, and in which it said too much.
    disagreed: u32,
    exceeded: u32,
    /// Cycles since the last good reading.
    pub missed: u32,
}

impl CellMonitor {
    /// Takes in a reading; the newest of a cycle counts.
    pub fn receive(&mut self, reading: Result<Reading, ReadingError>) {
        self.arrived = Some(reading);
    }

    /// N; 0 before the first reading.
    pub fn tension(&self) -> f64 {
        self.reading.map_or(0.0, |reading| reading.tension)
    }

    /// Whether a good reading came in time.
    pub fn is_alive(&self, limits: &Limits) -> bool {
        self.reading.is_some() && self.missed <= limits.lost_cycles
    }

    /// Whether it agrees with the motor now.
    pub fn agrees(&self) -> bool {
        self.disagreed == 0
    }

    /// Once a cycle, with the tension commanded (N) in the cycle before. `cable` counts from 1.
    pub fn update(&mut self, cable: usize, limits: &Limits, commanded: f64) -> Result<(), Fault> {
        match self.arrived.take() {
            Some(Ok(reading)) => {
                if self.reading.is_none_or(|last| last.bits != reading.bits) {
                    (self.commanded, self.stuck) = (commanded, 0);
                }
                (self.reading, self.absurd, self.missed) = (Some(reading), None, 0);
            }
            Some(Err(ReadingError::Range { tension })) => {
                (self.absurd, self.missed) = (Some(tension), self.missed.saturating_add(1));
            }
            Some(Err(ReadingError::Short)) | None => self.missed = self.missed.saturating_add(1),
        }
        self.stuck =
            if (commanded - self.commanded).abs() > limits.stuck { self.stuck.saturating_add(1) } else { 0 };
        let is_off = (self.tension() - commanded).abs() > limits.disagreement;
        self.disagreed = if is_off { self.disagreed.saturating_add(1) } else { 0 };
        let is_above = self.tension() - commanded > limits.disagreement;
        self.exceeded = if is_above { self.exceeded.saturating_add(1) } else { 0 };
        match self.absurd {
            Some(tension) if self.missed > limits.lost_cycles => {
                Err(Fault::LoadCellAbsurd { cable, tension })
            }
            None if self.missed > limits.lost_cycles => Err(Fault::LoadCellSilent { cable }),
            _ if self.stuck > limits.lost_cycles => Err(Fault::LoadCellStuck { cable }),
            _ => Ok(()),
        }
    }

    /// A fault if it said more than its motor pulls for longer than `cycles`: less may be a cable that is not taut yet.
    pub fn excess(&self, cable: usize, commanded: f64, cycles: u32) -> Result<(), Fault> {
        if self.exceeded <= cycles {
            return Ok(());
        }
        Err(Fault::LoadCellDisagrees { cable, measured: self.tension(), commanded })
    }

    /// A fault if it disagreed for longer than `cycles`.
    pub fn disagreement(&self, cable: usize, commanded: f64, cycles: u32) -> Result<(), Fault> {
        if self.disagreed <= cycles {
            return Ok(());
        }
        Err(Fault::LoadCellDisagrees { cable, measured: self.tension(), commanded })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::{AKD, parse};

    const PERIOD: u64 = 4_000_000;

    fn setup() -> (Winch, Limits) {
        let config = parse(AKD).unwrap();
        (config.drives[0].winch, config.limits)
    }

    /// An encoder at home with 1 m, then moving at `speed` for 50 cycles, and what it still says at the end.
    fn moving(speed: f64) -> (Encoder, u64) {
        let (winch, limits) = setup();
        let mut encoder = Encoder::default();
        encoder.receive(1000);
        encoder.update(1, &winch, &limits, 0).unwrap();
        encoder.home(1.0);
        let mut now = 0;
        for _ in 0..50 {
            now += PERIOD;
            encoder.receive(winch.counts(speed * now as f64 * 1e-9, 1000));
            encoder.update(1, &winch, &limits, now).unwrap();
        }
        (encoder, now)
    }

    #[test]
    fn lengths_follow_the_counts_and_are_carried_on_over_lost_frames() {
        let (winch, limits) = setup();
        let (mut encoder, mut now) = moving(0.2);
        assert!((encoder.length - 1.04).abs() < 1e-5, "{}", encoder.length);
        for k in 1..=limits.lost_cycles {
            now += PERIOD;
            assert_eq!(encoder.update(1, &winch, &limits, now), Ok(()));
            assert!((encoder.length - 1.04 - 0.0008 * f64::from(k)).abs() < 1e-5, "{}", encoder.length);
        }
        assert_eq!(encoder.update(1, &winch, &limits, now + PERIOD), Err(Fault::EncoderSilent { cable: 1 }));
    }

    #[test]
    fn an_encoder_that_stands_still_at_once_is_frozen_but_one_at_rest_is_not() {
        let (winch, limits) = setup();
        let last_fault = |speed: f64| {
            let (mut encoder, mut now) = moving(speed);
            let counts = encoder.counts.unwrap();
            (0..=limits.lost_cycles)
                .map(|_| {
                    now += PERIOD;
                    encoder.receive(counts);
                    encoder.update(1, &winch, &limits, now)
                })
                .last()
                .unwrap()
        };
        assert_eq!(last_fault(0.1), Err(Fault::EncoderFrozen { cable: 1 }));
        assert_eq!(last_fault(0.0), Ok(()));
    }

    #[test]
    fn a_jump_is_seen_at_once_and_a_duplicate_does_nothing() {
        let (winch, limits) = setup();
        let (encoder, now) = moving(0.1);
        let counts = encoder.counts.unwrap();
        let mut jumped = encoder;
        jumped.receive(counts + 10_000);
        let fault = jumped.update(3, &winch, &limits, now + PERIOD).unwrap_err();
        assert!(matches!(fault, Fault::EncoderJump { cable: 3, speed } if speed < -5.0), "{fault}");
        let (mut once, mut twice) = (encoder, encoder);
        once.receive(counts - 160);
        twice.receive(counts - 160);
        twice.receive(counts - 160);
        once.update(1, &winch, &limits, now + PERIOD).unwrap();
        twice.update(1, &winch, &limits, now + PERIOD).unwrap();
        assert_eq!(once.length, twice.length);
    }

    fn good(tension: f64) -> Result<Reading, ReadingError> {
        Ok(Reading { bits: (tension as f32).to_bits(), tension })
    }

    /// The first fault when the cell says what `says` says in each cycle while `commanded` is commanded.
    fn cell_fault(
        says: impl Fn(u32) -> Option<Result<Reading, ReadingError>>,
        commanded: impl Fn(u32) -> f64,
    ) -> Option<(u32, Fault)> {
        let (_, limits) = setup();
        let mut cell = CellMonitor::default();
        cell.receive(good(commanded(0)));
        (0..200).find_map(|k| {
            if let Some(reading) = says(k) {
                cell.receive(reading);
            }
            let result =
                cell.update(2, &limits, commanded(k)).and_then(|()| cell.disagreement(2, commanded(k), 25));
            Some((k, result.err()?))
        })
    }

    #[test]
    fn a_cell_that_is_silent_absurd_stuck_or_off_is_found() {
        let rising = |k: u32| 10.0 + 0.1 * f64::from(k);
        assert_eq!(cell_fault(|k| Some(good(rising(k))), rising), None);
        assert_eq!(cell_fault(|_| Some(good(10.0)), |_| 10.0), None, "at rest");
        let silent = |k| (k < 50).then(|| good(10.0));
        assert_eq!(cell_fault(silent, |_| 10.0), Some((54, Fault::LoadCellSilent { cable: 2 })));
        let absurd = |k| Some(if k < 50 { good(10.0) } else { Err(ReadingError::Range { tension: 1e6 }) });
        assert_eq!(
            cell_fault(absurd, |_| 10.0),
            Some((54, Fault::LoadCellAbsurd { cable: 2, tension: 1e6 }))
        );
        let one_glitch =
            |k| Some(if k == 50 { Err(ReadingError::Range { tension: 1e6 }) } else { good(10.0) });
        assert_eq!(cell_fault(one_glitch, |_| 10.0), None);
        assert_eq!(cell_fault(|_| Some(good(10.0)), rising), Some((20, Fault::LoadCellStuck { cable: 2 })));
        let off = |k: u32| Some(good(if k < 50 { 10.0 } else { 15.0 + 0.01 * f64::from(k) }));
        assert!(matches!(cell_fault(off, |_| 10.0), Some((75, Fault::LoadCellDisagrees { cable: 2, .. }))));
    }
}
