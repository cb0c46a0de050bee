//! What keeps the robot from the closed form, how far, and what that leaves of the certificate. Derived in `docs/certificate.md`.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::motion::Step;
use crate::robot::{CABLES, Coordinates, PerCable, Rig};

/// Makes an upper bound of a formula of positive terms that is computed with rounding.
const UPWARDS: f64 = 1.0 + 1e-9;
/// By how much a bound of the disturbing accelerations is tried larger than what the last one led to.
const GROWTH: f64 = 1.02;
/// Bounds tried.
const MOST_BOUNDS: usize = 200;

/// Bounds of what the controller does not know or cannot do; all zero is the closed form itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Relative error of the mass and of each moment of inertia, below 1.
    pub mass: f64,
    /// Distance of the centre of mass from where the rig says it is, m.
    pub centre_of_mass: f64,
    /// Force on the centre of mass, N.
    pub force: f64,
    /// Torque about it, N m.
    pub torque: f64,
    /// Difference of what a cable pulls from what was commanded, N: friction that no force loop makes up for.
    pub friction: f64,
    /// Longest time for which a command is held, s.
    pub sample_period: f64,
    /// Age of the pose and velocity that a command is computed from, s.
    pub delay: f64,
}

/// How far coordinates (m, rad), rates (m/s, rad/s) and accelerations (m/s², rad/s²) that go into the law may be from the closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Of the coordinates.
    pub coordinates: Coordinates,
    /// Of their rates.
    pub rates: Coordinates,
    /// Of the accelerations.
    pub accelerations: Coordinates,
}

/// What the cables come to over all time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Least and greatest tension of each cable, N.
    pub tension: PerCable<[f64; 2]>,
    /// Least and greatest length of any cable, m.
    pub length: [f64; 2],
}

impl Tube {
    /// The closed form itself.
    pub fn empty() -> Self {
        let none = Coordinates::zeros();
        Self { coordinates: none, rates: none, accelerations: none }
    }
}

/// Greatest value of φ: e^(-μt)/M at t = ln(M/μ)/(M - μ).
fn largest_phi(step: &Step) -> f64 {
    let (slow, fast) = (step.slow_rate(), step.fast_rate());
    let peak = if slow == fast { 1.0 / slow } else { ((fast - slow) / slow).ln_1p() / (fast - slow) };
    (-slow * peak).exp() / fast * UPWARDS
}

/// Greatest |x - x_d| of each coordinate.
fn largest_error(step: &Step) -> Coordinates {
    step.start.minus(&step.set_point).abs() + step.rates.abs() * largest_phi(step)
}

/// Whether an angle may get half a turn away from its set point, where the law turns back the other way round.
pub fn reaches_half_turn(step: &Step, tube: &Tube) -> bool {
    let error = largest_error(step) + tube.coordinates;
    error.fixed_rows::<3>(3).iter().any(|angle| *angle > PI - 1e-6)
}

/// The coordinates, rates and accelerations that the law is told, while all cables together pull `tension` (N) at most and the
/// shortest of them is `shortest` (m) in the closed form; `None` where no bound is found.
///
/// For a bound D of the accelerations that the model does not know, the motion stays in a tube about the closed form, and in this tube
/// those accelerations are below G(D). A D with G(D) < D is what is looked for.
pub fn tube(rig: &Rig, step: &Step, margins: &Margins, shortest: f64, tension: f64) -> Option<Tube> {
    let mut bound = Coordinates::zeros();
    for _ in 0..MOST_BOUNDS {
        let around = Around::new(rig, step, margins, &bound);
        let disturbance = around.disturbance(shortest, tension)?;
        if disturbance.iter().zip(&bound).all(|(found, tried)| found < tried || *found == 0.0) {
            return Some(around.told());
        }
        bound = disturbance * GROWTH;
    }
    None
}

/// Bounds of the motion, all of absolute values, while the unknown accelerations are within a bound.
struct Around<'a> {
    rig: &'a Rig,
    step: &'a Step,
    margins: &'a Margins,
    /// Distance from the closed form.
    tube: Tube,
    /// Rates of the coordinates.
    rates: Coordinates,
    /// Accelerations that the law would command at the true state, and those that happen.
    commanded: Coordinates,
    actual: Coordinates,
    /// Age of the state that the tensions were computed from, s.
    age: f64,
}

