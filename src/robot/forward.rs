//! Forward kinematics: the pose from six cable lengths, by Newton's method, with a proof of the result.

use nalgebra::{Rotation3, Vector6};
use thiserror::Error;

use super::{Geometry, PerCable, Pose};

/// Newton converges in five or six iterations within its range.
const MAX_ITERATIONS: usize = 20;
/// The iteration ends when a step is shorter than this, m.
const STEP_TOLERANCE: f64 = 1e-9;

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

/// The pose with these cable lengths (m), the one near `guess`.
///
/// The last iterate is accepted by the Newton-Kantorovich theorem: with the Jacobian's inverse bounded by β, the Newton
/// step by η and the Jacobian's Lipschitz constant by L, βηL ≤ 1/2 proves a solution within 2η. A rotation vector is
/// measured as the displacement at the platform's radius ρ; then the second derivative of a length is at most
/// 2/l + 1/ρ, hence L = √6 (2/l + 1/ρ) for six lengths of at least l (docs/kinematics.md).
///
/// # Errors
/// [`ForwardError`] if a length makes no sense or no solution can be proved near the guess.
pub fn forward_kinematics(
    geometry: &Geometry,
    length: &PerCable<f64>,
    guess: &Pose,
) -> Result<ForwardSolution, ForwardError> {
    if let Some(i) = length.iter().position(|l| !(l.is_finite() && *l > 0.0)) {
        return Err(ForwardError::Length { cable: i + 1, value: length[i] });
    }
    let radius = geometry.platform_radius();
    let mut position = guess.position();
    let mut rotation = guess.rotation();
    for _ in 0..MAX_ITERATIONS {
        let cables = geometry.cables(&position, &rotation);
        // dl = -Wᵀ (dp, dθ): a column for a unit of length in each of the six.
        let mut jacobian = -cables.wrench_matrix().transpose();
        jacobian.fixed_columns_mut::<3>(3).scale_mut(1.0 / radius);
        let inverse = jacobian.try_inverse().ok_or(ForwardError::Singular)?;
        let residual = Vector6::from_fn(|i, _| length[i] - cables.length[i]);
        let step = inverse * residual;
        let eta = step.norm();
        if !eta.is_finite() {
            return Err(ForwardError::Singular);
        }
        position += step.fixed_rows::<3>(0);
        rotation = Rotation3::from_scaled_axis(step.fixed_rows::<3>(3) / radius) * rotation;
        if eta < STEP_TOLERANCE {
            let shortest =
                cables.length.iter().copied().fold(f64::INFINITY, f64::min) - 2.0 * 2f64.sqrt() * eta;
            let lipschitz = 6f64.sqrt() * (2.0 / shortest + 1.0 / radius);
            let proved = shortest > 0.0 && inverse.norm() * eta * lipschitz <= 0.5;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Coordinates, RobotParameters};

    fn setup() -> Geometry {
        Geometry::new(&RobotParameters::default())
    }

    fn lengths(geometry: &Geometry, pose: &Pose) -> PerCable<f64> {
        geometry.cables(&pose.position(), &pose.rotation()).length
    }

    #[test]
    fn finds_the_pose_after_a_move() {
        let geometry = setup();
        let pose = Pose(Coordinates::new(0.04, -0.03, 1.02, 0.05, -0.05, 0.08));
        let solution = forward_kinematics(&geometry, &lengths(&geometry, &pose), &Pose::default()).unwrap();
        assert!(solution.pose.minus(&pose).norm() < 1e-9);
        assert!(solution.error_bound < 1e-8);
    }

    #[test]
    fn lengths_of_no_pose_are_refused() {
        let geometry = setup();
        let mut length = lengths(&geometry, &Pose::default());
        length[2] = 3.0;
        assert!(forward_kinematics(&geometry, &length, &Pose::default()).is_err());
        length[2] = f64::NAN;
        let error = forward_kinematics(&geometry, &length, &Pose::default()).unwrap_err();
        assert!(matches!(error, ForwardError::Length { cable: 3, .. }), "{error}");
    }
}
