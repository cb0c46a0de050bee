//! How soon each drive shows what a control word does: the age of all that it is told and that is heard of it, before
//! any torque. A power stage may take its time for a transition, so the least of them counts.

use super::{Bridge, Fault};
use crate::Nanoseconds;
use crate::cia402::DriveState;

/// The control word that a drive is sent, and what it made of those before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reaction {
    word: u16,
    /// When that was first sent.
    since: Nanoseconds,
    /// Where it leads the drive from where that was; nowhere once it is there.
    awaited: Option<DriveState>,
    /// Whether the answer to a word before may be still on its way.
    is_doubtful: bool,
    /// From a word to the status word that showed its transition, since the drive was last led up.
    least: Option<Nanoseconds>,
}

impl Reaction {
    /// The drive is led up from now on.
    pub fn begin(&mut self) {
        self.least = None;
    }

    /// What is sent at `now` to a drive in this state. A word that was in effect already shows nothing; one that stood
    /// for `patience` has been answered.
    pub fn command(&mut self, word: u16, state: Option<DriveState>, now: Nanoseconds, patience: Nanoseconds) {
        if word == self.word {
            return;
        }
        let has_stood = now.saturating_sub(self.since) > patience;
        self.is_doubtful = !has_stood && (self.is_doubtful || self.awaited.is_some());
        let awaited = state.and_then(|state| state.after(word));
        (self.word, self.since, self.awaited) = (word, now, awaited);
    }

    /// What its status word says at `now`.
    pub fn show(&mut self, state: DriveState, now: Nanoseconds) {
        if self.awaited != Some(state) {
            return;
        }
        self.awaited = None;
        let time = now.saturating_sub(self.since);
        if !self.is_doubtful {
            self.least = Some(self.least.map_or(time, |least| least.min(time)));
        }
    }
}

impl Bridge {
    /// Takes in the status words of this cycle.
    pub(super) fn watch_reactions(&mut self) {
        for (drive, reaction) in self.drives.iter().zip(&mut self.reactions) {
            if let Some(state) = drive.state {
                reaction.show(state, self.time);
            }
        }
    }

    /// Of these drives (from 0) one that shows no transition in time. Of one of which none was measured, because the
    /// operator was quicker than it, torque tells later.
    pub(super) fn slow_drive(&self, mut cables: impl Iterator<Item = usize>) -> Option<Fault> {
        let most = (self.config.limits.latency * self.config.period as f64) as Nanoseconds;
        cables.find_map(|i| {
            let time = self.reactions[i].least.filter(|least| *least > most)?;
            Some(Fault::SlowReaction { node: self.config.drives[i].node, time, most })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cia402::control::*;
    use DriveState::*;

    const MS: Nanoseconds = 1_000_000;
    const PATIENCE: Nanoseconds = 3000 * MS;

    /// At each time (ms) a state is heard, and a word sent in return. The least time of a transition after the last.
    fn least(steps: &[(Nanoseconds, DriveState, u16)]) -> Option<Nanoseconds> {
        let mut reaction = Reaction::default();
        for (time, state, word) in steps {
            let now = 10_000 * MS + time * MS;
            reaction.show(*state, now);
            reaction.command(*word, Some(*state), now, PATIENCE);
        }
        reaction.least.map(|least| least / MS)
    }

    #[test]
    fn the_quickest_transition_counts_and_a_slow_power_stage_does_not() {
        let steps = [
            (0, SwitchOnDisabled, SHUTDOWN),
            (4, SwitchOnDisabled, SHUTDOWN),
            (8, ReadyToSwitchOn, SWITCH_ON),
            (108, SwitchedOn, ENABLE_OPERATION),
            (208, OperationEnabled, ENABLE_OPERATION),
        ];
        assert_eq!(least(&steps), Some(8));
    }

    #[test]
    fn a_word_that_was_in_effect_already_shows_nothing() {
        // It stood because of another drive in the same frame.
        let steps = [(0, NotReadyToSwitchOn, SHUTDOWN), (40, SwitchOnDisabled, SHUTDOWN)];
        assert_eq!(least(&[&steps[..], &[(41, ReadyToSwitchOn, SWITCH_ON)]].concat()), None);
    }

    /// Over a link with 60 ms there and back: pressed, let go, pressed again.
    #[test]
    fn the_late_answer_to_a_word_that_was_taken_back_is_not_taken_for_a_quick_one() {
        let taken_back = [
            (0, SwitchOnDisabled, SHUTDOWN),
            (8, SwitchOnDisabled, DISABLE_VOLTAGE),
            (50, SwitchOnDisabled, SHUTDOWN),
            (60, ReadyToSwitchOn, SWITCH_ON),
        ];
        assert_eq!(least(&taken_back), None);
        let later = [(3100, SwitchOnDisabled, SHUTDOWN), (3160, ReadyToSwitchOn, SWITCH_ON)];
        assert_eq!(least(&[&taken_back[..2], &later].concat()), Some(60));
    }
}