impl<'a> Around<'a> {
    fn new(rig: &'a Rig, step: &'a Step, margins: &'a Margins, bound: &Coordinates) -> Self {
        let (sum, product) = (step.gains.lambda + step.gains.eta, step.gains.omega_n_squared());
        let (phi, error, speed) =
            (largest_phi(step), step.start.minus(&step.set_point).abs(), step.rates.abs());
        // ∫φ = 1/(λη), ∫|φ'| = 2 max φ, ∫|φ''| = 1 + 2 Z_M.
        let tube = Tube {
            coordinates: bound * (UPWARDS / product),
            rates: bound * (2.0 * phi * UPWARDS),
            accelerations: bound * ((1.0 + 2.0 * step.gains.z_m()) * UPWARDS),
        };
        let commanded = (error * product + speed * sum) * UPWARDS + tube.accelerations;
        Self {
            rig,
            step,
            margins,
            tube,
            rates: (error * (product * phi) + speed) * UPWARDS + tube.rates,
            commanded,
            actual: (commanded + bound) * UPWARDS,
            age: margins.sample_period + margins.delay,
        }
    }

    /// How far the law's accelerations at the state it is told are from those at the true one.
    fn late(&self) -> Coordinates {
        let (sum, product) =
            (self.step.gains.lambda + self.step.gains.eta, self.step.gains.omega_n_squared());
        (self.rates * product + self.actual * sum) * (self.age * UPWARDS)
    }

    /// The tube of what the law is told.
    fn told(&self) -> Tube {
        Tube {
            coordinates: (self.tube.coordinates + self.rates * self.age) * UPWARDS,
            rates: (self.tube.rates + self.actual * self.age) * UPWARDS,
            accelerations: (self.tube.accelerations + self.late()) * UPWARDS,
        }
    }

    /// The accelerations of the coordinates that the model does not know; `None` beyond the range of the estimates.
    fn disturbance(&self, shortest: f64, tension: f64) -> Option<Coordinates> {
        let Self { rig, margins, age, .. } = *self;
        let radius = rig.attachments.iter().map(|b| b.norm()).fold(0.0, f64::max);
        let (speed, spin) = (linear(&self.rates), angular(&self.rates));
        let shortest = shortest - linear(&self.tube.coordinates) - radius * angular(&self.tube.coordinates);
        if shortest <= 0.0 || reaches_half_turn(self.step, &self.told()) {
            return None;
        }
        // What a cable turns through while a command is held and grows old, seen from the base and from the platform.
        let turned = age * (speed + spin * radius) / shortest;
        let friction = CABLES as f64 * margins.friction;
        let force = tension * turned + friction;
        let torque = radius * (tension * (turned + age * spin) + friction);

        let (late, known) = (self.late(), 1.0 / (1.0 - margins.mass));
        let alpha = angular(&self.actual) + spin * spin;
        let weight = self.commanded + Coordinates::z() * rig.g;
        let push = late + weight * margins.mass + Coordinates::repeat((force + margins.force) / rig.mass);
        let swing = margins.centre_of_mass * (alpha + spin * spin);
        let position = push * known + Coordinates::repeat(swing);

        let pull = rig.mass * (linear(&weight) + linear(&late)) + force;
        let largest = rig.inertia.max();
        let gyroscopic = largest * spin * (2.0 * age * alpha + margins.mass * spin);
        let torque = gyroscopic + torque + margins.centre_of_mass * pull + margins.torque;
        let kinematic = angular(&late) + age * spin * (3.0 * angular(&self.actual) + spin * spin);
        let told = kinematic + margins.mass * (angular(&self.commanded) + spin * spin);
        let body = rig.inertia.map(|moment| known * (told + torque / moment));
        let [roll, pitch, yaw] = self.angle_accelerations(&body)?;
        Some(Coordinates::new(position.x, position.y, position.z, roll, pitch, yaw) * UPWARDS)
    }

    /// Bounds of the accelerations of roll, pitch and yaw, from those of angular accelerations about the platform's axes.
    fn angle_accelerations(&self, body: &Vector3<f64>) -> Option<[f64; 3]> {
        let largest = |k: usize| {
            let goal = self.step.set_point.0[k];
            let ends = goal.abs().max((goal + self.step.start.minus(&self.step.set_point)[k]).abs());
            ends + self.step.rates[k].abs() * largest_phi(self.step) + self.tube.coordinates[k]
        };
        let (roll, pitch) = (largest(3).min(1.0), largest(4));
        let across = roll * body.y + body.z;
        (pitch < 1.5).then(|| [body.x + pitch.tan() * across, body.y + roll * body.z, across / pitch.cos()])
    }
}

/// Of x, y, z together.
fn linear(q: &Coordinates) -> f64 {
    q.fixed_rows::<3>(0).norm()
}

/// Of roll, pitch and yaw together: each turns the platform about an axis of its own.
fn angular(q: &Coordinates) -> f64 {
    q.fixed_rows::<3>(3).sum()
}
