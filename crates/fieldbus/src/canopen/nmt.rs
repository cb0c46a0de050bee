//! Network management: commands to nodes, and the heartbeats by which nodes tell their state.

use std::fmt;

use super::Node;
use crate::frame::{Frame, FrameKind};

const NMT_ID: u16 = 0x000;
const HEARTBEAT_ID: u16 = 0x700;

/// What a master tells a node, or all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmtCommand {
    /// To Operational: process data flows.
    Start = 0x01,
    /// To Stopped.
    Stop = 0x02,
    /// To Pre-operational: service data only.
    EnterPreOperational = 0x80,
    /// Start again from power-on values.
    ResetNode = 0x81,
    /// Start the communication again.
    ResetCommunication = 0x82,
}

/// What a node tells in its heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmtState {
    /// It has just started.
    BootUp = 0x00,
    /// No data flow.
    Stopped = 0x04,
    /// Process data flows.
    Operational = 0x05,
    /// Service data only.
    PreOperational = 0x7F,
}

impl fmt::Display for NmtState {
    /// As the standard writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BootUp => "Initialisation",
            Self::Stopped => "Stopped",
            Self::Operational => "Operational",
            Self::PreOperational => "Pre-operational",
        })
    }
}

impl NmtCommand {
    /// To one node, or with `None` to all.
    pub fn frame(self, node: Option<Node>) -> Frame {
        Frame::data(NMT_ID, [self as u8, node.unwrap_or(0)])
    }

    /// What a frame commands, and whom; `None` if it is no such command.
    pub fn parse(frame: &Frame) -> Option<(Self, Option<Node>)> {
        if frame.kind() != FrameKind::Data || frame.id() != NMT_ID || frame.length() != 2 {
            return None;
        }
        let [command, node] = frame.array(0)?;
        let command = match command {
            0x01 => Self::Start,
            0x02 => Self::Stop,
            0x80 => Self::EnterPreOperational,
            0x81 => Self::ResetNode,
            0x82 => Self::ResetCommunication,
            _ => return None,
        };
        Some((command, (node != 0).then_some(node)))
    }
}

impl NmtState {
    /// A heartbeat of `node`.
    pub fn heartbeat(self, node: Node) -> Frame {
        Frame::data(HEARTBEAT_ID + u16::from(node), [self as u8])
    }

    /// The node and its state, if the frame is a heartbeat.
    pub fn parse(frame: &Frame) -> Option<(Node, Self)> {
        let node = node_of(frame, HEARTBEAT_ID)?;
        let [state] = frame.array(0)?;
        // Bit 7 toggles under node guarding.
        let state = match state & 0x7F {
            0x00 => Self::BootUp,
            0x04 => Self::Stopped,
            0x05 => Self::Operational,
            0x7F => Self::PreOperational,
            _ => return None,
        };
        Some((node, state))
    }
}

/// The node a data frame belongs to if it is of the service that starts at `base`.
pub(super) fn node_of(frame: &Frame, base: u16) -> Option<Node> {
    let node = frame.id().checked_sub(base)?;
    (frame.kind() == FrameKind::Data && (1..=127).contains(&node)).then_some(node as Node)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_the_standards() {
        assert_eq!(NmtCommand::Start.frame(Some(5)), Frame::data(0, [0x01, 5]));
        let everyone = NmtCommand::ResetCommunication.frame(None);
        assert_eq!(everyone, Frame::data(0, [0x82, 0]));
        assert_eq!(NmtCommand::parse(&everyone), Some((NmtCommand::ResetCommunication, None)));
        assert_eq!(NmtCommand::parse(&Frame::data(0, [0x03, 0])), None);
        assert_eq!(NmtCommand::parse(&Frame::data(0, [0x01])), None);
    }

    #[test]
    fn heartbeats_tell_node_and_state() {
        assert_eq!(NmtState::parse(&Frame::data(0x701, [0x00])), Some((1, NmtState::BootUp)));
        assert_eq!(NmtState::parse(&Frame::data(0x77F, [0x85])), Some((127, NmtState::Operational)));
        assert_eq!(NmtState::PreOperational.heartbeat(3), Frame::data(0x703, [0x7F]));
        assert_eq!(NmtState::parse(&Frame::data(0x701, [])), None);
        assert_eq!(NmtState::parse(&Frame::data(0x700, [5])), None);
        assert_eq!(NmtState::parse(&Frame::remote(0x701, 1).unwrap()), None);
    }
}
