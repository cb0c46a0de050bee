//! The rigid body on its cables: 13 states and their derivative.

use nalgebra::{LU, Quaternion, Rotation3, SVector, U3, UnitQuaternion, Vector3, Vector6};

use crate::robot::memory::are_finite;
use crate::robot::{Cables, Coordinates, PerCable, Pose, Rig};

/// Position (m), velocity (m/s), quaternion (w, x, y, z) from the platform's to the base frame, angular velocity in the platform's
/// frame (rad/s).
pub type State = SVector<f64, 13>;

/// The state at rest at a pose.
pub fn at_rest(pose: &Pose) -> State {
    let mut state = State::zeros();
    state.fixed_rows_mut::<3>(0).copy_from(&pose.position());
    let q = UnitQuaternion::from_rotation_matrix(&pose.rotation());
    state.fixed_rows_mut::<4>(6).copy_from_slice(&[q.w, q.i, q.j, q.k]);
    state
}

/// The state at a pose, moving with these rates of the six coordinates.
pub fn moving(pose: &Pose, rates: &Coordinates) -> State {
    let mut state = at_rest(pose);
    state.fixed_rows_mut::<3>(3).copy_from(&rates.fixed_rows::<3>(0));
    let omega = pose.rate_matrix() * rates.fixed_rows::<3>(3);
    state.fixed_rows_mut::<3>(10).copy_from(&(pose.rotation().inverse() * omega));
    state
}

/// Centre of mass, m.
pub fn position(state: &State) -> Vector3<f64> {
    state.fixed_rows::<3>(0).into_owned()
}

/// Velocity of the centre of mass, m/s, base frame.
pub fn velocity(state: &State) -> Vector3<f64> {
    state.fixed_rows::<3>(3).into_owned()
}

/// Orientation as a matrix.
pub fn rotation(state: &State) -> Rotation3<f64> {
    let quaternion = quaternion(state);
    let size = quaternion.coords.amax();
    // Whose square is no number any more.
    let is_extreme = size > 0.0 && !(1e-100..1e100).contains(&size);
    let quaternion = if is_extreme { quaternion / size } else { quaternion };
    UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix()
}

/// Angular velocity in the base frame, rad/s.
pub fn angular_velocity(state: &State) -> Vector3<f64> {
    rotation(state) * state.fixed_rows::<3>(10)
}

/// (velocity, angular velocity) in the base frame.
pub fn twist(state: &State) -> Vector6<f64> {
    let (v, w) = (velocity(state), angular_velocity(state));
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}

/// The state with its quaternion brought back to length one.
pub fn normalised(mut state: State) -> State {
    let length = state.fixed_rows::<4>(6).norm();
    state.fixed_rows_mut::<4>(6).unscale_mut(length);
    state
}

/// Whether they are finite numbers, and the orientation is one, as [`normalised`] leaves it.
pub(super) fn is_sound(state: &State) -> bool {
    const ROUNDING: f64 = 1e-12;
    are_finite(state) && (state.fixed_rows::<4>(6).norm() - 1.0).abs() < ROUNDING
}

pub(super) fn quaternion(state: &State) -> Quaternion<f64> {
    Quaternion::new(state[6], state[7], state[8], state[9])
}

/// A rig, and its inertia tensor made ready to be divided by.
pub struct Body<'a> {
    rig: &'a Rig,
    inverse: LU<f64, U3, U3>,
}

impl<'a> Body<'a> {
    /// The platform of a rig.
    pub fn new(rig: &'a Rig) -> Self {
        Self { rig, inverse: rig.inertia.lu() }
    }
}

/// Newton and Euler's equations (1), solved for the accelerations. `tension` gives the pull of the cables (N) at this state;
/// `force` (N) and `torque` (N m), base frame, act besides.
pub fn derivative(
    body: &Body,
    state: &State,
    tension: impl FnOnce(&Cables) -> PerCable<f64>,
    (force, torque): (&Vector3<f64>, &Vector3<f64>),
) -> State {
    let rotation = rotation(state);
    let rig = body.rig;
    let cables = rig.cables(&position(state), &rotation);
    let (pull, turn) = cables.wrench(&tension(&cables));

    let mut acceleration = (pull + force) / rig.mass;
    acceleration += rig.gravity;

    let omega: Vector3<f64> = state.fixed_rows::<3>(10).into_owned();
    let momentum = rig.inertia * omega;
    let torque = rotation.inverse() * (turn + torque) - omega.cross(&momentum);
    // A tensor whose inverse does not exist is refused before.
    let angular_acceleration = body.inverse.solve(&torque).unwrap_or_default();
    let spin = quaternion(state) * Quaternion::from_imag(omega) * 0.5;

    let mut rate = State::zeros();
    rate.fixed_rows_mut::<3>(0).copy_from(&velocity(state));
    rate.fixed_rows_mut::<3>(3).copy_from(&acceleration);
    rate.fixed_rows_mut::<4>(6).copy_from_slice(&[spin.w, spin.i, spin.j, spin.k]);
    rate.fixed_rows_mut::<3>(10).copy_from(&angular_acceleration);
    rate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tensions;
    use crate::robot::RigFile;

    #[test]
    fn tensions_of_the_inverse_dynamics_give_the_accelerations_asked_for() {
        for text in [include_str!("../../rigs/paper.toml"), include_str!("../../rigs/eight.toml")] {
            let RigFile { mut rig, home, .. } = RigFile::parse(text).unwrap();
            (rig.inertia[(0, 1)], rig.inertia[(1, 0)]) = (0.005, 0.005);
            let pose = Pose(home.0 + Coordinates::new(0.05, -0.04, 0.1, 0.1, -0.2, 0.3));
            gives_the_accelerations(&rig, &pose);
        }
    }

    fn gives_the_accelerations(rig: &Rig, pose: &Pose) {
        let rates = Coordinates::new(0.1, 0.2, -0.1, 0.3, 0.4, -0.5);
        let wanted = Coordinates::new(0.5, -0.6, 0.7, 0.8, -0.9, 1.0);
        let tension = tensions(rig, pose, &rates, &wanted, 0.0).unwrap();
        let state = moving(pose, &rates);
        let none = Vector3::zeros();
        let rate = derivative(&Body::new(rig), &state, |_| tension, (&none, &none));
        // α = E φ'' + E' φ' in the base frame; the body frame's ω' is Rᵀα.
        let alpha = pose.rate_matrix() * wanted.fixed_rows::<3>(3)
            + pose.rate_matrix_derivative(&rates) * rates.fixed_rows::<3>(3);
        assert!((rate.fixed_rows::<3>(3) - wanted.fixed_rows::<3>(0)).norm() < 1e-11);
        assert!((rate.fixed_rows::<3>(10) - pose.rotation().inverse() * alpha).norm() < 1e-10);
    }
}
