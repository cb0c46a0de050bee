//! Guide pulleys that swivel: the cable leaves at a point that moves with the platform (docs/kinematics.md).

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A pulley at the anchor of a cable. The cable runs along `axis` from the winch onto the wheel at the anchor; the wheel swivels about that
/// line, so that it always faces the attachment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pulley {
    /// Radius of the wheel, to the middle of the cable, m.
    pub radius: f64,
    /// Unit vector, base frame: the way the cable runs at the anchor, from the winch.
    #[schemars(with = "[f64; 3]")]
    pub axis: Vector3<f64>,
}

/// A cable over a pulley.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// From the attachment to where the cable leaves the wheel: a unit vector.
    pub direction: Vector3<f64>,
    /// Length from there to there, m.
    pub free: f64,
    /// Length from the anchor to the attachment: the free part and the arc on the wheel, m.
    pub length: f64,
}

impl Pulley {
    /// The cable to an attachment at `to_attachment` from the anchor, m. Not finite where the attachment is inside the wheel or on the axis.
    ///
    /// In the plane of the wheel, with e the way from the axis to the attachment: the wheel's centre is r e from the anchor, and the
    /// attachment (p, q) from the centre along e and the axis. The cable leaves at the angle θ from e, where
    /// d² = p² + q², s = √(d² - r²), cos θ = (p r - q s)/d², sin θ = (q r + p s)/d². The arc is r (π - θ).
    pub fn run(&self, to_attachment: &Vector3<f64>) -> Run {
        let height = to_attachment.dot(&self.axis);
        let sideways = to_attachment - self.axis * height;
        let distance = sideways.norm();
        let (p, q) = (distance - self.radius, height);
        let square = p * p + q * q;
        let free = (square - self.radius * self.radius).sqrt();
        let (cos, sin) = ((p * self.radius - q * free) / square, (q * self.radius + p * free) / square);
        let direction = sideways * (-sin / distance) + self.axis * cos;
        Run { direction, free, length: free + self.radius * (std::f64::consts::PI - libm::atan2(sin, cos)) }
    }

    /// By how much the direction of the run to an attachment changes to first order when that moves by `shift`, m: in the wheel's plane it turns
    /// about where the cable leaves, across that plane with the wheel.
    pub fn turned_by(&self, to_attachment: &Vector3<f64>, shift: &Vector3<f64>) -> Vector3<f64> {
        let Run { direction, free, .. } = self.run(to_attachment);
        let sideways = to_attachment - self.axis * to_attachment.dot(&self.axis);
        let distance = sideways.norm();
        let outwards = sideways / distance;
        let across = self.axis.cross(&outwards);
        let within = direction.cross(&across);
        across * (direction.dot(&outwards) * across.dot(shift) / distance)
            - within * (within.dot(shift) / free)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn length_falls_as_the_attachment_moves_along_the_cable() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        for _ in 0..1000 {
            let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let (axis, at, moved) = (vector().normalize(), vector() * 3.0, vector());
            let pulley = Pulley { radius: 0.1, axis };
            let run = pulley.run(&at);
            if at.cross(&axis).norm() < 0.3 || run.free.is_nan() {
                continue;
            }
            let length = |t: f64| pulley.run(&(at + moved * t)).length;
            let rate = (length(1e-6) - length(-1e-6)) / 2e-6;
            assert!((rate + run.direction.dot(&moved)).abs() < 1e-8, "{rate}");
            assert!((run.direction.norm() - 1.0).abs() < 1e-14);
            // Where it leaves is on the wheel: its distance from the centre is the radius, at right angles to the cable.
            let sideways = (at - axis * at.dot(&axis)).normalize();
            let from_centre = at + run.direction * run.free - sideways * 0.1;
            assert!(
                (from_centre.norm() - 0.1).abs() < 1e-14 && from_centre.dot(&run.direction).abs() < 1e-14
            );
        }
    }

    #[test]
    fn a_cable_half_round_the_wheel_comes_straight_back() {
        let pulley = Pulley { radius: 0.1, axis: Vector3::new(0.0, 0.0, -1.0) };
        let run = pulley.run(&Vector3::new(0.2, 0.0, 1.5));
        assert!((run.direction - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
        assert!(
            (run.free - 1.5).abs() < 1e-15 && (run.length - 1.5 - 0.1 * std::f64::consts::PI).abs() < 1e-15
        );
    }

    #[test]
    fn a_small_wheel_is_a_point() {
        let (at, axis) = (Vector3::new(0.3, -0.4, 1.2), Vector3::new(0.0, 0.6, -0.8));
        let run = Pulley { radius: 1e-9, axis }.run(&at);
        assert!((run.length - at.norm()).abs() < 1e-8 && (run.direction + at / at.norm()).norm() < 1e-8);
    }
}
