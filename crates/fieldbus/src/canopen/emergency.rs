//! Emergency messages: a node tells of an error the moment it happens.

use std::fmt;

use super::nmt::node_of;
use super::{Node, SYNC_ID};
use crate::frame::Frame;

/// An emergency message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Who tells.
    pub node: Node,
    /// Error code of CiA 301 or 402; 0 means that the error is gone.
    pub code: u16,
    /// Object 0x1001.
    pub register: u8,
    /// What the maker adds.
    pub maker: [u8; 5],
}

impl Emergency {
    /// As a frame.
    pub fn frame(&self) -> Frame {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e] = self.maker;
        Frame::data(SYNC_ID + u16::from(self.node), [low, high, self.register, a, b, c, d, e])
    }

    /// `None` if the frame is something else.
    pub fn parse(frame: &Frame) -> Option<Self> {
        let node = node_of(frame, SYNC_ID)?;
        let [low, high, register, maker @ ..] = frame.array::<8>(0)?;
        Some(Self { node, code: u16::from_le_bytes([low, high]), register, maker })
    }
}

impl fmt::Display for Emergency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {} reports 0x{:04X} ({}), ", self.node, self.code, text(self.code))?;
        write!(f, "error register 0x{:02X}, maker's bytes {:02X?}", self.register, self.maker)
    }
}

/// The most specific entry that covers a code: all its digits, then its class (xx), then its group.
pub fn text(code: u16) -> &'static str {
    let entry = |code: u16| TEXTS.iter().find(|(known, _)| *known == code).map(|(_, text)| *text);
    let classes = [code, code & 0xFFF0, code & 0xFF00, code & 0xF000];
    classes.into_iter().find_map(entry).unwrap_or("unknown error")
}

/// Of CiA 301 and CiA 402, the codes that drives and transducers send.
const TEXTS: &[(u16, &str)] = &[
    (0x0000, "error gone"),
    (0x1000, "generic error"),
    (0x2000, "current"),
    (0x2100, "current, input side"),
    (0x2200, "current inside the device"),
    (0x2300, "current, output side"),
    (0x2310, "continuous over-current"),
    (0x2320, "short circuit or earth leakage"),
    (0x2350, "load level, I²t"),
    (0x3000, "voltage"),
    (0x3100, "mains voltage"),
    (0x3130, "phase failure"),
    (0x3200, "voltage inside the device"),
    (0x3210, "DC link over-voltage"),
    (0x3220, "DC link under-voltage"),
    (0x3300, "output voltage"),
    (0x4000, "temperature"),
    (0x4100, "ambient temperature"),
    (0x4200, "device temperature"),
    (0x4210, "device too hot"),
    (0x4310, "drive or motor too hot"),
    (0x5000, "device hardware"),
    (0x5400, "power section"),
    (0x5440, "contactor"),
    (0x5500, "data memory"),
    (0x6000, "device software"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data set"),
    (0x7000, "additional modules"),
    (0x7100, "power module"),
    (0x7110, "brake chopper"),
    (0x7120, "motor"),
    (0x7121, "motor blocked"),
    (0x7300, "sensor"),
    (0x7305, "incremental encoder 1"),
    (0x7310, "speed sensor"),
    (0x7320, "position sensor"),
    (0x7500, "communication module"),
    (0x8000, "monitoring"),
    (0x8100, "communication"),
    (0x8110, "CAN overrun, messages lost"),
    (0x8120, "CAN in error passive mode"),
    (0x8130, "life guard or heartbeat error"),
    (0x8140, "recovered from bus off"),
    (0x8150, "two nodes with one identifier"),
    (0x8200, "protocol error"),
    (0x8210, "PDO too short, not processed"),
    (0x8220, "PDO too long"),
    (0x8240, "SYNC of an unexpected length"),
    (0x8250, "RPDO time-out"),
    (0x8300, "torque control"),
    (0x8311, "excess torque"),
    (0x8400, "velocity control"),
    (0x8500, "position control"),
    (0x8600, "positioning controller"),
    (0x8611, "following error"),
    (0x9000, "external error"),
    (0xF000, "additional functions"),
    (0xFF00, "specific to the device"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_back_as_they_were_written() {
        let emergency = Emergency { node: 3, code: 0x8130, register: 0x11, maker: [0x29, 0xF1, 0, 0, 0] };
        assert_eq!(emergency.frame(), Frame::data(0x083, [0x30, 0x81, 0x11, 0x29, 0xF1, 0, 0, 0]));
        assert_eq!(Emergency::parse(&emergency.frame()), Some(emergency));
        assert!(emergency.to_string().contains("node 3 reports 0x8130 (life guard or heartbeat error)"));
        assert_eq!(Emergency::parse(&super::super::sync()), None);
        assert_eq!(Emergency::parse(&Frame::data(0x083, [0x30, 0x81])), None);
    }

    #[test]
    fn an_unlisted_code_has_the_text_of_its_class() {
        assert_eq!(text(0x2311), "continuous over-current");
        assert_eq!(text(0x8131), "life guard or heartbeat error");
        assert_eq!(text(0x3299), "voltage inside the device");
        assert_eq!(text(0xFF12), "specific to the device");
        assert_eq!(text(0xA000), "unknown error");
    }
}
