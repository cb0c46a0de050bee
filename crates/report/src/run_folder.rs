//! The run folder: a recorded run as two files, `run.csv` with every column and `run.json` with what was run.
//!
//! Whoever runs something writes one (`cable-robot simulate`, `cargo demo`), `cable-robot report` reads it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Run;
use super::events::EVENTS_CSV;
use super::files::{Part, begin, probe, unwritten};
use super::table::{Rows, Table, TableError};
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::orbit::Orbit;
use cable_robot::robot::ParameterError;
use cable_robot::robot::parameters::require;
use cable_robot::sim::PlantParameters;
use cable_robot_files::read_text;

/// Number of the format that this program writes and reads.
pub const FORMAT: u32 = 2;
/// The recorded columns, see [`columns`](super::recording::columns).
pub const RUN_CSV: &str = "run.csv";
/// What was run: a [`RunInfo`].
pub const RUN_JSON: &str = "run.json";
/// The report of the run, where `cable-robot report` writes it.
pub const REPORT_HTML: &str = "report.html";
/// What compares it with another run, in the folder of the first.
pub const COMPARISON_HTML: &str = "comparison.html";

/// What was run, and with what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct RunInfo {
    /// Number of the format.
    pub format: u32,
    /// Version of the program that wrote it.
    pub program_version: String,
    /// What people call the run.
    pub title: String,
    /// Name or path of the scenario, if the run had one.
    pub scenario: Option<String>,
    /// What was the controller.
    pub controller: Model,
    /// What was the plant.
    pub plant: Model,
    /// Name of the rig.
    pub rig: String,
    /// The orbit that the controller led the robot along, if the run had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orbit: Option<Orbit>,
    /// Time between two steps of the controller, s.
    pub step: f64,
    /// Robot, gains, planner and limits.
    pub controller_parameters: ControllerParameters,
    /// Robot, start and imperfections.
    pub plant_parameters: PlantParameters,
}

/// Where controller or plant came from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Model {
    /// The library's own.
    Library,
    /// A rig with drives and load cells.
    Rig,
    /// An FMU.
    Fmu {
        /// The file.
        path: PathBuf,
        /// Name in its description.
        name: String,
        /// Version of FMI, `2.0` or `3.0`.
        fmi_version: String,
    },
}

/// A recorded run with all that is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunFolder {
    /// `run.json`.
    pub info: RunInfo,
    /// `run.csv`.
    pub table: Table,
}

/// A run folder that cannot be written or read.
#[derive(Debug, Error)]
pub enum RunFolderError {
    /// The folder or a file in it cannot be written.
    #[error("cannot write {}: {reason}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {reason}; a run folder holds {RUN_CSV} and {RUN_JSON}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// `run.json` is no JSON, or lacks a field; the reason ends with line and column.
    #[error("{}: {reason}", .path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: serde_json::Error,
    },
    /// `run.json` is of another time.
    #[error("{}: format = {found}; this program reads format {FORMAT}", .path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u64,
    },
    /// `run.json` says what makes no sense.
    #[error("{}: {table}: {reason}", .path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The part of it.
        table: &'static str,
        /// The parameter, its value and what is allowed.
        reason: ParameterError,
    },
    /// `run.csv` is not as it should be.
    #[error("{}: {reason}", .path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// Where and why.
        reason: TableError,
    },
}

impl RunFolder {
    /// Writes both files into `folder`, which is made if need be. Each is written whole beside its place; then what is left there of
    /// another run, its report too, is removed, and both are moved to their places: no folder ever holds files of two runs.
    ///
    /// # Errors
    /// [`RunFolderError::Write`]; nothing is left then, and what stood there is untouched.
    pub fn write(&self, folder: &Path) -> Result<(), RunFolderError> {
        make(folder)?;
        let csv = Part::write(&folder.join(RUN_CSV), |file| Ok(self.table.write_csv(file)?))?;
        let json = json(folder, &self.info)?;
        forget(folder)?;
        csv.settle()?;
        json.settle()
    }

