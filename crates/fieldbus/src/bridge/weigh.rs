//! The first lift, in a survey: some millimetres, on springs around where the platform stands, for as long as the operator holds it; then the load cells say what
//! hangs on them.

use super::output::blend;
use super::trial::{LIFT, Trial};
use super::{Bridge, Event, Fault, Mode, Refusal};
use crate::Nanoseconds;
use cable_robot::robot::{PerCable, Pose, forward_kinematics};

/// A platform that this many times its weight does not lift is too heavy, or held.
const MOST: f64 = 1.5;
/// It has left its stand at this share of the way that it is led, and hangs at this one.
const LIFTED: f64 = 0.1;
const HANGS: f64 = 0.25;
/// Then the share that is carried is led to where it hangs there, at most this slowly against the ramp: slower than the platform swings on the
/// springs, so that the two do not rock each other.
const SLOW: f64 = 0.25;
/// The whole weight is taken up in so many `slack.ramp`.
const RAMPS: f64 = 2.0;

/// Where the platform stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stand {
    pub pose: Pose,
    /// m.
    pub length: PerCable<f64>,
}

/// Where the lift is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lift {
    /// More and more of the weight is carried.
    Up,
    /// It hangs, and comes to rest.
    Settling { since: Nanoseconds },
    /// Load cells are read.
    Reading { since: Nanoseconds, sum: PerCable<f64>, cycles: u32 },
    /// Less and less of the weight is carried.
    Down,
}

impl Bridge {
    /// The platform is to be lifted a little; asked again and again while it may.
    pub(super) fn weigh(&mut self, now: Nanoseconds) -> Result<(), Refusal> {
        if let Mode::Trying(Trial::Weigh { given, .. }) = &mut self.mode {
            *given = now;
            return Ok(());
        }
        if self.is_home_stale {
            return Err(Refusal::StillPressed);
        }
        self.stand = self.standing()?;
        self.pose = self.stand.pose;
        self.enter(Mode::Trying(Trial::Weigh { given: now, share: 0.0, lift: Lift::Up }));
        Ok(())
    }

    /// The platform stands at home, or on the blocks where it was placed last.
    fn standing(&self) -> Result<Stand, Refusal> {
        let length = self.lengths();
        let off = |stand: &Stand, i: usize| length[i] - stand.length[i];
        let strays =
            |stand: &Stand| (0..self.cables()).find(|i| off(stand, *i).abs() > 0.5 * self.lift_height());
        let home = Stand { pose: self.config.home, length: self.home_length };
        let stand = match (strays(&home), self.placed) {
            (None, _) => home,
            (Some(_), Some(placed)) if strays(&placed).is_none() => placed,
            (Some(i), _) => return Err(Refusal::NotAtHome { cable: i + 1, off: off(&home, i) }),
        };
        // Nobody places it exactly: heights count from where it stands.
        let found = forward_kinematics(&self.config.rig, &length, &stand.pose);
        let pose = found.map_err(|_| Refusal::NotYet(Fault::NoPose))?.pose;
        Ok(Stand { pose, length })
    }

    /// m.
    fn lift_height(&self) -> f64 {
        LIFT * self.config.slack.most
    }

    fn raised(&self) -> Pose {
        let (mut pose, up) = (self.stand.pose, -self.config.rig.gravity.normalize());
        (0..3).for_each(|axis| pose.0[axis] += self.lift_height() * up[axis]);
        pose
    }

    /// With this share of the weight carried, N: what carries it where it stands, and springs around where it is led.
    pub(super) fn weighing_pull(&self, share: f64) -> PerCable<f64> {
        let rig = &self.config.rig;
        let (slack, carried) = (self.config.slack.pretension, self.gravity_hold(&self.stand.pose));
        let led = blend(&self.stand.length, &rig.cables_at(&self.raised()).length, share.min(1.0));
        let safe = &self.config.safe;
        PerCable::from_fn(self.cables(), |i| {
            let (length, rate) = self.drives[i].encoder.last_measured();
            let spring = share.min(1.0) * (safe.stiffness * (length - led[i]) + safe.damping * rate);
            let weight = slack + share * (carried[i] - slack);
            (weight + spring).clamp(0.0, rig.cables[i].limits.max)
        })
    }

    /// The next cycle of a lift.
    pub(super) fn lift(&mut self, given: Nanoseconds, share: f64, lift: Lift) {
        let step = self.config.period as f64 / (RAMPS * self.config.slack.ramp as f64);
        let is_held = self.time.saturating_sub(given) <= self.config.timeouts.enable;
        let waited = |since: Nanoseconds, time: Nanoseconds| self.time.saturating_sub(since) >= time;
        let ramp = self.config.slack.ramp;
        let (share, lift) = match lift {
            Lift::Down if share <= step => {
                self.is_home_stale = is_held;
                return self.enter(Mode::Ready);
            }
            Lift::Down => (share - step, Lift::Down),
            _ if !is_held => (share, Lift::Down),
            Lift::Up if self.rise() >= LIFTED * self.lift_height() => {
                (share, Lift::Settling { since: self.time })
            }
            Lift::Up if share >= MOST => {
                self.events.push(self.time, Event::NotLifted);
                (share, Lift::Down)
            }
            Lift::Up => (share + step, Lift::Up),
            Lift::Settling { since } if waited(since, ramp) && self.too_low().abs() < SLOW => {
                let sum = PerCable::filled(self.cables(), 0.0);
                (share, Lift::Reading { since: self.time, sum, cycles: 0 })
            }
            Lift::Settling { .. } => (share + step * self.too_low(), lift),
            Lift::Reading { since, sum, cycles } if waited(since, ramp / 4) => {
                self.say_weight(&sum.map(|sum| sum / f64::from(cycles.max(1))));
                (share, Lift::Down)
            }
            Lift::Reading { since, sum, cycles } => {
                let sum = PerCable::from_fn(self.cables(), |i| sum[i] + self.cells[i].tension());
                (share + step * self.too_low(), Lift::Reading { since, sum, cycles: cycles + 1 })
            }
        };
        self.mode = Mode::Trying(Trial::Weigh { given, share, lift });
    }

    /// How much higher than it stood it is, m.
    fn rise(&self) -> f64 {
        let way = self.pose.position() - self.stand.pose.position();
        -way.dot(&self.config.rig.gravity.normalize())
    }

    /// How far it is below where it is to hang, as a share of that height.
    fn too_low(&self) -> f64 {
        let height = HANGS * self.lift_height();
        SLOW * ((height - self.rise()) / height).clamp(-1.0, 1.0)
    }

    fn say_weight(&mut self, tension: &PerCable<f64>) {
        let (rig, tilt) = (&self.config.rig, self.pose.angles().amax());
        let (force, _) = rig.cables_at(&self.pose).wrench(tension);
        let mass = -force.dot(&rig.gravity) / rig.gravity.norm_squared();
        let event = Event::Weighed { mass, rise: self.rise(), tilt, pose: self.pose, reading: *tension };
        self.events.push(self.time, event);
    }
}
