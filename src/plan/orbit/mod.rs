//! Periodic motions that may leave the static workspace: circles, lines and hypotrochoids that begin and end
//! at rest in their centre. Derived in docs/orbit.md.

mod certificate;
mod follower;
mod proof;
mod ramp;

use std::f64::consts::TAU;
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::control::Reference;
use crate::robot::parameters::require;
use crate::robot::{ParameterError, Pose, Rig};
pub use follower::Follower;
pub use proof::{OrbitError, Part, Proof, Refusal};
use ramp::Ramp;

/// Where no other number is given: turns at full size,
pub const TURNS: f64 = 3.0;
/// share and
pub const SHARE: f64 = 0.15;
/// lobes of a hypotrochoid.
pub const LOBES: u32 = 3;
/// Turns; stops are proved one by one on the way up.
const LONGEST_START: f64 = 40.0;

/// What an orbit draws about its centre, in the level coordinates x and y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Figure {
    /// Of this radius.
    Circle {
        /// R, m.
        radius: f64,
    },
    /// To and fro.
    Line {
        /// Half its length R, m.
        radius: f64,
        /// Of the end at which it begins, from the x axis towards y, rad.
        direction: f64,
    },
    /// A circle and on it a smaller one that turns the other way round: a rosette.
    Hypotrochoid {
        /// R of the large circle, m.
        radius: f64,
        /// Radius of the small circle, as a share of R.
        share: f64,
        /// Lobes, two or more: the small circle turns `lobes` - 1 times as fast.
        lobes: u32,
    },
}

/// R_j (cos, sin)(k_j φ + α_j): one term of Eq. (O1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Term {
    /// R_j, m.
    pub radius: f64,
    /// k_j.
    pub harmonic: f64,
    /// α_j, rad.
    pub angle: f64,
}

impl Figure {
    /// Eq. (O1).
    pub(super) fn terms(&self) -> [Term; 2] {
        let term = |radius: f64, harmonic: f64, angle: f64| Term { radius, harmonic, angle };
        match *self {
            Self::Circle { radius } => [term(radius, 1.0, 0.0), term(0.0, 1.0, 0.0)],
            Self::Line { radius, direction } => {
                [term(0.5 * radius, 1.0, direction), term(0.5 * radius, -1.0, direction)]
            }
            Self::Hypotrochoid { radius, share, lobes } => {
                [term(radius, 1.0, 0.0), term(share * radius, 1.0 - f64::from(lobes), 0.0)]
            }
        }
    }

    /// R, m.
    pub fn radius(&self) -> f64 {
        let (Self::Circle { radius } | Self::Line { radius, .. } | Self::Hypotrochoid { radius, .. }) = self;
        *radius
    }

    /// The same of another size.
    #[must_use]
    pub fn with_radius(mut self, new: f64) -> Self {
        let (Self::Circle { radius } | Self::Line { radius, .. } | Self::Hypotrochoid { radius, .. }) =
            &mut self;
        *radius = new;
        self
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Circle { radius } => write!(f, "circle of {radius:?} m"),
            Self::Line { radius, direction } => {
                write!(f, "line of {radius:?} m to each side, towards {direction:.4} rad")
            }
            Self::Hypotrochoid { radius, share, lobes } => {
                write!(f, "hypotrochoid of {radius:?} m with {share} of it in {lobes} lobes")
            }
        }
    }
}

impl fmt::Display for Orbit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, rate, turns, start, .. } = self;
        write!(f, "{figure}, {rate:.4} rad/s, {turns} turns at full size, start and stop {start:.3} s each")
    }
}

/// An orbit from rest to rest: with the figure grown from its centre, gone round, and shrunk into its centre
/// again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Orbit {
    /// Where it begins and ends; height and orientation stay.
    pub centre: Pose,
    /// What it draws.
    pub figure: Figure,
    /// Ω, rad/s.
    pub rate: f64,
    /// Turns at full size. A line may have none: then it swings to its first end and back.
    pub turns: f64,
    /// T₁, how long it grows from the centre, s; a stop takes as long.
    pub start: f64,
}

impl Orbit {
    /// √(g/h), rad/s: the rate at which a pendulum swings that is as long as the anchors are above `centre`
    /// on average, m. On a circle of this rate the paper's robot pulls at its centre of mass as if it rested
    /// in the middle.
    pub fn natural_rate(rig: &Rig, centre: &Pose) -> f64 {
        let gravity = rig.gravity.norm();
        let height = (centre.position() - rig.middle()).dot(&rig.gravity) / gravity;
        (gravity / height).sqrt()
    }

