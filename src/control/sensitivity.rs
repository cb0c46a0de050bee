//! What the tensions at rest differ by for what is not known: geometry, mass, a wrench, the encoders.

use nalgebra::{Vector3, Vector6};

use super::Gains;
use super::distribution::Solutions;
use super::estimator::jump_of_acceleration;
use super::tensions::static_tensions;
use crate::robot::dynamics::wrench_of;
use crate::robot::{Cables, Coordinates, PerCable, Pose, Rig};

/// How the tensions at rest at a pose answer. Of more than six cables the least change of all tensions is meant.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity<'a> {
    rig: &'a Rig,
    pose: Pose,
    cables: Cables,
    /// N.
    tensions: PerCable<f64>,
    /// Rows of W⁺: (f, t), from a force and a torque to a tension.
    inverse: PerCable<Vector6<f64>>,
}

impl<'a> Sensitivity<'a> {
    /// `None` where the wrench matrix is singular.
    pub fn new(rig: &'a Rig, pose: &Pose) -> Option<Self> {
        let cables = rig.cables_at(pose);
        let columns = cables.wrench_matrix();
        let tensions = static_tensions(rig, pose, 0.0)?;
        let mut inverse = PerCable::filled(columns.len(), Vector6::zeros());
        for k in 0..6 {
            let unit = Vector6::ith(k, 1.0);
            let solutions = Solutions::new(&columns, &unit, rig.platform_radius())?;
            for (row, value) in inverse.iter_mut().zip(solutions.least().iter()) {
                row[k] = *value;
            }
        }
        Some(Self { rig, pose: *pose, cables, tensions, inverse })
    }

    /// For anchors and attachments off by up to `accuracy` (m), to first order, N: the greatest of any cable, for the worst errors of all.
    ///
    /// A cable j that pulls u along d at the arm a, and is l long, adds u c·(α - β)/l + u (d × t)·β to the tension of cable i, where c is what
    /// is across d of f + t × a, and α and β are the errors of anchor and attachment.
    pub fn geometry(&self, accuracy: f64) -> f64 {
        self.greatest(|row| {
            let (force, torque) = parts(row);
            self.misplaced(accuracy, &force, &torque)
        })
    }

    /// Largest torque about an axis (of length one, base frame) that such errors of the geometry add, N m.
    pub fn torque_of_geometry(&self, accuracy: f64, axis: &Vector3<f64>) -> f64 {
        self.misplaced(accuracy, &Vector3::zeros(), axis)
    }

    /// Largest value that such errors of the geometry add to f·force + t·torque of the cables.
    fn misplaced(&self, accuracy: f64, f: &Vector3<f64>, t: &Vector3<f64>) -> f64 {
        let of_cable = |j: usize| {
            let direction = self.cables.direction[j];
            let turned = f + t.cross(&self.cables.arm[j]);
            let across = turned - direction * turned.dot(&direction);
            let (bent, moved) = (across / self.cables.free[j], direction.cross(t));
            self.tensions[j].abs() * (bent.norm() + (moved - bent).norm())
        };
        accuracy * (0..self.tensions.len()).map(of_cable).sum::<f64>()
    }

    /// For a mass that differs by this share, N.
    pub fn mass(&self, share: f64) -> f64 {
        let weight = self.rig.gravity * self.rig.mass;
        let weight = Vector6::new(weight.x, weight.y, weight.z, 0.0, 0.0, 0.0);
        share * self.greatest(|row| row.dot(&weight).abs())
    }

    /// For a force and a torque of up to these sizes (N, N m), N.
    pub fn wrench(&self, force: f64, torque: f64) -> f64 {
        self.greatest(|row| {
            let (f, t) = parts(row);
            f.norm() * force + t.norm() * torque
        })
    }

    /// For measured lengths that jump by `resolution` (m), N: W⁺ᵀ makes of that jumps of the pose, the observer and the law accelerations.
    pub fn encoders(&self, resolution: f64, gains: &Gains, disturbance_pole: f64) -> f64 {
        let jump = jump_of_acceleration(gains, disturbance_pole);
        let moved = |k: usize| self.inverse.iter().map(|row| row[k].abs()).sum::<f64>() * resolution;
        let wrench = wrench_of(self.rig, &self.pose, &Coordinates::from_fn(|k, _| jump * moved(k))).abs();
        self.greatest(|row| row.abs().dot(&wrench))
    }

    /// For this wrench (N, N m), N.
    pub fn of_wrench(&self, wrench: &Vector6<f64>) -> f64 {
        self.greatest(|row| row.dot(wrench).abs())
    }

