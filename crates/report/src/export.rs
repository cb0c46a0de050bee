//! Runs in formats that other viewers open: MCAP (Foxglove, PlotJuggler) and Parquet (tables of numbers).
//!
//! The same run gives the same bytes.

mod foxglove;
mod mcap_file;
mod parquet_file;
mod scene;
mod variables;

pub use mcap_file::mcap;
pub use parquet_file::parquet;

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use ::mcap::McapError;
use ::parquet::errors::ParquetError;
use thiserror::Error;

use super::RunFolderError;
use super::files::{unwritten, write_whole};

/// A run that cannot be written in another format.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The run cannot be read, or the file not be written.
    #[error(transparent)]
    Run(#[from] RunFolderError),
    /// A time that the format does not know.
    #[error("{}: time = {time} s is not allowed: MCAP knows no time before 0", .path.display())]
    Time {
        /// The file of the run.
        path: PathBuf,
        /// s.
        time: f64,
    },
}

/// Why a file is not whole.
enum Failure {
    /// What it is made of.
    Run(ExportError),
    /// The file itself.
    Written(io::Error),
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        Self::Run(error)
    }
}

impl From<RunFolderError> for Failure {
    fn from(error: RunFolderError) -> Self {
        Self::Run(error.into())
    }
}

impl From<McapError> for Failure {
    fn from(error: McapError) -> Self {
        Self::Written(match error {
            McapError::Io(error) => error,
            other => io::Error::other(other),
        })
    }
}

impl From<ParquetError> for Failure {
    fn from(error: ParquetError) -> Self {
        Self::Written(io::Error::other(error))
    }
}

/// Writes a file whole or not at all; what is wrong with the run is told apart from what is wrong with the file.
fn whole<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<T, Failure>,
) -> Result<T, ExportError> {
    let mut outcome = None;
    let written = write_whole(path, |file| match write(file) {
        Err(Failure::Written(reason)) => Err(reason),
        Err(Failure::Run(error)) => {
            outcome = Some(Err(error));
            Err(io::Error::other("the run cannot be read"))
        }
        Ok(value) => {
            outcome = Some(Ok(value));
            Ok(())
        }
    });
    match (written, outcome) {
        (_, Some(Err(error))) => Err(error),
        (Ok(()), Some(Ok(value))) => Ok(value),
        (Err(reason), _) => Err(reason.into()),
        (Ok(()), None) => Err(unwritten(path, io::Error::other("nothing was written")).into()),
    }
}

#[cfg(test)]
mod tests;
