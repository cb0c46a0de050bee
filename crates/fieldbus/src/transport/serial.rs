//! A serial CAN adapter (slcan): on a serial device, a pseudo-terminal or a TCP connection.

use std::net::{TcpStream, ToSocketAddrs};
use std::os::fd::{AsFd, OwnedFd};
use std::path::PathBuf;
use std::time::Duration;

use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::{Errno, read, write};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr};

use super::address::Address;
use super::clock::{now, wait_until_readable};
use super::{Filter, LinkError, OpenError, Received, Transport, is_wanted};
use crate::Nanoseconds;
use crate::frame::Frame;
use crate::slcan::{self, Decoder};

/// The bit rates that adapters know, bit/s, in the order of their commands S0 to S8.
pub const BIT_RATES: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// Most bytes that may wait in a serial port: 16 frames of 22 bytes.
const MOST_WAITING_SERIAL: usize = 16 * 22;

/// Most bytes that may be without an acknowledgement of the other end, which may keep it back for 40 ms: that long at 350
/// cycles a second with seven frames each.
const MOST_WAITING_TCP: usize = 98 * 22;

/// How long a TCP connection may take.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Reads in one call to `receive`, after which it comes back even if the other end babbles: 8 KiB.
const MOST_READS: usize = 16;

/// The link to an adapter, or with [`pseudo_terminal`] the adapter's end of it.
pub struct SerialLine {
    link: OwnedFd,
    most_waiting: usize,
    /// A full buffer cut the frame before.
    cut: bool,
    filters: Vec<Filter>,
    decoder: Decoder,
    buffer: [u8; 512],
    taken: usize,
    filled: usize,
    read_at: Nanoseconds,
    closes_adapter: bool,
}

/// The command that sets a bit rate, `S0` to `S8`.
pub fn bit_rate_command(bitrate: u32) -> Option<[u8; 3]> {
    let index = BIT_RATES.iter().position(|known| *known == bitrate)?;
    Some([b'S', b'0' + index as u8, b'\r'])
}

/// A new pseudo-terminal: the adapter's end of it, and the device that the other program opens as `slcan:/dev/pts/N`.
///
/// # Errors
/// As the system says.
pub fn pseudo_terminal() -> std::io::Result<(impl Transport, PathBuf)> {
    let link = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&link)?;
    unlockpt(&link)?;
    rustix::io::ioctl_fionbio(&link, true)?;
    make_raw(&link, 115_200)?;
    let path = ptsname(&link, Vec::new())?.into_string().map_err(std::io::Error::other)?;
    Ok((SerialLine::new(link, MOST_WAITING_SERIAL, &[]), path.into()))
}

/// The adapter's end of a TCP connection that another program opened as `slcan:tcp://host:port`.
///
/// # Errors
/// As the system says.
pub fn tcp_adapter(stream: TcpStream) -> std::io::Result<impl Transport> {
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)?;
    Ok(SerialLine::new(stream.into(), MOST_WAITING_TCP, &[]))
}

impl SerialLine {
    /// Opens the link, sets the bit rate of the adapter behind it and opens its bus; `text` is for messages.
    pub fn open(
        text: &str,
        address: &Address,
        bit_rate: [u8; 3],
        filters: &[Filter],
    ) -> Result<Self, OpenError> {
        let opened = match *address {
            Address::Tcp(host) => connect(host).map(|link| Self::new(link, MOST_WAITING_TCP, filters)),
            Address::Device(path, baud) => {
                open_device(path, baud).map(|link| Self::new(link, MOST_WAITING_SERIAL, filters))
            }
            Address::Interface(_) => Err(Errno::INVAL.into()),
        };
        let opened = opened.and_then(|mut line| line.open_adapter(bit_rate).map(|()| line));
        opened.map_err(|cause| {
            let advice = advice(address, &cause);
            OpenError::Refused { address: text.into(), cause, advice }
        })
    }

    fn new(link: OwnedFd, most_waiting: usize, filters: &[Filter]) -> Self {
        Self {
            link,
            most_waiting,
            cut: false,
            filters: filters.into(),
            decoder: Decoder::default(),
            buffer: [0; 512],
            taken: 0,
            filled: 0,
            read_at: 0,
            closes_adapter: false,
        }
    }

    /// An empty command ends what a program before may have left half sent; an open bus must be closed to set its bit rate.
    fn open_adapter(&mut self, bit_rate: [u8; 3]) -> std::io::Result<()> {
        for command in [&b"\r"[..], b"C\r", &bit_rate, b"O\r"] {
            write(&self.link, command)?;
        }
        self.closes_adapter = true;
        Ok(())
    }

