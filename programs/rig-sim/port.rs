//! Where the simulated rig meets the bridge: a pseudo-terminal or a TCP port that it offers, or a CAN address that it opens.

use std::net::TcpListener;

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
    /// Opens `address` for a bus: `pty`, `listen:HOST:PORT` or a CAN address. Says what the bridge has to be told.
    pub fn open(bus: &Bus, address: &str) -> Result<(Self, String)> {
        let port = |link, listener| Self { link, listener, dropped: 0 };
        if address == "pty" {
            let (link, device) = pseudo_terminal().context("cannot make a pseudo-terminal")?;
            return Ok((port(Some(Box::new(link)), None), format!("slcan:{}", device.display())));
        }
        if let Some(at) = address.strip_prefix("listen:") {
            let listener = TcpListener::bind(at).with_context(|| format!("cannot listen at {at}"))?;
            listener.set_nonblocking(true)?;
            let at = listener.local_addr()?;
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
