//! A fieldbus file on disk, and the rig file that it names.

use std::io;
use std::path::{Path, PathBuf};

use cable_robot::robot::{RigFile, RigFileError};
use cable_robot_files::read_text;
use thiserror::Error;

use crate::config::{Config, ConfigError, rig_path};

/// Both files, and what they mean together.
#[derive(Clone, Debug)]
pub struct Files {
    /// What they mean.
    pub config: Config,
    /// Text of the fieldbus file.
    pub fieldbus: String,
    /// Text of the rig file.
    pub rig: String,
}

/// A file that cannot be read, or is refused.
#[derive(Debug, Error)]
pub enum FilesError {
    /// It cannot be read.
    #[error("cannot read {}", .path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The fieldbus file is refused.
    #[error("{}", .path.display())]
    Fieldbus {
        /// Which.
        path: PathBuf,
        /// Why.
        source: ConfigError,
    },
    /// The rig file is refused.
    #[error("{}", .path.display())]
    Rig {
        /// Which.
        path: PathBuf,
        /// Why.
        source: RigFileError,
    },
}

impl Files {
    /// Reads a fieldbus file and the rig file that it names.
    ///
    /// # Errors
    /// [`FilesError`] with the file and the reason.
    pub fn read(path: &Path) -> Result<Self, FilesError> {
        let fieldbus = text(path)?;
        let named = rig_path(&fieldbus).map_err(|source| refused(path, source))?;
        let rig = path.parent().unwrap_or(Path::new("")).join(named);
        Self::of(path, fieldbus, &rig)
    }

    /// Reads a fieldbus file with this rig file in the place of the one that it names.
    ///
    /// # Errors
    /// As [`Files::read`].
    pub fn read_with_rig(path: &Path, rig: &Path) -> Result<Self, FilesError> {
        Self::of(path, text(path)?, rig)
    }

    fn of(path: &Path, fieldbus: String, rig_path: &Path) -> Result<Self, FilesError> {
        let rig = text(rig_path)?;
        let refused_rig = |source| FilesError::Rig { path: rig_path.to_owned(), source };
        let parsed = RigFile::parse(&rig).map_err(refused_rig)?;
        let config = Config::parse(&fieldbus, &parsed).map_err(|source| refused(path, source))?;
        Ok(Self { config, fieldbus, rig })
    }
}

fn text(path: &Path) -> Result<String, FilesError> {
    read_text(path).map_err(|source| FilesError::Read { path: path.to_owned(), source })
}

fn refused(path: &Path, source: ConfigError) -> FilesError {
    FilesError::Fieldbus { path: path.to_owned(), source }
}
