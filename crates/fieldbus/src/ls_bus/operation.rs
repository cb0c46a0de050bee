//! The operations of FMI-LS-BUS 1.0.0 for CAN as bytes: operation code (u32), length of the whole (u32), arguments; little endian,
//! one behind the other. Of the standard: "Layered Standard Bus Protocol", and "Operations" of "CAN, CAN FD, CAN XL".

use std::fmt;

use thiserror::Error;

use crate::frame::{Frame, FrameKind, LARGEST_ID};

/// Operation codes of the standard.
mod code {
    pub const FORMAT_ERROR: u32 = 0x01;
    pub const CAN_TRANSMIT: u32 = 0x10;
    pub const CAN_FD_TRANSMIT: u32 = 0x11;
    pub const CAN_XL_TRANSMIT: u32 = 0x12;
    pub const CONFIRM: u32 = 0x20;
    pub const ARBITRATION_LOST: u32 = 0x30;
    pub const BUS_ERROR: u32 = 0x31;
    pub const CONFIGURATION: u32 = 0x40;
    pub const STATUS: u32 = 0x41;
    pub const WAKEUP: u32 = 0x42;
}

/// Operation code and length.
const HEADER: usize = 8;
/// Header, identifier, ide, rtr, length of the data.
const TRANSMIT: usize = HEADER + 8;
/// The longest identifier of CAN, 29 bits.
const LARGEST_EXTENDED_ID: u32 = 0x1FFF_FFFF;
/// Bytes of data of a classic frame.
const LARGEST_DATA: usize = 8;

/// An operation that was received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation<'a> {
    /// Somebody could not read this operation of ours.
    FormatError(&'a [u8]),
    /// A classic frame; `None` for a 29-bit identifier, which nobody here has.
    Transmit(Option<Frame>),
    /// A frame of CAN FD or CAN XL, with its operation code.
    OtherTransmit(u32),
    /// A frame of ours with this identifier was acknowledged.
    Confirm(u32),
    /// A frame of ours with this identifier lost the arbitration and was dropped.
    ArbitrationLost(u32),
    /// A frame was destroyed.
    BusError(BusError),
    /// Addressed to a bus simulation.
    ForTheBus,
    /// A node that sleeps shall wake up; none of ours sleeps.
    Wakeup,
}

/// A frame that was destroyed on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusError {
    /// Of the frame.
    pub id: u32,
    /// 1 bit, 2 stuffing, 3 form, 4 checksum, 5 acknowledge, 6 broken error frame.
    pub code: u8,
    /// Whether this node was the first to see it.
    pub is_primary: bool,
    /// Whether it was this node's frame.
    pub is_sender: bool,
}

/// What is no operation, all of it; to be sent back as Format Error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Malformed<'a> {
    /// The bytes.
    pub bytes: &'a [u8],
    /// What is wrong with them.
    pub why: Flaw,
}

/// What is wrong with bytes that should be an operation.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum Flaw {
    #[error("{0} bytes are left, an operation has at least {HEADER}")]
    Truncated(usize),
    #[error("its length is {length}, but there are {left} bytes; it counts the {HEADER} bytes of its header")]
    Overlong { length: u32, left: usize },
    #[error("its length is {length}; right is {wanted}")]
    Length { length: usize, wanted: usize },
    #[error("its operation code 0x{0:X} is none of CAN's")]
    UnknownCode(u32),
    #[error("{field} is {value}; it is 0 or 1")]
    NoBoolean { field: &'static str, value: u8 },
    #[error("its identifier is 0x{id:X}; the largest is 0x{largest:X}")]
    Identifier { id: u32, largest: u32 },
    #[error("it has {0} bytes of data, a classic frame at most {LARGEST_DATA}")]
    DataLength(usize),
    #[error("{field} is {value}; it is {allowed}")]
    Field { field: &'static str, value: u8, allowed: &'static str },
}

/// The operations in the bytes of a binary variable. Behind one whose length makes no sense there is nothing to be read.
pub fn operations(bytes: &[u8]) -> impl Iterator<Item = Result<Operation<'_>, Malformed<'_>>> {
    let mut left = bytes;
    std::iter::from_fn(move || {
        if left.is_empty() {
            return None;
        }
        let (one, rest) = match split(left) {
            Ok(parts) => parts,
            Err(why) => return Some(Err(Malformed { bytes: std::mem::take(&mut left), why })),
        };
        left = rest;
        Some(read(one).map_err(|why| Malformed { bytes: one, why }))
    })
}

/// The first operation and what follows it.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8]), Flaw> {
    let length = u32_at(bytes, 4).ok_or(Flaw::Truncated(bytes.len()))?;
    let fits = (HEADER..=bytes.len()).contains(&(length as usize));
    if fits { Ok(bytes.split_at(length as usize)) } else { Err(Flaw::Overlong { length, left: bytes.len() }) }
}

