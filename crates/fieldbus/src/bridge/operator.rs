//! From state to state: what the operator asks, what time and nodes bring about, and what a fault does.

use super::state::{Cause, Event, OperatorCommand, Refusal, State};
use super::weigh::Lift;
use super::{Bridge, CellMonitor, DriveMonitor, Fault, Follower, FrameQueue, Mode, Reaction, Trial};
use crate::Nanoseconds;
use crate::cia402::DriveState;
use cable_robot::robot::Pose;

/// Whether there is something to reset.
fn is_reset_from(mode: &Mode) -> bool {
    !matches!(
        mode,
        Mode::Listening { .. } | Mode::Quieting { .. } | Mode::Configuring | Mode::Off | Mode::Shadow { .. }
    )
}

impl Bridge {
    /// Takes in what the operator asks for at `now`.
    ///
    /// # Errors
    /// [`Refusal`]: why it is not done.
    pub fn operator(&mut self, command: OperatorCommand, now: Nanoseconds) -> Result<(), Refusal> {
        let now = now + self.offset;
        let refusal = Refusal::State { command, state: self.state() };
        match (command, self.mode) {
            (OperatorCommand::Goal(goal), _) if !goal.0.iter().all(|x| x.is_finite()) => {
                return Err(Refusal::Goal(goal));
            }
            (OperatorCommand::Goal(goal), Mode::Enabled { .. } | Mode::Shadow { .. }) => {
                if let Some((axis, at)) = self.outside(&goal) {
                    return Err(Refusal::OutOfBox { axis: b"xyz"[axis].into(), at });
                }
                self.goal = goal;
            }
            (OperatorCommand::Home, Mode::Homing { .. }) if self.is_home_stale => {
                return Err(Refusal::StillPressed);
            }
            (OperatorCommand::Home, Mode::Homing { .. }) => return self.begin_homing(now),
            (OperatorCommand::Home, Mode::TakingUpSlack { .. } | Mode::Ready) => self.home_given = now,
            (OperatorCommand::Enable, Mode::Enabled { since, from, lifted, .. }) => {
                self.mode = Mode::Enabled { since, from, lifted, confirmed: now };
            }
            (OperatorCommand::Pull(cable), Mode::Homing { .. } | Mode::Trying(Trial::Pull { .. }))
                if self.is_survey && cable < self.cables() =>
            {
                return self.pull(cable, now);
            }
            (OperatorCommand::Jog(cable, direction), Mode::Homing { .. } | Mode::Jogging(_))
                if cable < self.cables() =>
            {
                return self.jog(cable, direction, now);
            }
            (OperatorCommand::Weigh, Mode::Ready | Mode::Trying(Trial::Weigh { .. })) if self.is_survey => {
                return self.weigh(now);
            }
            (OperatorCommand::Zero, Mode::Homing { .. }) if self.is_survey => return self.zero(now),
            (OperatorCommand::TryWatchdog, Mode::Homing { .. }) if self.is_survey => {
                return self.try_watchdog(now);
            }
            (OperatorCommand::Placed(pose), Mode::Ready) if self.is_survey => return self.note_placing(pose),
            (OperatorCommand::Enable, Mode::Ready | Mode::Safe(Some(_))) if self.is_survey => {
                return Err(refusal);
            }
            (OperatorCommand::Enable, Mode::Ready | Mode::Safe(Some(_))) if self.is_released => {
                return self.enable(now);
            }
            (OperatorCommand::Enable, Mode::Ready | Mode::Safe(Some(_))) => {
                return Err(Refusal::StillPressed);
            }
            // A button that is pressed too early does nothing later either.
            (OperatorCommand::Enable, _) => {
                self.is_released = false;
                return Err(refusal);
            }
            (OperatorCommand::Release, _) => {
                (self.is_released, self.is_home_stale) = (true, false);
                if matches!(self.mode, Mode::Enabled { .. }) || self.pulls_on_stand() {
                    self.come_down(Cause::Released);
                } else if let Mode::Trying(Trial::Weigh { given, share, .. }) = self.mode {
                    self.mode = Mode::Trying(Trial::Weigh { given, share, lift: Lift::Down });
                }
            }
            (OperatorCommand::Lower, _) => {
                (self.is_released, self.is_home_stale) = (true, false);
                if self.hangs() || self.pulls_on_stand() {
                    self.come_down(Cause::Lower);
                }
            }
            (OperatorCommand::Reset, mode) if is_reset_from(&mode) => {
                self.is_reset_due = true;
                self.come_down(Cause::Reset);
            }
            (OperatorCommand::Shutdown, _) => {
                self.is_shutting_down = true;
                self.come_down(Cause::Shutdown);
            }
            _ => return Err(refusal),
        }
        Ok(())
    }

