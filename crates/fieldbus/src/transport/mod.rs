//! Where frames come from and go to: Linux SocketCAN, or a serial CAN adapter (slcan) on a device, a pseudo-terminal or TCP.
//!
//! Nothing here waits longer than it is told, and nothing is sent late: a frame that cannot go now is refused and forgotten,
//! and what waits in the kernel is bounded to about a cycle's frames. Addresses are described in `docs/can-addresses.md`.

mod address;
mod clock;
mod serial;
mod socket_can;

use rustix::io::Errno;
use thiserror::Error;

pub use clock::now;
pub use serial::{pseudo_terminal, tcp_adapter};

use crate::Nanoseconds;
use crate::bridge::TransportError;
use crate::frame::{Frame, FrameKind};
use address::Address;

/// One end of a CAN bus. None of its functions allocates memory.
pub trait Transport: Send {
    /// Puts a frame on the bus, at once or not at all.
    ///
    /// # Errors
    /// [`LinkError`]; the frame was dropped and will not be sent later.
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError>;

    /// The next frame from the bus; `None` if there is none until `deadline`, a time on the clock of [`now`]. A deadline
    /// that has passed asks only for what is there.
    ///
    /// # Errors
    /// [`LinkError`], but not [`LinkError::BufferFull`]. A controller that has left the bus is no error here
    /// but a frame of [`FrameKind::Error`], so that it is recorded with the others.
    fn receive(&mut self, deadline: Nanoseconds) -> Result<Option<Received>, LinkError>;
}

/// A frame from the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// What came.
    pub frame: Frame,
    /// When, on the clock of [`now`]: as the kernel saw it (SocketCAN) or when it was read (slcan). Never decreases.
    pub time: Nanoseconds,
}

/// Which frames are wanted: those whose identifier agrees with `id` in the bits of `mask`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// The bits wanted.
    pub id: u16,
    /// The bits looked at.
    pub mask: u16,
}

/// Whether a frame is wanted; without a filter all are, and error reports always.
fn is_wanted(filters: &[Filter], frame: &Frame) -> bool {
    let matches = |filter: &Filter| (frame.id() ^ filter.id) & filter.mask == 0;
    frame.kind() == FrameKind::Error || filters.is_empty() || filters.iter().any(matches)
}

/// What is wrong with a link in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The interface is switched off (ENETDOWN). Every `send` says so, `receive` once; when the interface is switched on again
    /// the link goes on.
    #[error("the CAN link is down")]
    Down,
    /// The interface or adapter is gone, or the other end has hung up; only opening it anew can help.
    #[error("the CAN link was removed")]
    Removed,
    /// Frames wait unsent and this one found no room (ENOBUFS): nobody acknowledges them or the bus is too slow.
    #[error("the CAN link's send buffer is full")]
    BufferFull,
    /// An error report cannot be sent.
    #[error("an error frame cannot be sent")]
    ErrorFrame,
    /// Anything else.
    #[error("the CAN link failed: {0}")]
    Other(Errno),
}

impl From<Errno> for LinkError {
    fn from(error: Errno) -> Self {
        match error {
            Errno::NETDOWN | Errno::NETUNREACH => Self::Down,
            Errno::NODEV | Errno::NXIO | Errno::IO | Errno::PIPE | Errno::CONNRESET => Self::Removed,
            Errno::NOBUFS | Errno::AGAIN => Self::BufferFull,
            other => Self::Other(other),
        }
    }
}

impl From<std::io::Error> for LinkError {
    fn from(error: std::io::Error) -> Self {
        Errno::from_io_error(&error).unwrap_or(Errno::PROTO).into()
    }
}

/// What the bridge is told.
impl From<LinkError> for TransportError {
    fn from(error: LinkError) -> Self {
        match error {
            LinkError::BufferFull => Self::NoRoom,
            LinkError::Down => Self::Down,
            LinkError::Removed | LinkError::ErrorFrame | LinkError::Other(_) => Self::Gone,
        }
    }
}