/// One operation, which has at least a header.
fn read(one: &[u8]) -> Result<Operation<'_>, Flaw> {
    let code = u32_at(one, 0).ok_or(Flaw::Truncated(one.len()))?;
    Ok(match code {
        code::FORMAT_ERROR => Operation::FormatError(counted(one, HEADER)?),
        code::CAN_TRANSMIT => Operation::Transmit(transmitted(one)?),
        code::CAN_FD_TRANSMIT | code::CAN_XL_TRANSMIT => Operation::OtherTransmit(code),
        code::CONFIRM => Operation::Confirm(identifier(one, HEADER + 4)?),
        code::ARBITRATION_LOST => Operation::ArbitrationLost(identifier(one, HEADER + 4)?),
        code::BUS_ERROR => Operation::BusError(bus_error(one)?),
        code::CONFIGURATION | code::STATUS => Operation::ForTheBus,
        code::WAKEUP => {
            of_length(one, HEADER)?;
            Operation::Wakeup
        }
        unknown => return Err(Flaw::UnknownCode(unknown)),
    })
}

/// A classic frame. A remote frame has a length; bytes behind it are not on the bus, and writers differ in whether they are here: those of
/// the standard's headers of 1.0.0 have them, later ones have not.
fn transmitted(one: &[u8]) -> Result<Option<Frame>, Flaw> {
    let (ide, rtr) = (boolean(one, HEADER + 4, "ide")?, boolean(one, HEADER + 5, "rtr")?);
    let id = u32_at(one, HEADER).ok_or(Flaw::Truncated(one.len()))?;
    let largest = if ide { LARGEST_EXTENDED_ID } else { LARGEST_ID.into() };
    if id > largest {
        return Err(Flaw::Identifier { id, largest });
    }
    let length = u16_at(one, TRANSMIT - 2).ok_or(Flaw::Truncated(one.len()))?.into();
    if length > LARGEST_DATA {
        return Err(Flaw::DataLength(length));
    }
    if !(rtr && one.len() == TRANSMIT) {
        of_length(one, TRANSMIT + length)?;
    }
    let zeros = [0; LARGEST_DATA];
    let (kind, data) =
        if rtr { (FrameKind::Remote, &zeros[..length]) } else { (FrameKind::Data, &one[TRANSMIT..]) };
    Ok(if ide { None } else { Frame::new(kind, id as u16, data) })
}

fn bus_error(one: &[u8]) -> Result<BusError, Flaw> {
    let id = identifier(one, HEADER + 7)?;
    let [code, flag] = [one[HEADER + 4], one[HEADER + 5]];
    if !(1..=6).contains(&code) {
        return Err(Flaw::Field { field: "the error code", value: code, allowed: "from 1 to 6" });
    }
    if !(1..=2).contains(&flag) {
        let allowed = "1 (primary) or 2 (secondary)";
        return Err(Flaw::Field { field: "the error flag", value: flag, allowed });
    }
    Ok(BusError { id, code, is_primary: flag == 1, is_sender: boolean(one, HEADER + 6, "isSender")? })
}

/// The identifier of an operation that has this length.
fn identifier(one: &[u8], length: usize) -> Result<u32, Flaw> {
    of_length(one, length)?;
    u32_at(one, HEADER).ok_or(Flaw::Truncated(one.len()))
}

/// All that follows a length (u16) at `at`, to the end.
fn counted(one: &[u8], at: usize) -> Result<&[u8], Flaw> {
    let length: usize = u16_at(one, at).ok_or(Flaw::Truncated(one.len()))?.into();
    of_length(one, at + 2 + length)?;
    Ok(&one[at + 2..])
}

fn of_length(one: &[u8], wanted: usize) -> Result<(), Flaw> {
    if one.len() == wanted { Ok(()) } else { Err(Flaw::Length { length: one.len(), wanted }) }
}

fn boolean(one: &[u8], at: usize, field: &'static str) -> Result<bool, Flaw> {
    match one.get(at) {
        Some(0) => Ok(false),
        Some(1) => Ok(true),
        Some(&value) => Err(Flaw::NoBoolean { field, value }),
        None => Err(Flaw::Truncated(one.len())),
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

/// State of a node on the bus, as ISO 11898-1 counts errors; the numbers of the Status operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeStatus {
    /// It takes part.
    ErrorActive = 1,
    /// It takes part, and lets others go first.
    ErrorPassive = 2,
    /// It sends nothing any more.
    BusOff = 3,
}

impl fmt::Display for NodeStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ErrorActive => "error active",
            Self::ErrorPassive => "error passive",
            Self::BusOff => "bus off",
        })
    }
}

