//! What a cycle reads off drives, load cells and nodes, what the controller makes of it, and what is wrong with either.

use super::{Bridge, Fault, Mode, Trial};
use crate::cia402::DriveState;
use crate::config::Limits;
use cable_robot::plan::ControllerInputs;
use cable_robot::robot::{PerCable, forward_kinematics};
use cable_robot::sim::ControllerModel;

impl Bridge {
    /// Whether cables may be under tension by the bridge's doing.
    pub(super) fn is_active(&self) -> bool {
        let is_on_the_way = matches!(
            self.mode,
            Mode::TakingUpSlack { .. }
                | Mode::Stopping { .. }
                | Mode::Safe(_)
                | Mode::Trying(Trial::Pull { .. })
                | Mode::Jogging(_)
        );
        is_on_the_way || self.is_pulling()
    }

    /// Whether the drives are to be in Operation enabled by now.
    pub(super) fn is_pulling(&self) -> bool {
        match self.mode {
            Mode::TakingUpSlack { step, .. } => step.is_some(),
            Mode::Ready | Mode::Enabled { .. } | Mode::Lowering { .. } => true,
            Mode::Trying(trial) => trial.is_lift(),
            Mode::Stopping { to, .. } | Mode::Safe(to) | Mode::Fault(to) => to.is_some(),
            Mode::Listening { .. }
            | Mode::Quieting { .. }
            | Mode::Configuring
            | Mode::Homing { .. }
            | Mode::Jogging(_)
            | Mode::Off
            | Mode::Shadow { .. } => false,
        }
    }

    /// Whether the drive of a cable (from 0) is, alone or with all.
    pub(super) fn is_led(&self, cable: usize) -> bool {
        match self.mode {
            Mode::Jogging(jog) => jog.is_led(cable),
            Mode::Trying(Trial::Pull { cable: pulling, begun: Some(_), .. }) => cable == pulling,
            _ => self.is_pulling(),
        }
    }

    /// Encoders and load cells of this cycle.
    pub(super) fn measure(&mut self) {
        let (mut limits, time, commanded) = (self.config.limits, self.time, self.commanded);
        let patience = self.config.cycles(limits.disagreement_time);
        let bridged = self.config.period * u64::from(limits.lost_cycles + 1);
        let patience_for_good = self.config.heartbeat.timeout.max(bridged);
        // Nothing hangs on what an encoder says while no torque is on: a platform that falls may be fast, and stop at once.
        let has_torque = self.is_pulling();
        let takes_up_slack = matches!(self.mode, Mode::TakingUpSlack { .. });
        // Nor while it hangs and may touch its stand, nor while a person puts it down, who stops it at once.
        if !matches!(self.mode, Mode::Ready | Mode::Enabled { .. }) || self.is_survey {
            limits.freeze_speed = f64::INFINITY;
        }
        let is_first_pull =
            matches!(self.mode, Mode::TakingUpSlack { step: Some(step), .. } if step.is_first());
        // A slack cable stops at once when it is taut, and its load cell says nothing until then.
        if takes_up_slack {
            limits.stuck = f64::INFINITY;
        }
        let is_compared = has_torque && !takes_up_slack && !self.is_on_its_way();
        for i in 0..self.cables() {
            let winch = &self.config.drives[i].winch;
            // Slower than two counts a cycle no encoder tells rest from motion.
            let two_counts = 2.0 * winch.metres_per_count() * 1e9 / self.config.period as f64;
            let of_encoder = Limits { freeze_speed: limits.freeze_speed.max(two_counts), ..limits };
            let encoder = self.drives[i].encoder.update(i + 1, winch, &of_encoder, time);
            let mut cell = self.cells[i].update(i + 1, &limits, commanded[i]);
            if is_compared {
                cell = cell.and_then(|()| self.cells[i].disagreement(i + 1, commanded[i], patience));
            }
            if is_first_pull {
                cell = cell.and_then(|()| self.cells[i].excess(i + 1, commanded[i], patience));
            }
            if has_torque {
                self.drives[i].encoder.give_up(time, patience_for_good);
                self.expect(encoder);
                self.expect(cell);
            }
        }
        if has_torque {
            let frozen = self.compare_encoders(is_compared && !self.is_survey);
            self.expect(frozen);
        }
        self.no_room = if self.had_no_room { self.no_room + 1 } else { 0 };
        self.had_no_room = false;
    }

