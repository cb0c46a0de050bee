//! What the robot is: Table I of the paper, SI units.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A parameter that makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("parameter {name} = {value} is not allowed: {allowed}")]
pub struct ParameterError {
    /// Name as in the contract (and in the FMU).
    pub name: Cow<'static, str>,
    /// The value given.
    pub value: f64,
    /// What would be right, in words.
    pub allowed: Cow<'static, str>,
}

/// Succeeds if `ok`, else names the parameter, its value and what is allowed.
pub fn require(
    ok: bool,
    name: impl Into<Cow<'static, str>>,
    value: f64,
    allowed: &'static str,
) -> Result<(), ParameterError> {
    if ok { Ok(()) } else { Err(ParameterError { name: name.into(), value, allowed: allowed.into() }) }
}

/// Geometry and mass of the robot. The default is Table I.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotParameters {
    /// Half the side of the base triangle, m.
    pub a: f64,
    /// Half the side of the platform triangle, m.
    pub b: f64,
    /// Mass of the platform, kg.
    pub m: f64,
    /// Moment of inertia about the body x axis through the centre of mass, kg m².
    pub i1: f64,
    /// Moment of inertia about the body y axis, kg m².
    pub i2: f64,
    /// Moment of inertia about the body z axis, kg m².
    pub i3: f64,
    /// Gravitational acceleration along +z (z points down), m/s².
    pub g: f64,
}

impl Default for RobotParameters {
    /// Table I; the paper gives no g, 9.81 reproduces its tensions.
    fn default() -> Self {
        Self { a: 0.45, b: 0.25, m: 6.0, i1: 0.018, i2: 0.018, i3: 0.075, g: 9.81 }
    }
}

impl RobotParameters {
    /// Names the first parameter that makes no sense.
    ///
    /// # Errors
    /// [`ParameterError`] with the parameter's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let positive = |name: &'static str, value: f64| {
            require(value.is_finite() && value > 0.0, name, value, "must be finite and greater than 0")
        };
        positive("a", self.a)?;
        positive("b", self.b)?;
        require(self.b < self.a, "b", self.b, "the platform must be smaller than the base, 0 < b < a")?;
        positive("m", self.m)?;
        positive("I1", self.i1)?;
        positive("I2", self.i2)?;
        positive("I3", self.i3)?;
        positive("g", self.g)
    }

    /// Whether the principal moments can be those of a rigid body (the largest at most the sum of the other two).
    /// Table I's cannot (0.018 + 0.018 < 0.075); the equations accept them all the same.
    pub fn inertia_is_physical(&self) -> bool {
        let largest = self.i1.max(self.i2).max(self.i3);
        2.0 * largest <= self.i1 + self.i2 + self.i3
    }
}
