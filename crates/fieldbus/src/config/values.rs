//! What the values of a fieldbus file have besides those of other files: times, and buses by their names.

use std::ops::RangeInclusive;

use cable_robot::checked_toml::{Checked, Refused};
use toml::Spanned;

use crate::Nanoseconds;

/// A time given in seconds, if it is in the range.
pub fn time(
    check: &Checked,
    value: &Spanned<f64>,
    field: &str,
    range: RangeInclusive<f64>,
) -> Result<Nanoseconds, Refused> {
    Ok((1e9 * check.within(value, field, range, "s")?).round() as Nanoseconds)
}

/// Place of the bus with this name.
pub fn bus(
    check: &Checked,
    name: &Spanned<String>,
    field: &str,
    buses: &[super::Bus],
) -> Result<usize, Refused> {
    let known = || buses.iter().map(|bus| bus.name.as_str()).collect::<Vec<_>>().join(", ");
    let place = buses.iter().position(|bus| bus.name == *name.get_ref());
    let refusal = || {
        let allowed = format!("must be the name of one of [[buses]]: {}", known());
        check.refuse(name.span().start, field, name.get_ref(), allowed)
    };
    place.ok_or_else(refusal)
}