/// Why a link could not be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// Not an address.
    #[error(
        "{0:?} is not a CAN address: expected one like can0, socketcan:can0, slcan:/dev/ttyACM0, slcan:/dev/ttyUSB0@115200 or slcan:tcp://host:port"
    )]
    Address(String),
    /// The slcan protocol has no command for the bit rate.
    #[error("{address}: slcan has no bit rate of {bitrate} bit/s: expected one of {:?}", serial::BIT_RATES)]
    BitRate {
        /// The address asked for.
        address: String,
        /// bit/s.
        bitrate: u32,
    },
    /// The system said no.
    #[error("cannot open {address}: {cause}; {advice}")]
    Refused {
        /// The address asked for.
        address: String,
        /// What the system said.
        cause: std::io::Error,
        /// What would be right.
        advice: String,
    },
}

/// Opens a link: `can0` or `socketcan:can0`, whose bit rate the system has set; `slcan:` with a device or `tcp://host:port`,
/// whose adapter is told `bitrate` (bit/s) and opened.
///
/// Frames that no filter matches are not received; without filters all are, those with 29-bit identifiers excepted.
///
/// # Errors
/// [`OpenError`] with the address and what would be right.
pub fn open(address: &str, bitrate: u32, filters: &[Filter]) -> Result<Box<dyn Transport>, OpenError> {
    let parsed = Address::parse(address).ok_or_else(|| OpenError::Address(address.into()))?;
    if let Address::Interface(interface) = parsed {
        return Ok(Box::new(socket_can::SocketCan::open(address, interface, filters)?));
    }
    let command = serial::bit_rate_command(bitrate)
        .ok_or_else(|| OpenError::BitRate { address: address.into(), bitrate })?;
    Ok(Box::new(serial::SerialLine::open(address, &parsed, command, filters)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_system_are_told_apart() {
        let read = |errno: Errno| LinkError::from(std::io::Error::from(errno));
        assert_eq!(read(Errno::NETDOWN), LinkError::Down);
        assert_eq!(read(Errno::NODEV), LinkError::Removed);
        assert_eq!(read(Errno::NXIO), LinkError::Removed);
        assert_eq!(read(Errno::NOBUFS), LinkError::BufferFull);
        assert_eq!(read(Errno::INVAL), LinkError::Other(Errno::INVAL));
    }

    #[test]
    fn what_cannot_be_opened_is_said_with_what_would_be_right() {
        let message = |address: &str, bitrate| open(address, bitrate, &[]).err().unwrap().to_string();
        assert_eq!(
            message("slcan:ttyACM0", 1_000_000),
            "\"slcan:ttyACM0\" is not a CAN address: expected one like can0, socketcan:can0, slcan:/dev/ttyACM0, \
             slcan:/dev/ttyUSB0@115200 or slcan:tcp://host:port"
        );
        assert!(
            message("slcan:/dev/ttyACM0", 333_333)
                .contains("no bit rate of 333333 bit/s: expected one of [10000,")
        );
        let absent = message("slcan:/dev/no_such_adapter", 1_000_000);
        assert!(absent.starts_with("cannot open slcan:/dev/no_such_adapter: No such file"), "{absent}");
        assert!(absent.contains("/dev/ttyACM0"), "{absent}");
        let file = message("slcan:/dev/null", 1_000_000);
        assert!(file.contains("is not a serial device"), "{file}");
        let refused = message("slcan:tcp://127.0.0.1:1", 1_000_000);
        assert!(refused.contains("refused") && refused.contains("listens"), "{refused}");
        // With or without CAN in the kernel that runs the test.
        let interface = message("socketcan:no_such_if", 1_000_000);
        assert!(interface.starts_with("cannot open socketcan:no_such_if: "), "{interface}");
    }

    #[test]
    fn filters_look_at_the_bits_of_their_mask() {
        let filters = [Filter { id: 0x180, mask: 0x780 }, Filter { id: 0x701, mask: 0x7FF }];
        let wanted = |id| is_wanted(&filters, &Frame::data(id, []));
        assert!(wanted(0x181) && wanted(0x1FF) && wanted(0x701));
        assert!(!wanted(0x201) && !wanted(0x702) && !wanted(0x000));
        assert!(is_wanted(&[], &Frame::data(0x702, [])));
        assert!(is_wanted(&filters, &Frame::new(FrameKind::Error, 0x040, &[0; 8]).unwrap()));
    }
}