/// An operation to be sent, at most 24 bytes long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// A frame.
    Transmit(Frame),
    /// The bit rate of the bus, bit/s.
    BitRate(u32),
    /// Frames that lose the arbitration shall wait in the bus simulation.
    BufferAndRetransmit,
    /// The node's state has changed.
    Status(NodeStatus),
}

/// The longest [`Request`], bytes.
pub const LONGEST_REQUEST: usize = TRANSMIT + LARGEST_DATA;

/// Parameters of the Configuration operation.
const CAN_BAUDRATE: u8 = 1;
const ARBITRATION_LOST_BEHAVIOR: u8 = 4;
const BUFFER_AND_RETRANSMIT: u8 = 1;

impl Request {
    /// Appends its bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Transmit(frame) => {
                let (id, is_remote) = (u32::from(frame.id()), frame.kind() == FrameKind::Remote);
                // The standard's length counts the bytes that a remote frame asks for.
                let data = if is_remote { &[0; LARGEST_DATA][..frame.length()] } else { frame.bytes() };
                header(out, code::CAN_TRANSMIT, TRANSMIT + data.len());
                out.extend(id.to_le_bytes());
                out.extend([0, is_remote.into()]);
                out.extend((frame.length() as u16).to_le_bytes());
                out.extend(data);
            }
            Self::BitRate(rate) => {
                header(out, code::CONFIGURATION, HEADER + 5);
                out.push(CAN_BAUDRATE);
                out.extend(rate.to_le_bytes());
            }
            Self::BufferAndRetransmit => {
                header(out, code::CONFIGURATION, HEADER + 2);
                out.extend([ARBITRATION_LOST_BEHAVIOR, BUFFER_AND_RETRANSMIT]);
            }
            Self::Status(status) => {
                header(out, code::STATUS, HEADER + 1);
                out.push(*status as u8);
            }
        }
    }
}

/// Appends the answer to what is no operation, with as much of it as a length of 16 bits and `room` allow; nothing if there is none.
pub fn write_format_error(bytes: &[u8], room: usize, out: &mut Vec<u8>) {
    let Some(room) = room.checked_sub(HEADER + 2) else { return };
    let bytes = &bytes[..bytes.len().min(room).min(u16::MAX.into())];
    header(out, code::FORMAT_ERROR, HEADER + 2 + bytes.len());
    out.extend((bytes.len() as u16).to_le_bytes());
    out.extend(bytes);
}

fn header(out: &mut Vec<u8>, code: u32, length: usize) {
    out.extend(code.to_le_bytes());
    out.extend((length as u32).to_le_bytes());
}

