//! What can go wrong in a call from outside, and which status of the standard that is.

use thiserror::Error;

use super::lifecycle::State;
use super::log::Category;
use super::models::Scalar;
use super::variables::Kind;
use cable_robot::plan::OF_LONGEST_STEP;
use cable_robot::robot::{MemoryError, ParameterError};
use cable_robot::sim::plant::PlantError;

/// Status of a call: the numbers are the same in both versions of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, with something to tell.
    Warning = 1,
    /// Not done, and nothing is lost: the run may go on.
    Discard = 2,
    /// Not done: reset the instance, give it back a saved state, or free it.
    Error = 3,
}

/// Why a call did not do what was asked.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum FmiError {
    #[error("{function} is not supported: {why}")]
    Unsupported { function: &'static str, why: &'static str },
    #[error("{function} is not allowed in the state {state}; it is allowed in {allowed}")]
    OutOfOrder { function: &'static str, state: State, allowed: String },
    #[error("{argument} is NULL or not aligned; it must point to the data")]
    Pointer { argument: &'static str },
    #[error("{argument} has the length {given}; right is {wanted}")]
    Length { argument: &'static str, given: usize, wanted: String },
    #[error(
        "{function}: {model} has no variable with value reference {reference}; see its modelDescription.xml"
    )]
    UnknownReference { function: &'static str, model: &'static str, reference: u32 },
    #[error(
        "{function}: {name} (value reference {reference}) is of type {kind}, which this function does not handle"
    )]
    WrongType { function: &'static str, name: String, reference: u32, kind: &'static str },
    #[error("{name} cannot be set in the state {state}: {allowed}")]
    NotSettable { name: String, state: State, allowed: &'static str },
    #[error("{name} = {value} is not allowed: {allowed}")]
    BadValue { name: String, value: f64, allowed: String },
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    #[error("{name} cannot be read yet: {why}")]
    NotReady { name: String, why: String },
    #[error("{name} cannot be used: {why}")]
    Clock { name: String, why: &'static str },
    #[error("{argument} = {value} is not allowed: {allowed}")]
    Argument { argument: &'static str, value: f64, allowed: String },
    #[error(
        "communicationStepSize = {h} s is too long, the step was not made; at most {longest:.3e} s: {OF_LONGEST_STEP}"
    )]
    TooLong { h: f64, longest: f64 },
    #[error("the step failed and was undone: {0}")]
    Plant(#[from] PlantError),
    #[error("this is not a usable FMU state: {0}")]
    State(String),
    #[error(transparent)]
    Memory(#[from] MemoryError),
    #[error("the log category {name:?} does not exist; the categories are {known}")]
    UnknownCategory { name: String, known: String },
    #[error(
        "the token {given:?} belongs to no model of this library; it has {known}: are XML and library of one build?"
    )]
    Token { given: String, known: String },
    #[error("{path} in the FMU's resources cannot be used: {why}")]
    Resource { path: String, why: String },
    #[error("{function}: {name} is no {role}")]
    NotDifferentiable { function: &'static str, name: String, role: &'static str },
    #[error("{name} = {value} at these states and inputs")]
    NotFinite { name: String, value: f64 },
    #[error("{what} cannot be retrieved: {why}")]
    NoSuchStatus { what: &'static str, why: &'static str },
    #[error("{function} failed for an internal reason, please report it: {message}")]
    Panic { function: &'static str, message: String },
}

impl FmiError {
    /// A value that is none of its row's type.
    pub fn bad_value(scalar: &Scalar, value: f64) -> Self {
        let allowed = match scalar.row.kind {
            Kind::Enumeration(kind) => {
                let items = kind.numbered().map(|(number, name, _)| format!("{number} ({name})"));
                items.collect::<Vec<_>>().join(", ")
            }
            Kind::Float64 => "a finite number".to_owned(),
            Kind::Int32 => "a whole number".to_owned(),
            Kind::Boolean | Kind::Clock => "0 (false) or 1 (true)".to_owned(),
            Kind::String => "a text".to_owned(),
        };
        Self::BadValue { name: scalar.name(), value, allowed }
    }

    /// The status that the standard has for this.
    pub fn status(&self) -> Status {
        match self {
            Self::UnknownCategory { .. } => Status::Warning,
            Self::NotReady { .. }
            | Self::NotFinite { .. }
            | Self::NoSuchStatus { .. }
            | Self::TooLong { .. } => Status::Discard,
            _ => Status::Error,
        }
    }

    /// The log category it is reported under.
    pub fn category(&self) -> Category {
        match self.status() {
            Status::Ok | Status::Warning => Category::Warning,
            Status::Discard => Category::Discard,
            Status::Error => Category::Error,
        }
    }
}