    /// Whether motors pull, the platform on its stand, and are switched off by whoever lets go.
    fn pulls_on_stand(&self) -> bool {
        matches!(
            self.mode,
            Mode::TakingUpSlack { .. } | Mode::Ready | Mode::Trying(Trial::Pull { .. }) | Mode::Jogging(_)
        )
    }

    pub(super) fn enter(&mut self, mode: Mode) {
        self.mode = mode;
        let state = self.state();
        self.events.push(self.time, Event::Entered(state));
    }

    /// The platform is at the home pose: every cable has its length there.
    fn begin_homing(&mut self, now: Nanoseconds) -> Result<(), Refusal> {
        let limits = self.config.limits;
        for i in 0..self.cables() {
            let (cable, node) = (i + 1, self.config.drives[i].node);
            let missing = match self.drives[i].state {
                _ if !self.drives[i].encoder.is_alive(&limits) => Some(Fault::EncoderSilent { cable }),
                _ if !self.cells[i].is_alive(&limits) => Some(Fault::LoadCellSilent { cable }),
                // Nothing pulls yet: what a cell says of that is what it will be wrong by.
                _ if !self.cells[i].agrees() => self.cells[i].disagreement(cable, 0.0, 0).err(),
                Some(state) if state.is_faulted() => Some(Fault::DriveFault { node, state }),
                _ => None,
            };
            if let Some(fault) = missing {
                return Err(Refusal::NotYet(fault));
            }
        }
        self.take_references();
        self.home_given = now;
        self.followers.iter_mut().for_each(Follower::forget_delay);
        self.reactions.iter_mut().for_each(Reaction::begin);
        self.enter(Mode::TakingUpSlack { since: now, step: None });
        Ok(())
    }

    fn is_everything_alive(&self) -> bool {
        let limits = &self.config.limits;
        self.drives.iter().all(|drive| drive.encoder.is_alive(limits))
            && self.cells.iter().all(|cell| cell.is_alive(limits))
    }

    pub(super) fn take_references(&mut self) {
        for i in 0..self.cables() {
            self.drives[i].encoder.home(self.home_length[i]);
        }
        // What was remembered of lengths was said of others.
        let lengths = self.lengths();
        self.still_since.fill(lengths);
        self.pose = self.config.home;
    }

    fn enable(&mut self, now: Nanoseconds) -> Result<(), Refusal> {
        for i in 0..self.cables() {
            let now = self.cells[i].disagreement(i + 1, self.commanded[i], 0);
            now.map_err(Refusal::NotYet)?;
        }
        (self.is_released, self.lowers_at) = (false, None);
        self.certified = self.commanded;
        let at = self.pose.position();
        self.goal = Pose::at(at.x, at.y, at.z);
        let lifted = self.gravity_hold(&self.pose);
        self.enter(Mode::Enabled { since: now, from: self.commanded, lifted, confirmed: now });
        Ok(())
    }

    /// Everything anew; the drives lose their torque. Who never was alone on the buses listens once more.
    pub(super) fn reset(&mut self) {
        (self.is_running, self.is_reset_due) = (false, false);
        self.is_resetting_drives = true;
        (self.is_released, self.is_home_stale) = (true, false);
        (self.pending, self.reported_faults, self.fault) = Default::default();
        self.drives.fill(DriveMonitor::default());
        self.cells.fill(CellMonitor::default());
        self.followers.fill(Follower::new());
        self.reactions.fill(Reaction::default());
        let since = self.time;
        self.enter(if self.has_spoken { Mode::Quieting { since } } else { Mode::Listening { since } });
    }

