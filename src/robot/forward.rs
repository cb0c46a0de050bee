//! Forward kinematics: the pose from six or more cable lengths, by Newton's method, with a proof of the result.

use nalgebra::{Matrix6, Rotation3, Vector6};
use thiserror::Error;

use super::{LEAST_CABLES, PerCable, Pose, Rig};

/// Newton converges in five or six iterations within its range.
const MAX_ITERATIONS: usize = 20;
/// The iteration ends when a step is shorter than this, m.
const STEP_TOLERANCE: f64 = 1e-9;
/// More than six lengths belong to no pose if one is off the nearest pose's by more than this share of the platform's radius.
const MISFIT: f64 = 0.05;

/// A pose that provably has the given lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardSolution {
    /// The pose.
    pub pose: Pose,
    /// A true solution lies within this distance of `pose`, m (a rotation counts at the platform's radius).
    /// Rounding errors of the order of 1e-15 are not included.
    pub error_bound: f64,
}

/// No pose can be given for these lengths.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ForwardError {
    /// A length is not a positive number.
    #[error("cable length {cable} = {value} m: it must be finite and greater than 0")]
    Length {
        /// Cable number, from 1.
        cable: usize,
        /// The length given, m.
        value: f64,
    },
    /// The iteration met a pose where the wrench matrix cannot be inverted.
    #[error("forward kinematics met a singular pose: the cable lengths belong to no pose near the last one")]
    Singular,
    /// The iteration did not come to rest, or rests where convergence cannot be proved.
    #[error("forward kinematics did not converge: the cable lengths belong to no pose near the last one")]
    NotConverged,
}

/// The pose with these cable lengths (m), the one near `guess`. More than six lengths seldom belong to one pose: then it is the one whose
/// lengths are nearest in the sense of least squares.
///
/// The last iterate is accepted by the Newton-Kantorovich theorem: with the Jacobian's (pseudo-)inverse bounded by β, the Newton
/// step by η and the Jacobian's Lipschitz constant by L, βηL ≤ 1/2 proves a solution within 2η. A rotation vector is
/// measured as the displacement at the platform's radius ρ; then the second derivative of a length is at most
/// 2/s + 1/ρ, hence L = √n (2/s + 1/ρ) for n cables with straight parts of at least s (docs/kinematics.md).
///
/// # Errors
/// [`ForwardError`] if a length makes no sense or no solution can be proved near the guess.
pub fn forward_kinematics(rig: &Rig, length: &[f64], guess: &Pose) -> Result<ForwardSolution, ForwardError> {
    if let Some(i) = length.iter().position(|l| !(l.is_finite() && *l > 0.0)) {
        return Err(ForwardError::Length { cable: i + 1, value: length[i] });
    }
    let radius = rig.platform_radius();
    let mut position = guess.position();
    let mut rotation = guess.rotation();
    for _ in 0..MAX_ITERATIONS {
        let cables = rig.cables(&position, &rotation);
        // dl = -Wᵀ (dp, dθ): a column for a unit of length in each of the six.
        let rows = cables.wrench_matrix().map(|column| {
            let mut row = -column;
            row.fixed_rows_mut::<3>(3).scale_mut(1.0 / radius);
            row
        });
        let inverse = pseudo_inverse(&rows).ok_or(ForwardError::Singular)?;
        let misfit = PerCable::from_fn(rows.len(), |i| length[i] - cables.length[i]);
        let step =
            inverse.iter().zip(misfit).fold(Vector6::zeros(), |sum, (column, misfit)| sum + column * misfit);
        let eta = step.norm();
        if !eta.is_finite() {
            return Err(ForwardError::Singular);
        }
        position += step.fixed_rows::<3>(0);
        rotation = Rotation3::from_scaled_axis(step.fixed_rows::<3>(3) / radius) * rotation;
        if eta < STEP_TOLERANCE {
            let shortest =
                cables.free.iter().copied().fold(f64::INFINITY, f64::min) - 2.0 * 2f64.sqrt() * eta;
            let lipschitz = (rows.len() as f64).sqrt() * (2.0 / shortest + 1.0 / radius);
            let beta = inverse.iter().map(Vector6::norm_squared).sum::<f64>().sqrt();
            let belongs = rows.len() == LEAST_CABLES || misfit.iter().all(|m| m.abs() <= MISFIT * radius);
            let proved = belongs && shortest > 0.0 && beta * eta * lipschitz <= 0.5;
            // The step just taken leads from an iterate with bound 2η to one with bound 2η or less.
            return if proved {
                Ok(ForwardSolution { pose: Pose::from_parts(&position, &rotation), error_bound: 2.0 * eta })
            } else {
                Err(ForwardError::NotConverged)
            };
        }
    }
    Err(ForwardError::NotConverged)
}

/// The columns of the inverse of the matrix with these rows, or of (JᵀJ)⁻¹Jᵀ for more than six.
fn pseudo_inverse(rows: &PerCable<Vector6<f64>>) -> Option<PerCable<Vector6<f64>>> {
    if rows.len() == LEAST_CABLES {
        let inverse = Matrix6::from_fn(|i, k| rows[i][k]).try_inverse()?;
        return Some(PerCable::from_fn(LEAST_CABLES, |i| inverse.column(i).into_owned()));
    }
    let normal: Matrix6<f64> = rows.iter().map(|row| row * row.transpose()).sum();
    let inverse = normal.try_inverse()?;
    Some(rows.map(|row| inverse * row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Coordinates, RigFile};

    fn setup() -> Rig {
        RigFile::default().rig
    }

    fn lengths(rig: &Rig, pose: &Pose) -> PerCable<f64> {
        rig.cables_at(pose).length
    }

    #[test]
    fn eight_lengths_give_the_pose_and_one_that_is_far_off_is_refused() {
        let file = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
        let pose = Pose(file.home.0 + Coordinates::new(0.04, -0.03, 0.02, 0.05, -0.05, 0.08));
        let mut length = lengths(&file.rig, &pose);
        let solution = forward_kinematics(&file.rig, &length, &file.home).unwrap();
        assert!(solution.pose.minus(&pose).norm() < 1e-8);
        length[4] += file.rig.platform_radius();
        assert_eq!(forward_kinematics(&file.rig, &length, &file.home), Err(ForwardError::NotConverged));
    }

    #[test]
    fn finds_the_pose_after_a_move() {
        let rig = setup();
        let pose = Pose(Coordinates::new(0.04, -0.03, 1.02, 0.05, -0.05, 0.08));
        let solution = forward_kinematics(&rig, &lengths(&rig, &pose), &Pose::default()).unwrap();
        assert!(solution.pose.minus(&pose).norm() < 1e-9);
        assert!(solution.error_bound < 1e-8);
    }

    #[test]
    fn lengths_of_no_pose_are_refused() {
        let rig = setup();
        let mut length = lengths(&rig, &Pose::default());
        length[2] = 3.0;
        assert!(forward_kinematics(&rig, &length, &Pose::default()).is_err());
        length[2] = f64::NAN;
        let error = forward_kinematics(&rig, &length, &Pose::default()).unwrap_err();
        assert!(matches!(error, ForwardError::Length { cable: 3, .. }), "{error}");
    }
}
