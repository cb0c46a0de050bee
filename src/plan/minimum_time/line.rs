//! The fastest motion of the paper's robot along a straight line, heights included, every tension within its limits. Derived in docs/minimum-time.md.
//!
//! On the line P = P₀ + s d every G_i of docs/exact.md, (E1), is G_i = g (h_i - ν_i s) - κ_i s'': there is no term with s'². A limit of a
//! tension is therefore one of s'' that depends on s alone, and a straight line in s but for l_i. With chords in the place of that, on the safe
//! side of it, every limit holds at every s by construction.

use arrayvec::ArrayVec;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::arc::Timing;
use super::envelope::{Ray, least};
use super::pieces::{Limits, MOST_PIECES};
use crate::robot::triangles::{FACET_NORMALS, SIX, ends};
use crate::robot::{RobotParameters, TensionLimits};

/// Each of the six cables binds once in a piece at most.
const MOST_RAYS: usize = MOST_PIECES * SIX;

/// Straight bounds from the start of the line to its end.
type Bound = ArrayVec<Ray, MOST_RAYS>;

/// A straight way of the paper's robot, level and without a turn, and between what its tensions stay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    robot: RobotParameters,
    limits: TensionLimits,
    from: Vector3<f64>,
    /// Of length 1, or 0 where the line has no length.
    direction: Vector3<f64>,
    length: f64,
}

/// What bounds s'': both are positive along the whole line.
struct Bounds {
    /// Its greatest value, A₊, m/s².
    rise: Bound,
    /// The greatest value of -s'', -A₋, m/s².
    fall: Bound,
}

impl Line {
    /// Between two positions of the platform's centre in the paper's frame, m, with every tension within `limits`, N.
    pub fn new(
        robot: &RobotParameters,
        limits: TensionLimits,
        from: &Vector3<f64>,
        to: &Vector3<f64>,
    ) -> Self {
        let (way, length) = (to - from, (to - from).norm());
        let direction = if length > 0.0 { way / length } else { Vector3::zeros() };
        Self { robot: *robot, limits, from: *from, direction, length }
    }

    /// Whether a run can have left this.
    pub(super) fn is_sound(&self) -> bool {
        self.robot.validate().is_ok()
            && self.limits.min.is_finite()
            && !self.limits.max.is_nan()
            && self.from.iter().chain(&self.direction).all(|number| number.is_finite())
            && self.length.is_finite()
    }

    /// m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The position at `s` m from the start.
    pub fn point(&self, s: f64) -> Vector3<f64> {
        self.from + self.direction * s
    }

    /// The tensions at a place with an acceleration along the line, N: u = m l G/(3 a z).
    pub fn tensions(&self, s: f64, acceleration: f64) -> [f64; SIX] {
        let RobotParameters { a, b, m, g, .. } = self.robot;
        let (point, ends) = (self.point(s), ends(a, b));
        std::array::from_fn(|i| {
            let (anchor, attachment) = ends[i];
            let h = 0.5 * a - FACET_NORMALS[i].dot(&point.xy());
            let kappa = self.direction.z * h + point.z * FACET_NORMALS[i].dot(&self.direction.xy());
            let length = (anchor - attachment - point).norm();
            m * length * (g * h - kappa * acceleration) / (3.0 * a * point.z)
        })
    }

    /// The fastest motion from its start, with the speed `v0` (m/s) there, to rest at its end, no faster than `fastest` (m/s). `None` where the robot cannot rest
    /// somewhere on the line with its tensions within the limits, where it is too fast at the start, on a way straight down that no greatest tension limits, and where it would take
    /// more arcs than there is room for.
    pub fn fastest(&self, v0: f64, fastest: f64) -> Option<Timing> {
        let mut timing = Timing::begun_at(0.0);
        if self.length == 0.0 {
            return (v0 == 0.0).then_some(timing);
        }
        let Bounds { rise, fall } = self.bounds()?;
        // W = s'²/2, dW/ds = s'': forwards from the start, backwards from rest at the end.
        let speeding = Profile::new(&rise, self.length, 0.5 * v0 * v0);
        let braking = Profile::back_from_rest(&fall, self.length);
        let switch = speeding.crossing(&braking)?;
        let most = 0.5 * fastest * fastest;
        if speeding.at(0.0) > most {
            return None;
        }
        let (up, down) = if speeding.at(switch) > most {
            (speeding.place_of(most), braking.place_of(most))
        } else {
            (switch, switch)
        };
        speeding.emit(0.0, up, &mut timing);
        if down > up {
            timing.push(fastest, [0.0, 0.0], down, fastest);
        }
        braking.emit(down, self.length, &mut timing);
        (timing.end == self.length).then_some(timing)
    }

    /// "Switch now": the stop from the place `s` (m) with the speed `v` (m/s, greater than 0) of one of the motions above. It is proved with them. `None` where it would take
    /// more arcs than there is room for.
    pub fn stop(&self, s: f64, v: f64) -> Option<Timing> {
        let fall = self.bounds()?.fall;
        let mut timing = Timing::begun_at(s);
        let mut energy = 0.5 * v * v;
        for k in 0..fall.len() {
            let end = end_of(&fall, k, self.length);
            if end <= s || energy <= 0.0 {
                continue;
            }
            let start = timing.end;
            let (a, slope) = (fall[k].at(start), fall[k].slope);
            let left = energy - a * (end - start) - 0.5 * slope * (end - start) * (end - start);
            let to = if left > 0.0 { end } else { (start + way_of(energy, a, slope)).min(end) };
            let after = left.max(0.0);
            timing.push((2.0 * energy).sqrt(), [-a, -slope], to, (2.0 * after).sqrt());
            energy = after;
        }
        (!timing.is_full()).then_some(timing)
    }

