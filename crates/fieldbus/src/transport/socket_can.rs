//! Linux SocketCAN.

use std::io::ErrorKind;
use std::time::SystemTime;

use rustix::io::Errno;
use socketcan::{
    CanFilter, CanFrame, CanSocket, EmbeddedFrame, Frame as _, Socket, SocketOptions, StandardId,
};

use super::clock::{now, wait_until_readable};
use super::{Filter, LinkError, OpenError, Received, Transport};
use crate::Nanoseconds;
use crate::frame::{Frame, FrameKind, LARGEST_ID};

/// Room for frames that wait in the kernel, in bytes as it counts them: 16 frames of 768 bytes, which a bus of 1 Mbit/s
/// sends in 2 ms. With the kernel's own default of 277 an old command could come 30 ms late.
const SEND_BUFFER: usize = 16 * 768 / 2; // the kernel doubles it

/// Marks a 29-bit identifier in a filter (linux/can.h).
const EXTENDED_FLAG: u32 = 0x8000_0000;

/// ARPHRD_CAN of linux/if_arp.h.
const CAN_LINK_TYPE: &str = "280";

/// A raw socket on a CAN interface.
pub struct SocketCan {
    socket: CanSocket,
    latest: Nanoseconds,
}

impl SocketCan {
    /// Opens an interface that is up; `address` is for messages.
    pub fn open(address: &str, interface: &str, filters: &[Filter]) -> Result<Self, OpenError> {
        let socket = open_socket(interface, filters).map_err(|cause| {
            let advice = advice(interface, &cause);
            OpenError::Refused { address: address.into(), cause, advice }
        })?;
        Ok(Self { socket, latest: 0 })
    }

    /// The kernel stamps frames with the wall clock; the age is taken off the clock that nobody sets.
    fn arrival(&mut self, stamp: Option<SystemTime>) -> Nanoseconds {
        let age = stamp.and_then(|stamp| stamp.elapsed().ok()).unwrap_or_default();
        let time = now().saturating_sub(age.as_nanos() as u64);
        self.latest = self.latest.max(time);
        self.latest
    }
}

fn open_socket(interface: &str, filters: &[Filter]) -> std::io::Result<CanSocket> {
    let socket = CanSocket::open(interface)?;
    // An interface that is down is told as an error that waits in the socket.
    if let Some(error) = socket.as_raw_socket().take_error()? {
        return Err(error);
    }
    socket.set_nonblocking(true)?;
    socket.set_error_filter_accept_all()?;
    socket.set_recv_timestamp(true)?;
    socket.as_raw_socket().set_send_buffer_size(SEND_BUFFER)?;
    let standard = |filter: &Filter| CanFilter::new(filter.id.into(), EXTENDED_FLAG | u32::from(filter.mask));
    let any = [Filter { id: 0, mask: 0 }];
    let filters = if filters.is_empty() { &any } else { filters };
    socket.set_filters(&filters.iter().map(standard).collect::<Vec<_>>())?;
    Ok(socket)
}

impl Transport for SocketCan {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let frame = encode(frame).ok_or(LinkError::ErrorFrame)?;
        Ok(self.socket.write_frame(&frame)?)
    }

    fn receive(&mut self, deadline: Nanoseconds) -> Result<Option<Received>, LinkError> {
        loop {
            match self.socket.read_frame_with_timestamps() {
                Ok((frame, stamps)) => {
                    let time = self.arrival(stamps.socket);
                    if let Some(frame) = decode(&frame) {
                        return Ok(Some(Received { frame, time }));
                    }
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if !wait_until_readable(self.socket.as_raw_socket(), deadline)? {
                        return Ok(None);
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

fn encode(frame: &Frame) -> Option<CanFrame> {
    let id = StandardId::new(frame.id())?;
    match frame.kind() {
        FrameKind::Data => CanFrame::new(id, frame.bytes()),
        FrameKind::Remote => CanFrame::new_remote(id, frame.length()),
        FrameKind::Error => None,
    }
}

/// `None` for a 29-bit identifier, which the filters keep out.
fn decode(frame: &CanFrame) -> Option<Frame> {
    let id = |id: u32| u16::try_from(id).ok().filter(|_| !frame.is_extended());
    match frame {
        CanFrame::Data(data) => Frame::new(FrameKind::Data, id(data.raw_id())?, data.data()),
        CanFrame::Remote(remote) => Frame::remote(id(remote.raw_id())?, remote.dlc() as u8),
        // Only classes up to 0x200 exist.
        CanFrame::Error(error) => {
            Frame::new(FrameKind::Error, error.error_bits() as u16 & LARGEST_ID, error.data())
        }
    }
}

/// What would be right, after an interface could not be opened.
fn advice(interface: &str, cause: &std::io::Error) -> String {
    match Errno::from_io_error(cause) {
        Some(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) => {
            "this kernel has no CAN: load its modules (modprobe can-raw) or use an slcan adapter".into()
        }
        Some(Errno::NETDOWN) => format!(
            "switch it on with the bus's bit rate: ip link set {interface} up type can bitrate 1000000"
        ),
        _ => match interfaces() {
            names if names.is_empty() => "this machine has no CAN interface".into(),
            names => format!("the CAN interfaces here are {}", names.join(", ")),
        },
    }
}

/// The names of the CAN interfaces of this machine.
fn interfaces() -> Vec<String> {
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let is_can = |entry: &std::fs::DirEntry| {
        std::fs::read_to_string(entry.path().join("type")).is_ok_and(|kind| kind.trim() == CAN_LINK_TYPE)
    };
    entries.filter(is_can).map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::error_class;
    use socketcan::{CanErrorFrame, ExtendedId};

    #[test]
    fn frames_come_back_as_they_were_sent() {
        for frame in [Frame::data(0x7FF, [1, 2, 3]), Frame::data(0, []), Frame::remote(0x701, 4).unwrap()] {
            assert_eq!(decode(&encode(&frame).unwrap()), Some(frame));
        }
    }

    #[test]
    fn an_error_report_is_read_but_never_sent() {
        let report = CanFrame::Error(CanErrorFrame::new_error(0x40, &[0, 4]).unwrap());
        let frame = decode(&report).unwrap();
        assert_eq!((frame.kind(), frame.id()), (FrameKind::Error, error_class::BUS_OFF));
        assert_eq!(frame.bytes()[..2], [0, 4]);
        assert!(encode(&frame).is_none());
    }

    #[test]
    fn identifiers_of_29_bits_are_passed_over() {
        let extended = CanFrame::new(ExtendedId::new(0x181).unwrap(), &[1]).unwrap();
        assert_eq!(decode(&extended), None);
    }
}
