//! Coming down: what becomes of the platform when its controller may pull no more. [`Bridge::way_out`] is the table of docs/rig.md.

use super::output::blend;
use super::state::{Cause, Event};
use super::{Bridge, Fault, Held, Mode, SafePull};
use crate::Nanoseconds;
use crate::config::{Config, SafeOutput};
use cable_robot::control::static_tensions;
use cable_robot::robot::{PerCable, Pose};

/// What is done at once.
#[derive(Clone, Copy, Debug, PartialEq)]
enum WayOut {
    /// It stands: motors off.
    SwitchOff,
    /// The drives' quick stop, then off.
    QuickStop,
    /// The safe output, and then down: after `safe.hold_time`, or as soon as the safe output is there.
    Hold { is_asked: bool },
}

/// From where it hangs to above its stand, then straight down, and then on until no winch pulls any more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    start: Pose,
    above: Pose,
    home: Pose,
    /// How long the first leg takes, and the second.
    to_above: Nanoseconds,
    to_home: Nanoseconds,
    /// m/s, of the platform on the way and of each cable after it.
    speed: f64,
}

impl Way {
    fn new(config: &Config, start: Pose) -> Self {
        let (home, up, speed) = (config.home, -config.rig.gravity.normalize(), config.lowering_speed());
        // As far as it may be from where it is led, so that it does not come to its stand from the side.
        let clearance = config.limits.following;
        let aside = start.position() - home.position();
        let aside = aside - up * aside.dot(&up);
        let above = if aside.norm() > clearance {
            let mut above = home;
            (0..3).for_each(|axis| above.0[axis] += clearance * up[axis]);
            above
        } else {
            start
        };
        let time = |from: &Pose, to: &Pose| {
            let way = to.minus(from);
            let (shift, turn) = (way.fixed_rows::<3>(0).norm(), way.fixed_rows::<3>(3).norm());
            // The fastest of a smooth way is half more than its mean.
            (1.5e9 * (shift + config.rig.platform_radius() * turn) / speed) as Nanoseconds
        };
        Self { start, above, home, to_above: time(&start, &above), to_home: time(&above, &home), speed }
    }

    /// So long after it began: where the platform is led, and how much longer (m) than there its cables are let.
    fn at(&self, elapsed: Nanoseconds) -> (Pose, f64) {
        if elapsed < self.to_above {
            return (between(&self.start, &self.above, elapsed as f64 / self.to_above as f64), 0.0);
        }
        let elapsed = elapsed - self.to_above;
        if elapsed < self.to_home {
            return (between(&self.above, &self.home, elapsed as f64 / self.to_home as f64), 0.0);
        }
        (self.home, self.speed * (elapsed - self.to_home) as f64 * 1e-9)
    }
}

/// From rest to rest, `share` of the time.
fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    Pose(from.0 + to.minus(from) * (share * share * (3.0 - 2.0 * share)))
}

impl Bridge {
    /// The table: where the platform is, what is known of it, and what happened.
    fn way_out(&self, cause: &Cause) -> WayOut {
        let falls = self.config.safe.output == SafeOutput::TorqueOff;
        let is_led = self.config.safe.stiffness > 0.0;
        match (self.hangs(), self.lost_encoders(), cause) {
            (false, _, _) => WayOut::SwitchOff,
            (true, 2.., _) => WayOut::QuickStop,
            (true, _, Cause::Lower) if is_led => WayOut::Hold { is_asked: true },
            (true, _, _) if falls => WayOut::QuickStop,
            (true, _, Cause::Reset | Cause::Shutdown) => WayOut::Hold { is_asked: true },
            (true, _, _) => WayOut::Hold { is_asked: false },
        }
    }

    /// Whether the motors hold the platform, as far as the bridge knows.
    pub(super) fn hangs(&self) -> bool {
        matches!(
            self.mode,
            Mode::Enabled { .. }
                | Mode::Stopping { to: Some(_), .. }
                | Mode::Safe(Some(_))
                | Mode::Fault(Some(_))
                | Mode::Lowering { .. }
        )
    }

