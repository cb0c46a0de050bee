//! The variables that both models have: time, and the rig: Table I of the paper's, or cable by cable.

use nalgebra::Vector3;

use crate::values::Values;
use crate::variables::units::{KILOGRAM, KILOGRAM_METRE2, METRE, METRE_PER_SECOND2, NEWTON, SECOND};
use crate::variables::{ABOVE_ZERO, Causality, Row, Shape, Variability, output, parameter};
use cable_robot::robot::{PerCable, Rig, RobotParameters, TensionLimits};

pub const TIME: Row = Row {
    causality: Causality::Independent,
    ..output(0, "time", Shape::Scalar, Some(&SECOND), &[], "Simulation time")
};
pub const A: Row =
    Row { min: Some(ABOVE_ZERO), ..parameter(1, "a", &METRE, &[0.45], "Half the side of the base triangle") };
pub const B: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(2, "b", &METRE, &[0.25], "Half the side of the platform triangle, smaller than a")
};
pub const M: Row =
    Row { min: Some(ABOVE_ZERO), ..parameter(3, "m", &KILOGRAM, &[6.0], "Mass of the platform") };
pub const I1: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(4, "I1", &KILOGRAM_METRE2, &[0.018], "Moment of inertia about the platform's x axis")
};
pub const I2: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(5, "I2", &KILOGRAM_METRE2, &[0.018], "Moment of inertia about the platform's y axis")
};
pub const I3: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(6, "I3", &KILOGRAM_METRE2, &[0.075], "Moment of inertia about the platform's z axis")
};
pub const G: Row = Row {
    min: Some(ABOVE_ZERO),
    ..parameter(7, "g", &METRE_PER_SECOND2, &[9.81], "Gravitational acceleration, along +z (down)")
};

pub const MASS: Row =
    Row { min: Some(ABOVE_ZERO), ..parameter(300, "mass", &KILOGRAM, &[], "Mass of the platform") };
pub const INERTIA: Row = Row {
    shape: Shape::Tensor,
    ..parameter(
        301,
        "inertia",
        &KILOGRAM_METRE2,
        &[],
        "Inertia of the platform about its centre of mass, in its own frame",
    )
};
pub const GRAVITY: Row = Row {
    shape: Shape::Vector,
    ..parameter(307, "gravity", &METRE_PER_SECOND2, &[], "Gravitational acceleration, base frame")
};
pub const ANCHOR: Row = Row {
    shape: Shape::CableVectors,
    ..parameter(
        320,
        "anchor",
        &METRE,
        &[],
        "Where the cable leaves the base, or runs onto its pulley, base frame",
    )
};
pub const ATTACHMENT: Row = Row {
    shape: Shape::CableVectors,
    ..parameter(
        370,
        "attachment",
        &METRE,
        &[],
        "Where the cable holds the platform, from the centre of mass, in the platform's frame",
    )
};
pub const CABLE_MIN: Row = Row {
    variability: Variability::Tunable,
    shape: Shape::Cables,
    seventh: 426,
    min: Some(0.0),
    nominal: Some(10.0),
    ..parameter(420, "minTension", &NEWTON, &[], "Least tension that the cable is ever commanded")
};
pub const CABLE_MAX: Row = Row {
    variability: Variability::Tunable,
    shape: Shape::Cables,
    seventh: 446,
    min: Some(ABOVE_ZERO),
    nominal: Some(10.0),
    ..parameter(
        440,
        "maxTension",
        &NEWTON,
        &[],
        "Greatest tension that the cable is ever commanded; 1e300 and more for none",
    )
};

/// From this tension on nothing limits it, N: FMI knows no infinite numbers.
const UNLIMITED: f64 = 1e300;

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

/// The rig as the user has set it; what has no variables is as in `rig`.
pub fn rig(values: &Values, rig: &Rig) -> Rig {
    let mut rig = *rig;
    let (anchors, attachments) = (values.cable_vectors(&ANCHOR), values.cable_vectors(&ATTACHMENT));
    for (i, cable) in rig.cables.iter_mut().enumerate() {
        (cable.anchor, cable.attachment) = (anchors[i], attachments[i]);
    }
    rig.mass = values.scalar(&MASS);
    rig.inertia = values.tensor(&INERTIA);
    rig.gravity = values.vector(&GRAVITY);
    rig
}

/// The same with the limits that the user has set.
pub fn rig_with_limits(values: &Values, known: &Rig) -> Rig {
    let mut rig = rig(values, known);
    for (cable, limits) in rig.cables.iter_mut().zip(&limits_of_cables(values)) {
        cable.limits = *limits;
    }
    rig
}

/// The limits of each cable in `values`.
pub fn limits_of_cables(values: &Values) -> PerCable<TensionLimits> {
    let (min, max) = (values.cables(&CABLE_MIN), values.cables(&CABLE_MAX));
    PerCable::from_fn(min.len(), |i| {
        let max = if max[i] >= UNLIMITED { f64::INFINITY } else { max[i] };
        TensionLimits { min: min[i] + 0.0, max } // -0 is 0
    })
}

/// Copies a rig into `values`.
pub fn write_rig(rig: &Rig, values: &mut Values) {
    let flat = |points: &mut dyn Iterator<Item = Vector3<f64>>| -> Vec<f64> {
        points.flat_map(|point| [point.x, point.y, point.z]).collect()
    };
    values.write(&MASS, [rig.mass]);
    let tensor = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|element| rig.inertia[element]);
    values.write(&INERTIA, tensor);
    values.write(&GRAVITY, rig.gravity.iter().copied());
    values.write(&ANCHOR, flat(&mut rig.cables.iter().map(|cable| cable.anchor)));
    values.write(&ATTACHMENT, flat(&mut rig.cables.iter().map(|cable| cable.attachment)));
}

/// Copies the limits of its cables into `values`.
pub fn write_limits(rig: &Rig, values: &mut Values) {
    values.write(&CABLE_MIN, rig.cables.map(|cable| cable.limits.min));
    values.write(&CABLE_MAX, rig.cables.map(|cable| cable.limits.max.min(UNLIMITED)));
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
