//! One cable in or out while the operator holds a button, the platform on its stand and all other drives off. The winch is a spring around a length
//! that is led at `slack.most` per `slack.ramp`, and a damper: against what it cannot move its torque rises as slowly as when slack is taken up, and
//! it brakes what moves faster. A torque that falls with the speed alone would have to fall so steeply that a free winch, which is light, swings
//! between full torque either way.

use std::fmt;

use super::{Bridge, Cause, Event, Fault, Mode, Refusal};
use crate::Nanoseconds;
use crate::cia402::DriveState;
use cable_robot::robot::PerCable;

/// A cable is at rest that moves by no more than this share of `slack.most` in a quarter of `slack.ramp`, and goes the wrong way that has moved so far back.
const STILL: f64 = 0.05;

/// The damper makes up for a spring that is late by so many periods; the loop itself has two. With more of it a light
/// winch swings sooner when the link is slow.
const DAMPED: f64 = 5.0;

/// Which way a cable moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogDirection {
    /// The winch hauls it in.
    In,
    /// The winch pays it out.
    Out,
}

impl JogDirection {
    /// By what a length (m) changes, and a tension is multiplied.
    fn signs(self) -> [f64; 2] {
        match self {
            Self::In => [-1.0, 1.0],
            Self::Out => [1.0, -1.0],
        }
    }
}

impl fmt::Display for JogDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::In { "in" } else { "out" })
    }
}

/// A cable that is jogged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jog {
    /// From 0.
    pub cable: usize,
    direction: JogDirection,
    /// When the operator asked for it last, and first.
    given: Nanoseconds,
    since: Nanoseconds,
    /// None until its drive is enabled.
    way: Option<Way>,
}

/// Lengths, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    from: f64,
    /// How far the winch is led ahead of where it is.
    lead: f64,
    last: f64,
    /// Where it has pulled with all that it may, and since when.
    held: Option<(f64, Nanoseconds)>,
}

impl Jog {
    /// Whether its drive is to be in Operation enabled by now.
    pub fn is_led(&self, cable: usize) -> bool {
        self.way.is_some() && self.cable == cable
    }
}

impl Bridge {
    /// A cable (from 0) is to move; asked again and again while it may.
    pub(super) fn jog(
        &mut self,
        cable: usize,
        direction: JogDirection,
        now: Nanoseconds,
    ) -> Result<(), Refusal> {
        match self.mode {
            Mode::Jogging(jog) if (jog.cable, jog.direction) == (cable, direction) => {
                self.mode = Mode::Jogging(Jog { given: now, ..jog });
            }
            // Another one lets go.
            Mode::Jogging(_) => {
                self.is_home_stale = true;
                self.come_down(Cause::Released);
                return Err(Refusal::StillPressed);
            }
            _ if self.is_home_stale => return Err(Refusal::StillPressed),
            _ if self.is_survey && !self.is_direction_known(cable) => {
                return Err(Refusal::DirectionUnknown { cable: cable + 1 });
            }
            _ => {
                self.may_be_led_up(cable).map_err(Refusal::NotYet)?;
                self.reactions[cable].begin();
                self.enter(Mode::Jogging(Jog { cable, direction, given: now, since: now, way: None }));
            }
        }
        Ok(())
    }

    /// The jog of this cycle.
    pub(super) fn go_on_jogging(&mut self, jog: Jog) {
        let waits = |since: Nanoseconds| self.time.saturating_sub(since);
        let (cable, drive) = (jog.cable, &self.drives[jog.cable]);
        match jog.way {
            _ if waits(jog.given) > self.config.timeouts.enable => self.end_jog(Cause::EnableExpired),
            None if drive.state == Some(DriveState::OperationEnabled) => {
                if let Some(fault) = self.slow_drive(cable..=cable) {
                    return self.fail(fault);
                }
                let (length, _) = drive.encoder.last_measured();
                let way = Some(Way { from: length, lead: 0.0, last: length, held: None });
                self.mode = Mode::Jogging(Jog { way, ..jog });
            }
            None if waits(jog.since) > self.config.timeouts.drive => self.fail_drive_stuck(cable),
            None => {}
            Some(_) if !drive.encoder.is_alive(&self.config.limits) => {
                self.fail(Fault::EncoderSilent { cable: cable + 1 });
            }
            Some(way) => self.lead_jog(jog, way),
        }
    }

    /// The winch is led a cycle's way on, at most `slack.most` ahead of where it is and never behind that.
    fn lead_jog(&mut self, jog: Jog, way: Way) {
        let (length, rate) = self.drives[jog.cable].encoder.last_measured();
        let [sign, _] = jog.direction.signs();
        let (most, still) = (self.config.slack.most, STILL * self.config.slack.most);
        let step = self.jog_speed() * self.config.period as f64 * 1e-9;
        let lead = (way.lead - sign * (length - way.last) + step).clamp(0.0, most);
        let has_all = self.commanded[jog.cable].abs() >= self.whole_pull(jog.cable);
        let held = way.held.filter(|(at, _)| has_all && (length - at).abs() <= still);
        let held = held.or(has_all.then_some((length, self.time)));
        let is_held =
            |(_, since): (f64, Nanoseconds)| self.time.saturating_sub(since) >= self.config.slack.ramp / 4;
        let is_taut = jog.direction == JogDirection::In && held.is_some_and(is_held);
        if rate.abs() > self.config.limits.cable_speed {
            self.end_jog(Cause::TooFast);
        } else if sign * (length - way.from) < -still {
            self.end_jog(Cause::WrongWay);
        } else if is_taut {
            self.end_jog(Cause::Taut);
        } else {
            self.mode = Mode::Jogging(Jog { way: Some(Way { lead, last: length, held, ..way }), ..jog });
        }
    }

    /// m/s.
    fn jog_speed(&self) -> f64 {
        self.config.slack.most * 1e9 / self.config.slack.ramp as f64
    }

    /// The greatest tension of a jog as the drive is told, N.
    fn whole_pull(&self, cable: usize) -> f64 {
        let winch = &self.config.drives[cable].winch;
        winch.tension(winch.target_torque(self.config.slack.pretension))
    }

    /// N, below 0 outwards.
    pub(super) fn jog_pull(&self, jog: &Jog) -> PerCable<f64> {
        let mut tension = PerCable::filled(self.cables(), 0.0);
        let Some(way) = jog.way else { return tension };
        let (_, rate) = self.drives[jog.cable].encoder.last_measured();
        let ([sign, pull], most) = (jog.direction.signs(), self.config.slack.pretension);
        let stiffness = most / self.config.slack.most;
        let damping = stiffness * DAMPED * self.config.period as f64 * 1e-9;
        let along = stiffness * way.lead + damping * (self.jog_speed() - sign * rate);
        tension[jog.cable] = pull * along.clamp(-most, most);
        tension
    }

    /// The button may still be pressed.
    fn end_jog(&mut self, cause: Cause) {
        self.is_home_stale = true;
        self.come_down(cause);
    }

    /// How far it went.
    pub(super) fn say_jog(&mut self, jog: &Jog) {
        let (length, _) = self.drives[jog.cable].encoder.last_measured();
        let came_in = jog.way.map_or(0.0, |way| way.from - length);
        let measured = self.cells[jog.cable].tension();
        self.events.push(self.time, Event::Jogged { cable: jog.cable, came_in, measured });
    }
}
