//! An orbit over a span of time, enclosed: what the certificate looks at.

use super::ramp::Ramp;
use super::{Term, Trajectory};
use crate::reach::certificate::motion::Motion;
use crate::reach::certificate::taylor::Taylor;

impl Trajectory {
    /// Times (s) of its start, its first turn at full size, as far as it goes, and its stop: it is smooth on
    /// each, and nothing else comes in between.
    pub fn pieces(&self) -> [[f64; 2]; 3] {
        let stop = self.down.begin();
        let grown = self.up.end().min(stop);
        [[0.0, grown], [grown, stop.min(grown + self.orbit.period())], [stop, self.down.end()]]
    }

    /// Eq. (O2) and its derivatives within `half` s of `middle`, on one piece.
    pub(super) fn enclosed(&self, middle: f64, half: f64) -> Motion {
        let [b, db, ddb] = self.size_enclosed(self.ramp(middle), middle, half);
        let orbit = &self.orbit;
        let constant = |k: usize| Taylor::constant(orbit.centre.0[k]);
        let mut motion = Motion {
            coordinates: std::array::from_fn(constant),
            rates: [Taylor::ZERO; 6],
            accelerations: [Taylor::ZERO; 6],
        };
        for Term { radius, harmonic, angle } in orbit.figure.terms() {
            let w = harmonic * orbit.rate;
            let (sin, cos) =
                phase([w, middle - orbit.start, half, angle], middle.abs() + orbit.start).sin_cos();
            for (k, [e, across]) in [[cos, -sin], [sin, cos]].into_iter().enumerate() {
                motion.coordinates[k] = motion.coordinates[k] + b * e * radius;
                motion.rates[k] = motion.rates[k] + (db * e + b * across * w) * radius;
                let acceleration = (ddb - b * (w * w)) * e + db * across * (2.0 * w);
                motion.accelerations[k] = motion.accelerations[k] + acceleration * radius;
            }
        }
        motion
    }

    /// b, b', b''; at full size they are constant.
    fn size_enclosed(&self, ramp: &Ramp, middle: f64, half: f64) -> [Taylor; 3] {
        if middle > self.up.end() && middle < self.down.begin() {
            return [Taylor::constant(1.0), Taylor::ZERO, Taylor::ZERO];
        }
        ramp.enclosed(middle, half)
    }
}

/// w t + `angle` within `half` s of t, which was computed from times of `size`.
fn phase([w, t, half, angle]: [f64; 4], size: f64) -> Taylor {
    let rounding = 8.0 * f64::EPSILON * (w.abs() * size + angle.abs());
    let mut phase = Taylor::ball(w * t + angle, rounding);
    phase.coefficients[1] = w * half;
    phase
}

#[cfg(test)]
mod tests {
    use crate::plan::orbit::{Figure, Orbit};
    use crate::robot::Pose;
    use rand::{RngExt, SeedableRng};

    /// Random orbits and stops: what is enclosed is what the law is led along, and rates and accelerations
    /// are the derivatives of the pose.
    #[test]
    fn the_enclosure_holds_the_motion_and_its_derivatives() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        for case in 0..300 {
            let radius = rng.random_range(0.1..0.5);
            let figure = match case % 3 {
                0 => Figure::Circle { radius },
                1 => Figure::Line { radius, direction: rng.random_range(-3.0..3.0) },
                _ => Figure::Hypotrochoid { radius, share: 0.2, lobes: 3 },
            };
            let (rate, start) = (rng.random_range(1.0..4.0), rng.random_range(1.0..3.0));
            let orbit = Orbit { centre: Pose::at(0.1, -0.1, 1.0), figure, rate, turns: 1.5, start };
            let whole = orbit.trajectory();
            let trajectory = whole.stopped(rng.random_range(0.2..1.1) * whole.stop_begins());
            for [from, to] in trajectory.pieces() {
                if to <= from {
                    continue;
                }
                let half = rng.random_range(0.0..0.5 * (to - from).min(0.2));
                let middle = rng.random_range(from + half..=to - half);
                let enclosed = trajectory.enclosed(middle, half);
                for tau in [-1.0, -0.4, 0.3, 1.0] {
                    let t = middle + half * tau;
                    let here = trajectory.at(t);
                    let h = 1e-4;
                    let [before, after] = [t - h, t + h].map(|t| trajectory.at(t));
                    for k in 0..6 {
                        let found = [&enclosed.coordinates, &enclosed.rates, &enclosed.accelerations];
                        let exact = [here.pose.0[k], here.rates[k], here.accelerations[k]];
                        for (number, value) in found.into_iter().zip(exact) {
                            let c = &number[k].coefficients;
                            let polynomial = c.iter().rev().fold(0.0, |sum, c| sum * tau + c);
                            let off = (polynomial - value).abs();
                            assert!(off <= number[k].error + 1e-13, "{orbit:?} {t}: {off} {:?}", number[k]);
                        }
                        if t - h > from && t + h < to {
                            let rate = (after.pose.0[k] - before.pose.0[k]) / (2.0 * h);
                            let acceleration = (after.rates[k] - before.rates[k]) / (2.0 * h);
                            assert!((rate - exact[1]).abs() < 1e-5, "{orbit:?} {t}");
                            assert!((acceleration - exact[2]).abs() < 1e-4, "{orbit:?} {t}");
                        }
                    }
                }
            }
        }
    }
}