    pub(super) fn is_sound(&self, i: usize) -> bool {
        self.drives[i].encoder.is_sound(&self.config.limits)
    }

    /// Encoders that are not believed any more, whatever they say from now on.
    pub(super) fn lost_encoders(&self) -> usize {
        self.drives.iter().filter(|drive| drive.encoder.has_failed).count()
    }

    /// Ends what the controller does, or the operator, as the table has it.
    pub(super) fn come_down(&mut self, cause: Cause) {
        let way_out = self.way_out(&cause);
        match (way_out, self.mode) {
            // The drives stop by themselves; what follows is known when they have.
            (_, Mode::Stopping { to: None, .. }) => {}
            (WayOut::SwitchOff, _) => self.switch_off(cause),
            (WayOut::QuickStop, _) => self.stop(cause, None),
            (WayOut::Hold { is_asked }, Mode::Enabled { .. }) => {
                self.lowers_at =
                    Some(if is_asked { self.time } else { self.time + self.config.safe.hold_time });
                self.stop(cause, Some(self.safe_pull()));
            }
            (WayOut::Hold { .. }, Mode::Lowering { .. })
                if matches!(cause, Cause::Fault(Fault::OffStand { .. })) =>
            {
                self.lowers_at = None;
                self.stop(cause, Some(self.safe_pull()));
            }
            (WayOut::Hold { is_asked: true }, _) if cause == Cause::Lower || !self.is_off_stand() => {
                self.lowers_at = Some(self.time);
            }
            (WayOut::Hold { .. }, Mode::Safe(to)) if self.fault.is_some() => self.enter(Mode::Fault(to)),
            (WayOut::Hold { .. }, _) => {}
        }
    }

    /// Whether it was let down and there was no stand: it is not tried again by itself.
    fn is_off_stand(&self) -> bool {
        self.reported_faults.iter().any(|fault| matches!(fault, Fault::OffStand { .. }))
    }

    /// The way goes on with time.
    pub(super) fn go_on_down(&mut self) {
        match self.mode {
            Mode::Stopping { since, to, .. } if self.time.saturating_sub(since) >= self.config.safe.ramp => {
                match to {
                    None if self.is_shutting_down || self.is_reset_due => self.switch_off(Cause::Shutdown),
                    to if self.fault.is_some() => self.enter(Mode::Fault(to)),
                    to => self.enter(Mode::Safe(to)),
                }
            }
            Mode::Safe(Some(from)) | Mode::Fault(Some(from))
                if self.lowers_at.is_some_and(|at| at <= self.time) =>
            {
                let way = Way::new(&self.config, from.pose);
                self.enter(Mode::Lowering { since: self.time, from, way });
            }
            Mode::Lowering { since, way, .. } => self.look_for_stand(since, &way),
            _ => {}
        }
    }

    /// On its stand the platform goes no farther, and the winches pull less and less.
    fn look_for_stand(&mut self, since: Nanoseconds, way: &Way) {
        let (_, paid_out) = way.at(self.time.saturating_sub(since));
        if paid_out == 0.0 {
            return;
        }
        let most = self.config.slack.most;
        let off = |i: usize| self.drives[i].encoder.length - self.home_length[i];
        let loose = |i: usize| {
            let winch = &self.config.drives[i].winch;
            winch.tension(winch.target_torque(self.config.slack.pretension))
        };
        let is_loose = (0..self.cables()).all(|i| self.commanded[i] <= loose(i));
        // What is shorter than at home lies on something, and is known to when nothing pulls any more.
        // A platform that hangs askew, since a drive does not pull what it is told, has other lengths where it comes down.
        let is_askew = self.reported_faults.iter().any(|fault| fault.is_of_drive());
        let is_off =
            |i: &usize| !is_askew && self.is_sound(*i) && (off(*i) > most || is_loose && off(*i) < -most);
        if let Some(i) = (0..self.cables()).find(is_off) {
            self.fail(Fault::OffStand { cable: i + 1, length: off(i), most });
        } else if is_loose {
            self.switch_off(Cause::Landed);
        }
    }

