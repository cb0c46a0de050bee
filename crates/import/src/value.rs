//! A scalar of any FMI type, in the three shapes that a caller meets.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The value of a scalar variable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// `Real`, `Float64` or `Float32`, in the variable's unit.
    Float(f64),
    /// Any integer type, or an enumeration's number.
    Int(i64),
    /// A Boolean.
    Bool(bool),
}

impl Value {
    /// The value as a number: true is 1, false is 0.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Float(number) => number,
            Self::Int(number) => number as f64,
            Self::Bool(flag) => f64::from(u8::from(flag)),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(number) => number.fmt(f),
            Self::Int(number) => number.fmt(f),
            Self::Bool(flag) => flag.fmt(f),
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Float(number)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Int(number)
    }
}

impl From<bool> for Value {
    fn from(flag: bool) -> Self {
        Self::Bool(flag)
    }
}
