//! Service data, expedited transfers only: reading and writing objects of at most four bytes.

use super::nmt::node_of;
use super::{Node, Object, Value, Width};
use crate::frame::Frame;

const REQUEST_ID: u16 = 0x600;
const RESPONSE_ID: u16 = 0x580;

/// What the client asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoRequest {
    /// Write an object ("download").
    Write(Object, Value),
    /// Read an object ("upload").
    Read(Object),
}

/// A server's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoResponse {
    /// The object asked for.
    pub object: Object,
    /// How it went.
    pub result: SdoResult,
}

/// How a transfer went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoResult {
    /// Written.
    Written,
    /// Read.
    Value(Value),
    /// Read, but the server does not say how many of the four bytes count.
    Unsized([u8; 4]),
    /// The object is longer than an expedited answer: it would come in segments. So many bytes, if the server says how many.
    Segmented(Option<u32>),
    /// Refused with an abort code ([`abort_text`]).
    Aborted(u32),
}

/// Abort code of this client and server for what is no expedited transfer.
pub const UNSUPPORTED: u32 = 0x0504_0001;

impl SdoRequest {
    /// To a node.
    pub fn frame(&self, node: Node) -> Frame {
        let (command, object, bits) = match *self {
            Self::Write(object, value) => (0x23 | unused_bytes(value.width), object, value.bits),
            Self::Read(object) => (0x40, object, 0),
        };
        message(REQUEST_ID + u16::from(node), command, object, bits)
    }

    /// What a server is asked; `Err` holds the object of a request that it does not know.
    pub fn parse(frame: &Frame) -> Option<(Node, Result<Self, Object>)> {
        let node = node_of(frame, REQUEST_ID)?;
        let (command, object, bits) = fields(frame)?;
        let request = match command {
            0x40 => Ok(Self::Read(object)),
            _ => written_value(command, 0x23, bits).map(|value| Self::Write(object, value)).ok_or(object),
        };
        Some((node, request))
    }

    /// The object asked for.
    pub fn object(&self) -> Object {
        match *self {
            Self::Write(object, _) | Self::Read(object) => object,
        }
    }
}

impl SdoResponse {
    /// From a node.
    pub fn frame(&self, node: Node) -> Frame {
        let (command, bits) = match self.result {
            SdoResult::Written => (0x60, 0),
            SdoResult::Value(value) => (0x43 | unused_bytes(value.width), value.bits),
            SdoResult::Unsized(bytes) => (0x42, u32::from_le_bytes(bytes)),
            SdoResult::Segmented(bytes) => (0x40 | u8::from(bytes.is_some()), bytes.unwrap_or(0)),
            SdoResult::Aborted(code) => (0x80, code),
        };
        message(RESPONSE_ID + u16::from(node), command, self.object, bits)
    }

    /// The node and its answer; `None` if the frame is no answer.
    pub fn parse(frame: &Frame) -> Option<(Node, Self)> {
        let node = node_of(frame, RESPONSE_ID)?;
        let (command, object, bits) = fields(frame)?;
        let result = match command {
            0x60 => SdoResult::Written,
            0x80 => SdoResult::Aborted(bits),
            // Expedited without a size.
            0x42 => SdoResult::Unsized(bits.to_le_bytes()),
            0x40 => SdoResult::Segmented(None),
            0x41 => SdoResult::Segmented(Some(bits)),
            _ => written_value(command, 0x43, bits).map_or(SdoResult::Aborted(UNSUPPORTED), SdoResult::Value),
        };
        Some((node, Self { object, result }))
    }
}

/// Bits 2 and 3 of a command: how many of the four data bytes say nothing.
fn unused_bytes(width: Width) -> u8 {
    (4 - width as u8) << 2
}

fn written_value(command: u8, base: u8, bits: u32) -> Option<Value> {
    if command & !0x0C != base {
        return None;
    }
    let width = Width::of_bytes(4 - (command >> 2 & 3))?;
    let kept = if width == Width::Bits32 { u32::MAX } else { (1 << (8 * width.bytes())) - 1 };
    Some(Value { bits: bits & kept, width })
}

fn message(id: u16, command: u8, object: Object, bits: u32) -> Frame {
    let [low, high] = object.index.to_le_bytes();
    let [a, b, c, d] = bits.to_le_bytes();
    Frame::data(id, [command, low, high, object.subindex, a, b, c, d])
}

fn fields(frame: &Frame) -> Option<(u8, Object, u32)> {
    let [command, low, high, subindex, data @ ..] = frame.array::<8>(0)?;
    Some((command, Object::new(u16::from_le_bytes([low, high]), subindex), u32::from_le_bytes(data)))
}

