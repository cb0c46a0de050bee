//! What a memory that was saved is checked for before it is taken up: a file may say anything.

use thiserror::Error;

use super::{ParameterError, PerCable};

/// Why no run can have left such a memory.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MemoryError {
    /// A parameter in it makes no sense.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Something else in it.
    #[error("wrong {part}: right is {allowed}")]
    Part {
        /// What of it.
        part: &'static str,
        /// What would be right, in words.
        allowed: &'static str,
    },
}

/// Succeeds if `ok`, else names the part and what is allowed.
pub fn expect(ok: bool, part: &'static str, allowed: &'static str) -> Result<(), MemoryError> {
    if ok { Ok(()) } else { Err(MemoryError::Part { part, allowed }) }
}

/// Whether there is one a cable, and each is a number and not infinite.
pub fn are_of_each_cable(values: &PerCable<f64>, cables: usize) -> bool {
    values.len() == cables && are_finite(values)
}

/// Whether they are numbers, and none is infinite.
pub fn are_finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> bool {
    numbers.into_iter().all(|number| number.is_finite())
}
