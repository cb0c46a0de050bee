//! A classic CAN frame with an 11-bit identifier, and the error reports of a controller.

use std::fmt;

/// Largest 11-bit identifier.
pub const LARGEST_ID: u16 = 0x7FF;

/// What a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// Carries data.
    Data,
    /// Asks for data; has a length but no bytes.
    Remote,
    /// Never was on the bus: the controller reports an error; the identifier is its class (see [`error_class`]).
    Error,
}

/// Classes of an error frame, bits of its identifier, as SocketCAN numbers them (linux/can/error.h).
pub mod error_class {
    /// Transmission timed out.
    pub const TRANSMIT_TIMEOUT: u16 = 0x001;
    /// Trouble of the controller, told in data byte 1.
    pub const CONTROLLER: u16 = 0x004;
    /// No node acknowledged a frame.
    pub const NO_ACKNOWLEDGE: u16 = 0x020;
    /// The controller has left the bus.
    pub const BUS_OFF: u16 = 0x040;
}

/// A classic CAN frame, at most 8 bytes of data.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    kind: FrameKind,
    id: u16,
    length: u8,
    bytes: [u8; 8],
}

impl Frame {
    /// A data frame whose length is known when the program is compiled; of `id` the lower 11 bits count.
    pub fn data<const N: usize>(id: u16, data: [u8; N]) -> Self {
        const { assert!(N <= 8) };
        let mut bytes = [0; 8];
        bytes[..N].copy_from_slice(&data);
        Self { kind: FrameKind::Data, id: id & LARGEST_ID, length: N as u8, bytes }
    }

    /// A frame of any kind; `None` if the identifier has more than 11 bits or there are more than 8 bytes.
    pub fn new(kind: FrameKind, id: u16, data: &[u8]) -> Option<Self> {
        if id > LARGEST_ID || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self { kind, id, length: data.len() as u8, bytes })
    }

    /// A remote frame that asks for `length` bytes; `None` as in [`Frame::new`].
    pub fn remote(id: u16, length: u8) -> Option<Self> {
        Self::new(FrameKind::Remote, id, [0; 8].get(..usize::from(length))?)
    }

    /// What it is.
    pub fn kind(&self) -> FrameKind {
        self.kind
    }

    /// Identifier, or the class of an error frame.
    pub fn id(&self) -> u16 {
        self.id
    }

    /// Number of bytes, 0 to 8; of a remote frame those asked for.
    pub fn length(&self) -> usize {
        self.length.into()
    }

    /// The data; empty for a remote frame.
    pub fn bytes(&self) -> &[u8] {
        if self.kind == FrameKind::Remote { &[] } else { &self.bytes[..self.length()] }
    }

    /// `N` bytes from `at` on; `None` if the frame is shorter.
    pub fn array<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        self.bytes().get(at..at.checked_add(N)?)?.try_into().ok()
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// As candump writes it: `181#0011`, `181#R2`, `20000040#0000000000000000`.
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            FrameKind::Data => write!(f, "{:03X}#", self.id)?,
            FrameKind::Remote => write!(f, "{:03X}#R{}", self.id, self.length)?,
            FrameKind::Error => write!(f, "{:08X}#", super::candump::ERROR_FLAG | u32::from(self.id))?,
        }
        self.bytes().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// Parses exactly `N` hexadecimal digits.
pub(super) fn hex<const N: usize>(digits: &[u8]) -> Option<u32> {
    let digits: &[u8; N] = digits.try_into().ok()?;
    digits.iter().try_fold(0, |value, digit| Some(value << 4 | char::from(*digit).to_digit(16)?))
}

/// Parses pairs of hexadecimal digits into at most 8 bytes.
pub(super) fn hex_bytes<'a>(digits: &[u8], bytes: &'a mut [u8; 8]) -> Option<&'a [u8]> {
    if !digits.len().is_multiple_of(2) || digits.len() > 16 {
        return None;
    }
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = hex::<2>(pair)? as u8;
    }
    Some(&bytes[..digits.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_is_read_within_the_frame_only() {
        let frame = Frame::data(0x181, [1, 2, 3]);
        assert_eq!((frame.id(), frame.length(), frame.bytes()), (0x181, 3, &[1, 2, 3][..]));
        assert_eq!(frame.array::<2>(1), Some([2, 3]));
        assert_eq!(frame.array::<2>(2), None);
        assert_eq!(frame.array::<2>(usize::MAX), None);
    }

    #[test]
    fn too_long_or_too_large_is_refused() {
        assert_eq!(Frame::new(FrameKind::Data, 0x800, &[]), None);
        assert_eq!(Frame::new(FrameKind::Data, 1, &[0; 9]), None);
        assert_eq!(Frame::remote(1, 9), None);
        assert_eq!(Frame::remote(1, 8).unwrap().bytes(), &[] as &[u8]);
    }
}
