//! Whether each drive does what it is commanded: its torque, the bits of its status word, its mode of operation.

use super::{Bridge, Fault, FrameQueue, Mode};
use crate::Nanoseconds;
use crate::canopen::{SdoRequest, SdoResponse, SdoResult};
use crate::cia402::{CYCLIC_TORQUE, DriveState, MODE_DISPLAY, status};
use crate::config::MOST_LOST_CYCLES;

/// Cycles from a command to the sample that shows it: taken over at one SYNC, sampled at the next, and behind by the motor's lag.
const WAY: usize = 3;

/// What one drive was commanded of late, and what it says that it does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follower {
    /// The latest commands, ‰ of the rated torque, and where the next goes.
    commanded: [i16; MOST_LOST_CYCLES as usize + WAY],
    next: usize,
    /// Its torque and its status word since the last cycle.
    arrived: Option<(i16, u16)>,
    /// Bits of [`EXPECTED`] that it has shown since it was enabled: not every drive has them.
    shown: u16,
    /// Cycles in a row in which a bit was not as it should be.
    odd: u32,
    /// Its mode of operation, as it was shown last.
    mode: Option<i8>,
    /// How far its torque was behind the command, away from zero, while that rose and while it fell: sums (‰) and their terms.
    behind: [(f64, f64); 2],
}

/// Bits that an enabled drive shows.
const EXPECTED: u16 = status::REMOTE | status::FOLLOWS;

impl Follower {
    pub fn new() -> Self {
        Self {
            commanded: [0; MOST_LOST_CYCLES as usize + WAY],
            next: 0,
            arrived: None,
            shown: 0,
            odd: 0,
            mode: None,
            behind: [(0.0, 0.0); 2],
        }
    }

    /// What is sent in a cycle, ‰.
    pub fn command(&mut self, torque: i16) {
        self.commanded[self.next] = torque;
        self.next = (self.next + 1) % self.commanded.len();
    }

    pub fn receive(&mut self, torque: i16, status: u16) {
        self.arrived = Some((torque, status));
    }

    /// What between the least and the greatest of so many commands (‰) is nearest to this torque: a motor may be on its way from one to another.
    fn nearest(&self, torque: i16, window: usize) -> i16 {
        let of_late = (1..=window)
            .map(|k| self.commanded[(self.next + self.commanded.len() - k) % self.commanded.len()]);
        let (least, greatest) = of_late.fold((i16::MAX, i16::MIN), |(a, b), one| (a.min(one), b.max(one)));
        torque.clamp(least, greatest)
    }

    /// Whether it is in the mode in which it follows torques.
    pub fn shows_mode(&self) -> bool {
        self.mode == Some(CYCLIC_TORQUE as i8)
    }

    /// What it shows in place of that.
    pub fn mode(&self) -> i8 {
        self.mode.unwrap_or(0)
    }

    /// Begins to measure how far its torque is behind.
    pub fn forget_delay(&mut self) {
        self.behind = [(0.0, 0.0); 2];
    }

    /// A torque while the command changes steadily.
    fn take_delay(&mut self, torque: i16, is_rising: bool) {
        let commanded = self.commanded[(self.next + self.commanded.len() - 1) % self.commanded.len()];
        let (sum, terms) = &mut self.behind[usize::from(is_rising)];
        (*sum, *terms) = (*sum + f64::from(commanded) - f64::from(torque), *terms + 1.0);
    }

    /// Cycles between a command and the torque, if commands rose and fell by `slope` (‰ a cycle). What the torque is always off by cancels.
    fn delay(&self, slope: f64) -> Option<f64> {
        let [fall, rise] = self.behind.map(|(sum, terms)| (terms > 0.0).then(|| sum / terms));
        Some((rise? - fall?) / (2.0 * slope))
    }

    /// Bits that are not as they should be.
    fn odd_bits(&mut self, status: u16) -> u16 {
        self.shown |= status & EXPECTED;
        self.shown & !status | status & status::INTERNAL_LIMIT
    }
}

/// Which drive is asked next for its mode of operation, and when.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ModeQuestion {
    cable: usize,
    due: Nanoseconds,
}