/// Whether bytes that make no operation are a Format Error themselves: that is not answered, or two nodes would never end.
pub fn is_format_error(bytes: &[u8]) -> bool {
    u32_at(bytes, 0) == Some(code::FORMAT_ERROR)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    fn written(requests: &[Request]) -> Vec<u8> {
        let mut out = vec![];
        requests.iter().for_each(|request| request.write(&mut out));
        out
    }

    fn flaws(bytes: &[u8]) -> Vec<String> {
        operations(bytes).filter_map(|one| Some(one.err()?.why.to_string())).collect()
    }

    /// The layout of the standard's table for CAN Transmit, byte by byte, and of its Configuration.
    #[test]
    fn the_bytes_are_those_of_the_standard() {
        let frame = Frame::data(0x181, [0xAA, 0xBB]);
        let wanted = [0x10, 0, 0, 0, 18, 0, 0, 0, 0x81, 1, 0, 0, 0, 0, 2, 0, 0xAA, 0xBB];
        assert_eq!(written(&[Request::Transmit(frame)]), wanted);
        let wanted = [0x40, 0, 0, 0, 13, 0, 0, 0, 1, 0x40, 0x42, 0x0F, 0];
        assert_eq!(written(&[Request::BitRate(1_000_000)]), wanted);
        let wanted = [0x40, 0, 0, 0, 10, 0, 0, 0, 4, 1, 0x41, 0, 0, 0, 9, 0, 0, 0, 3];
        assert_eq!(written(&[Request::BufferAndRetransmit, Request::Status(NodeStatus::BusOff)]), wanted);
    }

    #[test]
    fn what_is_written_is_read() {
        let frames = [
            Frame::data(0, []),
            Frame::data(0x7FF, [1, 2, 3, 4, 5, 6, 7, 8]),
            Frame::remote(0x701, 3).unwrap(),
        ];
        let bytes = written(&frames.map(Request::Transmit));
        let read: Vec<_> = operations(&bytes).map(|one| one.unwrap()).collect();
        assert_eq!(read, frames.map(|frame| Operation::Transmit(Some(frame))));
    }

    #[test]
    fn the_operations_of_a_bus_are_understood() {
        let mut bytes = vec![0x20, 0, 0, 0, 12, 0, 0, 0, 0x81, 1, 0, 0];
        bytes.extend([0x30, 0, 0, 0, 12, 0, 0, 0, 0x81, 1, 0, 0]);
        bytes.extend([0x31, 0, 0, 0, 15, 0, 0, 0, 0x81, 1, 0, 0, 4, 1, 0]);
        bytes.extend([0x42, 0, 0, 0, 8, 0, 0, 0]);
        bytes.extend([0x01, 0, 0, 0, 12, 0, 0, 0, 2, 0, 7, 8]);
        // An identifier of 29 bits, and a remote frame with the bytes that some write behind it.
        bytes.extend([0x10, 0, 0, 0, 16, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0x1F, 1, 0, 0, 0]);
        bytes.extend([0x10, 0, 0, 0, 17, 0, 0, 0, 1, 7, 0, 0, 0, 1, 1, 0, 9]);
        let error = BusError { id: 0x181, code: 4, is_primary: true, is_sender: false };
        let wanted = [
            Operation::Confirm(0x181),
            Operation::ArbitrationLost(0x181),
            Operation::BusError(error),
            Operation::Wakeup,
            Operation::FormatError(&[7, 8]),
            Operation::Transmit(None),
            Operation::Transmit(Frame::remote(0x701, 1)),
        ];
        let read: Vec<_> = operations(&bytes).map(|one| one.unwrap()).collect();
        assert_eq!(read, wanted);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = written(&[Request::Transmit(Frame::data(0x181, [1]))]);
        let with = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            flaws(&bytes)
        };
        for (at, byte, wanted) in [
            (0, 0x13, "its operation code 0x13 is none of CAN's"),
            (4, 7, "its length is 7, but there are 17 bytes; it counts the 8 bytes of its header"),
            (7, 1, "its length is 16777233, but there are 17 bytes; it counts the 8 bytes of its header"),
            (9, 8, "its identifier is 0x881; the largest is 0x7FF"),
            (12, 2, "ide is 2; it is 0 or 1"),
            (13, 255, "rtr is 255; it is 0 or 1"),
            (14, 2, "its length is 17; right is 18"),
            (14, 9, "it has 9 bytes of data, a classic frame at most 8"),
        ] {
            assert_eq!(with(at, byte), [wanted]);
        }
        assert_eq!(flaws(&good[..7]), ["7 bytes are left, an operation has at least 8"]);
        let bus_error = [0x31, 0, 0, 0, 15, 0, 0, 0, 1, 0, 0, 0, 7, 1, 0];
        assert_eq!(flaws(&bus_error), ["the error code is 7; it is from 1 to 6"]);
    }

    #[test]
    fn one_that_is_wrong_does_not_hide_the_next() {
        let mut bytes = written(&[Request::Transmit(Frame::data(1, [1])), Request::BufferAndRetransmit]);
        bytes[12] = 7;
        let read: Vec<_> = operations(&bytes).collect();
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].unwrap_err().bytes, &bytes[..17]);
        assert_eq!(read[1], Ok(Operation::ForTheBus));
    }

    /// No bytes make it panic or read for ever; whatever is read again is what was written.
    #[test]
    fn bytes_of_all_kinds_are_survived() {
        let mut random = Pcg64::seed_from_u64(7);
        let codes = [0x01, 0x10, 0x11, 0x12, 0x20, 0x30, 0x31, 0x40, 0x41, 0x42, 0x99];
        for _ in 0..100_000 {
            let length = random.random_range(0..40);
            let mut bytes: Vec<u8> = (0..length).map(|_| random.random()).collect();
            if let Some(header) = bytes.get_mut(..8) {
                header[..4].copy_from_slice(&[codes[random.random_range(0..codes.len())], 0, 0, 0]);
                header[4..].copy_from_slice(&[random.random_range(0..40), 0, 0, 0]);
            }
            let read = operations(&bytes).inspect(|one| {
                if let Ok(Operation::Transmit(Some(frame))) = one {
                    let again = written(&[Request::Transmit(*frame)]);
                    assert_eq!(operations(&again).next(), Some(Ok(Operation::Transmit(Some(*frame)))));
                }
            });
            assert!(read.count() <= bytes.len().div_ceil(8));
        }
    }

    #[test]
    fn a_format_error_has_no_more_than_there_is_room_for() {
        let mut out = vec![];
        write_format_error(&[1, 2, 3], 12, &mut out);
        assert_eq!(out, [1, 0, 0, 0, 12, 0, 0, 0, 2, 0, 1, 2]);
        write_format_error(&[1, 2, 3], 9, &mut out);
        assert_eq!(out.len(), 12);
        write_format_error(&vec![0; 100_000], usize::MAX, &mut out);
        assert_eq!(out.len(), 12 + 10 + 65_535);
    }
}
