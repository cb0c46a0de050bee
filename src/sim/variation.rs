//! How the plant in continuous time answers to small changes of state, inputs and parameters: its equations, differentiated by hand.

use nalgebra::{Matrix3, Quaternion, Rotation3, Vector3};

use super::body::{self, State};
use super::plant::{FRICTION_TURNOVER, PlantInputs, PlantOutputs, held_back};
use crate::robot::{Coordinates, PerCable, Pose, Rig};

/// A change of state, inputs and parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Of the state.
    pub state: State,
    /// Of the inputs.
    pub inputs: PlantInputs,
    /// Of the parameters.
    pub parameters: ParameterChange,
}

/// A change of the parameters that the equations are smooth in; units as those of [`Rig`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterChange {
    /// Of each cable's anchor.
    pub anchor: PerCable<Vector3<f64>>,
    /// Of each cable's attachment.
    pub attachment: PerCable<Vector3<f64>>,
    /// Of the platform's mass.
    pub mass: f64,
    /// Of its inertia.
    pub inertia: Matrix3<f64>,
    /// Of gravity.
    pub gravity: Vector3<f64>,
    /// Of the friction, N.
    pub friction: f64,
}

impl Change {
    /// Nothing changes.
    pub fn none(cables: usize) -> Self {
        let parameters = ParameterChange {
            anchor: PerCable::filled(cables, Vector3::zeros()),
            attachment: PerCable::filled(cables, Vector3::zeros()),
            mass: 0.0,
            inertia: Matrix3::zeros(),
            gravity: Vector3::zeros(),
            friction: 0.0,
        };
        Self { state: State::zeros(), inputs: PlantInputs::none(cables), parameters }
    }
}

/// The change of the state at rest at a pose when that pose changes.
pub fn of_rest(pose: &Pose, by: &Coordinates) -> State {
    let rest = body::at_rest(pose);
    // E φ' is an angular velocity in the base frame; q' = q (0, Ω) / 2 with Ω in the platform's.
    let turn = pose.rotation().inverse() * (pose.rate_matrix() * by.fixed_rows::<3>(3));
    let quaternion = body::quaternion(&rest) * Quaternion::from_imag(turn) * 0.5;
    let mut change = State::zeros();
    change.fixed_rows_mut::<3>(0).copy_from(&by.fixed_rows::<3>(0));
    change.fixed_rows_mut::<4>(6).copy_from_slice(&[quaternion.w, quaternion.i, quaternion.j, quaternion.k]);
    change
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
        let ParameterChange { anchor, attachment, .. } = &by.parameters;
        let arm = PerCable::from_fn(self.rig.cables.len(), |i| {
            rotation * (moved.turn.cross(&self.rig.cables[i].attachment) + attachment[i])
        });
        let shift = PerCable::from_fn(arm.len(), |i| moved.position + arm[i] - anchor[i]);
        let direction = self.rig.turned_by(&cables, &body::position(self.state), &shift);
        let (velocity, omega) = (body::velocity(self.state), body::angular_velocity(self.state));
        let angular_velocity = rotation * (moved.turn.cross(&moved.own_omega) + moved.omega);
        let length_rate = PerCable::from_fn(arm.len(), |i| {
            let at = velocity + omega.cross(&cables.arm[i]);
            let at_moved = moved.velocity + angular_velocity.cross(&cables.arm[i]) + omega.cross(&arm[i]);
            -direction[i].dot(&at) - cables.direction[i].dot(&at_moved)
        });

        let rates = cables.length_rates(&body::twist(self.state));
        let pull = self.pull(&rates, &length_rate, by);
        let tension = PerCable::from_fn(pull.len(), |i| if self.taut[i] { pull[i] } else { 0.0 });

        let (mut force, mut torque) = (by.inputs.disturbance_force, by.inputs.disturbance_torque);
        for i in 0..arm.len() {
            let bent = cables.direction[i] * tension[i] + direction[i] * self.tension[i];
            force += bent;
            torque += cables.arm[i].cross(&bent) + arm[i].cross(&(cables.direction[i] * self.tension[i]));
        }
        let (pulling, turning) = cables.wrench(&self.tension);
        let force = (force, pulling + self.inputs.disturbance_force);
        let torque = (torque, turning + self.inputs.disturbance_torque);

        let pose = Pose::from_parts(&body::position(self.state), &rotation);
        // E φ' is the angular velocity; near a quarter turn of pitch the angles do not tell.
        let angles = pose.rate_matrix().try_inverse().unwrap_or_default() * (rotation * moved.turn);
        let mut encoder_pose = Coordinates::zeros();
        encoder_pose.fixed_rows_mut::<3>(0).copy_from(&moved.position);
        encoder_pose.fixed_rows_mut::<3>(3).copy_from(&angles);
        Effect {
            derivative: self.derivative(&moved, &rotation, &by.parameters, force, torque),
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

    fn pull(&self, rates: &PerCable<f64>, changed: &PerCable<f64>, by: &Change) -> PerCable<f64> {
        let command = &by.inputs.motor_tension;
        if self.friction == 0.0 && by.parameters.friction == 0.0 {
            return *command;
        }
        PerCable::from_fn(rates.len(), |i| {
            let turned = libm::tanh(rates[i] / FRICTION_TURNOVER);
            let of_friction = self.friction * (1.0 - turned * turned) * changed[i] / FRICTION_TURNOVER
                + held_back(by.parameters.friction, rates[i]);
            if self.inputs.motor_tension[i] > 0.0 { command[i] + of_friction } else { of_friction }
        })
    }

    /// Of Newton and Euler's equations: the changes of force and torque, each with what it is itself, base frame; no gravity in them.
    fn derivative(
        &self,
        moved: &Moved,
        rotation: &Rotation3<f64>,
        by: &ParameterChange,
        (force_change, force): (Vector3<f64>, Vector3<f64>),
        (torque_change, torque): (Vector3<f64>, Vector3<f64>),
    ) -> State {
        let (inertia, back) = (self.rig.inertia, rotation.inverse());
        let factors = inertia.lu();
        let solve = |torque: &Vector3<f64>| factors.solve(torque).unwrap_or_default();
        let spun = moved.own_omega.cross(&(inertia * moved.own_omega));
        let acceleration = solve(&(back * torque - spun));
        let turned = back * torque_change - moved.turn.cross(&(back * torque)) - by.inertia * acceleration;
        let gyroscopic = moved.omega.cross(&(inertia * moved.own_omega))
            + moved.own_omega.cross(&(inertia * moved.omega + by.inertia * moved.own_omega));
        let spin = (moved.quaternion * Quaternion::from_imag(moved.own_omega)
            + moved.own_quaternion * Quaternion::from_imag(moved.omega))
            * 0.5;
        let mut rate = State::zeros();
        rate.fixed_rows_mut::<3>(0).copy_from(&moved.velocity);
        let mass = self.rig.mass;
        let linear = (force_change - force * (by.mass / mass)) / mass + by.gravity;
        rate.fixed_rows_mut::<3>(3).copy_from(&linear);
        rate.fixed_rows_mut::<4>(6).copy_from_slice(&[spin.w, spin.i, spin.j, spin.k]);
        rate.fixed_rows_mut::<3>(10).copy_from(&solve(&(turned - gyroscopic)));
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
