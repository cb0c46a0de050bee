//! Which tensions give a motion, Eq. (1): the only ones for six cables, for more those that [`distribution`](super::distribution)
//! chooses.

use crate::robot::dynamics::required_wrench;
use crate::robot::{Coordinates, PerCable, Pose, Rig};

/// The tensions of this motion, N; negative where a cable would have to push. More than six cables keep `margin` (N) from their limits
/// where they can. `None` where the wrench matrix is singular.
pub fn tensions(
    rig: &Rig,
    pose: &Pose,
    rates: &Coordinates,
    accelerations: &Coordinates,
    margin: f64,
) -> Option<PerCable<f64>> {
    let columns = rig.cables_at(pose).wrench_matrix();
    super::distribution::share(rig, &columns, &required_wrench(rig, pose, rates, accelerations), margin)
}

/// How far inside their limits the tensions can be at rest, N: less than 0 where the platform cannot be held.
pub fn static_margin(rig: &Rig, pose: &Pose) -> f64 {
    super::distribution::widest_margin(rig, &rig.cables_at(pose).wrench_matrix(), &rig.static_wrench())
}

/// The tensions at rest, N; `None` where the wrench matrix is singular.
pub fn static_tensions(rig: &Rig, pose: &Pose, margin: f64) -> Option<PerCable<f64>> {
    tensions(rig, pose, &Coordinates::zeros(), &Coordinates::zeros(), margin)
}
