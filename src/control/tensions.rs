//! Which tensions give a motion, Eq. (1): the only ones for six cables, for more those that [`distribution`](super::distribution)
//! chooses.

use super::distribution::{Distribution, Solutions, reference, share, widest_margin};
use crate::robot::dynamics::required_wrench;
use crate::robot::{Coordinates, LEAST_CABLES, PerCable, Pose, Rig};

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
    share(rig, &columns, &required_wrench(rig, pose, rates, accelerations), margin)
}

/// How far inside their limits the tensions can be at rest, N: less than 0 where the platform cannot be held.
pub fn static_margin(rig: &Rig, pose: &Pose) -> f64 {
    widest_margin(rig, &rig.cables_at(pose).wrench_matrix(), &rig.static_wrench())
}

/// The tensions at rest, N; `None` where the wrench matrix is singular.
pub fn static_tensions(rig: &Rig, pose: &Pose, margin: f64) -> Option<PerCable<f64>> {
    tensions(rig, pose, &Coordinates::zeros(), &Coordinates::zeros(), margin)
}

/// A limit that a platform at rest breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// Cable number, from 1.
    pub cable: usize,
    /// The limit that stands against the weight most, N.
    pub limit: f64,
    /// Whether that is the greatest tension.
    pub is_greatest: bool,
}

/// What forbids that the platform rests at `pose`: the first cable at or beyond a limit of six, the limit that counts most of more. `None` if
/// nothing does, or the wrench matrix is singular.
pub fn barrier(rig: &Rig, pose: &Pose) -> Option<Barrier> {
    let columns = rig.cables_at(pose).wrench_matrix();
    let limit = |i: usize, is_greatest: bool| {
        let limits = rig.cables[i].limits;
        Barrier { cable: i + 1, limit: if is_greatest { limits.max } else { limits.min }, is_greatest }
    };
    if rig.cables.len() == LEAST_CABLES {
        let tensions = share(rig, &columns, &rig.static_wrench(), 0.0)?;
        return tensions.into_iter().zip(&rig.cables).enumerate().find_map(|(i, (u, cable))| {
            (u <= cable.limits.min || u > cable.limits.max).then(|| limit(i, u > cable.limits.max))
        });
    }
    let solutions = Solutions::new(&columns, &rig.static_wrench(), rig.platform_radius())?;
    match solutions.distribute(&rig.limits(), &reference(rig), 0.0) {
        Distribution::Feasible(_) => None,
        Distribution::Infeasible { weights, .. } => {
            let most = (0..weights.len()).max_by(|i, j| weights[*i].abs().total_cmp(&weights[*j].abs()))?;
            Some(limit(most, weights[most] > 0.0))
        }
    }
}
