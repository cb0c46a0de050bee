//! CiA 301, as much of it as a master of drives and load cells needs. Names and numbers are the standard's.

pub mod eds;
pub mod emergency;
pub mod nmt;
pub mod object;
pub mod sdo;

pub use emergency::Emergency;
pub use nmt::{NmtCommand, NmtState};
pub use object::{Direction, Object, Value, Width};
pub use sdo::{SdoRequest, SdoResponse, SdoResult};

use super::frame::Frame;

/// A node's address, 1 to 127.
pub type Node = u8;

/// Identifier of SYNC.
pub const SYNC_ID: u16 = 0x080;
/// Identifier of the first transmit PDO of node 0; a node's is this plus its address. So are the others.
pub const TPDO1: u16 = 0x180;
/// First receive PDO.
pub const RPDO1: u16 = 0x200;

/// SYNC without a counter.
pub fn sync() -> Frame {
    Frame::data(SYNC_ID, [])
}
