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
        self.parameters.unknown_at(pose).at_rest()
    }

    /// What the tensions on the way between two poses may differ by, N.
    pub(super) fn unknown_on_the_way(&self, from: &Pose, to: &Pose) -> f64 {
        let share = 2.0 * (1.0 + self.parameters.gains().z_m());
        let at = |pose: &Pose| {
            let Unknown { mass, geometry, wrench, noise } = self.parameters.unknown_at(pose);
            // The observer finds the mass once and for all; the others may change to their opposite.
            share * (mass + 2.0 * (geometry + wrench)) + noise
        };
        at(from).max(at(to))
    }

    /// What is not known at these poses, the greatest of each kind.
    pub(super) fn unknown_by(&self, poses: &[Pose]) -> Unknown {
        let all = poses.iter().map(|pose| self.parameters.unknown_at(pose));
        all.fold(Unknown::default(), |most, one| most.and(&one))
    }
}

/// The law and the observer answer a wrench that changes as it likes with at most this many times its greatest size, whatever the gains: docs/minimum-time.md.
const ANSWER: f64 = 2.0;

/// What tensions at rest may differ by, N.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Unknown {
    /// For the mass,
    mass: f64,
    /// for the geometry,
    geometry: f64,
    /// for forces and torques,
    wrench: f64,
    /// for measurements that jump.
    noise: f64,
}

impl Unknown {
    pub(super) fn at_rest(&self) -> f64 {
        self.mass + (self.geometry + self.wrench) + self.noise
    }

    /// On a motion that the law has followed since a rest, where cables pull `pull` times as much as at rest: for mass and geometry tensions differ by as many times more. `found`
    /// is what the observer has found of it, which the motion is planned with.
    pub(super) fn when_followed(&self, pull: f64, found: f64) -> f64 {
        let at_rest = self.mass + (self.geometry + self.wrench);
        ANSWER * (pull * (self.mass + self.geometry) + self.wrench) + found.min(at_rest) + self.noise
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            mass: self.mass.max(other.mass),
            geometry: self.geometry.max(other.geometry),
            wrench: self.wrench.max(other.wrench),
            noise: self.noise.max(other.noise),
        }
    }
}

impl ControllerParameters {
    /// The first parameter of those that say what is not known which is not zero.
    pub(super) fn is_uncertain(&self) -> Option<(&'static str, f64)> {
        self.unknowns().into_iter().find(|(_, value)| *value > 0.0)
    }

    /// The largest torque that is not known, the geometry's apart, N m.
    fn torque_bound(&self) -> f64 {
        self.disturbance_bound * self.rig.platform_radius()
    }

    /// Nothing if all is known; without bound where the wrench matrix is singular.
    fn unknown_at(&self, pose: &Pose) -> Unknown {
        if self.is_uncertain().is_none() {
            return Unknown::default();
        }
        let Some(sensitivity) = Sensitivity::new(&self.rig, pose) else {
            return Unknown { mass: f64::INFINITY, ..Unknown::default() };
        };
        let pole = self.observer().map_or(0.0, |observer| observer.pole);
        Unknown {
            mass: sensitivity.mass(self.mass_tolerance),
            geometry: sensitivity.geometry(self.rig.accuracy),
            wrench: sensitivity.wrench(self.disturbance_bound, self.torque_bound()),
            noise: sensitivity.encoders(self.encoder_resolution, &self.gains(), pole),
        }
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
        let Unknown { mass, geometry, wrench, noise } = self.unknown_at(pose);
        let differ = 2.0 * (1.0 + gains.z_m()) * (mass + (geometry + wrench)) + noise;
        margin - (0..3).map(lost).sum::<f64>() - differ
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{DisturbanceObserver, Estimator, Gains};
    use crate::robot::{Coordinates, RigFile};

    /// What law and observer answer a push with, integrated over all time without its sign, in units of the push: the most that they answer any other with.
    fn answer(gains: &Gains, pole: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let (rig, home) = (RigFile::default().rig, Pose::default());
        let observer = DisturbanceObserver { pole, force: 1.0, torque: 1.0 };
        // m/s, along x: so little that nothing else comes in.
        let push = 1e-6;
        let (mut x, mut v, mut answer) = (0.0, push, 0.0);
        let (mut estimator, mut before) = (Estimator::at_rest(home), 0.0);
        let duration = 14.0 / gains.lambda.min(gains.eta).min(pole);
        for _ in 0..(duration / STEP) as u32 {
            let mut measured = home;
            measured.0[0] += x;
            let along_x = |value: f64| Coordinates::ith(0, value);
            let imposed = along_x(before) + estimator.disturbing(&rig);
            estimator.update(&measured, &imposed, STEP, Some((&rig, &observer)));
            let error = estimator.pose.0[0] - home.0[0];
            let law = -(gains.lambda + gains.eta) * estimator.rates[0] - gains.omega_n_squared() * error;
            let given = law - estimator.disturbing(&rig)[0];
            answer += given.abs() * STEP / push;
            x += v * STEP + given * (0.5 * STEP * STEP);
            v += given * STEP;
            before = given;
        }
        answer
    }

    #[test]
    fn no_wrench_is_answered_with_more_than_twice_its_size() {
        let mut most = 0.0f64;
        for (lambda, eta) in [(1.0, 1.0), (3.0, 3.0), (15.0, 2.0), (15.0, 15.0), (60.0, 60.0)] {
            for pole in [2.0, 10.0] {
                let answer = answer(&Gains { lambda, eta }, pole);
                println!("gains {lambda} and {eta}, observer {pole}: {answer:.3}");
                most = most.max(answer);
            }
        }
        assert!(most < ANSWER && most > 0.95 * ANSWER, "{most}");
    }
}