    /// For an error of the pose and of the rates (m, rad, and those a second) that the law takes back, to first order: b and c of b f + c φ for each cable, N and
    /// N/s, with f and φ of [`Response`](super::Response).
    ///
    /// Of cable i it is (A e + B e'')_i with e = e₀ f + e₀' φ. A is what a shift changes while the tensions are held, B what an acceleration does.
    pub fn of_error(&self, error: &Coordinates, rates: &Coordinates, gains: &Gains) -> PerCable<[f64; 2]> {
        /// s, so that a speed is a small way.
        const SHORT: f64 = 1e-3;
        let (sum, omega2) = (gains.lambda + gains.eta, gains.omega_n_squared());
        let pulled = |by: Coordinates| {
            let (force, torque) = self.rig.cables_at(&Pose(self.pose.0 + by)).wrench(&self.tensions);
            Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
        };
        let at_rest = pulled(Coordinates::zeros());
        let (a_e, a_v) = (at_rest - pulled(*error), (at_rest - pulled(rates * SHORT)) / SHORT);
        let [b_e, b_v] = [error, rates].map(|by| wrench_of(self.rig, &self.pose, by));
        // f'' = -ω² f + ω² S φ, φ'' = -S f + (S² - ω²) φ.
        let of_f = a_e - b_e * omega2 - b_v * sum;
        let of_phi = a_v + b_e * (omega2 * sum) + b_v * (sum * sum - omega2);
        PerCable::from_fn(self.inverse.len(), |i| [self.inverse[i].dot(&of_f), self.inverse[i].dot(&of_phi)])
    }

    fn greatest(&self, change: impl Fn(&Vector6<f64>) -> f64) -> f64 {
        self.inverse.iter().map(change).fold(0.0, f64::max)
    }
}

fn parts(row: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (row.fixed_rows::<3>(0).into_owned(), row.fixed_rows::<3>(3).into_owned())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::robot::RigFile;

    /// The rig with both ends of each cable off by exactly `by`, in random directions.
    fn off(rng: &mut Pcg64, rig: &Rig, by: f64) -> Rig {
        let mut off = *rig;
        for cable in off.cables.iter_mut() {
            for end in [&mut cable.anchor, &mut cable.attachment] {
                *end += random(rng, by);
            }
        }
        off
    }

    fn random(rng: &mut Pcg64, length: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize() * length
    }

    /// Greatest difference of a tension from that of the rig believed.
    fn differs(believed: &Rig, truth: &Rig, pose: &Pose) -> f64 {
        let [believed, truth] = [believed, truth].map(|rig| static_tensions(rig, pose, 0.0).unwrap());
        (0..6).map(|i| (truth[i] - believed[i]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn no_random_rig_is_farther_off_and_the_worst_comes_near() {
        let mut rng = Pcg64::seed_from_u64(51);
        let rig = RigFile::default().rig;
        for pose in [Pose::default(), Pose::at(0.1, 0.05, 1.0), Pose::at(0.0, -0.15, 0.6)] {
            let sensitivity = Sensitivity::new(&rig, &pose).unwrap();
            let (geometry, mass) = (sensitivity.geometry(1e-5), sensitivity.mass(0.01));
            let wrench = sensitivity.wrench(1e-3, 1e-4);
            let mut most = [0.0f64; 3];
            for _ in 0..20_000 {
                most[0] = most[0].max(differs(&rig, &off(&mut rng, &rig, 1e-5), &pose));
                let mut heavy = rig;
                heavy.mass *= 1.0 + rng.random_range(-0.01..0.01);
                most[1] = most[1].max(differs(&rig, &heavy, &pose));
                let mut pushed = rig;
                pushed.disturbance.fixed_rows_mut::<3>(0).copy_from(&random(&mut rng, 1e-3));
                pushed.disturbance.fixed_rows_mut::<3>(3).copy_from(&random(&mut rng, 1e-4));
                most[2] = most[2].max(differs(&rig, &pushed, &pose));
            }
            println!(
                "{pose:?}: a millimetre costs {:.3} N, a hundredth of the mass {mass:.3} N, a newton and 0.1 N m {:.3} N",
                100.0 * geometry,
                1e3 * wrench
            );
            for (most, bound) in most.into_iter().zip([geometry, mass, wrench]) {
                assert!(most < 1.001 * bound && most > 0.4 * bound, "{most} N, bound {bound} N");
            }
        }
    }
}