    /// Reads both files.
    ///
    /// # Errors
    /// [`RunFolderError`] with the file, the place in it and what was expected.
    pub fn read(folder: &Path) -> Result<Self, RunFolderError> {
        let (info, file) = Self::open(folder)?;
        let csv = |reason| RunFolderError::Csv { path: folder.join(RUN_CSV), reason };
        Ok(Self { info, table: Table::read_csv(file).map_err(csv)? })
    }

    /// What `run.json` says, and `run.csv`, not yet read.
    pub(super) fn open(folder: &Path) -> Result<(RunInfo, File), RunFolderError> {
        let (json, csv) = (folder.join(RUN_JSON), folder.join(RUN_CSV));
        let text = read_text(&json).map_err(|reason| RunFolderError::Read { path: json.clone(), reason })?;
        let info = parse(&text, &json)?;
        let file = cable_robot_files::open(&csv)
            .map_err(|reason| RunFolderError::Read { path: csv.clone(), reason })?;
        Ok((info, file))
    }

    /// What the report needs of it. An FMU from elsewhere may lack outputs: its set point is then the goal, its index and
    /// `atGoal` 0, its margin the smallest tension of the moment, its load cells what the motors pull, its slack what
    /// these say.
    ///
    /// # Errors
    /// [`TableError::Missing`]: a column that is needed is not there.
    pub fn run(&self) -> Result<Run, TableError> {
        let column = |name: String| self.table.column(&name).map(<[f64]>::to_vec);
        let told = |model: &Model, first: &str| *model == Model::Library || self.table.get(first).is_some();
        let by_controller = |first: &str| told(&self.info.controller, first);
        let by_plant = |first: &str| told(&self.info.plant, first);
        let axes = |name: &str| all(["x", "y", "z"], |axis| column(format!("{name}.{axis}")));
        let count = self.info.plant_parameters.rig.cables.len();
        let cables = |name: &str| -> Result<Vec<_>, _> {
            (1..=count).map(|i| column(format!("{name}[{i}]"))).collect()
        };
        let single = |name: &str, instead: f64| {
            if by_controller(name) { column(name.to_owned()) } else { Ok(vec![instead; self.table.rows()]) }
        };
        let measured = by_plant("plant.measuredTension[1]");
        let tension = cables(if measured { "plant.measuredTension" } else { "controller.motorTension" })?;
        let own = by_controller("controller.setPoint.x");
        Ok(Run {
            times: column("time".to_owned())?,
            position: axes("plant.encoderPose")?,
            set_point: axes(if own { "controller.setPoint" } else { "controller.goalPose" })?,
            set_point_index: single("controller.setPointIndex", 0.0)?,
            slack: if by_plant("plant.slack[1]") { cables("plant.slack")? } else { slack(&tension) },
            tension_margin: if by_controller("controller.tensionMargin") {
                column("controller.tensionMargin".to_owned())?
            } else {
                smallest(&tension)
            },
            at_goal: single("controller.atGoal", 0.0)?,
            tension,
        })
    }
}

/// A run folder whose rows are written as they come: however the program ends, those so far are there.
pub struct GrowingRun {
    path: PathBuf,
    rows: Rows<File>,
}

impl GrowingRun {
    /// Writes `run.json` and the names of the columns into `folder`, in place of what is left there of another run.
    ///
    /// # Errors
    /// [`RunFolderError::Write`].
    pub fn begin(folder: &Path, info: &RunInfo, names: &[String]) -> Result<Self, RunFolderError> {
        make(folder)?;
        let path = folder.join(RUN_CSV);
        let json = json(folder, info)?;
        forget(folder)?;
        let file = begin(&path)?;
        let rows = Rows::begin(file, names).map_err(|reason| unwritten(&path, reason.into()))?;
        json.settle()?;
        Ok(Self { path, rows })
    }