    /// Names the first number that makes no sense.
    ///
    /// # Errors
    /// [`ParameterError`] with the number's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.validate_but_start()?;
        let is_short = self.start <= LONGEST_START * self.period();
        require(self.start > 0.0, "start", self.start, "must be greater than 0 (s)")?;
        require(is_short, "start", self.start, "must take no longer than 40 turns (s)")
    }

    /// All but the start.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn validate_but_start(&self) -> Result<(), ParameterError> {
        let positive = |name: &'static str, value: f64, allowed: &'static str| {
            require(value.is_finite() && value > 0.0, name, value, allowed)
        };
        positive("radius", self.figure.radius(), "must be greater than 0 (m)")?;
        positive("rate", self.rate, "must be greater than 0 (rad/s)")?;
        let swings_back = matches!(self.figure, Figure::Line { .. }) && self.turns == 0.0;
        let is_counted = swings_back || self.turns > 0.0 && self.turns <= 1e6;
        let turns = "must be greater than 0 and at most 1,000,000, of a line 0 or greater";
        require(is_counted, "turns", self.turns, turns)?;
        match self.figure {
            Figure::Circle { .. } => Ok(()),
            Figure::Line { direction, .. } => {
                require(direction.is_finite(), "direction", direction, "must be finite (rad)")
            }
            Figure::Hypotrochoid { share, lobes, .. } => {
                positive("share", share, "must be greater than 0 (of the radius)")?;
                require((2..=100).contains(&lobes), "lobes", lobes.into(), "must be from 2 to 100")
            }
        }
    }

    /// Time of a turn, s.
    pub fn period(&self) -> f64 {
        TAU / self.rate
    }

    /// The motion from rest to rest as it is meant.
    pub fn trajectory(&self) -> Trajectory {
        let up = Ramp::to_rest([0.0; 3], 1.0, 0.0, self.start);
        Trajectory { orbit: *self, up, down: self.down(&up, self.start + self.turns * self.period()) }
    }

    /// The motion that goes on long enough for any stop within a turn to be one at full size.
    fn endless(&self) -> Trajectory {
        Self { turns: 2.0, ..*self }.trajectory()
    }

    fn down(&self, up: &Ramp, begin: f64) -> Ramp {
        Ramp::to_rest(up.at(begin), 0.0, begin, self.start)
    }
}

/// An orbit in time, up to rest: P = C + b(t) F(Ω (t - T₁)), Eq. (O2), where b grows from 0 to 1 and, from
/// some time on, falls to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory {
    orbit: Orbit,
    up: Ramp,
    down: Ramp,
}

impl Trajectory {
    /// The same with a stop that begins at a time, s, if that is before its own.
    #[must_use]
    pub fn stopped(&self, begin: f64) -> Self {
        if begin >= self.down.begin() {
            return *self;
        }
        Self { down: self.orbit.down(&self.up, begin), ..*self }
    }

    /// When its stop begins, s.
    pub fn stop_begins(&self) -> f64 {
        self.down.begin()
    }

    /// When it rests, s.
    pub fn end(&self) -> f64 {
        self.down.end()
    }

    /// b, b', b''.
    fn size(&self, time: f64) -> [f64; 3] {
        self.ramp(time).at(time)
    }

    /// The one that says how large the figure is at a time, s.
    fn ramp(&self, time: f64) -> &Ramp {
        if time < self.down.begin() { &self.up } else { &self.down }
    }

    /// Where it leads the robot at a time, s.
    pub fn at(&self, time: f64) -> Reference {
        let [b, db, ddb] = self.size(time);
        let mut reference = Reference::resting(&self.orbit.centre);
        for Term { radius, harmonic, angle } in self.orbit.figure.terms() {
            let w = harmonic * self.orbit.rate;
            let (sin, cos) = libm::sincos(w * (time - self.orbit.start) + angle);
            // (O2) and its derivatives, e = (cos, sin) and e' = w (-sin, cos).
            for (k, [e, across]) in [[cos, -sin], [sin, cos]].into_iter().enumerate() {
                reference.pose.0[k] += radius * b * e;
                reference.rates[k] += radius * (db * e + b * w * across);
                reference.accelerations[k] += radius * ((ddb - b * w * w) * e + 2.0 * db * w * across);
            }
        }
        reference
    }
}

/// The largest distance of p of the paper's robot from the middle on an orbit of this height above the
/// platform z and gravity g, at most, m: Eq. (O4). Every cable is taut where that is less than a/2.
pub fn reach_of_p(orbit: &Orbit, z: f64, g: f64) -> f64 {
    // Greatest |b'| T₁ and |b''| T₁² of (O3).
    const FIRST: f64 = 15.0 / 8.0;
    const SECOND: f64 = 5.773_502_691_896_258;
    let (share, start) = (z / g, orbit.start);
    let of_term = |Term { radius, harmonic, .. }: Term| {
        let w = harmonic * orbit.rate;
        let along = (1.0 - w * w * share).abs() + share * SECOND / (start * start);
        radius * libm::hypot(along, 2.0 * w * share * FIRST / start)
    };
    orbit.figure.terms().into_iter().map(of_term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use rand::{RngExt, SeedableRng};

    /// p = P + (z/g) P'' in dense samples of start, turn and stop; for short starts nearly all of (O4) is
    /// reached.
    #[test]
    fn p_goes_no_farther_than_the_closed_form_says() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        let mut nearest = f64::INFINITY;
        for _ in 0..200 {
            let radius = rng.random_range(0.1..0.6);
            let figure = match rng.random_range(0..3) {
                0 => Figure::Circle { radius },
                1 => Figure::Line { radius, direction: rng.random_range(-3.0..3.0) },
                _ => Figure::Hypotrochoid { radius, share: 0.1, lobes: 4 },
            };
            let (z, g) = (rng.random_range(0.5..2.0), 9.81);
            let (rate, start) = (rng.random_range(1.0..5.0), rng.random_range(0.05..3.0));
            let orbit = Orbit { centre: Pose::at(0.0, 0.0, z), figure, rate, turns: 1.0, start };
            let trajectory = orbit.trajectory();
            let p = |k: u32| {
                let led = trajectory.at(trajectory.end() * f64::from(k) / 20_000.0);
                let of = |k: usize| led.pose.0[k] + z / g * led.accelerations[k];
                Vector2::new(of(0), of(1)).norm()
            };
            let farthest = (0..=20_000).map(p).fold(0.0, f64::max);
            let most = reach_of_p(&orbit, z, g);
            assert!(farthest <= most * (1.0 + 1e-9), "{orbit:?} {farthest} {most}");
            nearest = nearest.min(most / farthest);
        }
        assert!(nearest < 1.05, "{nearest}");
    }
}