    /// `None` where the robot cannot rest somewhere on it, or nothing bounds s'' on one side, or the line goes up to the base.
    fn bounds(&self) -> Option<Bounds> {
        let has_length = self.length > 0.0 && self.length.is_finite();
        if !has_length || [0.0, self.length].into_iter().any(|s| self.point(s).z <= 0.0) {
            return None;
        }
        let limits = Limits::new(&self.robot, &self.limits, &self.from, &self.direction);
        let (mut rise, mut fall) = (Bound::new(), Bound::new());
        for piece in &limits.pieces(self.length)? {
            let [rises, falls] = &piece.rays;
            least(rises, piece.end(), &mut rise);
            least(falls, piece.end(), &mut fall);
        }
        Some(Bounds { rise, fall })
    }
}

/// W = s'²/2 along the line, m²/s², with dW/ds = ±the rays' values.
struct Profile<'a> {
    rays: &'a [Ray],
    length: f64,
    /// W where each ray begins.
    energy: ArrayVec<f64, MOST_RAYS>,
    /// 1, or -1 where it falls.
    sign: f64,
}

impl<'a> Profile<'a> {
    /// Speeding up from `energy` at the start.
    fn new(rays: &'a [Ray], length: f64, energy: f64) -> Self {
        let mut profile = Self { rays, length, energy: ArrayVec::new(), sign: 1.0 };
        let mut sum = energy;
        for k in 0..rays.len() {
            profile.energy.push(sum);
            sum += profile.gain(k, profile.end(k));
        }
        profile
    }

    /// Braking down to rest at the end.
    fn back_from_rest(rays: &'a [Ray], length: f64) -> Self {
        let mut profile = Self { rays, length, energy: rays.iter().map(|_| 0.0).collect(), sign: -1.0 };
        let mut sum = 0.0;
        for k in (0..rays.len()).rev() {
            sum -= profile.gain(k, profile.end(k));
            profile.energy[k] = sum;
        }
        profile
    }

    fn end(&self, k: usize) -> f64 {
        end_of(self.rays, k, self.length)
    }

    /// What W gains along ray `k` up to `s`.
    fn gain(&self, k: usize, s: f64) -> f64 {
        let ray = &self.rays[k];
        let x = s - ray.s;
        self.sign * (ray.value * x + 0.5 * ray.slope * x * x)
    }

    /// W at `s`.
    fn at(&self, s: f64) -> f64 {
        let k = self.rays.iter().rposition(|ray| ray.s <= s).unwrap_or(0);
        (self.energy[k] + self.gain(k, s)).max(0.0)
    }

    /// Where W is `energy`, which it is somewhere.
    fn place_of(&self, energy: f64) -> f64 {
        let is_beyond = |k: &usize| (self.energy[*k] - energy) * self.sign > 0.0;
        let k = (0..self.rays.len()).find(is_beyond).unwrap_or(self.rays.len()).max(1) - 1;
        let ray = &self.rays[k];
        let missing = (energy - self.energy[k]) * self.sign;
        (ray.s + way_of(missing, ray.value, ray.slope)).min(self.end(k))
    }

    /// Where this one, which rises, meets `other`, which falls to zero. `None` if it is above it from the start.
    fn crossing(&self, other: &Profile) -> Option<f64> {
        let gap = |s: f64| other.at(s) - self.at(s);
        if gap(0.0) < 0.0 {
            return None;
        }
        let (mut here, mut k, mut j) = (0.0, 0, 0);
        loop {
            let end = self.end(k).min(other.end(j));
            if end >= self.length || gap(end) <= 0.0 {
                let slopes = self.rays[k].at(here) + other.rays[j].at(here);
                let way = way_of(gap(here).max(0.0), slopes, self.rays[k].slope + other.rays[j].slope);
                return Some((here + way).min(end));
            }
            k += usize::from(self.end(k) <= end);
            j += usize::from(other.end(j) <= end);
            here = end;
        }
    }

    /// The arcs between two places.
    fn emit(&self, from: f64, to: f64, timing: &mut Timing) {
        for k in 0..self.rays.len() {
            let (start, end) = (self.rays[k].s.max(from), self.end(k).min(to));
            if end > start {
                let speed = |s: f64| (2.0 * (self.energy[k] + self.gain(k, s)).max(0.0)).sqrt();
                let law = [self.rays[k].at(start), self.rays[k].slope].map(|value| self.sign * value);
                // Rest at the end is rest, whatever was rounded.
                let v1 = if self.sign < 0.0 && end == self.length { 0.0 } else { speed(end) };
                timing.push(speed(start), law, end, v1);
            }
        }
    }
}

/// Where ray `k` of a row on a line of this length ends.
fn end_of(rays: &[Ray], k: usize, length: f64) -> f64 {
    rays.get(k + 1).map_or(length, |next| next.s)
}

/// x with p x + q x²/2 = `energy`.
fn way_of(energy: f64, p: f64, q: f64) -> f64 {
    2.0 * energy / (p + (p * p + 2.0 * q * energy).max(0.0).sqrt())
}

#[cfg(test)]
mod tests;
