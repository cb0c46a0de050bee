//! A node's connection to one bus: what is to be sent, what was received, and the error counters of its CAN controller.

use std::fmt;

use super::operation::{
    BusError, LONGEST_REQUEST, NodeStatus, Operation, Request, is_format_error, operations,
    write_format_error,
};
use crate::bridge::{FrameQueue, TransportError};
use crate::frame::Frame;

/// Cycles whose frames there is room for.
pub const CYCLES: u32 = 16;
/// Bytes that may wait to be sent, and that may be received at once.
pub const ROOM: usize = CYCLES as usize * FrameQueue::CAPACITY * LONGEST_REQUEST;

/// What a port has received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Received<'a> {
    /// A frame.
    Frame(Frame),
    /// The error counter of the transmitter has passed 255.
    BusOff,
    /// Something to tell people.
    Notice(Notice<'a>),
}

/// Something to tell people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice<'a> {
    /// What was received is no operation; it is sent back as Format Error.
    Malformed(super::operation::Malformed<'a>),
    /// Somebody could not read this of ours.
    FormatError(&'a [u8]),
    /// A frame of CAN FD or XL, with its operation code.
    NotClassic(u32),
    /// A frame of ours was dropped because it lost the arbitration.
    Dropped(u32),
    /// A frame was destroyed.
    Destroyed(BusError),
    /// The CAN controller has another state.
    Status(NodeStatus),
}

/// The connection to one bus. After [`Port::new`] nothing is allocated.
#[derive(Debug)]
pub struct Port {
    /// Operations to be sent, [`ROOM`] bytes at most.
    tx: Vec<u8>,
    /// So much of them is shown to the importer.
    shown: usize,
    transmit_errors: u16,
    receive_errors: u16,
    status: NodeStatus,
}

impl Port {
    /// Switched on: tells a bus of this bit rate (bit/s) what it must know, at the first event.
    pub fn new(bit_rate: f64) -> Self {
        let mut port = Self {
            tx: Vec::with_capacity(ROOM),
            shown: 0,
            transmit_errors: 0,
            receive_errors: 0,
            status: NodeStatus::ErrorActive,
        };
        // Both fit.
        let _ = port.push(Request::BitRate(bit_rate as u32));
        let _ = port.push(Request::BufferAndRetransmit);
        port.show();
        port
    }

    /// A frame, for the next bus communication point.
    ///
    /// # Errors
    /// [`TransportError`] if too much waits already, or the controller is off the bus: it will never be sent.
    pub fn send(&mut self, frame: Frame) -> Result<(), TransportError> {
        if self.status == NodeStatus::BusOff {
            return Err(TransportError::Down);
        }
        self.push(Request::Transmit(frame))
    }

    fn push(&mut self, request: Request) -> Result<(), TransportError> {
        if self.tx.len() + LONGEST_REQUEST > ROOM {
            return Err(TransportError::NoRoom);
        }
        request.write(&mut self.tx);
        Ok(())
    }

    /// A bus communication point has come. Whether there is anything to send.
    pub fn show(&mut self) -> bool {
        self.shown = self.tx.len();
        self.shown > 0
    }

    /// What is sent now.
    pub fn shown(&self) -> &[u8] {
        &self.tx[..self.shown]
    }

    /// What was shown is sent.
    pub fn forget_shown(&mut self) {
        self.tx.drain(..self.shown);
        self.shown = 0;
    }

    /// Takes in the operations of a binary variable, and tells `take` of each frame and of what is odd, in their order.
    pub fn receive<'a>(&mut self, bytes: &'a [u8], take: &mut dyn FnMut(Received<'a>)) {
        for operation in operations(bytes) {
            match operation {
                Ok(Operation::Transmit(frame)) => {
                    self.receive_errors = self.receive_errors.saturating_sub(1);
                    self.settle(take);
                    frame.into_iter().for_each(|frame| take(Received::Frame(frame)));
                }
                Ok(Operation::Confirm(_)) => {
                    self.transmit_errors = self.transmit_errors.saturating_sub(1);
                    self.settle(take);
                }
                Ok(Operation::BusError(error)) => self.count(error, take),
                Ok(Operation::OtherTransmit(code)) => take(Received::Notice(Notice::NotClassic(code))),
                Ok(Operation::ArbitrationLost(id)) => take(Received::Notice(Notice::Dropped(id))),
                Ok(Operation::FormatError(bytes)) => take(Received::Notice(Notice::FormatError(bytes))),
                Ok(Operation::ForTheBus | Operation::Wakeup) => {}
                Err(malformed) => {
                    if !is_format_error(malformed.bytes) {
                        write_format_error(malformed.bytes, ROOM - self.tx.len(), &mut self.tx);
                    }
                    take(Received::Notice(Notice::Malformed(malformed)));
                }
            }
        }
    }

    /// As ISO 11898-1 counts: 8 for what was sent, 1 for what was received, 8 more for whoever saw it first.
    fn count<'a>(&mut self, error: BusError, take: &mut dyn FnMut(Received<'a>)) {
        take(Received::Notice(Notice::Destroyed(error)));
        if error.is_sender {
            self.transmit_errors = self.transmit_errors.saturating_add(8);
        } else {
            let more = if error.is_primary { 9 } else { 1 };
            self.receive_errors = (self.receive_errors + more).min(255);
        }
        self.settle(take);
    }

    /// The state that belongs to the counters. Nothing leads back from bus off but a reset.
    fn settle<'a>(&mut self, take: &mut dyn FnMut(Received<'a>)) {
        let status = match (self.transmit_errors, self.receive_errors) {
            _ if self.status == NodeStatus::BusOff => NodeStatus::BusOff,
            (256.., _) => NodeStatus::BusOff,
            (128.., _) | (_, 128..) => NodeStatus::ErrorPassive,
            _ => NodeStatus::ErrorActive,
        };
        if status == self.status {
            return;
        }
        self.status = status;
        if status == NodeStatus::BusOff {
            // What waits is not sent any more.
            self.tx.truncate(self.shown);
            take(Received::BusOff);
        }
        // Where there is no room for it nobody has listened for long.
        let _ = self.push(Request::Status(status));
        take(Received::Notice(Notice::Status(status)));
    }
}

