//! Frames as text lines `(123.456789) can0 181#0011`, the log format of can-utils and python-can.

use std::fmt;

use thiserror::Error;

use super::Nanoseconds;
use super::frame::{Frame, FrameKind, LARGEST_ID, hex, hex_bytes};

/// Marks an error frame among 29-bit identifiers.
pub(super) const ERROR_FLAG: u32 = 0x2000_0000;

/// A line of a log. Its time is kept to the microsecond, as the format has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// When the frame was seen.
    pub time: Nanoseconds,
    /// The bus, as the log calls it.
    pub bus: &'a str,
    /// The frame.
    pub frame: Frame,
}

/// Why a line of a log was not understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CandumpError {
    /// No `(seconds.fraction)` at its start.
    #[error("expected a time like (123.456789)")]
    Time,
    /// No bus name after the time.
    #[error("expected the name of a bus after the time")]
    Bus,
    /// The frame is not `id#data`.
    #[error("expected a frame like 181#0011, 181#R2 or 20000040#0000000000000000")]
    Frame,
    /// A 29-bit identifier: CANopen has none.
    #[error("29-bit identifiers are not used here")]
    Extended,
}

impl<'a> Line<'a> {
    /// Reads a line.
    ///
    /// # Errors
    /// [`CandumpError`]: what was expected.
    pub fn parse(line: &'a str) -> Result<Self, CandumpError> {
        let mut words = line.split_ascii_whitespace();
        let time = words.next().and_then(parse_time).ok_or(CandumpError::Time)?;
        let bus = words.next().ok_or(CandumpError::Bus)?;
        let frame = parse_frame(words.next().ok_or(CandumpError::Frame)?)?;
        // Newer candumps append T or R for the direction.
        match words.next() {
            None | Some("T" | "R") => Ok(Self { time, bus, frame }),
            Some(_) => Err(CandumpError::Frame),
        }
    }
}

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let microseconds = self.time / 1000;
        let (seconds, fraction) = (microseconds / 1_000_000, microseconds % 1_000_000);
        write!(f, "({seconds}.{fraction:06}) {} {}", self.bus, self.frame)
    }
}

fn parse_time(text: &str) -> Option<Nanoseconds> {
    let (seconds, fraction) = text.strip_prefix('(')?.strip_suffix(')')?.split_once('.')?;
    let all_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !all_digits(seconds) || !all_digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let scale = 10u64.pow(9 - fraction.len() as u32);
    let seconds = seconds.parse::<u64>().ok()?.checked_mul(1_000_000_000)?;
    seconds.checked_add(fraction.parse::<u64>().ok()? * scale)
}

/// Reads `181#0011`, `181#R2` or an error frame.
///
/// # Errors
/// [`CandumpError::Frame`] or [`CandumpError::Extended`].
pub fn parse_frame(text: &str) -> Result<Frame, CandumpError> {
    let (id, data) = text.split_once('#').ok_or(CandumpError::Frame)?;
    let (kind, id) = match id.len() {
        3 => (FrameKind::Data, hex::<3>(id.as_bytes()).ok_or(CandumpError::Frame)?),
        8 => {
            let id = hex::<8>(id.as_bytes()).ok_or(CandumpError::Frame)?;
            if id & ERROR_FLAG == 0 {
                return Err(CandumpError::Extended);
            }
            (FrameKind::Error, id & !ERROR_FLAG)
        }
        _ => return Err(CandumpError::Frame),
    };
    let id = u16::try_from(id).ok().filter(|id| *id <= LARGEST_ID).ok_or(CandumpError::Frame)?;
    let frame = match data.as_bytes() {
        [b'R'] if kind == FrameKind::Data => Frame::remote(id, 0),
        [b'R', n @ b'0'..=b'8'] if kind == FrameKind::Data => Frame::remote(id, n - b'0'),
        digits => hex_bytes(digits, &mut [0; 8]).and_then(|bytes| Frame::new(kind, id, bytes)),
    };
    frame.ok_or(CandumpError::Frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::error_class;

    #[test]
    fn lines_come_back_as_they_were_written() {
        for text in [
            "(123.456789) can0 181#0011",
            "(0.000001) vcan0 080#",
            "(1.000000) can1 701#R1",
            "(1436509052.249713) can0 20000040#0000000000000000",
        ] {
            assert_eq!(Line::parse(text).unwrap().to_string(), text);
        }
        let line = Line::parse("(123.456789) can0 181#0011").unwrap();
        assert_eq!((line.time, line.bus), (123_456_789_000, "can0"));
        assert_eq!(line.frame, Frame::data(0x181, [0x00, 0x11]));
    }

    #[test]
    fn a_report_of_bus_off_is_an_error_frame() {
        let frame = parse_frame("20000040#0000000000000000").unwrap();
        assert_eq!((frame.kind(), frame.id()), (FrameKind::Error, error_class::BUS_OFF));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |text: &str| Line::parse(text).unwrap_err();
        assert_eq!(error(""), CandumpError::Time);
        assert_eq!(error("123.4 can0 181#00"), CandumpError::Time);
        assert_eq!(error("(99999999999999.0) can0 181#00"), CandumpError::Time);
        assert_eq!(error("(1.0)"), CandumpError::Bus);
        for frame in
            ["", "181", "181#0", "181#001122334455667788", "181#R9", "81#00", "xyz#00", "8F1#", "181##1"]
        {
            assert_eq!(error(&format!("(1.0) can0 {frame}")), CandumpError::Frame, "{frame}");
        }
        assert_eq!(error("(1.0) can0 12345678#00"), CandumpError::Extended);
        assert_eq!(error("(1.0) can0 é81#00"), CandumpError::Frame);
    }
}
