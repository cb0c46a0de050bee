//! The addresses of links.

/// Baud rate of a serial port when the address names none.
const DEFAULT_BAUD: u32 = 115_200;

/// A parsed address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Address<'a> {
    /// A CAN interface of the kernel.
    Interface(&'a str),
    /// An slcan adapter on a serial device, with its baud rate (of no effect on USB adapters and pseudo-terminals).
    Device(&'a str, u32),
    /// An slcan adapter behind `host:port`.
    Tcp(&'a str),
}

impl<'a> Address<'a> {
    /// Reads an address; `None` if it is none.
    pub fn parse(text: &'a str) -> Option<Self> {
        match text.split_once(':') {
            None => interface(text),
            Some(("socketcan", name)) => interface(name),
            Some(("slcan", rest)) if rest.starts_with('/') => device(rest),
            Some(("slcan", rest)) => tcp(rest.strip_prefix("tcp://")?),
            Some(_) => None,
        }
    }
}

/// Interfaces have names of at most 15 bytes, without slashes and spaces.
fn interface(name: &str) -> Option<Address<'_>> {
    let allowed = |byte: u8| byte.is_ascii_graphic() && byte != b'/' && byte != b':';
    (1..=15).contains(&name.len()).then_some(())?;
    name.bytes().all(allowed).then_some(Address::Interface(name))
}

fn device(text: &str) -> Option<Address<'_>> {
    match text.rsplit_once('@') {
        None => Some(Address::Device(text, DEFAULT_BAUD)),
        Some((path, baud)) => Some(Address::Device(path, baud.parse().ok().filter(|baud| *baud > 0)?)),
    }
}

fn tcp(text: &str) -> Option<Address<'_>> {
    let (host, port) = text.rsplit_once(':')?;
    (!host.is_empty() && port.parse::<u16>().is_ok()).then_some(Address::Tcp(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read() {
        let known = [
            ("can0", Address::Interface("can0")),
            ("socketcan:vcan1", Address::Interface("vcan1")),
            ("slcan:/dev/ttyACM0", Address::Device("/dev/ttyACM0", 115_200)),
            ("slcan:/dev/ttyUSB0@3000000", Address::Device("/dev/ttyUSB0", 3_000_000)),
            ("slcan:tcp://127.0.0.1:3333", Address::Tcp("127.0.0.1:3333")),
            ("slcan:tcp://[::1]:3333", Address::Tcp("[::1]:3333")),
        ];
        for (text, address) in known {
            assert_eq!(Address::parse(text), Some(address), "{text}");
        }
    }

    #[test]
    fn what_is_no_address_is_refused() {
        for text in [
            "",
            "socketcan:",
            "an_interface_too_long",
            "/dev/ttyACM0",
            "slcan:",
            "slcan:ttyACM0",
            "slcan:/dev/ttyACM0@fast",
            "slcan:/dev/ttyACM0@0",
            "slcan:tcp://host",
            "slcan:tcp://:3333",
            "slcan:tcp://host:99999",
            "usb:can0",
            "can 0",
        ] {
            assert_eq!(Address::parse(text), None, "{text}");
        }
    }
}
