//! What can go wrong between this program and an FMU.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;
use std::process::ExitStatus;
use std::time::Duration;

use thiserror::Error;

use super::{Status, Value, VariableType};

/// Every error names the file or the instance it came from, and what would be right.
#[derive(Debug, Error)]
pub enum CosimError {
    /// The file is missing or no zip archive.
    #[error("{} cannot be opened as an FMU: {reason}", .path.display())]
    Archive {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// `modelDescription.xml` is missing or not understood.
    #[error("{fmu}: modelDescription.xml: {problem}")]
    Description {
        /// File name of the FMU.
        fmu: String,
        /// What is wrong, and what is expected.
        problem: String,
    },
    /// The FMU carries no binary for this machine.
    #[error("{fmu} has no binary {wanted}; it has: {present}")]
    Platform {
        /// File name of the FMU.
        fmu: String,
        /// Path in the archive that this machine needs.
        wanted: String,
        /// Folders below `binaries/`, separated by commas.
        present: String,
    },
    /// The dynamic linker refused the binary.
    #[error("{fmu}: the binary cannot be loaded: {reason}")]
    Library {
        /// File name of the FMU.
        fmu: String,
        /// What the dynamic linker says, for instance which other library it misses.
        reason: String,
    },
    /// The FMU's binary lacks a function that the standard demands.
    #[error("{instance}: the FMU's binary has no function {function}")]
    MissingFunction {
        /// Name of the instance.
        instance: String,
        /// Name of the C function.
        function: Cow<'static, str>,
    },
    /// A C function did not succeed.
    #[error("{instance}: {action}: {function} gave {status}{}", quote(.said))]
    Call {
        /// Name of the instance.
        instance: String,
        /// What was tried, with the variable and the value.
        action: String,
        /// Name of the C function.
        function: Cow<'static, str>,
        /// What it returned.
        status: Status,
        /// What the FMU logged about it; empty if nothing.
        said: String,
    },
    /// The FMU gave no instance.
    #[error("{instance}: the FMU could not be instantiated{}", quote(.said))]
    Instantiation {
        /// Name of the instance.
        instance: String,
        /// What the FMU logged about it; empty if nothing.
        said: String,
    },
    /// The process in which the FMU ran is no more.
    #[error("{instance}: {action}: {how}{}", quote(.said))]
    Lost {
        /// Name of the instance.
        instance: String,
        /// What was tried.
        action: String,
        /// What became of the process.
        how: Lost,
        /// What the FMU logged before; empty if nothing.
        said: String,
    },
    /// The FMU asks for the end of the simulation.
    #[error("{instance} asks to end the simulation in the step from {time} s")]
    Terminated {
        /// Name of the instance.
        instance: String,
        /// Start of the step, s.
        time: f64,
    },
    /// The FMU lacks a capability, and says so in its description.
    #[error("{instance}: the FMU does not offer this: {capability} is not true in its modelDescription.xml")]
    NotOffered {
        /// Name of the instance.
        instance: String,
        /// The attribute's name.
        capability: &'static str,
    },
    /// A state was used with another instance than the one it came from.
    #[error("{instance}: the state belongs to another instance; serialise it to carry it over")]
    ForeignState {
        /// Name of the instance.
        instance: String,
    },
    /// No such variable.
    #[error("{instance} has no variable {variable}")]
    UnknownVariable {
        /// Name of the instance.
        instance: String,
        /// The name asked for.
        variable: String,
    },
    /// A variable that is no number and no Boolean, or an array.
    #[error("{instance}.{variable} is {kind}; only scalar numbers, Booleans and enumerations can be used")]
    Unsupported {
        /// Name of the instance.
        instance: String,
        /// Name of the variable.
        variable: String,
        /// Its type in words.
        kind: String,
    },
    /// A value that the variable cannot hold.
    #[error("{instance}.{variable} is of type {kind:?} and cannot be set to {value}")]
    WrongType {
        /// Name of the instance.
        instance: String,
        /// Name of the variable.
        variable: String,
        /// Its type.
        kind: VariableType,
        /// The value given.
        value: Value,
    },
}

/// How the process of an FMU was lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lost {
    /// It could not be started, for this reason.
    NotStarted(String),
    /// It crashed, or the FMU ended it.
    Ended(ExitStatus),
    /// A call took longer than this.
    Silent(Duration),
    /// The caller wanted to stop while a call lasted.
    Stopped,
    /// What came was no answer, or was too long.
    Garbled,
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted(reason) => write!(f, "the FMU's process could not be started: {reason}"),
            Self::Ended(status) if status.code().is_some() => {
                write!(f, "the FMU ended its process by itself ({status})")
            }
            Self::Ended(status) => write!(f, "the FMU's process crashed ({status})"),
            Self::Silent(limit) => {
                write!(f, "the FMU did not return within {} s; its process was killed", limit.as_secs_f64())
            }
            Self::Stopped => {
                write!(f, "the FMU had not returned when it was to stop; its process was killed")
            }
            Self::Garbled => write!(f, "the FMU's process sent no answer but something else"),
        }
    }
}

/// What the FMU said, as the end of a message.
fn quote(said: &str) -> String {
    if said.is_empty() { String::new() } else { format!(": \"{said}\"") }
}
