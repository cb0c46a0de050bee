//! The variables that both models have: time, and Table I.

use crate::fmi::values::Values;
use crate::fmi::variables::units::{KILOGRAM, KILOGRAM_METRE2, METRE, METRE_PER_SECOND2, SECOND};
use crate::fmi::variables::{Causality, Row, Shape, output, parameter};
use crate::robot::RobotParameters;

pub const TIME: Row = Row {
    causality: Causality::Independent,
    ..output(0, "time", Shape::Scalar, Some(&SECOND), &[], "Simulation time")
};
pub const A: Row =
    Row { min: Some(0.0), ..parameter(1, "a", &METRE, &[0.45], "Half the side of the base triangle") };
pub const B: Row = Row {
    min: Some(0.0),
    ..parameter(2, "b", &METRE, &[0.25], "Half the side of the platform triangle, smaller than a")
};
pub const M: Row = Row { min: Some(0.0), ..parameter(3, "m", &KILOGRAM, &[6.0], "Mass of the platform") };
pub const I1: Row = Row {
    min: Some(0.0),
    ..parameter(4, "I1", &KILOGRAM_METRE2, &[0.018], "Moment of inertia about the platform's x axis")
};
pub const I2: Row = Row {
    min: Some(0.0),
    ..parameter(5, "I2", &KILOGRAM_METRE2, &[0.018], "Moment of inertia about the platform's y axis")
};
pub const I3: Row = Row {
    min: Some(0.0),
    ..parameter(6, "I3", &KILOGRAM_METRE2, &[0.075], "Moment of inertia about the platform's z axis")
};
pub const G: Row = Row {
    min: Some(0.0),
    ..parameter(7, "g", &METRE_PER_SECOND2, &[9.81], "Gravitational acceleration, along +z (down)")
};

/// The rest of Table I's robot at (0, 0, 1): each cable's length, m, and its tension m g l / (6 z), N.
pub const REST_LENGTH: f64 = 1.096965511460289;
pub const REST_TENSION: f64 = 10.761231667425436;

/// Table I as the user has set it.
pub fn parameters(values: &Values) -> RobotParameters {
    RobotParameters {
        a: values.scalar(&A),
        b: values.scalar(&B),
        m: values.scalar(&M),
        i1: values.scalar(&I1),
        i2: values.scalar(&I2),
        i3: values.scalar(&I3),
        g: values.scalar(&G),
    }
}

/// Copies Table I into `values`.
pub fn write_robot(robot: &RobotParameters, values: &mut Values) {
    let RobotParameters { a, b, m, i1, i2, i3, g } = *robot;
    for (row, value) in [(&A, a), (&B, b), (&M, m), (&I1, i1), (&I2, i2), (&I3, i3), (&G, g)] {
        values.write(row, [value]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_values_are_the_rest_of_table_i() {
        let RobotParameters { a, b, m, g, .. } = RobotParameters::default();
        let length = (1.0 + 4.0 / 3.0 * (a * a + b * b - a * b)).sqrt();
        assert!((REST_LENGTH - length).abs() < 1e-12);
        assert!((REST_TENSION - m * g * length / 6.0).abs() < 1e-12);
    }
}
