//! Eqs. (2) to (6): the Lyapunov law on all six coordinates.

use super::Gains;
use super::tensions::tensions;
use crate::robot::{Coordinates, PerCable, Pose, Rig};

/// s = x' + λ (x - x_d), Eq. (2); angles are subtracted the short way round.
pub fn sliding_variable(gains: &Gains, pose: &Pose, rates: &Coordinates, set_point: &Pose) -> Coordinates {
    rates + pose.minus(set_point) * gains.lambda
}

/// V = sᵀs/2, Eq. (3).
pub fn lyapunov_function(s: &Coordinates) -> f64 {
    0.5 * s.norm_squared()
}

/// The accelerations x'' = -λ x' - η s that the law imposes: Eq. (5), s' = -η s.
pub fn acceleration(gains: &Gains, pose: &Pose, rates: &Coordinates, set_point: &Pose) -> Coordinates {
    -rates * gains.lambda - sliding_variable(gains, pose, rates, set_point) * gains.eta
}

/// The law (4): the tensions that give these accelerations, N; negative where a cable would have to push. More than six cables keep `margin`
/// (N) from their limits where they can. `None` where the wrench matrix is singular.
///
/// D(x) and C(x, x') of (4) are not formed: Newton and Euler's equations (1) with x'' of [`acceleration`] are the same.
pub fn tension_command(
    rig: &Rig,
    gains: &Gains,
    pose: &Pose,
    rates: &Coordinates,
    set_point: &Pose,
    margin: f64,
) -> Option<PerCable<f64>> {
    tensions(rig, pose, rates, &acceleration(gains, pose, rates, set_point), margin)
}