impl fmt::Display for Notice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(malformed) => {
                write!(f, "received what is no operation of CAN ({}): ", malformed.why)?;
                hexadecimal(malformed.bytes, f)
            }
            Self::FormatError(bytes) => {
                write!(f, "Format Error: this operation was not understood: ")?;
                hexadecimal(bytes, f)
            }
            Self::NotClassic(code) => {
                write!(f, "received a frame of CAN FD or CAN XL (operation code 0x{code:X}), passed over")
            }
            Self::Dropped(id) => {
                write!(f, "Arbitration Lost: the frame 0x{id:03X} was dropped; it is not sent again")
            }
            Self::Destroyed(error) => write!(f, "Bus Error {}: the frame 0x{:03X}", error.code, error.id),
            Self::Status(status) => write!(f, "the CAN controller is {status}"),
        }
    }
}

/// The first bytes, enough to recognise an operation.
fn hexadecimal(bytes: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    bytes.iter().take(LONGEST_REQUEST).try_for_each(|byte| write!(f, "{byte:02X}"))?;
    if bytes.len() > LONGEST_REQUEST { write!(f, "... ({} bytes)", bytes.len()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERROR: [u8; 15] = [0x31, 0, 0, 0, 15, 0, 0, 0, 0x81, 1, 0, 0, 5, 1, 1];

    /// A port that has said its configuration.
    fn port() -> Port {
        let mut port = Port::new(1e6);
        port.forget_shown();
        port
    }

    fn texts(port: &mut Port, bytes: &[u8]) -> Vec<String> {
        let mut texts = vec![];
        port.receive(bytes, &mut |received| {
            texts.push(match received {
                Received::Frame(frame) => frame.to_string(),
                Received::BusOff => "bus off".to_owned(),
                Received::Notice(notice) => notice.to_string(),
            });
        });
        texts
    }

    #[test]
    fn a_port_begins_with_the_bit_rate_and_shows_nothing_twice() {
        let mut port = Port::new(500e3);
        assert_eq!(port.shown().len(), 13 + 10);
        assert_eq!(port.shown()[9..13], 500_000_u32.to_le_bytes());
        // What comes in between waits for the next point.
        port.send(Frame::data(1, [])).unwrap();
        assert_eq!(port.shown().len(), 13 + 10);
        port.forget_shown();
        assert!(port.shown().is_empty());
        assert!(port.show());
        assert_eq!(port.shown().len(), 16);
        port.forget_shown();
        assert!(!port.show());
    }

    #[test]
    fn what_has_no_room_is_refused_and_nothing_is_allocated() {
        let mut port = port();
        let frame = Frame::data(1, [0; 8]);
        let sent = (0..2000).filter(|_| port.send(frame).is_ok()).count();
        assert_eq!(sent, CYCLES as usize * FrameQueue::CAPACITY);
        assert_eq!(port.send(frame), Err(TransportError::NoRoom));
        assert_eq!((port.tx.len(), port.tx.capacity()), (ROOM, ROOM));
        texts(&mut port, &[9; 30]);
        assert_eq!((port.tx.len(), port.tx.capacity()), (ROOM, ROOM));
    }

    #[test]
    fn what_is_no_operation_is_sent_back_and_a_broken_format_error_is_not() {
        let mut port = port();
        let told = texts(&mut port, &[0x99, 0, 0, 0, 9, 0, 0, 0, 7]);
        assert_eq!(
            told,
            [
                "received what is no operation of CAN (its operation code 0x99 is none of CAN's): 990000000900000007"
            ]
        );
        assert!(port.show());
        assert_eq!(port.shown(), [1, 0, 0, 0, 19, 0, 0, 0, 9, 0, 0x99, 0, 0, 0, 9, 0, 0, 0, 7]);
        port.forget_shown();
        assert_eq!(texts(&mut port, &[1, 0, 0, 0, 9, 0, 0, 0, 7]).len(), 1);
        assert!(!port.show());
    }

    #[test]
    fn a_transmitter_with_too_many_errors_is_off_the_bus() {
        let mut port = port();
        let told: Vec<String> = (0..40).flat_map(|_| texts(&mut port, &ERROR)).collect();
        let passive = told.iter().position(|text| text.ends_with("error passive")).unwrap();
        let off = told.iter().position(|text| text == "bus off").unwrap();
        // 16 errors make 128, 32 make 256; one line more for the change before.
        assert_eq!((passive, off), (16, 33));
        assert!(port.show());
        let status = |status| [0x41, 0, 0, 0, 9, 0, 0, 0, status];
        assert_eq!(port.shown(), status(3), "what waited before is not sent");
        assert_eq!(port.send(Frame::data(1, [])), Err(TransportError::Down));
    }

    #[test]
    fn what_is_confirmed_leads_back() {
        let mut port = port();
        (0..16).for_each(|_| _ = texts(&mut port, &ERROR));
        let confirm = [0x20, 0, 0, 0, 12, 0, 0, 0, 0x81, 1, 0, 0];
        assert_eq!(texts(&mut port, &confirm), ["the CAN controller is error active"]);
        assert!(port.show());
        assert_eq!(port.shown()[8], 2);
        assert_eq!(port.shown()[17], 1);
    }
}
