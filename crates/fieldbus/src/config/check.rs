//! Checks values of a file and knows where they stand in it.

use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;

use toml::Spanned;

use super::ConfigError;
use crate::Nanoseconds;

pub(super) struct Check<'a> {
    pub text: &'a str,
}

impl Check<'_> {
    /// The error for a value that stands at `offset`.
    pub fn refuse(
        &self,
        offset: usize,
        field: &str,
        value: impl Display,
        allowed: impl Into<String>,
    ) -> ConfigError {
        let line = self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1;
        ConfigError::Value {
            line,
            field: field.to_owned(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }

    /// The value, if it is in the range.
    pub fn within<T: PartialOrd + Debug + Display + Copy>(
        &self,
        value: &Spanned<T>,
        field: &str,
        range: RangeInclusive<T>,
        unit: &str,
    ) -> Result<T, ConfigError> {
        let given = *value.get_ref();
        if range.contains(&given) {
            return Ok(given);
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let allowed = format!("must be from {} to {}{unit}", range.start(), range.end());
        Err(self.refuse(value.span().start, field, given, allowed))
    }

    /// A time given in seconds.
    pub fn time(
        &self,
        value: &Spanned<f64>,
        field: &str,
        range: RangeInclusive<f64>,
    ) -> Result<Nanoseconds, ConfigError> {
        Ok((1e9 * self.within(value, field, range, "s")?).round() as Nanoseconds)
    }

    /// Place of the bus with this name.
    pub fn bus(
        &self,
        name: &Spanned<String>,
        field: &str,
        buses: &[super::Bus],
    ) -> Result<usize, ConfigError> {
        let known = || buses.iter().map(|bus| bus.name.as_str()).collect::<Vec<_>>().join(", ");
        let place = buses.iter().position(|bus| bus.name == *name.get_ref());
        let refusal = || {
            let allowed = format!("must be the name of one of [[buses]]: {}", known());
            self.refuse(name.span().start, field, name.get_ref(), allowed)
        };
        place.ok_or_else(refusal)
    }
}
