//! What `Exact` leaves for anchors and attachments that are not quite where the rig file says. Derived in docs/exact.md.

use nalgebra::{Rotation3, UnitVector3, Vector3};

use super::interface::{ControllerParameters, PlannerKind};
use super::planner::Planner;
use crate::control::{geometry_margin, static_margin, static_tensions};
use crate::robot::dynamics::inertia;
use crate::robot::{ParameterError, Pose, Rig};

/// Halvings in the search for the largest accuracy that can be borne.
const HALVINGS: usize = 30;

impl Planner {
    /// What the tensions at rest may differ by, N.
    pub(super) fn accuracy_at(&self, pose: &Pose) -> f64 {
        if self.rig().accuracy == 0.0 {
            return 0.0;
        }
        geometry_margin(self.rig(), pose).unwrap_or(f64::INFINITY)
    }

    /// What the tensions on the way between two poses may differ by, N.
    pub(super) fn accuracy_on_the_way(&self, from: &Pose, to: &Pose) -> f64 {
        if self.rig().accuracy == 0.0 {
            return 0.0;
        }
        let share = 2.0 * (2.0 + 2.0 * self.parameters.gains().z_m());
        share * self.accuracy_at(from).max(self.accuracy_at(to))
    }
}

/// Whether a robot that is started at rest at `pose` stays taut until its observer has found what the geometry does.
///
/// # Errors
/// The parameter `accuracy`, with the largest value that can be borne there.
pub(super) fn check_start(parameters: &ControllerParameters, pose: &Pose) -> Result<(), ParameterError> {
    let said = parameters.rig.accuracy;
    let bears = |accuracy: f64| {
        let mut parameters = *parameters;
        parameters.rig.accuracy = accuracy;
        margin_of_start(&parameters, pose) > 0.0
    };
    if said == 0.0 || parameters.planner == PlannerKind::Bounded || !bears(0.0) || bears(said) {
        return Ok(());
    }
    let (mut below, mut above) = (0.0, said);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + above);
        *(if bears(middle) { &mut below } else { &mut above }) = middle;
    }
    let allowed = format!(
        "at this start at most {below:.2e} m can be borne: until the observer has found what the geometry does, a cable could go slack"
    );
    Err(ParameterError { name: "accuracy".into(), value: said, allowed: allowed.into() })
}

/// What is left of the smallest margin of a tension at rest, N, when the platform is turned by the torque that an unknown geometry makes and
/// the observer has not found yet.
fn margin_of_start(parameters: &ControllerParameters, pose: &Pose) -> f64 {
    let rig = &parameters.rig;
    let (Some(torque), Some(differ)) = (torque_of_geometry(rig, pose), geometry_margin(rig, pose)) else {
        return f64::NEG_INFINITY;
    };
    let gains = parameters.gains();
    // s²: the displacement for each unit of disturbing acceleration.
    let softness = parameters
        .observer()
        .map_or(1.0 / gains.omega_n_squared(), |observer| gains.largest_phi() * observer.time(&gains));
    let turn = inertia(rig, pose).try_inverse().unwrap_or_default().abs() * torque * softness;
    let margin = static_margin(rig, pose);
    let lost = |k: usize| {
        let axis = UnitVector3::new_unchecked(Vector3::ith(k, 1.0));
        let turned = |by: f64| {
            let rotation = Rotation3::from_axis_angle(&axis, by) * pose.rotation();
            static_margin(rig, &Pose::from_parts(&pose.position(), &rotation))
        };
        margin - turned(turn[k]).min(turned(-turn[k]))
    };
    margin - (0..3).map(lost).sum::<f64>() - (2.0 + 2.0 * gains.z_m()) * differ
}

/// Largest torque about each axis of the base that anchors and attachments off by the rig's accuracy add at rest, N m: of a cable that pulls
/// u along d, is l long and has the arm a, u (a × ε + α × d) with |ε| ≤ 2 accuracy/l and |α| ≤ accuracy.
fn torque_of_geometry(rig: &Rig, pose: &Pose) -> Option<Vector3<f64>> {
    let (cables, tensions) = (rig.cables_at(pose), static_tensions(rig, pose, 0.0)?);
    let about = |axis: Vector3<f64>| -> f64 {
        let of_cable = |j: usize| {
            let (turned, moved) = (axis.cross(&cables.arm[j]), axis.cross(&cables.direction[j]));
            tensions[j].abs() * (2.0 * turned.norm() / cables.free[j] + moved.norm())
        };
        (0..tensions.len()).map(of_cable).sum()
    };
    Some(Vector3::from_fn(|k, _| rig.accuracy * about(Vector3::ith(k, 1.0))))
}
