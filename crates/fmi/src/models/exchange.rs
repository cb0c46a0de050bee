//! The variables of the plant for Model Exchange: those of the plant, its 13 states, their derivatives and the event indicators.

use super::plant::{
    ANGULAR_VELOCITY, CABLE_LENGTH, DISTURBANCE_FORCE, DISTURBANCE_TORQUE, ENCODER_POSE, FRICTION,
    INITIAL_POSE, MEASURED_TENSION, MOTOR_TENSION, SLACK, VELOCITY, checked_parameters, inputs,
    write as write_outputs,
};
use super::robot::{A, ANCHOR, ATTACHMENT, B, G, GRAVITY, I1, I2, I3, INERTIA, M, MASS, TIME};
use super::{Interface, Scalar};
use crate::values::Values;
use crate::variables::units::{
    METRE, METRE_PER_SECOND, METRE_PER_SECOND2, NEWTON, PER_SECOND, RADIAN_PER_SECOND, RADIAN_PER_SECOND2,
};
use crate::variables::{Row, Shape, local};
use cable_robot::robot::ParameterError;
use cable_robot::sim::body::State;
use cable_robot::sim::variation::{Change, Effect};
use cable_robot::sim::{ContinuousPlant, PlantInputs};

const STATE_POSITION: Row =
    local(600, "state.position", Shape::Vector, Some(&METRE), &[&INITIAL_POSE], "Centre of mass, base frame");
const STATE_VELOCITY: Row =
    local(603, "state.velocity", Shape::Vector, Some(&METRE_PER_SECOND), &[], "Its velocity, base frame");
const STATE_QUATERNION: Row = local(
    606,
    "state.quaternion",
    Shape::Quaternion,
    None,
    &[&INITIAL_POSE],
    "Rotation from the platform's to the base frame; a length other than one is divided out",
);
const STATE_ANGULAR_VELOCITY: Row = local(
    610,
    "state.angularVelocity",
    Shape::Vector,
    Some(&RADIAN_PER_SECOND),
    &[],
    "Angular velocity of the platform in its own frame",
);

const fn rate(
    first: u32,
    of: &'static Row,
    unit: &'static crate::variables::Unit,
    depends_on: &'static [&'static Row],
) -> Row {
    Row {
        derivative_of: Some(of),
        ..local(first, of.name, of.shape, Some(unit), depends_on, "Derivative with respect to time")
    }
}

const OF_POSITION: Row = rate(620, &STATE_POSITION, &METRE_PER_SECOND, &[]);
const OF_VELOCITY: Row = rate(
    623,
    &STATE_VELOCITY,
    &METRE_PER_SECOND2,
    &[
        &A,
        &B,
        &M,
        &G,
        &MASS,
        &GRAVITY,
        &ANCHOR,
        &ATTACHMENT,
        &INITIAL_POSE,
        &MOTOR_TENSION,
        &DISTURBANCE_FORCE,
    ],
);
const OF_QUATERNION: Row = rate(626, &STATE_QUATERNION, &PER_SECOND, &[]);
const OF_ANGULAR_VELOCITY: Row = rate(
    630,
    &STATE_ANGULAR_VELOCITY,
    &RADIAN_PER_SECOND2,
    &[
        &A,
        &B,
        &I1,
        &I2,
        &I3,
        &INERTIA,
        &ANCHOR,
        &ATTACHMENT,
        &INITIAL_POSE,
        &MOTOR_TENSION,
        &DISTURBANCE_TORQUE,
    ],
);
const PULL: Row = Row {
    seventh: 646,
    nominal: Some(10.0),
    ..local(
        640,
        "pull",
        Shape::Cables,
        Some(&NEWTON),
        &[&MOTOR_TENSION, &FRICTION],
        "What the cable would pull if it could also push; it goes slack or taut where this changes sign",
    )
};

/// No encoder stands between the platform and what is seen of it.
const POSE: Row = Row { depends_on: &[&INITIAL_POSE], description: "Pose of the platform", ..ENCODER_POSE };
const LENGTH: Row = Row { description: "Length of the cable", ..CABLE_LENGTH };
const TENSION: Row = Row { description: "Tension of the cable", ..MEASURED_TENSION };

