//! What `Exact` leaves for what is not known of rig and sensors: geometry, mass, forces, encoders. Derived in docs/exact.md.

use nalgebra::{Rotation3, UnitVector3, Vector3};

use super::interface::{ControllerParameters, PlannerKind};
use super::planner::Planner;
use crate::control::{Sensitivity, static_margin};
use crate::robot::dynamics::inertia;
use crate::robot::{ParameterError, Pose};

/// Halvings in the search for the largest accuracy that can be borne.
const HALVINGS: usize = 30;

impl Planner {
    /// What the tensions at rest may differ by, N.
    pub(super) fn unknown_at(&self, pose: &Pose) -> f64 {
        let unknown = self.parameters.unknown_at(pose);
        unknown.map_or(0.0, |unknown| unknown.steady + unknown.varying + unknown.noise)
    }

    /// What the tensions on the way between two poses may differ by, N.
    pub(super) fn unknown_on_the_way(&self, from: &Pose, to: &Pose) -> f64 {
        let share = 2.0 * (1.0 + self.parameters.gains().z_m());
        let at = |pose: &Pose| {
            let unknown = self.parameters.unknown_at(pose);
            unknown.map_or(0.0, |unknown| share * (unknown.steady + 2.0 * unknown.varying) + unknown.noise)
        };
        at(from).max(at(to))
    }
}

/// What tensions at rest may differ by, N.
struct Unknown {
    /// For a wrench that stays as it is: the observer finds it once and for all.
    steady: f64,
    /// For one that changes along the way, up to its opposite.
    varying: f64,
    /// For measurements that jump.
    noise: f64,
}

impl ControllerParameters {
    /// The first parameter of those that say what is not known which is not zero.
    fn is_uncertain(&self) -> Option<(&'static str, f64)> {
        self.unknowns().into_iter().find(|(_, value)| *value > 0.0)
    }

    /// The largest torque that is not known, the geometry's apart, N m.
    fn torque_bound(&self) -> f64 {
        self.disturbance_bound * self.rig.platform_radius()
    }

    /// `None` if all is known; without bound where the wrench matrix is singular.
    fn unknown_at(&self, pose: &Pose) -> Option<Unknown> {
        self.is_uncertain()?;
        let Some(sensitivity) = Sensitivity::new(&self.rig, pose) else {
            return Some(Unknown { steady: f64::INFINITY, varying: 0.0, noise: 0.0 });
        };
        let steady = sensitivity.mass(self.mass_tolerance);
        let varying = sensitivity.geometry(self.rig.accuracy)
            + sensitivity.wrench(self.disturbance_bound, self.torque_bound());
        let pole = self.observer().map_or(0.0, |observer| observer.pole);
        Some(Unknown {
            steady,
            varying,
            noise: sensitivity.encoders(self.encoder_resolution, &self.gains(), pole),
        })
    }

    /// `Bounded` leaves nothing for what is not known nor for long steps, and limits no speed.
    pub(super) fn check_planner(&self) -> Result<(), ParameterError> {
        let is_bounded = self.planner == PlannerKind::Bounded;
        let Some((name, value)) = self.heeded_by_exact().find(|(_, value)| is_bounded && *value > 0.0) else {
            return Ok(());
        };
        let allowed = "must be 0 with the planner Bounded, which does not heed it: choose Exact (2)";
        Err(ParameterError { name: name.into(), value, allowed: allowed.into() })
    }

    /// Whether a robot that is started at rest at `pose` stays taut until its observer has found what is not known.
    ///
    /// # Errors
    /// The parameter that is too large, with the largest value that can be borne there.
    pub(super) fn check_start(&self, pose: &Pose) -> Result<(), ParameterError> {
        let Some((name, value)) = self.is_uncertain() else { return Ok(()) };
        let bears = |share: f64| self.scaled(share).margin_of_start(pose) > 0.0;
        if !bears(0.0) || bears(1.0) {
            return Ok(());
        }
        let (mut below, mut above) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (below + above);
            *(if bears(middle) { &mut below } else { &mut above }) = middle;
        }
        let allowed = format!(
            "at this start at most {:.2e} can be borne, and the same share of what else is not known: until the observer has found it, a \
             cable could go slack",
            value * below
        );
        Err(ParameterError { name: name.into(), value, allowed: allowed.into() })
    }

    /// With this share of all that is not known.
    fn scaled(&self, share: f64) -> Self {
        let mut scaled = *self;
        scaled.rig.accuracy *= share;
        scaled.mass_tolerance *= share;
        scaled.encoder_resolution *= share;
        scaled.disturbance_bound *= share;
        scaled
    }

    /// What is left of the smallest margin of a tension at rest, N, when the platform is turned by the torque that is not known and that the
    /// observer has not found yet.
    fn margin_of_start(&self, pose: &Pose) -> f64 {
        let rig = &self.rig;
        let margin = static_margin(rig, pose);
        let Some(sensitivity) = Sensitivity::new(rig, pose) else { return f64::NEG_INFINITY };
        let torque = Vector3::from_fn(|k, _| {
            sensitivity.torque_of_geometry(rig.accuracy, &Vector3::ith(k, 1.0)) + self.torque_bound()
        });
        let gains = self.gains();
        // s²: the displacement for each unit of disturbing acceleration.
        let softness = self
            .observer()
            .map_or(1.0 / gains.omega_n_squared(), |observer| gains.largest_phi() * observer.time(&gains));
        let turn = inertia(rig, pose).try_inverse().unwrap_or_default().abs() * torque * softness;
        let lost = |k: usize| {
            let axis = UnitVector3::new_unchecked(Vector3::ith(k, 1.0));
            let turned = |by: f64| {
                let rotation = Rotation3::from_axis_angle(&axis, by) * pose.rotation();
                static_margin(rig, &Pose::from_parts(&pose.position(), &rotation))
            };
            margin - turned(turn[k]).min(turned(-turn[k]))
        };
        let differ = self.unknown_at(pose).map_or(0.0, |unknown| {
            2.0 * (1.0 + gains.z_m()) * (unknown.steady + unknown.varying) + unknown.noise
        });
        margin - (0..3).map(lost).sum::<f64>() - differ
    }
}
