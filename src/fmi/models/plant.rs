//! The plant's variables, and the way from values to a [`Plant`] and back.

use super::robot::{A, B, G, I1, I2, I3, M, REST_TENSION, TIME, parameters, write_robot};
use crate::fmi::values::Values;
use crate::fmi::variables::units::{
    METRE, METRE_PER_SECOND, NEWTON, NEWTON_METRE, RADIAN_PER_SECOND, SECOND,
};
use crate::fmi::variables::{Kind, Row, Shape, Variability, input, output, parameter, setting};
use crate::robot::ParameterError;
use crate::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

const INITIAL_POSE: Row = Row {
    shape: Shape::Pose,
    ..parameter(
        8,
        "initialPose",
        &METRE,
        &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "Pose at which the platform hangs at rest when the simulation starts",
    )
};
const FRICTION: Row = Row {
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

const MOTOR_TENSION: Row = Row {
    nominal: Some(10.0),
    ..input(
        100,
        "motorTension",
        Shape::Cables,
        Some(&NEWTON),
        &[REST_TENSION],
        "What the motor of the cable is told to pull; negative pulls with zero",
    )
};
const DISTURBANCE_FORCE: Row = input(
    106,
    "disturbanceForce",
    Shape::Vector,
    Some(&NEWTON),
    &[0.0],
    "Force on the platform's centre of mass, base frame",
);
const DISTURBANCE_TORQUE: Row = input(
    109,
    "disturbanceTorque",
    Shape::Vector,
    Some(&NEWTON_METRE),
    &[0.0],
    "Torque on the platform, base frame",
);

const POSE: &[&Row] = &[&A, &B, &INITIAL_POSE, &ENCODER_RESOLUTION];
const TENSION: &[&Row] = &[&LOAD_CELL_NOISE, &NOISE_SEED, &MOTOR_TENSION];

const ENCODER_POSE: Row =
    output(200, "encoderPose", Shape::Pose, None, POSE, "Pose of the platform as the encoders see it");
const VELOCITY: Row =
    output(206, "velocity", Shape::Vector, Some(&METRE_PER_SECOND), &[], "Velocity of the centre of mass");
const ANGULAR_VELOCITY: Row = output(
    209,
    "angularVelocity",
    Shape::Vector,
    Some(&RADIAN_PER_SECOND),
    &[],
    "Angular velocity of the platform, base frame",
);
const CABLE_LENGTH: Row = output(
    212,
    "cableLength",
    Shape::Cables,
    Some(&METRE),
    POSE,
    "Length of the cable as its encoder sees it",
);
const MEASURED_TENSION: Row = Row {
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
const SLACK: Row = Row {
    kind: Kind::Boolean,
    variability: Variability::Discrete,
    ..output(224, "slack", Shape::Cables, None, &[&MOTOR_TENSION], "Whether the cable pulls with nothing")
};

/// The table, in ascending order of value references.
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

/// Starts a plant with the parameters and inputs in `values`.
pub fn start(values: &Values) -> Result<Plant, ParameterError> {
    Plant::new(plant_parameters(values), &inputs(values))
}

fn plant_parameters(values: &Values) -> PlantParameters {
    PlantParameters {
        robot: parameters(values),
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

/// Copies parameters into `values`.
pub fn write_parameters(parameters: &PlantParameters, values: &mut Values) {
    write_robot(&parameters.robot, values);
    values.write(&INITIAL_POSE, parameters.initial_pose.0.iter().copied());
    values.write(&FRICTION, [parameters.friction]);
    values.write(&MOTOR_LAG, [parameters.motor_lag]);
    values.write(&ENCODER_RESOLUTION, [parameters.encoder_resolution]);
    values.write(&LOAD_CELL_NOISE, [parameters.load_cell_noise]);
    values.write(&NOISE_SEED, [parameters.noise_seed.into()]);
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

    #[test]
    fn the_start_values_are_the_defaults_of_the_domain() {
        assert_eq!(plant_parameters(&Values::new(ROWS)), PlantParameters::default());
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut values = Values::new(ROWS);
        for (k, reference) in ROWS.iter().flat_map(|row| row.references()).enumerate() {
            values.put(reference, k as f64);
        }
        values.write(&SLACK, [1.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        let mut copy = Values::new(ROWS);
        copy.put(TIME.first, values.at(TIME.first));
        write_parameters(&plant_parameters(&values), &mut copy);
        write_inputs(&inputs(&values), &mut copy);
        write(&outputs(&values), &mut copy);
        assert_eq!(copy, values);
    }
}