    /// Writes a row: in the order of the names, `time` first.
    ///
    /// # Errors
    /// [`RunFolderError::Write`].
    pub fn add(&mut self, row: &[f64]) -> Result<(), RunFolderError> {
        let added = self.rows.add(row).map_err(io::Error::from).and_then(|()| self.rows.flush());
        added.map_err(|reason| unwritten(&self.path, reason))
    }
}

/// `run.json`, beside its place.
fn json(folder: &Path, info: &RunInfo) -> Result<Part, RunFolderError> {
    Part::write(&folder.join(RUN_JSON), |file| {
        serde_json::to_writer_pretty(&mut *file, info)?;
        writeln!(file)
    })
}

/// Makes the folder and sees whether both files can be written there: to be called before the work.
///
/// # Errors
/// [`RunFolderError::Write`].
pub fn make(folder: &Path) -> Result<(), RunFolderError> {
    fs::create_dir_all(folder).map_err(|reason| RunFolderError::Write { path: folder.to_owned(), reason })?;
    [RUN_CSV, RUN_JSON].iter().try_for_each(|name| probe(&folder.join(name)))
}

/// Removes what is left of another run, if the folder held one: `run.json`, without which the rest is no run, its events and its reports.
fn forget(folder: &Path) -> Result<(), RunFolderError> {
    if !folder.join(RUN_JSON).is_file() {
        return Ok(());
    }
    for path in [REPORT_HTML, COMPARISON_HTML, EVENTS_CSV, RUN_JSON].map(|name| folder.join(name)) {
        match fs::remove_file(&path) {
            Err(reason) if reason.kind() != io::ErrorKind::NotFound => {
                return Err(RunFolderError::Write { path, reason });
            }
            _ => {}
        }
    }
    Ok(())
}

/// The info, once its format is known to be ours.
fn parse(text: &str, path: &Path) -> Result<RunInfo, RunFolderError> {
    #[derive(Deserialize)]
    struct Format {
        format: u64,
    }
    let wrong = |reason| RunFolderError::Json { path: path.to_owned(), reason };
    let Format { format } = serde_json::from_str(text).map_err(wrong)?;
    if format != u64::from(FORMAT) {
        return Err(RunFolderError::Format { path: path.to_owned(), found: format });
    }
    let info: RunInfo = serde_json::from_str(text).map_err(wrong)?;
    let step =
        require(info.step.is_finite() && info.step > 0.0, "step", info.step, "must be greater than 0 (s)");
    let checks = [
        ("run", step),
        ("controllerParameters", info.controller_parameters.validate()),
        ("plantParameters", info.plant_parameters.validate()),
    ];
    for (table, check) in checks {
        check.map_err(|reason| RunFolderError::Value { path: path.to_owned(), table, reason })?;
    }
    Ok(info)
}

/// An array of columns, or the first error.
fn all<K, const N: usize>(
    keys: [K; N],
    column: impl Fn(K) -> Result<Vec<f64>, TableError>,
) -> Result<[Vec<f64>; N], TableError> {
    let mut columns = std::array::from_fn(|_| Vec::new());
    for (place, key) in columns.iter_mut().zip(keys) {
        *place = column(key)?;
    }
    Ok(columns)
}

/// 1 where a tension is not positive.
fn slack(tension: &[Vec<f64>]) -> Vec<Vec<f64>> {
    tension.iter().map(|cable| cable.iter().map(|u| f64::from(u8::from(*u <= 0.0))).collect()).collect()
}

/// The smallest of each row.
fn smallest(tension: &[Vec<f64>]) -> Vec<f64> {
    let of_row = |row: usize| tension.iter().map(|column| column[row]).fold(f64::INFINITY, f64::min);
    (0..tension[0].len()).map(of_row).collect()
}

#[cfg(test)]
mod tests;