/// What an abort code means (CiA 301).
pub fn abort_text(code: u32) -> &'static str {
    match code {
        0x0503_0000 => "toggle bit not alternated",
        0x0504_0000 => "SDO protocol timed out",
        0x0504_0001 => "command specifier not valid or unknown",
        0x0504_0005 => "out of memory",
        0x0601_0000 => "unsupported access to an object",
        0x0601_0001 => "attempt to read a write only object",
        0x0601_0002 => "attempt to write a read only object",
        0x0602_0000 => "object does not exist in the object dictionary",
        0x0604_0041 => "object cannot be mapped to the PDO",
        0x0604_0042 => "number and length of the objects to be mapped would exceed PDO length",
        0x0604_0043 => "general parameter incompatibility",
        0x0604_0047 => "general internal incompatibility in the device",
        0x0606_0000 => "access failed due to a hardware error",
        0x0607_0010 => "data type or length of parameter does not match",
        0x0607_0012 => "length of parameter too high",
        0x0607_0013 => "length of parameter too low",
        0x0609_0011 => "sub-index does not exist",
        0x0609_0030 => "invalid value for parameter",
        0x0609_0031 => "value of parameter too high",
        0x0609_0032 => "value of parameter too low",
        0x0609_0036 => "maximum value is less than minimum value",
        0x0800_0000 => "general error",
        0x0800_0020 => "data cannot be transferred or stored to the application",
        0x0800_0021 => "data cannot be transferred or stored because of local control",
        0x0800_0022 => "data cannot be transferred or stored because of the present device state",
        0x0800_0024 => "no data available",
        _ => "unknown abort code",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBJECT: Object = Object::new(0x6071, 0);

    #[test]
    fn writes_of_each_width_are_the_standards() {
        for (width, command) in
            [(Width::Bits8, 0x2F), (Width::Bits16, 0x2B), (Width::Bits24, 0x27), (Width::Bits32, 0x23)]
        {
            let request = SdoRequest::Write(OBJECT, Value { bits: 0x12, width });
            let frame = request.frame(4);
            assert_eq!(frame, Frame::data(0x604, [command, 0x71, 0x60, 0, 0x12, 0, 0, 0]));
            assert_eq!(SdoRequest::parse(&frame), Some((4, Ok(request))));
        }
    }

    #[test]
    fn reads_and_their_answers_are_the_standards() {
        assert_eq!(SdoRequest::Read(OBJECT).frame(4), Frame::data(0x604, [0x40, 0x71, 0x60, 0, 0, 0, 0, 0]));
        let answer = |bytes: [u8; 8]| SdoResponse::parse(&Frame::data(0x584, bytes)).unwrap().1.result;
        assert_eq!(answer([0x4B, 0x71, 0x60, 0, 0xFF, 0xFF, 7, 7]), SdoResult::Value(Value::u16(0xFFFF)));
        assert_eq!(answer([0x42, 0x71, 0x60, 0, 1, 2, 3, 4]), SdoResult::Unsized([1, 2, 3, 4]));
        assert_eq!(answer([0x60, 0x71, 0x60, 0, 0, 0, 0, 0]), SdoResult::Written);
        assert_eq!(answer([0x80, 0x71, 0x60, 0, 0x00, 0x00, 0x02, 0x06]), SdoResult::Aborted(0x0602_0000));
        assert_eq!(answer([0x41, 0x71, 0x60, 0, 9, 0, 0, 0]), SdoResult::Segmented(Some(9)));
        assert_eq!(answer([0x40, 0x71, 0x60, 0, 0, 0, 0, 0]), SdoResult::Segmented(None));
        assert_eq!(answer([0xC2, 0x71, 0x60, 0, 0, 0, 0, 0]), SdoResult::Aborted(UNSUPPORTED));
    }

    #[test]
    fn answers_come_back_as_they_were_written() {
        for result in [
            SdoResult::Written,
            SdoResult::Value(Value::u8(10)),
            SdoResult::Segmented(Some(9)),
            SdoResult::Segmented(None),
            SdoResult::Aborted(0x0609_0030),
        ] {
            let response = SdoResponse { object: OBJECT, result };
            assert_eq!(SdoResponse::parse(&response.frame(9)), Some((9, response)));
        }
    }

    #[test]
    fn what_is_no_transfer_is_left_alone() {
        assert_eq!(SdoRequest::parse(&Frame::data(0x604, [0x40, 0x71, 0x60])), None);
        assert_eq!(
            SdoRequest::parse(&Frame::data(0x604, [0x21, 0x71, 0x60, 0, 9, 0, 0, 0])),
            Some((4, Err(OBJECT)))
        );
        assert_eq!(SdoResponse::parse(&Frame::data(0x604, [0; 8])), None);
        assert_eq!(abort_text(0x0602_0000), "object does not exist in the object dictionary");
        assert_eq!(abort_text(1), "unknown abort code");
    }
}