    /// What time and nodes bring about when nothing is wrong.
    pub(super) fn proceed(&mut self, out: &mut FrameQueue) {
        match self.mode {
            Mode::Shadow { is_homed: false } if self.is_everything_alive() => {
                self.take_references();
                self.mode = Mode::Shadow { is_homed: true };
            }
            Mode::Listening { since } => self.listen(since),
            Mode::Quieting { since } => self.quiet(since),
            Mode::Configuring => self.configure(out),
            Mode::Homing { since } => self.reset_drives(since),
            Mode::TakingUpSlack { .. }
                if self.time.saturating_sub(self.home_given) > self.config.timeouts.enable =>
            {
                self.is_home_stale = true;
                self.come_down(Cause::EnableExpired);
            }
            Mode::Trying(trial) => self.try_out(trial, out),
            Mode::Jogging(jog) => self.go_on_jogging(jog),
            Mode::TakingUpSlack { since, step } => self.take_up_slack(since, step),
            Mode::Enabled { confirmed, .. }
                if self.time.saturating_sub(confirmed) > self.config.timeouts.enable =>
            {
                self.come_down(Cause::EnableExpired);
            }
            _ => self.go_on_down(),
        }
    }

    fn configure(&mut self, out: &mut FrameQueue) {
        let (time, timeouts) = (self.time, self.config.timeouts);
        for k in 0..self.peers.len() {
            let bus = self.peers[k].bus;
            match self.peers[k].startup.next(time, &timeouts) {
                Ok(frame) => frame.into_iter().for_each(|frame| _ = out.push(bus, frame)),
                Err(fault) => return self.fail(fault),
            }
        }
        if self.peers.iter().all(|peer| peer.startup.is_done()) {
            if let Some(i) = self.exchanged_drive() {
                return self.fail(Fault::AnotherDrive { node: self.config.drives[i].node });
            }
            self.is_running = true;
            self.peers.iter_mut().for_each(|peer| peer.heard = time);
            self.enter(Mode::Homing { since: time });
        }
    }

    /// A drive that is not the one expected.
    fn exchanged_drive(&self) -> Option<usize> {
        let (expected, found) = (self.expected?, self.identities());
        (0..self.cables()).find(|i| expected[*i] != found[*i])
    }

    /// After a reset, and then only, drives are led out of Fault.
    fn reset_drives(&mut self, since: Nanoseconds) {
        if !self.is_resetting_drives || self.drives.iter().any(|drive| drive.state.is_none()) {
            return;
        }
        let faulted = (0..self.cables()).find(|i| self.drives[*i].state.is_some_and(DriveState::is_faulted));
        match faulted {
            None => self.is_resetting_drives = false,
            Some(i) if self.time.saturating_sub(since) > self.config.timeouts.drive => {
                self.fail_drive_stuck(i);
            }
            Some(_) => {}
        }
    }

    pub(super) fn fail_drive_stuck(&mut self, i: usize) {
        let state = self.drives[i].state.unwrap_or(DriveState::NotReadyToSwitchOn);
        self.fail(Fault::DriveStuck { node: self.config.drives[i].node, state });
    }

    pub(super) fn fail(&mut self, fault: Fault) {
        // With the torque off there is nothing left to lose.
        if matches!(self.mode, Mode::Fault(None) | Mode::Off) {
            return;
        }
        if self.reported_faults.insert(fault) {
            self.events.push(self.time, Event::Fault(fault));
        }
        self.fault.get_or_insert(fault);
        if !matches!(self.mode, Mode::Shadow { .. }) {
            self.come_down(Cause::Fault(fault));
        }
    }

    /// Whether the drives are off and may be left alone.
    pub fn is_off(&self) -> bool {
        let is_enabled =
            |state| matches!(state, Some(DriveState::OperationEnabled | DriveState::QuickStopActive));
        self.state() == State::Off && !self.drives.iter().any(|drive| is_enabled(drive.state))
    }
}
