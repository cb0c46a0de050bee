//! What goes between this process and that of an FMU: frames of a length (four bytes, little endian) and as many bytes of postcard. Numbers
//! go as their bits.

use std::ffi::OsString;
use std::io::{self, Read};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::limits::LONGEST_FRAME;
use super::slave::Failure;
use super::{FmiVersion, Status, Value, VariableType};

/// Bytes of a frame's length.
pub(super) const HEAD: usize = 4;

/// What a new process is to load and to instantiate. It is answered as a request is.
#[derive(Serialize, Deserialize)]
pub(super) struct Start {
    pub version: FmiVersion,
    pub library: OsString,
    pub name: String,
    pub token: String,
    /// The folder.
    pub resources: OsString,
}

/// A call of [`Slave`](super::slave::Slave). A state goes by its address in the FMU's process.
#[derive(Serialize, Deserialize)]
pub(super) enum Request {
    Get(Vec<(VariableType, u32)>),
    Set(Vec<(VariableType, u32, Value)>),
    SetLogging(bool),
    EnterInitialization(f64, Option<f64>),
    ExitInitialization,
    DoStep(f64, f64),
    Terminate,
    GetState,
    SetState(u64),
    FreeState(u64),
    Serialize(u64),
    Deserialize(Vec<u8>),
    /// Frees the instance and unloads the library; the last.
    Free,
}

/// What comes back: any number of messages of the FMU, then the answer.
#[derive(Serialize, Deserialize)]
pub(super) enum Message {
    Log(Status, String, String),
    Answer(Result<Reply, Refusal>),
}

#[derive(Serialize, Deserialize)]
pub(super) enum Reply {
    Done,
    Values(Vec<Value>),
    State(u64),
    Bytes(Vec<u8>),
}

/// A failure, and which of the variables asked for it concerns.
#[derive(Serialize, Deserialize)]
pub(super) struct Refusal {
    pub index: u64,
    pub failure: Failure,
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        Self { index: 0, failure }
    }
}

/// The frame of a value, in place of what `bytes` held.
pub(super) fn frame<T: Serialize>(value: &T, bytes: &mut Vec<u8>) -> io::Result<()> {
    bytes.clear();
    bytes.extend([0; HEAD]);
    postcard::to_io(value, &mut *bytes).map_err(io::Error::other)?;
    let length = bytes.len() - HEAD;
    if length > LONGEST_FRAME {
        return Err(io::Error::other(format!(
            "a message of {length} bytes; at most {LONGEST_FRAME} are sent"
        )));
    }
    bytes[..HEAD].copy_from_slice(&(length as u32).to_le_bytes());
    Ok(())
}

/// The length that a frame's first bytes give, if so much is taken.
pub(super) fn length(head: [u8; HEAD]) -> Option<usize> {
    Some(u32::from_le_bytes(head) as usize).filter(|length| *length <= LONGEST_FRAME)
}

/// Waits for the next frame; `None` at the end of the stream.
pub(super) fn receive<T: DeserializeOwned>(stream: &mut impl Read) -> io::Result<Option<T>> {
    let mut head = [0; HEAD];
    match stream.read_exact(&mut head) {
        Err(end) if end.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let mut bytes = vec![0; length(head).ok_or_else(|| io::Error::other("no request"))?];
    stream.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).map(Some).map_err(io::Error::other)
}