    /// An encoder that says the same to the last count while another cable moved by `freeze_travel` is frozen. Only what was measured
    /// counts: an encoder that says nothing does not say the same, and a length that is carried on is no motion.
    fn compare_encoders(&mut self, is_compared: bool) -> Result<(), Fault> {
        let lengths = PerCable::from_fn(self.cables(), |i| self.drives[i].encoder.last_measured().0);
        let is_sound = PerCable::from_fn(self.cables(), |i| self.is_sound(i));
        for i in 0..self.cables() {
            let travel = self.config.limits.freeze_travel.max(self.blind_travel(i));
            let encoder = &mut self.drives[i].encoder;
            if encoder.has_changed == Some(true) || !is_compared {
                self.still_since[i] = lengths;
            }
            let moved = |j: usize| (lengths[j] - self.still_since[i][j]).abs();
            let says_the_same = is_sound[i] && encoder.has_changed == Some(false);
            if says_the_same && (0..lengths.len()).any(|j| is_sound[j] && moved(j) > travel) {
                encoder.has_failed = true;
                return Err(Fault::EncoderFrozen { cable: i + 1 });
            }
        }
        Ok(())
    }

    /// So far (m) another cable may move while this one passes from shorter to longer and back within a count: twice what a straight line past
    /// its anchor takes.
    fn blind_travel(&self, i: usize) -> f64 {
        let count = self.config.drives[i].winch.metres_per_count();
        4.0 * (2.0 * self.home_length[i] * count).sqrt()
    }

    pub(super) fn watch_nodes(&mut self) {
        if !(self.is_active() || matches!(self.mode, Mode::Homing { .. })) {
            return;
        }
        let (time, timeout) = (self.time, self.config.heartbeat.timeout);
        for peer in self.peers.iter().filter(|peer| time.saturating_sub(peer.heard) > timeout) {
            self.pending.insert(Fault::HeartbeatLost { node: peer.node });
        }
    }

    pub(super) fn watch_drives(&mut self) {
        for i in 0..self.cables() {
            if !self.is_led(i) {
                continue;
            }
            let node = self.config.drives[i].node;
            match self.drives[i].state {
                Some(DriveState::OperationEnabled) | None => {}
                Some(state) if state.is_faulted() => self.raise(Fault::DriveFault { node, state }),
                Some(state) => self.raise(Fault::DriveLeft { node, state }),
            }
        }
    }

    /// The pose of the lengths, from Ready on.
    pub(super) fn follow_pose(&mut self) {
        let is_followed = match self.mode {
            Mode::TakingUpSlack { .. } => false,
            Mode::Shadow { is_homed } => is_homed,
            Mode::Ready => !self.is_survey,
            _ => self.is_pulling(),
        };
        self.measured_pose = None;
        let limits = self.config.limits;
        let is_measured = (0..self.cables()).all(|i| self.is_sound(i));
        // A length that nobody believes belongs to no pose; a shadow computes what the controller would, whatever comes.
        let is_shadow = matches!(self.mode, Mode::Shadow { .. });
        let is_well = self.pending.is_empty() && (is_shadow || self.lost_encoders() == 0);
        if !is_followed || !(is_well || is_measured) {
            return;
        }
        match forward_kinematics(&self.config.rig, &self.lengths(), &self.pose) {
            Ok(found) => {
                self.measured_pose = is_measured.then_some(found.pose);
                let angle = found.pose.angles().amax();
                if angle <= limits.tilt {
                    self.pose = found.pose;
                    self.watch_box();
                } else {
                    self.raise(Fault::Tilted { angle });
                }
            }
            Err(_) => self.raise(Fault::NoPose),
        }
    }

    pub(super) fn lengths(&self) -> PerCable<f64> {
        PerCable::from_fn(self.cables(), |i| self.drives[i].encoder.length)
    }

    /// Steps the controller, which only follows until the weight is its own.
    pub(super) fn ask(&mut self, controller: &mut dyn ControllerModel) {
        let enable = match self.mode {
            Mode::Enabled { since, .. } => self.time.saturating_sub(since) >= self.config.safe.ramp,
            Mode::Shadow { .. } => true,
            _ => false,
        };
        let inputs = ControllerInputs {
            encoder_pose: self.pose,
            cable_length: self.lengths(),
            // A shadow moves nothing: against load cells that answer another's tensions its force loop would wind up.
            measured_tension: match self.mode {
                Mode::Shadow { .. } => self.commanded,
                _ => self.measured(),
            },
            goal_pose: if enable { self.goal } else { self.pose },
            enable,
        };
        let (time, period) = (self.time as f64 * 1e-9, self.config.period as f64 * 1e-9);
        let Ok(outputs) = controller.step(time, period, &inputs) else {
            return self.raise(Fault::ControllerFailed);
        };
        self.answer = Some(outputs);
        let most = |i: usize| self.config.rig.cables[i].limits.max * (1.0 + 1e-9);
        // NaN is in no range.
        let asked = |i: usize| outputs.motor_tension.get(i).copied().unwrap_or(f64::NAN);
        let wrong = (0..self.cables()).find(|i| !(0.0..=most(*i)).contains(&asked(*i)));
        match wrong {
            Some(i) => self.raise(Fault::ControllerOutput { cable: i + 1, tension: asked(i) }),
            None if enable && outputs.status.lacks_pose() => self.raise(Fault::ControllerSensorFault),
            None => {}
        }
    }
}
