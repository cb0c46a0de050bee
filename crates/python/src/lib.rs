//! The Python module `cable_robot._native`: the library's answers as dictionaries, which the package `cable_robot` makes arrays and classes of.

mod answers;
mod rig;
mod run;

use std::ffi::OsString;
use std::path::PathBuf;

use cable_robot::robot::{Coordinates, Pose};
use cable_robot_programs::command::{self, Installation};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

/// x, y, z, roll, pitch, yaw: m and rad, or their rates.
type Six = [f64; 6];

fn pose(coordinates: Six) -> Pose {
    Pose(Coordinates::from(coordinates))
}

/// What the user is told, with its causes: `OSError` of a file, else `ValueError`.
fn refused(error: impl Into<anyhow::Error>) -> PyErr {
    let error = error.into();
    let words = format!("{error:#}");
    match error.downcast_ref::<std::io::Error>() {
        Some(_) => PyOSError::new_err(words),
        None => PyValueError::new_err(words),
    }
}

/// Runs the command line `cable-robot`, whose first word is the program's name, and returns its exit code.
#[pyfunction]
fn run_command(py: Python, arguments: Vec<OsString>, interpreter: PathBuf, fmus: PathBuf) -> u8 {
    let start = ["-m", "cable_robot"].map(str::to_owned).to_vec();
    let installation = Installation { program: Some(interpreter), arguments: start, fmus: Some(fmus) };
    py.detach(|| command::run(arguments, installation))
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::answers::{certify, plan};
    #[pymodule_export]
    use super::rig::Rig;
    #[pymodule_export]
    use super::run::{scenario, simulate};
    #[pymodule_export]
    use super::run_command;
}
