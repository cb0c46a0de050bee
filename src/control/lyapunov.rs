//! Eqs. (2) to (6): the Lyapunov law on all six coordinates, about a reference that may move. For one at rest it is the paper's.

use super::tensions::tensions;
use super::{Gains, Reference};
use crate::robot::{Coordinates, PerCable, Pose, Rig, dynamics};

/// s = (x' - r') + λ (x - r), Eq. (2); angles are subtracted the short way round.
pub fn sliding_variable(
    gains: &Gains,
    pose: &Pose,
    rates: &Coordinates,
    reference: &Reference,
) -> Coordinates {
    (rates - reference.rates) + pose.minus(&reference.pose) * gains.lambda
}

/// V = sᵀs/2, Eq. (3).
pub fn lyapunov_function(s: &Coordinates) -> f64 {
    0.5 * s.norm_squared()
}

/// The accelerations x'' = r'' - λ (x' - r') - η s that the law imposes: Eq. (5), s' = -η s.
pub fn acceleration(gains: &Gains, pose: &Pose, rates: &Coordinates, reference: &Reference) -> Coordinates {
    let s = sliding_variable(gains, pose, rates, reference);
    -(rates - reference.rates) * gains.lambda - s * gains.eta + reference.accelerations
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
    reference: &Reference,
    margin: f64,
) -> Option<PerCable<f64>> {
    tensions(rig, pose, rates, &acceleration(gains, pose, rates, reference), margin)
}

/// The accelerations of the coordinates that a command gives: those of the law, unless the cables do not pull (N) what it wants because of their limits.
pub fn imposed(
    rig: &Rig,
    gains: &Gains,
    (pose, rates): (&Pose, &Coordinates),
    reference: &Reference,
    [wanted, pulled]: [&PerCable<f64>; 2],
) -> Coordinates {
    if pulled == wanted {
        return acceleration(gains, pose, rates, reference);
    }
    dynamics::accelerations(rig, pose, rates, pulled)
}
