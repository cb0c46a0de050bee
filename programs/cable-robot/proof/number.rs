//! Doubles as text, exactly, each in one way: as glibc's `printf("%a")` spells them.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

/// A number of a proof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

/// Of the fraction in the bits of a double.
const FRACTION_BITS: u32 = 52;
/// Sign, `0x`, digit, point, 13 digits of the fraction, `p`, sign, four digits of the exponent.
const LONGEST: usize = 24;

/// A number's text.
#[derive(Default)]
struct Spelling {
    bytes: [u8; LONGEST],
    count: usize,
}

impl Spelling {
    /// `-0` becomes `0`.
    fn of(value: f64) -> Self {
        let (mut text, bits) = (Self::default(), (value + 0.0).to_bits());
        if bits >> 63 == 1 {
            text.push("-");
        }
        if value.is_infinite() {
            text.push("inf");
            return text;
        }
        let (biased, fraction) = ((bits >> FRACTION_BITS) & 0x7ff, bits & ((1 << FRACTION_BITS) - 1));
        text.push(if biased == 0 { "0x0" } else { "0x1" });
        if fraction > 0 {
            text.push(".");
        }
        let digits = 13 - fraction.trailing_zeros().min(FRACTION_BITS) / 4;
        (1..=digits).for_each(|k| text.digit(fraction >> (FRACTION_BITS - 4 * k) & 15));
        let exponent = match (biased, fraction) {
            (0, 0) => 0,
            (0, _) => -1022,
            _ => biased as i32 - 1023,
        };
        text.push(if exponent < 0 { "p-" } else { "p+" });
        text.decimal(exponent.unsigned_abs());
        text
    }

    fn push(&mut self, part: &str) {
        self.bytes[self.count..self.count + part.len()].copy_from_slice(part.as_bytes());
        self.count += part.len();
    }

    fn digit(&mut self, digit: u64) {
        self.bytes[self.count] = b"0123456789abcdef"[digit as usize];
        self.count += 1;
    }

    fn decimal(&mut self, value: u32) {
        if value >= 10 {
            self.decimal(value / 10);
        }
        self.digit(u64::from(value % 10));
    }

    fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..self.count]).expect("ASCII")
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(Spelling::of(self.0).as_str())
    }
}

impl JsonSchema for Number {
    fn schema_name() -> Cow<'static, str> {
        "Number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A double in hexadecimal, as printf(\"%a\") of glibc writes it.",
            "type": "string",
            "pattern": "^-?0x[01](\\.[0-9a-f]{0,12}[1-9a-f])?p(\\+[0-9]|-[1-9])[0-9]{0,3}$"
        })
    }
}

/// A number, or `"inf"`.
pub struct Limit;

impl JsonSchema for Limit {
    fn schema_name() -> Cow<'static, str> {
        "Limit".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Number>();
        json_schema!({ "anyOf": [number, { "const": "inf" }] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spelled(value: f64) -> String {
        Spelling::of(value).as_str().to_owned()
    }

    /// As glibc writes them, and Python with the zeros at the end of the fraction left out.
    #[test]
    fn numbers_are_spelled_as_printf_does() {
        for (value, text) in [
            (0.0, "0x0p+0"),
            (-0.0, "0x0p+0"),
            (1.0, "0x1p+0"),
            (6.0, "0x1.8p+2"),
            (-0.1, "-0x1.999999999999ap-4"),
            (9.81, "0x1.39eb851eb851fp+3"),
            (1.0 + f64::EPSILON, "0x1.0000000000001p+0"),
            (1.0 / 1024.0, "0x1p-10"),
            (f64::MAX, "0x1.fffffffffffffp+1023"),
            (-f64::MIN_POSITIVE, "-0x1p-1022"),
            (5e-324, "0x0.0000000000001p-1022"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(spelled(value), text);
        }
    }

    #[test]
    fn a_spelling_says_the_number_exactly() {
        let mut bits = 1_u64;
        for _ in 0..10_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let value = f64::from_bits(bits);
            if value.is_finite() {
                assert_eq!(parsed(&spelled(value)), value);
            }
        }
    }

    fn parsed(text: &str) -> f64 {
        let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |text| (-1.0, text));
        let (digits, exponent) = text.strip_prefix("0x").unwrap().split_once('p').unwrap();
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let all = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap();
        let power = exponent.parse::<i32>().unwrap() - 4 * fraction.len() as i32;
        // In two steps: the power alone may underflow.
        sign * all as f64 * 2f64.powi(power / 2) * 2f64.powi(power - power / 2)
    }
}
