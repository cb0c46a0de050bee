//! Where the simulated rig meets the bridge: a pseudo-terminal or a TCP port that it offers, or a CAN address that it opens.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};

use anyhow::{Context, Result};
use cable_robot_fieldbus::config::Bus;
use cable_robot_fieldbus::transport::{self, LinkError, Transport, pseudo_terminal, tcp_adapter};
use cable_robot_fieldbus::{Frame, Nanoseconds};

/// One bus.
pub struct Port {
    link: Option<Box<dyn Transport>>,
    /// Who calls here is the next bridge.
    listener: Option<TcpListener>,
    /// Frames that found no room or nobody.
    pub dropped: u64,
}

impl Port {
    /// Opens `address` for a bus: `pty`, `listen:PORT` of this machine alone, `listen:HOST:PORT` or a CAN address. Says what the bridge has to be told.
    pub fn open(bus: &Bus, address: &str) -> Result<(Self, String)> {
        let port = |link, listener| Self { link, listener, dropped: 0 };
        if address == "pty" {
            let (link, device) = pseudo_terminal().context("cannot make a pseudo-terminal")?;
            return Ok((port(Some(Box::new(link)), None), format!("slcan:{}", device.display())));
        }
        if let Some(at) = address.strip_prefix("listen:") {
            let listener = match at.parse::<u16>() {
                Ok(port) => TcpListener::bind((Ipv4Addr::LOCALHOST, port)),
                Err(_) => TcpListener::bind(at),
            };
            let listener = listener.with_context(|| format!("cannot listen at {at}"))?;
            listener.set_nonblocking(true)?;
            let at = listener.local_addr()?;
            if !at.ip().is_loopback() {
                warn_of_others(&bus.name, at)?;
            }
            return Ok((port(None, Some(listener)), format!("slcan:tcp://{at}")));
        }
        let link = transport::open(address, bus.bit_rate as u32, &[])?;
        Ok((port(Some(link), None), address.to_owned()))
    }

    /// The next frame until `deadline`, if there is one.
    pub fn receive(&mut self, deadline: Nanoseconds) -> Option<Frame> {
        if let (None, Some(listener)) = (&self.link, &self.listener)
            && let Ok((stream, _)) = listener.accept()
        {
            self.link = tcp_adapter(stream).ok().map(|link| Box::new(link) as Box<dyn Transport>);
        }
        match self.link.as_mut().map(|link| link.receive(deadline)) {
            Some(Ok(received)) => return received.map(|received| received.frame),
            // A pseudo-terminal waits for the next bridge, and so does a listener.
            Some(Err(LinkError::Removed)) if self.listener.is_some() => self.link = None,
            Some(Err(_)) | None => {}
        }
        let left = deadline.saturating_sub(transport::now());
        std::thread::sleep(std::time::Duration::from_nanos(left));
        None
    }

    /// Closes it for good.
    pub fn hang_up(&mut self) {
        (self.link, self.listener) = (None, None);
    }

    /// Sends a frame now or never.
    pub fn send(&mut self, frame: &Frame) {
        let sent = self.link.as_mut().is_some_and(|link| link.send(frame).is_ok());
        self.dropped += u64::from(!sent);
    }
}

/// Nobody asks who connects.
fn warn_of_others(bus: &str, at: SocketAddr) -> Result<()> {
    writeln!(
        std::io::stderr(),
        "rig-sim: {bus} listens at {at}: whoever reaches this machine may connect and command the torques; listen:{} is for this machine alone",
        at.port()
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use cable_robot_fieldbus::Files;

    use super::*;

    /// A port number alone was no address, so that people wrote 0.0.0.0.
    #[test]
    fn a_port_alone_is_one_of_this_machine() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml");
        let config = Files::read(path.as_ref()).unwrap().config;
        let (_port, told) = Port::open(&config.buses[0], "listen:0").unwrap();
        assert!(told.starts_with("slcan:tcp://127.0.0.1:"), "{told}");
    }
}
