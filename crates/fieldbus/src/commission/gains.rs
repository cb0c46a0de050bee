//! What load cells say, for each newton: from weighings of a platform whose mass is known.

use cable_robot::robot::{PerCable, Pose, Rig};
use nalgebra::{Cholesky, DMatrix, DVector, Matrix6};

use super::ALARM;

/// Before any weighing each gain is believed to be 1 within this, as a standard deviation.
const BELIEVED: f64 = 0.3;
/// Weighings tell a gain if they leave this share of what was not known of it.
const LEFT: f64 = 0.5;

/// The platform hung at rest, and its load cells were read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighing {
    /// Where.
    pub pose: Pose,
    /// N.
    pub reading: PerCable<f64>,
}

/// What each cell says for a newton.
#[derive(Clone, Debug, PartialEq)]
pub struct Gains {
    /// N/N.
    pub gain: PerCable<f64>,
    /// Standard deviations of these.
    pub deviation: PerCable<f64>,
    /// How many combinations of gains the weighings tell: all if there are as many as cables. One pose tells six.
    pub rank: usize,
}

impl Gains {
    /// From weighings with cells that are off by `noise` (N, standard deviation).
    ///
    /// With c_i = 1/gain_i and readings r, W diag(r) c is the wrench w that carries the platform, off by the wrench of the readings' errors, whose
    /// covariance is noise² W Wᵀ. The best c is that of least squares, with what is believed of it beforehand.
    pub fn new(rig: &Rig, weighings: &[Weighing], noise: f64) -> Option<Self> {
        let cables = rig.cables.len();
        let mut normal = DMatrix::zeros(cables, cables);
        let mut along = DVector::zeros(cables);
        for Weighing { pose, reading } in weighings {
            let columns = rig.cables_at(pose).wrench_matrix();
            let wrench_matrix = DMatrix::from_fn(6, cables, |k, i| columns[i][k]);
            let covariance = &wrench_matrix * wrench_matrix.transpose() * (noise * noise);
            let factor = Cholesky::new(Matrix6::from_fn(|i, k| covariance[(i, k)]))?;
            let readings = DMatrix::from_diagonal(&DVector::from_column_slice(reading));
            let whiten = |wrenches: DMatrix<f64>| factor.l_dirty().solve_lower_triangular(&wrenches);
            let told = whiten(wrench_matrix * readings)?;
            let carried = -rig.mass * rig.gravity;
            let wrench = whiten(DMatrix::from_fn(6, 1, |k, _| if k < 3 { carried[k] } else { 0.0 }))?;
            normal += told.transpose() * &told;
            along += told.transpose() * wrench.column(0);
        }
        let belief = BELIEVED.powi(-2);
        let rank = normal.clone().symmetric_eigenvalues().iter().filter(|told| **told > belief).count();
        let inverse = (normal + DMatrix::identity(cables, cables) * belief).try_inverse()?;
        let best = &inverse * (along.add_scalar(belief));
        // The gain is off by c's error over c².
        Some(Self {
            gain: PerCable::from_fn(cables, |i| best[i].recip()),
            deviation: PerCable::from_fn(cables, |i| inverse[(i, i)].sqrt() / (best[i] * best[i])),
            rank,
        })
    }

    /// Whether a cell (from 0) does not say what it should.
    pub fn is_blamed(&self, cable: usize) -> bool {
        (self.gain[cable] - 1.0).abs() > ALARM * self.deviation[cable]
    }

    /// Whether the weighings tell the gain of a cell (from 0).
    pub fn is_measured(&self, cable: usize) -> bool {
        self.deviation[cable] < LEFT * BELIEVED
    }
}

#[cfg(test)]
mod tests {
    use cable_robot::control::static_tensions;
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::SeedableRng;

    use super::*;
    use crate::commission::tests::normal;
    use crate::config::tests::{AKD, eight, parse};

    /// Gains off by 5 % as a standard deviation, readings by `noise`.
    fn weighed(rig: &Rig, poses: &[Pose], noise: f64, random: &mut Pcg64Mcg) -> (PerCable<f64>, Gains) {
        let cables = rig.cables.len();
        let gain = PerCable::from_fn(cables, |_| 1.0 + 0.05 * normal(random));
        let mut weigh = |pose: &Pose| {
            let tension = static_tensions(rig, pose, 0.0).unwrap();
            let reading = PerCable::from_fn(cables, |i| gain[i] * tension[i] + noise * normal(random));
            Weighing { pose: *pose, reading }
        };
        let weighings: Vec<_> = poses.iter().map(&mut weigh).collect();
        (gain, Gains::new(rig, &weighings, noise).unwrap())
    }

    #[test]
    fn one_pose_tells_six_gains_and_two_poses_eight() {
        let (six, eight) = (parse(AKD).unwrap(), eight());
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for (config, places, rank) in [(&six, 1, 6), (&eight, 1, 6), (&eight, 2, 8)] {
            let mut away = config.home.0;
            let [x, y, _] = config.limits.space;
            (away[0], away[1]) = (0.7 * x[1] + 0.3 * x[0], 0.4 * y[0] + 0.6 * y[1]);
            let poses = [config.home, Pose(away)];
            let noise = 0.25 * config.limits.disagreement;
            let (mut square, mut number) = (0.0, 0u32);
            let mut sharpest = f64::INFINITY;
            for _ in 0..50 {
                let (true_gain, found) = weighed(&config.rig, &poses[..places], noise, &mut random);
                assert_eq!(found.rank, rank, "{found:?}");
                for i in (0..true_gain.len()).filter(|i| found.is_measured(*i)) {
                    square += ((found.gain[i] - true_gain[i]) / found.deviation[i]).powi(2);
                    number += 1;
                    sharpest = sharpest.min(found.deviation[i]);
                }
            }
            let off = (square / f64::from(number.max(1))).sqrt();
            println!(
                "{}: {places} poses, rank {rank}, {} gains told, off by {off:.2} of what is said, at best {sharpest:.3}",
                config.name,
                number / 50
            );
            // Where not every gain is told, what is believed beforehand is wider than these gains are off.
            let least = if rank == config.rig.cables.len() { 0.5 } else { 0.0 };
            assert!((least..1.2).contains(&off), "{off}");
        }
    }
}