    /// The platform is on its stand: nothing holds it but that, and the motors are switched off.
    pub(super) fn switch_off(&mut self, cause: Cause) {
        self.lowers_at = None;
        if let Mode::Jogging(jog) = self.mode {
            self.say_jog(&jog);
        }
        if self.is_shutting_down {
            self.enter(Mode::Off);
        } else if self.is_reset_due {
            self.reset();
        } else if self.fault.is_some() {
            self.enter(Mode::Fault(None));
        } else {
            self.events.push(self.time, Event::LetGo(cause));
            self.enter(Mode::Homing { since: self.time });
        }
    }

    /// From what is commanded to the safe output.
    fn stop(&mut self, cause: Cause, to: SafePull) {
        if matches!(self.mode, Mode::Enabled { .. }) {
            self.events.push(self.time, Event::Stopped(cause));
        }
        // What takes the place of a way that has begun is there in its time.
        let since = if let Mode::Stopping { since, .. } = self.mode { since } else { self.time };
        self.enter(Mode::Stopping { since, from: self.commanded, to });
    }

    fn safe_pull(&self) -> Held {
        let tension = match self.config.safe.output {
            SafeOutput::Hold => self.certified,
            SafeOutput::GravityRamp | SafeOutput::TorqueOff => self.gravity_hold(&self.pose),
        };
        let rate = PerCable::filled(self.cables(), 0.0);
        Held { pose: self.pose, tension, least: 0.0, length: self.lengths(), rate }
    }

    /// What carries the platform at rest at a pose, N, as far as cables can.
    pub(super) fn gravity_hold(&self, pose: &Pose) -> PerCable<f64> {
        let rig = &self.config.rig;
        let held = static_tensions(rig, pose, 0.0).unwrap_or(self.certified);
        PerCable::from_fn(self.cables(), |i| held[i].clamp(0.0, rig.cables[i].limits.max))
    }

    /// Around what the winches are springs and dampers while the platform is let down: the tensions that carry it where it is led, and its lengths there.
    pub(super) fn led(&self, since: Nanoseconds, from: &Held, way: &Way) -> Held {
        let (elapsed, period) = (self.time.saturating_sub(since), self.config.period);
        let rig = &self.config.rig;
        let lengths = |elapsed: Nanoseconds| {
            let (pose, paid_out) = way.at(elapsed);
            rig.cables_at(&pose).length.map(|length| length + paid_out)
        };
        let (pose, paid_out) = way.at(elapsed);
        let (length, next) = (lengths(elapsed), lengths(elapsed + period));
        let rate = PerCable::from_fn(self.cables(), |i| (next[i] - length[i]) * 1e9 / period as f64);
        let carried =
            blend(&from.tension, &self.gravity_hold(&pose), self.share(since, self.config.safe.ramp));
        // A winch that knows no length is no spring: it gives as much as if its cable stood still.
        let given = |i: usize| if self.is_sound(i) { 0.0 } else { self.config.safe.stiffness * paid_out };
        let tension = PerCable::from_fn(self.cables(), |i| (carried[i] - given(i)).max(0.0));
        // On its stand no cable gets slack.
        let least = if paid_out > 0.0 { self.config.slack.pretension } else { 0.0 };
        Held { pose, tension, least, length, rate }
    }

    /// Whether the output is on its way from one law to another.
    pub(super) fn is_on_its_way(&self) -> bool {
        match self.mode {
            Mode::Stopping { .. } => true,
            Mode::Lowering { since, .. } => self.share(since, self.config.safe.ramp) < 1.0,
            _ => false,
        }
    }
}
