//! The variables of the plant for Model Exchange: those of the plant, its 13 states, their derivatives and the event indicators.

use super::plant::{
    ANGULAR_VELOCITY, CABLE_LENGTH, DISTURBANCE_FORCE, DISTURBANCE_TORQUE, ENCODER_POSE, FRICTION,
    INITIAL_POSE, MEASURED_TENSION, MOTOR_TENSION, SLACK, VELOCITY, checked_parameters, inputs,
    plant_parameters, write as write_outputs,
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
use cable_robot::sim::variation::{Change, Effect, ParameterChange, of_rest};
use cable_robot::sim::{ContinuousPlant, PlantParameters};

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

/// By how much the variables change when the `known` ones, states and real inputs, do by the `seed`; with the initial pose and the parameters that
/// equations are smooth in where `initial` says so. Written where the variables themselves stand in `values`.
///
/// # Errors
/// The first known variable that is none of these.
pub fn vary(
    interface: &Interface,
    plant: &ContinuousPlant,
    values: &mut Values,
    known: &[Scalar],
    seed: &[f64],
    initial: bool,
) -> Result<(), Scalar> {
    let allowed = |scalar: &&Scalar| {
        let is_one_of = |rows: &[&Row]| rows.iter().any(|row| row.first == scalar.row.first);
        is_one_of(&INPUTS) || is_one_of(&STATES.map(|(state, _)| state)) || initial && is_one_of(&SMOOTH)
    };
    if let Some(refused) = known.iter().find(|scalar| !allowed(scalar)) {
        return Err(*refused);
    }
    // Everything is linear in these numbers, so changes are read as the values themselves are.
    let mut seeds = Values::zero(interface.rows(), interface.cables());
    for (scalar, seed) in known.iter().zip(seed) {
        seeds.put(scalar.reference, seeds.at(scalar.reference) + seed);
    }
    let parameters = plant_parameters(interface, &seeds);
    let own = read_state(&seeds);
    let state = own + of_rest(&values.pose(&INITIAL_POSE), &parameters.initial_pose.0);
    let by = Change { state, inputs: inputs(&seeds), parameters: change_of(&parameters) };
    let Effect { derivative, pull, outputs } = plant.vary(&inputs(values), &by);
    write_outputs(&outputs, values);
    write_state(&state, values, |(state, _)| state);
    write_state(&derivative, values, |(_, rate)| rate);
    values.write(&PULL, pull);
    Ok(())
}

const INPUTS: [&Row; 3] = [&MOTOR_TENSION, &DISTURBANCE_FORCE, &DISTURBANCE_TORQUE];
const SMOOTH: [&Row; 14] = [
    &A,
    &B,
    &M,
    &I1,
    &I2,
    &I3,
    &G,
    &MASS,
    &INERTIA,
    &GRAVITY,
    &ANCHOR,
    &ATTACHMENT,
    &INITIAL_POSE,
    &FRICTION,
];

fn read_state(values: &Values) -> State {
    let places = STATES.into_iter().flat_map(|(row, _)| (0..row.count(0)).map(|k| row.reference(k)));
    State::from_iterator(places.map(|reference| values.at(reference)))
}

fn change_of(parameters: &PlantParameters) -> ParameterChange {
    let rig = &parameters.rig;
    ParameterChange {
        anchor: rig.cables.map(|cable| cable.anchor),
        attachment: rig.cables.map(|cable| cable.attachment),
        mass: rig.mass,
        inertia: rig.inertia,
        gravity: rig.gravity,
        friction: parameters.friction,
    }
}