impl Bridge {
    /// Torques and status words of this cycle. A drive that is not in Operation enabled is another's affair.
    pub(super) fn watch_followers(&mut self) {
        let limits = self.config.limits;
        let window = limits.lost_cycles as usize + WAY;
        for i in 0..self.cables() {
            let Some((torque, status)) = self.followers[i].arrived.take() else { continue };
            let monitor = &self.drives[i];
            if !self.is_led(i) || monitor.has_left || monitor.state != Some(DriveState::OperationEnabled) {
                (self.followers[i].shown, self.followers[i].odd) = (0, 0);
                continue;
            }
            if let Some(is_rising) = self.steady_change(i) {
                self.followers[i].take_delay(torque, is_rising);
            }
            let (cable, winch) = (i + 1, self.config.drives[i].winch);
            let commanded = self.followers[i].nearest(torque, window);
            let newtons = |torque: i16| winch.tension(torque);
            // Both are whole per mille.
            let is_off = (newtons(torque) - newtons(commanded)).abs() > limits.torque_error;
            // On the stand nothing hangs on it, and what is late is measured.
            let is_on_stand = matches!(self.mode, Mode::TakingUpSlack { .. });
            if is_off && torque.abs_diff(commanded) > 1 && !is_on_stand {
                let (actual, commanded) = (newtons(torque), newtons(commanded));
                self.raise(Fault::TorqueNotFollowed { cable, actual, commanded });
            }
            let bits = self.followers[i].odd_bits(status);
            let odd = if bits == 0 { 0 } else { self.followers[i].odd + 1 };
            self.followers[i].odd = odd;
            if odd > limits.lost_cycles {
                self.raise(Fault::DriveDisobeys { node: self.config.drives[i].node, bits });
            }
        }
    }

    /// From the command of a torque to the motor's word that it gives it, if that takes longer than allowed. The encoder's way is part of it:
    /// what the controller hears is as late as what it says.
    pub(super) fn late_drive(&self) -> Option<Fault> {
        (0..self.cables()).find_map(|i| {
            let winch = &self.config.drives[i].winch;
            let periods = self.followers[i]
                .delay(winch.direction * self.slack_slope() / winch.newtons_per_permille())?;
            let most = self.config.limits.latency;
            (periods > most).then_some(Fault::Late { cable: i + 1, periods, most })
        })
    }

    /// Asks one drive after the other, one a heartbeat, for its mode: that is not in the frames of a cycle.
    pub(super) fn ask_for_mode(&mut self, out: &mut FrameQueue) {
        let awaits_drives = matches!(self.mode, Mode::TakingUpSlack { step: None, .. });
        if !(awaits_drives || self.is_pulling()) || self.time < self.mode_question.due {
            return;
        }
        // Some drives show it only once they are enabled.
        let hidden = (0..self.cables()).find(|i| !self.followers[*i].shows_mode());
        let cable = hidden.unwrap_or(self.mode_question.cable % self.cables());
        let drive = &self.config.drives[cable];
        out.push(drive.bus, SdoRequest::Read(MODE_DISPLAY).frame(drive.node));
        self.mode_question = ModeQuestion { cable: cable + 1, due: self.time + self.config.heartbeat.period };
    }

    /// A drive that has another mode of operation than it is to have does not follow torques.
    pub(super) fn on_mode(&mut self, node: crate::canopen::Node, response: &SdoResponse) {
        let found = match response.result {
            SdoResult::Value(value) => value.bits as u8 as i8,
            SdoResult::Unsized([mode, ..]) => mode as i8,
            SdoResult::Written | SdoResult::Segmented(_) | SdoResult::Aborted(_) => return,
        };
        let drive = self.config.drives.iter().position(|drive| drive.node == node);
        let Some(i) = drive.filter(|_| response.object == MODE_DISPLAY) else { return };
        self.followers[i].mode = Some(found);
        if self.is_pulling() && !self.followers[i].shows_mode() {
            self.raise(Fault::ModeLeft { node, found });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_told_of_late_may_be_followed_and_what_is_older_not() {
        let mut follower = Follower::new();
        (0..200).for_each(|k| follower.command(10 * k));
        assert_eq!(follower.nearest(1990, 5), 1990);
        assert_eq!(follower.nearest(1952, 5), 1952);
        assert_eq!(follower.nearest(1900, 5), 1950, "the oldest of five");
    }

    #[test]
    fn a_delay_is_measured_whatever_the_torque_is_always_off_by() {
        let mut follower = Follower::new();
        for k in 0..100i16 {
            follower.command(2 * k);
            follower.take_delay(2 * (k - 3) + 9, true);
        }
        for k in 0..100i16 {
            follower.command(200 - 2 * k);
            follower.take_delay(200 - 2 * (k - 3) + 9, false);
        }
        assert_eq!(follower.delay(2.0), Some(3.0));
    }

    #[test]
    fn a_bit_that_a_drive_never_shows_is_not_missed() {
        let mut follower = Follower::new();
        assert_eq!(follower.odd_bits(status::REMOTE), 0);
        assert_eq!(follower.odd_bits(status::REMOTE | status::FOLLOWS), 0);
        assert_eq!(follower.odd_bits(status::REMOTE), status::FOLLOWS);
        assert_eq!(follower.odd_bits(0xFFFF), status::INTERNAL_LIMIT);
    }
}
