//! Taking up slack on the stand: the pretension in all cables, then in one after the other twice of it. A load cell that is dead,
//! scaled wrongly or that of another cable does not say what its own motor pulls.

use super::output::blend;
use super::{Bridge, Fault, Mode};
use crate::Nanoseconds;
use crate::cia402::DriveState;
use cable_robot::robot::PerCable;

/// To the pretension (0), then cable 1 to n pulls twice of it, then (n + 1) back to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SlackStep {
    number: usize,
    begun: Nanoseconds,
    /// Cycles in a row in which all load cells agreed.
    calm: u32,
}

impl SlackStep {
    /// Whether cables may be slack still.
    pub fn is_first(&self) -> bool {
        self.number == 0
    }
}

impl Bridge {
    /// What is pulled, N.
    pub(super) fn slack_pull(&self, step: &SlackStep) -> PerCable<f64> {
        let from = match step.number {
            0 => PerCable::filled(self.cables(), 0.0),
            number => self.slack_tension(number - 1),
        };
        let share = self.share(step.begun, self.slack_ramp(step.number));
        blend(&from, &self.slack_tension(step.number), share)
    }

    /// At the end of a step, N.
    fn slack_tension(&self, number: usize) -> PerCable<f64> {
        let pretension = self.config.slack.pretension;
        PerCable::from_fn(self.cables(), |i| if i + 1 == number { 2.0 * pretension } else { pretension })
    }

    /// Of the tension of a cable that pulls twice of the pretension, and back, N a cycle.
    pub(super) fn slack_slope(&self) -> f64 {
        self.config.slack.pretension * self.config.period as f64 / self.slack_ramp(1) as f64
    }

    /// Whether the tension of a cable rises or falls steadily, and has for half of its ramp.
    pub(super) fn steady_change(&self, cable: usize) -> Option<bool> {
        let Mode::TakingUpSlack { step: Some(step), .. } = self.mode else { return None };
        let share = self.share(step.begun, self.slack_ramp(step.number));
        let is_steady = (0.5..1.0).contains(&share);
        match step.number.checked_sub(cable + 1)? {
            0 if is_steady => Some(true),
            1 if is_steady => Some(false),
            _ => None,
        }
    }

    /// With the slack gone, a quarter of the time does.
    fn slack_ramp(&self, number: usize) -> Nanoseconds {
        if number == 0 { self.config.slack.ramp } else { self.config.slack.ramp / 4 }
    }

    pub(super) fn take_up_slack(&mut self, since: Nanoseconds, step: Option<SlackStep>) {
        let Some(step) = step else { return self.await_drives(since) };
        if let Some(fault) = self.loose_cable() {
            return self.fail(fault);
        }
        let elapsed = self.time.saturating_sub(step.begun);
        let Some(settling) = elapsed.checked_sub(self.slack_ramp(step.number)) else { return };
        let disagreeing = (0..self.cables()).find(|i| !self.cells[*i].agrees());
        let calm = if disagreeing.is_none() { step.calm + 1 } else { 0 };
        self.mode = Mode::TakingUpSlack { since, step: Some(SlackStep { calm, ..step }) };
        if calm > self.config.cycles(self.config.limits.disagreement_time) {
            self.end_slack_step(since, step.number);
        } else if let (Some(i), true) = (disagreeing, settling > self.config.slack.ramp) {
            let (measured, commanded) = (self.cells[i].tension(), self.commanded[i]);
            self.fail(Fault::LoadCellDisagrees { cable: i + 1, measured, commanded });
        }
    }

    fn await_drives(&mut self, since: Nanoseconds) {
        let is_enabled = |i: usize| self.drives[i].state == Some(DriveState::OperationEnabled);
        let waiting = (0..self.cables()).find(|i| !is_enabled(*i) || !self.followers[*i].shows_mode());
        match waiting {
            None => {
                if let Some(fault) = self.slow_drive(0..self.cables()) {
                    return self.fail(fault);
                }
                let step = Some(SlackStep { begun: self.time, ..SlackStep::default() });
                self.mode = Mode::TakingUpSlack { since, step };
            }
            Some(i) if self.time.saturating_sub(since) > self.config.timeouts.drive => {
                if is_enabled(i) {
                    let (node, found) = (self.config.drives[i].node, self.followers[i].mode());
                    self.fail(Fault::ModeRefused { node, found });
                } else {
                    self.fail_drive_stuck(i);
                }
            }
            Some(_) => {}
        }
    }

    fn loose_cable(&self) -> Option<Fault> {
        let moved = |i: usize| self.home_length[i] - self.drives[i].encoder.length;
        let i = (0..self.cables()).find(|i| moved(*i).abs() > self.config.slack.most)?;
        Some(Fault::LooseCable { cable: i + 1, length: moved(i) })
    }

    fn end_slack_step(&mut self, since: Nanoseconds, number: usize) {
        if number <= self.cables() {
            let step = Some(SlackStep { number: number + 1, begun: self.time, calm: 0 });
            self.mode = Mode::TakingUpSlack { since, step };
        } else if let Some(fault) = self.late_drive() {
            self.fail(fault);
        } else {
            // Only now the cables are taut, and as long as they are at the home pose.
            self.take_references();
            self.enter(Mode::Ready);
        }
    }
}
