//! Values of a TOML file: where they stand in it, and what is wrong with one that is refused.

use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;

use nalgebra::Vector3;
use thiserror::Error;
use toml::Spanned;

/// A value that makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("line {line}: {field} = {value} is not allowed: {allowed}")]
pub struct Refused {
    /// Line in the file, from 1.
    pub line: usize,
    /// The field, with its table; entries of lists and components counted from 1.
    pub field: String,
    /// The value given.
    pub value: String,
    /// What would be right.
    pub allowed: String,
}

/// The text of a file whose values are checked.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a> {
    /// All of it.
    pub text: &'a str,
}

impl Checked<'_> {
    /// Line, from 1, of a byte of the text.
    pub fn line(&self, offset: usize) -> usize {
        self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
    }

    /// The error for a value that stands at `offset`.
    pub fn refuse(
        &self,
        offset: usize,
        field: &str,
        value: impl Display,
        allowed: impl Into<String>,
    ) -> Refused {
        let line = self.line(offset);
        Refused { line, field: field.to_owned(), value: value.to_string(), allowed: allowed.into() }
    }

    /// `ok`, or the error for a value that stands where `at` does.
    ///
    /// # Errors
    /// [`Refused`] if not `ok`.
    pub fn require<T>(
        &self,
        ok: bool,
        at: &Spanned<T>,
        field: &str,
        value: impl Display,
        allowed: &str,
    ) -> Result<(), Refused> {
        if ok { Ok(()) } else { Err(self.refuse(at.span().start, field, value, allowed)) }
    }

    /// The number, if it is finite and greater than 0.
    ///
    /// # Errors
    /// [`Refused`] if not.
    pub fn positive(&self, number: &Spanned<f64>, field: &str, unit: &str) -> Result<f64, Refused> {
        let value = *number.get_ref();
        let allowed = format!("must be finite and greater than 0 ({unit})");
        self.require(value.is_finite() && value > 0.0, number, field, value, &allowed)?;
        Ok(value)
    }

    /// The vector, if its components are finite.
    ///
    /// # Errors
    /// [`Refused`] with the first component that is not.
    pub fn vector(
        &self,
        vector: &Spanned<[f64; 3]>,
        field: &str,
        unit: &str,
    ) -> Result<Vector3<f64>, Refused> {
        let allowed =
            if unit.is_empty() { "must be finite".into() } else { format!("must be finite ({unit})") };
        for (k, value) in vector.get_ref().iter().enumerate() {
            self.require(value.is_finite(), vector, &format!("{field}[{}]", k + 1), value, &allowed)?;
        }
        Ok((*vector.get_ref()).into())
    }

    /// The value, if it is in the range.
    ///
    /// # Errors
    /// [`Refused`] if not.
    pub fn within<T: PartialOrd + Debug + Display + Copy>(
        &self,
        value: &Spanned<T>,
        field: &str,
        range: RangeInclusive<T>,
        unit: &str,
    ) -> Result<T, Refused> {
        let given = *value.get_ref();
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let allowed = format!("must be from {} to {}{unit}", range.start(), range.end());
        self.require(range.contains(&given), value, field, given, &allowed)?;
        Ok(given)
    }
}
