//! Load cells: how makers write a force into a frame, and which readings can be one.

use thiserror::Error;

use super::canopen::{Object, Width};
use super::frame::Frame;

/// How a reading stands in a frame (little endian).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// INTEGER16, such as 0x7130.
    I16,
    /// INTEGER24, such as 0x8130.
    I24,
    /// INTEGER32, such as 0x9130 or 0x6130 of some makers.
    I32,
    /// REAL32, such as 0x6130 or 0x6403.
    F32,
}

impl Encoding {
    /// How much of a frame it takes.
    pub fn width(self) -> Width {
        match self {
            Self::I16 => Width::Bits16,
            Self::I24 => Width::Bits24,
            Self::I32 | Self::F32 => Width::Bits32,
        }
    }

    /// The number that `bits` stand for.
    fn number(self, bits: u32) -> f64 {
        match self {
            Self::I16 => f64::from(bits as i16),
            Self::I24 => f64::from((bits << 8) as i32 >> 8),
            Self::I32 => f64::from(bits as i32),
            Self::F32 => f64::from(f32::from_bits(bits)),
        }
    }
}

/// A load cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadCell {
    /// The object that is mapped.
    pub object: Object,
    /// How it is written.
    pub encoding: Encoding,
    /// N a unit of the object.
    pub scale: f64,
    /// N at a reading of zero.
    pub offset: f64,
    /// Least and greatest tension that the cell can mean, N.
    pub range: [f64; 2],
}

/// What a cell said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// As it was written, to tell a stuck cell.
    pub bits: u32,
    /// N.
    pub tension: f64,
}

/// A reading that cannot be a tension.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ReadingError {
    /// The frame ends before the reading does.
    #[error("its frame is too short")]
    Short,
    /// No number, or outside of the cell's range.
    #[error("{tension} N is outside of its range")]
    Range {
        /// N.
        tension: f64,
    },
}

impl LoadCell {
    /// The reading that starts at byte `at`.
    ///
    /// # Errors
    /// [`ReadingError`]: the reading cannot be a tension.
    pub fn read(&self, frame: &Frame, at: usize) -> Result<Reading, ReadingError> {
        let mut bytes = [0; 4];
        let width = self.encoding.width().bytes();
        bytes[..width].copy_from_slice(frame.bytes().get(at..at + width).ok_or(ReadingError::Short)?);
        let bits = u32::from_le_bytes(bytes);
        let tension = self.scale * self.encoding.number(bits) + self.offset;
        let [least, greatest] = self.range;
        // NaN is in no range.
        if tension >= least && tension <= greatest {
            Ok(Reading { bits, tension })
        } else {
            Err(ReadingError::Range { tension })
        }
    }

    /// The bits that stand for `tension` (N), as near as the encoding can.
    pub fn write(&self, tension: f64) -> u32 {
        let number = (tension - self.offset) / self.scale;
        match self.encoding {
            Encoding::I16 => u32::from(number.round() as i16 as u16),
            Encoding::I24 => (number.round().clamp(-8_388_608.0, 8_388_607.0) as i32 as u32) & 0xFF_FFFF,
            Encoding::I32 => number.round() as i32 as u32,
            Encoding::F32 => (number as f32).to_bits(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(encoding: Encoding) -> LoadCell {
        LoadCell { object: Object::new(0x7130, 1), encoding, scale: 0.01, offset: -2.0, range: [-5.0, 200.0] }
    }

    #[test]
    fn each_encoding_is_read_and_written() {
        for encoding in [Encoding::I16, Encoding::I24, Encoding::I32, Encoding::F32] {
            for tension in [10.76, -4.0, 150.0] {
                let [a, b, c, d] = cell(encoding).write(tension).to_le_bytes();
                let reading = cell(encoding).read(&Frame::data(0x1A1, [9, a, b, c, d]), 1).unwrap();
                assert!((reading.tension - tension).abs() < 1e-5, "{encoding:?} {tension} {reading:?}");
            }
        }
    }

    #[test]
    fn known_bytes() {
        let read = |encoding, bytes: [u8; 4]| cell(encoding).read(&Frame::data(1, bytes), 0).unwrap().tension;
        assert_eq!(read(Encoding::I16, [0xFF, 0xFF, 1, 1]), -0.01 - 2.0);
        assert_eq!(read(Encoding::I24, [0xFE, 0xFF, 0xFF, 1]), -0.02 - 2.0);
        assert_eq!(read(Encoding::F32, 300f32.to_le_bytes()), 1.0);
    }

    #[test]
    fn readings_that_cannot_be_are_refused() {
        let read = |frame: Frame| cell(Encoding::F32).read(&frame, 0).unwrap_err();
        assert!(
            matches!(read(Frame::data(1, f32::NAN.to_le_bytes())), ReadingError::Range { tension } if tension.is_nan())
        );
        assert!(matches!(read(Frame::data(1, f32::INFINITY.to_le_bytes())), ReadingError::Range { .. }));
        assert!(matches!(read(Frame::data(1, 1e6f32.to_le_bytes())), ReadingError::Range { .. }));
        assert_eq!(read(Frame::data(1, [0, 0, 0])), ReadingError::Short);
    }
}