/// The rows of states, in the order in which an integrator has them, with those of their derivatives.
pub const STATES: [(&Row, &Row); 4] = [
    (&STATE_POSITION, &OF_POSITION),
    (&STATE_VELOCITY, &OF_VELOCITY),
    (&STATE_QUATERNION, &OF_QUATERNION),
    (&STATE_ANGULAR_VELOCITY, &OF_ANGULAR_VELOCITY),
];
/// The event indicators.
pub const INDICATORS: &Row = &PULL;

/// The table of the paper's rig.
pub const ROWS: &[&Row] = &[
    &TIME,
    &A,
    &B,
    &M,
    &I1,
    &I2,
    &I3,
    &G,
    &INITIAL_POSE,
    &FRICTION,
    &MOTOR_TENSION,
    &DISTURBANCE_FORCE,
    &DISTURBANCE_TORQUE,
    &POSE,
    &VELOCITY,
    &ANGULAR_VELOCITY,
    &LENGTH,
    &TENSION,
    &SLACK,
    &STATE_POSITION,
    &STATE_VELOCITY,
    &STATE_QUATERNION,
    &STATE_ANGULAR_VELOCITY,
    &OF_POSITION,
    &OF_VELOCITY,
    &OF_QUATERNION,
    &OF_ANGULAR_VELOCITY,
    &PULL,
];

/// Starts a plant with the parameters and inputs in `values`.
pub fn start(interface: &Interface, values: &Values) -> Result<ContinuousPlant, ParameterError> {
    ContinuousPlant::new(checked_parameters(interface, values)?, &inputs(values))
}

/// Copies outputs, states, derivatives and event indicators into `values`, for the inputs that are there.
pub fn write(plant: &ContinuousPlant, values: &mut Values) {
    let inputs = inputs(values);
    write_outputs(&plant.outputs(&inputs), values);
    write_state(&plant.state, values, |(state, _)| state);
    write_state(&plant.derivative(&inputs), values, |(_, rate)| rate);
    values.write(&PULL, plant.indicators(&inputs));
}

fn write_state(state: &State, values: &mut Values, of: fn((&'static Row, &'static Row)) -> &'static Row) {
    let mut numbers = state.iter().copied();
    for row in STATES.map(of) {
        values.write(row, numbers.by_ref().take(row.count(0)));
    }
}

/// By how much the variables change when the `known` ones, states and real inputs, do by the `seed`. Written where the variables themselves stand in
/// `values`.
///
/// # Errors
/// The first known variable that is neither.
pub fn vary(
    plant: &ContinuousPlant,
    values: &mut Values,
    known: &[Scalar],
    seed: &[f64],
) -> Result<(), Scalar> {
    let at = inputs(values);
    let mut by =
        Change { state: State::zeros(), inputs: PlantInputs::none(values.cables(&MOTOR_TENSION).len()) };
    for (scalar, seed) in known.iter().zip(seed) {
        *place(&mut by, scalar).ok_or(*scalar)? += *seed;
    }
    let Effect { derivative, pull, outputs } = plant.vary(&at, &by);
    write_outputs(&outputs, values);
    write_state(&derivative, values, |(_, rate)| rate);
    values.write(&PULL, pull);
    Ok(())
}

/// Where a change of a known variable goes.
fn place<'a>(by: &'a mut Change, scalar: &Scalar) -> Option<&'a mut f64> {
    let Scalar { row, position, .. } = *scalar;
    let inputs = &mut by.inputs;
    match row.first {
        first if first == MOTOR_TENSION.first => Some(&mut inputs.motor_tension[position]),
        first if first == DISTURBANCE_FORCE.first => Some(&mut inputs.disturbance_force[position]),
        first if first == DISTURBANCE_TORQUE.first => Some(&mut inputs.disturbance_torque[position]),
        first => {
            let mut before = 0;
            for (state, _) in STATES {
                if state.first == first {
                    return Some(&mut by.state[before + position]);
                }
                before += state.count(0);
            }
            None
        }
    }
}
