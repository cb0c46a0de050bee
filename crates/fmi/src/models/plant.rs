//! The plant's variables, and the way from values to a [`Plant`] and back.

use super::Interface;
use super::robot::{
    A, ANCHOR, ATTACHMENT, B, G, GRAVITY, I1, I2, I3, INERTIA, M, MASS, REST_TENSION, TIME, parameters, rig,
    write_rig, write_robot,
};
use crate::values::Values;
use crate::variables::units::{METRE, METRE_PER_SECOND, NEWTON, NEWTON_METRE, RADIAN_PER_SECOND, SECOND};
use crate::variables::{Kind, Row, Shape, Variability, input, output, parameter, setting};
use cable_robot::control::static_tensions;
use cable_robot::robot::{ParameterError, Pose, Rig, Shape as PaperShape};
use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

pub(super) const INITIAL_POSE: Row = Row {
    shape: Shape::Pose,
    ..parameter(
        8,
        "initialPose",
        &METRE,
        &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "Pose at which the platform hangs at rest when the simulation starts",
    )
};
pub(super) const FRICTION: Row = Row {
    min: Some(0.0),
    ..parameter(14, "friction", &NEWTON, &[0.0], "Coulomb friction between motor and platform, a cable")
};
const MOTOR_LAG: Row = Row {
    min: Some(0.0),
    ..parameter(15, "motorLag", &SECOND, &[0.0], "Time constant of the motors' torque, 0 for none")
};
const ENCODER_RESOLUTION: Row = Row {
    min: Some(0.0),
    ..parameter(
        16,
        "encoderResolution",
        &METRE,
        &[0.0],
        "Smallest change of cable length that the encoders see, 0 for all",
    )
};
const LOAD_CELL_NOISE: Row = Row {
    min: Some(0.0),
    ..parameter(17, "loadCellNoise", &NEWTON, &[0.0], "Standard deviation of the load cells' noise")
};
const NOISE_SEED: Row = setting(
    18,
    "noiseSeed",
    Kind::Int32,
    &[1.0],
    "Seed of the load cells' noise: the same seed, the same noise",
);

pub(super) const MOTOR_TENSION: Row = Row {
    seventh: 500,
    nominal: Some(10.0),
    ..input(
        100,
        "motorTension",
        Shape::Cables,
        Some(&NEWTON),
        &[REST_TENSION],
        "Commanded tension of the cable's motor; negative pulls with zero",
    )
};
pub(super) const DISTURBANCE_FORCE: Row = input(
    106,
    "disturbanceForce",
    Shape::Vector,
    Some(&NEWTON),
    &[0.0],
    "Force on the platform's centre of mass, base frame",
);
pub(super) const DISTURBANCE_TORQUE: Row = input(
    109,
    "disturbanceTorque",
    Shape::Vector,
    Some(&NEWTON_METRE),
    &[0.0],
    "Torque on the platform, base frame",
);

const POSE: &[&Row] = &[&A, &B, &ANCHOR, &ATTACHMENT, &INITIAL_POSE, &ENCODER_RESOLUTION];
const TENSION: &[&Row] = &[&LOAD_CELL_NOISE, &NOISE_SEED, &MOTOR_TENSION];

pub(super) const ENCODER_POSE: Row =
    output(200, "encoderPose", Shape::Pose, None, POSE, "Pose of the platform as the encoders see it");
pub(super) const VELOCITY: Row =
    output(206, "velocity", Shape::Vector, Some(&METRE_PER_SECOND), &[], "Velocity of the centre of mass");
pub(super) const ANGULAR_VELOCITY: Row = output(
    209,
    "angularVelocity",
    Shape::Vector,
    Some(&RADIAN_PER_SECOND),
    &[],
    "Angular velocity of the platform, base frame",
);
pub(super) const CABLE_LENGTH: Row = Row {
    seventh: 510,
    ..output(
        212,
        "cableLength",
        Shape::Cables,
        Some(&METRE),
        POSE,
        "Length of the cable as its encoder sees it",
    )
};
pub(super) const MEASURED_TENSION: Row = Row {
    seventh: 520,
    nominal: Some(10.0),
    ..output(
        218,
        "measuredTension",
        Shape::Cables,
        Some(&NEWTON),
        TENSION,
        "Tension of the cable as its load cell sees it",
    )
};
pub(super) const SLACK: Row = Row {
    seventh: 530,
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(224, "slack", Shape::Cables, None, &[&MOTOR_TENSION], "Whether the cable pulls with nothing")
};

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
    &MOTOR_LAG,
    &ENCODER_RESOLUTION,
    &LOAD_CELL_NOISE,
    &NOISE_SEED,
    &MOTOR_TENSION,
    &DISTURBANCE_FORCE,
    &DISTURBANCE_TORQUE,
    &ENCODER_POSE,
    &VELOCITY,
    &ANGULAR_VELOCITY,
    &CABLE_LENGTH,
    &MEASURED_TENSION,
    &SLACK,
];

