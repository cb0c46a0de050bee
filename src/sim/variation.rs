//! How the plant in continuous time answers to small changes of state and inputs: its equations, differentiated by hand.

use nalgebra::{Quaternion, Rotation3, Vector3};

use super::body::{self, State};
use super::plant::{FRICTION_TURNOVER, PlantInputs, PlantOutputs};
use crate::robot::{Coordinates, PerCable, Pose, Rig};

/// A change of state and inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Of the state.
    pub state: State,
    /// Of the inputs.
    pub inputs: PlantInputs,
}

/// What it changes, to first order. Which cables are slack does not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// The state's derivative with respect to time.
    pub derivative: State,
    /// What each cable would pull if it could push, N.
    pub pull: PerCable<f64>,
    /// The outputs.
    pub outputs: PlantOutputs,
}

/// Where the changes begin.
pub(super) struct Point<'a> {
    pub rig: &'a Rig,
    pub friction: f64,
    pub state: &'a State,
    pub inputs: &'a PlantInputs,
    pub taut: &'a PerCable<bool>,
    /// Of the cables, N.
    pub tension: PerCable<f64>,
}

impl Point<'_> {
    pub fn vary(&self, by: &Change) -> Effect {
        let rotation = body::rotation(self.state);
        let cables = self.rig.cables(&body::position(self.state), &rotation);
        let moved = Moved::new(self.state, &by.state, &rotation);

        // Of attachments, directions and speeds of length.
        let arm = self.rig.cables.map(|cable| rotation * moved.turn.cross(&cable.attachment));
        let shift = arm.map(|arm| moved.position + arm);
        let direction = self.rig.turned_by(&cables, &body::position(self.state), &shift);
        let (velocity, omega) = (body::velocity(self.state), body::angular_velocity(self.state));
        let angular_velocity = rotation * (moved.turn.cross(&moved.own_omega) + moved.omega);
        let length_rate = PerCable::from_fn(arm.len(), |i| {
            let at = velocity + omega.cross(&cables.arm[i]);
            let at_moved = moved.velocity + angular_velocity.cross(&cables.arm[i]) + omega.cross(&arm[i]);
            -direction[i].dot(&at) - cables.direction[i].dot(&at_moved)
        });

        let rates = cables.length_rates(&body::twist(self.state));
        let pull = self.pull(&rates, &length_rate, &by.inputs.motor_tension);
        let tension = PerCable::from_fn(pull.len(), |i| if self.taut[i] { pull[i] } else { 0.0 });

        let (mut force, mut torque) = (by.inputs.disturbance_force, by.inputs.disturbance_torque);
        for i in 0..arm.len() {
            let bent = cables.direction[i] * tension[i] + direction[i] * self.tension[i];
            force += bent;
            torque += cables.arm[i].cross(&bent) + arm[i].cross(&(cables.direction[i] * self.tension[i]));
        }
        let (_, turning) = cables.wrench(&self.tension);
        let torque = (torque, turning + self.inputs.disturbance_torque);

        let pose = Pose::from_parts(&body::position(self.state), &rotation);
        // E φ' is the angular velocity; near a quarter turn of pitch the angles do not tell.
        let angles = pose.rate_matrix().try_inverse().unwrap_or_default() * (rotation * moved.turn);
        let mut encoder_pose = Coordinates::zeros();
        encoder_pose.fixed_rows_mut::<3>(0).copy_from(&moved.position);
        encoder_pose.fixed_rows_mut::<3>(3).copy_from(&angles);
        Effect {
            derivative: self.derivative(&moved, &rotation, &force, torque),
            pull,
            outputs: PlantOutputs {
                encoder_pose: Pose(encoder_pose),
                velocity: moved.velocity,
                angular_velocity,
                cable_length: PerCable::from_fn(arm.len(), |i| -cables.direction[i].dot(&shift[i])),
                measured_tension: tension,
                slack: self.taut.map(|_| false),
            },
        }
    }

    fn pull(&self, rates: &PerCable<f64>, by: &PerCable<f64>, command: &PerCable<f64>) -> PerCable<f64> {
        if self.friction == 0.0 {
            return *command;
        }
        PerCable::from_fn(rates.len(), |i| {
            let turned = libm::tanh(rates[i] / FRICTION_TURNOVER);
            let of_friction = self.friction * (1.0 - turned * turned) * by[i] / FRICTION_TURNOVER;
            if self.inputs.motor_tension[i] > 0.0 { command[i] + of_friction } else { of_friction }
        })
    }

    /// Of Newton and Euler's equations: the change of the force, and the change of the torque with the torque itself, base frame.
    fn derivative(
        &self,
        moved: &Moved,
        rotation: &Rotation3<f64>,
        force: &Vector3<f64>,
        (by, torque): (Vector3<f64>, Vector3<f64>),
    ) -> State {
        let (inertia, back) = (self.rig.inertia, rotation.inverse());
        let turned = back * by - moved.turn.cross(&(back * torque));
        let gyroscopic =
            moved.omega.cross(&(inertia * moved.own_omega)) + moved.own_omega.cross(&(inertia * moved.omega));
        let spin = (moved.quaternion * Quaternion::from_imag(moved.own_omega)
            + moved.own_quaternion * Quaternion::from_imag(moved.omega))
            * 0.5;
        let mut rate = State::zeros();
        rate.fixed_rows_mut::<3>(0).copy_from(&moved.velocity);
        rate.fixed_rows_mut::<3>(3).copy_from(&(force / self.rig.mass));
        rate.fixed_rows_mut::<4>(6).copy_from_slice(&[spin.w, spin.i, spin.j, spin.k]);
        let angular = inertia.lu().solve(&(turned - gyroscopic)).unwrap_or_default();
        rate.fixed_rows_mut::<3>(10).copy_from(&angular);
        rate
    }
}

/// The parts of a change of the state, and of the state what they act on.
struct Moved {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    quaternion: Quaternion<f64>,
    omega: Vector3<f64>,
    /// The rotation that the change of the quaternion is, platform's frame, rad.
    turn: Vector3<f64>,
    own_quaternion: Quaternion<f64>,
    own_omega: Vector3<f64>,
}

impl Moved {
    fn new(state: &State, by: &State, rotation: &Rotation3<f64>) -> Self {
        let (own, change) = (body::quaternion(state), body::quaternion(by));
        Self {
            position: body::position(by),
            velocity: body::velocity(by),
            quaternion: change,
            omega: by.fixed_rows::<3>(10).into_owned(),
            turn: (own.conjugate() * change).imag() * (2.0 / own.norm_squared()),
            own_quaternion: own,
            own_omega: rotation.inverse() * body::angular_velocity(state),
        }
    }
}
