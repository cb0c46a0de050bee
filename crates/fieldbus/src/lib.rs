//! Section VII, the rig: drives and load cells on a CAN bus, and what happens when things fail.
//!
//! Codecs and state machines only, but for [`files`] and [`transport`]: no sockets, no files, no clock. Time comes in as an argument.
//!
//! | | |
//! |---|---|
//! | [`frame`], [`candump`], [`slcan`] | CAN frames, and as text |
//! | [`canopen`], [`cia402`] | what frames mean: CiA 301, and drives |
//! | [`load_cell`] | how makers write a force |
//! | [`config`] | the fieldbus file |
//! | [`commission`] | whether the rig is what its files say |
//! | [`files`] | it and the rig file that it names, on disk |
//! | [`bus_load`] | what fits on a bus |
//! | [`export`] | the bus as a DBC file, for bench tools |
//! | [`LibraryController`] | the library's controller in the place of the packed one |
//! | [`bridge`] | the state machine between all of these |
//! | [`simulated`] | a lab without hardware |
//! | [`ls_bus`] | bridge and lab as nodes of a bus simulated with FMI |

pub mod bridge;
pub mod bus_load;
pub mod candump;
pub mod canopen;
pub mod cia402;
pub mod commission;
pub mod config;
mod controller;
pub mod export;
pub mod files;
pub mod frame;
pub mod load_cell;
pub mod ls_bus;
pub mod simulated;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod transport;

pub use bridge::{Bridge, FrameQueue, OperatorCommand, State};
pub use config::Config;
pub use controller::LibraryController;
pub use files::Files;
pub use frame::Frame;

/// Time since the program's start, ns. Nothing in this room looks at a clock.
pub type Nanoseconds = u64;
