//! What a state commands, and the frames that say so.

use super::{Bridge, FrameQueue, Held, Mode};
use crate::Nanoseconds;
use crate::bus_load::torque_frame_bytes;
use crate::canopen::{NmtState, sync};
use crate::cia402::{Demand, DriveState};
use crate::frame::{Frame, FrameKind};
use cable_robot::robot::PerCable;

impl Bridge {
    /// Tensions (N) and what is demanded of the drives.
    fn command(&mut self) -> (PerCable<f64>, Demand) {
        let nothing = PerCable::filled(self.cables(), 0.0);
        match self.mode {
            Mode::Shadow { .. } => (self.answer.map_or(nothing, |answer| answer.motor_tension), Demand::Off),
            Mode::Listening { .. } | Mode::Quieting { .. } | Mode::Configuring | Mode::Off => {
                (nothing, Demand::Off)
            }
            Mode::Homing { .. } if self.is_resetting_drives => (nothing, Demand::FaultReset),
            Mode::Homing { .. } => (nothing, Demand::Off),
            Mode::TakingUpSlack { step, .. } => {
                (step.map_or(nothing, |step| self.slack_pull(&step)), Demand::Enabled)
            }
            Mode::Trying(trial) if trial.is_lift() => (self.trial_pull(&trial), Demand::Keep),
            Mode::Trying(trial) => (self.trial_pull(&trial), Demand::Enabled),
            Mode::Jogging(jog) => (self.jog_pull(&jog), Demand::Enabled),
            Mode::Ready => (PerCable::filled(self.cables(), self.config.slack.pretension), Demand::Keep),
            Mode::Enabled { since, from, lifted, .. } => {
                let share = self.share(since, self.config.safe.ramp);
                self.certified = match self.answer {
                    Some(answer) if share == 1.0 => answer.motor_tension,
                    _ => blend(&from, &lifted, share),
                };
                (self.certified, Demand::Keep)
            }
            Mode::Stopping { since, from, to: Some(to), .. } => {
                let tension = blend(&from, &to.tension, self.share(since, self.config.safe.ramp));
                (self.stiffened(&Held { tension, ..to }), Demand::Keep)
            }
            Mode::Stopping { to: None, .. } => (nothing, Demand::QuickStop),
            Mode::Safe(Some(to)) | Mode::Fault(Some(to)) => (self.stiffened(&to), Demand::Keep),
            Mode::Lowering { since, from, way } => {
                self.certified = self.stiffened(&self.led(since, &from, &way));
                (self.certified, Demand::Keep)
            }
            Mode::Safe(None) | Mode::Fault(None) => (nothing, Demand::Off),
        }
    }

    /// Each winch resists by itself what its cable does: constant tensions alone let the platform turn over at some poses. One whose
    /// encoder failed cannot, and while a value is missing, nothing is made of lengths that were not measured.
    fn stiffened(&self, held: &Held) -> PerCable<f64> {
        let safe = &self.config.safe;
        PerCable::from_fn(self.cables(), |i| {
            let (length, rate) = self.drives[i].encoder.last_measured();
            let resistance =
                safe.stiffness * (length - held.length[i]) + safe.damping * (rate - held.rate[i]);
            let resistance = if self.is_sound(i) { resistance } else { 0.0 };
            (held.tension[i] + resistance).clamp(held.least, self.config.rig.cables[i].limits.max)
        })
    }

    /// How much of a ramp that began then is behind, 0 to 1.
    pub(super) fn share(&self, since: Nanoseconds, ramp: Nanoseconds) -> f64 {
        let elapsed = self.time.saturating_sub(since);
        if elapsed >= ramp { 1.0 } else { elapsed as f64 / ramp as f64 }
    }

    /// Torques, SYNC and heartbeat of this cycle. Says which torques are commanded, ‰.
    pub(super) fn send(&mut self, out: &mut FrameQueue) -> PerCable<i16> {
        let (tension, demand) = self.command();
        for drive in &mut self.drives {
            drive.has_left |= demand == Demand::Keep && drive.state != Some(DriveState::OperationEnabled);
        }
        let torque = PerCable::from_fn(self.cables(), |i| {
            let tension = if self.drives[i].has_left { 0.0 } else { tension[i] };
            let winch = &self.config.drives[i].winch;
            let is_jogged = matches!(self.mode, Mode::Jogging(_));
            if is_jogged { winch.torque_either_way(tension) } else { winch.target_torque(tension) }
        });
        self.commanded = PerCable::from_fn(self.cables(), |i| self.config.drives[i].winch.tension(torque[i]));
        self.followers.iter_mut().zip(&torque).for_each(|(follower, torque)| follower.command(*torque));
        if !self.has_spoken || matches!(self.mode, Mode::Trying(trial) if trial.is_silent()) {
            return torque;
        }
        let has_process_data = self.is_running || matches!(self.mode, Mode::Quieting { .. });
        if has_process_data {
            for (bus, id, slots) in &self.torque_frames {
                let is_led_up = match self.mode {
                    Mode::Trying(trial) => trial.leads_up(slots.iter().flatten().copied()),
                    Mode::Jogging(jog) => slots.contains(&Some(jog.cable)),
                    _ => true,
                };
                let word = self.control_word(slots, if is_led_up { demand } else { Demand::Off });
                for i in slots.iter().flatten() {
                    let patience = self.config.timeouts.drive;
                    self.reactions[*i].command(word, self.drives[*i].state, self.time, patience);
                }
                if let Some(frame) = torque_frame(*id, slots, word, &torque) {
                    out.push(*bus, frame);
                }
            }
        }
        for bus in 0..self.config.buses.len() {
            if has_process_data {
                out.push(bus, sync());
            }
            if self.time >= self.next_heartbeat {
                out.push(bus, NmtState::Operational.heartbeat(self.config.node));
            }
        }
        if self.time >= self.next_heartbeat {
            self.next_heartbeat = self.time + self.config.heartbeat.period;
        }
        torque
    }

    /// One control word for the drives that share a frame: upwards the one that the last of them needs, else the one that acts.
    /// A drive in Fault neither holds the others back nor needs a command. One that fell out to Switched on is led up again by the word
    /// that keeps the others enabled, since CiA 402 has no other; that is why no torque is commanded.
    fn control_word(&self, slots: &[Option<usize>; 3], demand: Demand) -> u16 {
        let states = || slots.iter().flatten().filter_map(|i| self.drives[*i].state);
        match demand {
            Demand::Enabled => {
                let sound = states().filter(|state| !state.is_faulted());
                sound.map(|state| state.control_word(demand)).min().unwrap_or(0)
            }
            _ => states().map(|state: DriveState| state.control_word(demand)).max().unwrap_or(0),
        }
    }
}

pub(super) fn blend(from: &PerCable<f64>, to: &PerCable<f64>, share: f64) -> PerCable<f64> {
    PerCable::from_fn(from.len(), |i| from[i] + (to[i] - from[i]) * share)
}

/// Control word, then the torque of each slot.
fn torque_frame(id: u16, slots: &[Option<usize>; 3], word: u16, torque: &PerCable<i16>) -> Option<Frame> {
    let mut bytes = [0; 8];
    bytes[..2].copy_from_slice(&word.to_le_bytes());
    for (slot, cable) in slots.iter().enumerate() {
        let value = cable.map_or(0, |i| torque[i]);
        bytes[2 + 2 * slot..][..2].copy_from_slice(&value.to_le_bytes());
    }
    Frame::new(FrameKind::Data, id, &bytes[..torque_frame_bytes(slots)])
}