/// A table of the paper's rig made one of another rig.
pub fn rows_of(table: &[&'static Row]) -> Vec<&'static Row> {
    let of_paper = [&A, &B, &M, &I1, &I2, &I3, &G].map(|row| row.name);
    let mut rows = vec![&TIME, &MASS, &INERTIA, &GRAVITY, &ANCHOR, &ATTACHMENT];
    rows.extend(table.iter().skip(1).filter(|row| !of_paper.contains(&row.name)));
    rows
}

/// Starts a plant with the parameters and inputs in `values`.
pub fn start(interface: &Interface, values: &Values) -> Result<Plant, ParameterError> {
    Plant::new(checked_parameters(interface, values)?, &inputs(values))
}

/// The parameters, those of the paper's robot checked under their own names. What a table lacks is zero.
pub(super) fn checked_parameters(
    interface: &Interface,
    values: &Values,
) -> Result<PlantParameters, ParameterError> {
    if interface.rig().is_none() {
        parameters(values).validate()?;
    }
    Ok(plant_parameters(interface, values))
}

pub(super) fn plant_parameters(interface: &Interface, values: &Values) -> PlantParameters {
    let default = PlantParameters::default();
    PlantParameters {
        rig: match interface.rig() {
            Some(known) => rig(values, known),
            None => Rig::paper(&parameters(values), default.rig.common_limits()),
        },
        initial_pose: values.pose(&INITIAL_POSE),
        friction: values.scalar(&FRICTION),
        motor_lag: values.scalar(&MOTOR_LAG),
        encoder_resolution: values.scalar(&ENCODER_RESOLUTION),
        load_cell_noise: values.scalar(&LOAD_CELL_NOISE),
        noise_seed: values.integer(&NOISE_SEED),
    }
}

/// What the plant reads in a step.
pub fn inputs(values: &Values) -> PlantInputs {
    PlantInputs {
        motor_tension: values.cables(&MOTOR_TENSION),
        disturbance_force: values.vector(&DISTURBANCE_FORCE),
        disturbance_torque: values.vector(&DISTURBANCE_TORQUE),
    }
}

/// Copies the outputs into `values`.
pub fn write(outputs: &PlantOutputs, values: &mut Values) {
    values.write(&ENCODER_POSE, outputs.encoder_pose.0.iter().copied());
    values.write(&VELOCITY, outputs.velocity.iter().copied());
    values.write(&ANGULAR_VELOCITY, outputs.angular_velocity.iter().copied());
    values.write(&CABLE_LENGTH, outputs.cable_length);
    values.write(&MEASURED_TENSION, outputs.measured_tension);
    values.write(&SLACK, outputs.slack.map(f64::from));
}

/// Copies parameters into `values`. Those of the paper's interface take the paper's robot of the rig.
pub fn write_parameters(interface: &Interface, parameters: &PlantParameters, values: &mut Values) {
    match (interface.rig(), PaperShape::of(&parameters.rig)) {
        (None, Ok(shape)) => write_robot(&shape.robot, values),
        _ => write_rig(&parameters.rig, values),
    }
    values.write(&INITIAL_POSE, parameters.initial_pose.0.iter().copied());
    values.write(&FRICTION, [parameters.friction]);
    values.write(&MOTOR_LAG, [parameters.motor_lag]);
    values.write(&ENCODER_RESOLUTION, [parameters.encoder_resolution]);
    values.write(&LOAD_CELL_NOISE, [parameters.load_cell_noise]);
    values.write(&NOISE_SEED, [parameters.noise_seed.into()]);
}

/// The start values of a rig's table: at home, at rest.
pub fn write_start(rig: &Rig, home: &Pose, values: &mut Values) {
    write_rig(rig, values);
    values.write(&INITIAL_POSE, home.0.iter().copied());
    let tension = static_tensions(rig, home, 0.0).unwrap_or_else(|| rig.cables.map(|_| 0.0));
    values.write(&MOTOR_TENSION, tension);
}

/// Copies inputs into `values`.
pub fn write_inputs(inputs: &PlantInputs, values: &mut Values) {
    values.write(&MOTOR_TENSION, inputs.motor_tension);
    values.write(&DISTURBANCE_FORCE, inputs.disturbance_force.iter().copied());
    values.write(&DISTURBANCE_TORQUE, inputs.disturbance_torque.iter().copied());
}

/// What [`write()`] wrote.
pub fn outputs(values: &Values) -> PlantOutputs {
    PlantOutputs {
        encoder_pose: values.pose(&ENCODER_POSE),
        velocity: values.vector(&VELOCITY),
        angular_velocity: values.vector(&ANGULAR_VELOCITY),
        cable_length: values.cables(&CABLE_LENGTH),
        measured_tension: values.cables(&MEASURED_TENSION),
        slack: values.cables(&SLACK).map(|slack| slack != 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use cable_robot::robot::RobotParameters;

    #[test]
    fn the_start_values_are_the_defaults_of_the_domain() {
        let interface = Model::Plant.interface();
        assert_eq!(plant_parameters(&interface, interface.start()), PlantParameters::default());
    }

    #[test]
    fn what_is_written_is_read_back() {
        let interface = Model::Plant.interface();
        let mut values = interface.start().clone();
        for (k, scalar) in interface.scalars().enumerate() {
            values.put(scalar.reference, k as f64);
        }
        // Numbers that the paper's robot is recognised by.
        write_robot(&RobotParameters { a: 0.7, b: 0.2, ..RobotParameters::default() }, &mut values);
        values.write(&SLACK, [1.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        let mut copy = interface.start().clone();
        copy.put(TIME.first, values.at(TIME.first));
        write_parameters(&interface, &plant_parameters(&interface, &values), &mut copy);
        write_inputs(&inputs(&values), &mut copy);
        write(&outputs(&values), &mut copy);
        assert_eq!(copy, values);
    }
}