    /// Makes the frame that was cut one that the adapter does not understand, so that it is never played out late.
    fn spoil_cut_frame(&mut self) -> Result<(), Errno> {
        if self.cut {
            self.cut = write(&self.link, b"-\r")? < 2;
        }
        Ok(())
    }

    /// The next wanted frame among the bytes that were read.
    fn next_frame(&mut self) -> Option<Received> {
        while self.taken < self.filled {
            self.taken += 1;
            if let Some(slcan::Received::Frame(frame)) = self.decoder.push(self.buffer[self.taken - 1])
                && is_wanted(&self.filters, &frame)
            {
                return Some(Received { frame, time: self.read_at });
            }
        }
        None
    }
}

impl Transport for SerialLine {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let encoded = slcan::encode(frame).ok_or(LinkError::ErrorFrame)?;
        let bytes = encoded.as_bytes();
        self.spoil_cut_frame()?;
        if self.cut || waiting(&self.link)? + bytes.len() > self.most_waiting {
            return Err(LinkError::BufferFull);
        }
        self.cut = write(&self.link, bytes)? < bytes.len();
        if self.cut { Err(LinkError::BufferFull) } else { Ok(()) }
    }

    fn receive(&mut self, deadline: Nanoseconds) -> Result<Option<Received>, LinkError> {
        let mut reads = 0;
        loop {
            if let Some(received) = self.next_frame() {
                return Ok(Some(received));
            }
            if reads >= MOST_READS && now() >= deadline {
                return Ok(None);
            }
            match read(&self.link, &mut self.buffer) {
                Ok(0) => return Err(LinkError::Removed),
                Ok(filled) => {
                    reads += 1;
                    (self.taken, self.filled, self.read_at) = (0, filled, now());
                }
                Err(Errno::AGAIN) => {
                    if !wait_until_readable(&self.link, deadline)? {
                        return Ok(None);
                    }
                }
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

impl Drop for SerialLine {
    fn drop(&mut self) {
        if self.closes_adapter {
            // Nobody is left to tell if it fails.
            let _ = write(&self.link, b"C\r");
        }
    }
}

fn connect(host: &str) -> std::io::Result<OwnedFd> {
    let mut last = std::io::ErrorKind::AddrNotAvailable.into();
    for address in host.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_nonblocking(true)?;
                return Ok(stream.into());
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn open_device(path: &str, baud: u32) -> std::io::Result<OwnedFd> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let link = rustix::fs::open(path, flags, Mode::empty())?;
    // The lock keeps out root as well, and pyserial asks for it.
    flock(&link, FlockOperation::NonBlockingLockExclusive)?;
    ioctl_tiocexcl(&link)?;
    make_raw(&link, baud)?;
    // An adapter that was left open has filled the buffer with frames that are old by now.
    tcflush(&link, QueueSelector::IFlush)?;
    Ok(link)
}

/// Bytes pass as they are, without an echo.
fn make_raw(link: impl AsFd, baud: u32) -> std::io::Result<()> {
    let mut settings = tcgetattr(&link)?;
    settings.make_raw();
    settings.set_speed(baud)?;
    Ok(tcsetattr(&link, OptionalActions::Now, &settings)?)
}

/// Bytes written to a serial port or TCP connection that have not left it, as far as the kernel knows.
#[allow(unsafe_code)]
fn waiting(link: impl AsFd) -> Result<usize, Errno> {
    use rustix::ioctl::{Getter, Opcode, ioctl};
    // SAFETY: TIOCOUTQ (for sockets it is called SIOCOUTQ) writes one int.
    let count = unsafe { ioctl(link, Getter::<{ libc::TIOCOUTQ as Opcode }, libc::c_int>::new()) }?;
    Ok(count.max(0) as usize)
}

/// What would be right, after a link could not be opened.
fn advice(address: &Address, cause: &std::io::Error) -> String {
    match (address, Errno::from_io_error(cause)) {
        (Address::Device(path, _), Some(Errno::NOTTY)) => format!("{path} is not a serial device"),
        (Address::Device(path, _), Some(Errno::ACCESS)) => {
            format!("you may not use {path}: add yourself to its group (ls -l {path}; often dialout)")
        }
        (Address::Device(..), Some(Errno::BUSY | Errno::AGAIN)) => "another program uses it".into(),
        (Address::Device(..), _) => "expected a serial device like /dev/ttyACM0 with an adapter on it".into(),
        _ => "expected a host and port at which an adapter listens".into(),
    }
}

#[cfg(test)]
#[path = "serial_tests.rs"]
mod tests;
