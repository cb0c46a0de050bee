//! The run folder: a recorded run as two files, `run.csv` with every column and `run.json` with what was run.
//!
//! Whoever runs something writes one (`cable-robot simulate`, `cargo demo`), `cable-robot report` reads it.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Run;
use super::files::{Part, probe, read_text};
use super::table::{Table, TableError};
use crate::plan::ControllerParameters;
use crate::robot::parameters::require;
use crate::robot::{CABLES, ParameterError};
use crate::sim::PlantParameters;

/// Number of the format that this program writes and reads.
pub const FORMAT: u32 = 1;
/// The recorded columns, see [`columns`](super::recording::columns).
pub const RUN_CSV: &str = "run.csv";
/// What was run: a [`RunInfo`].
pub const RUN_JSON: &str = "run.json";
/// The report of the run, where `cable-robot report` writes it.
pub const REPORT_HTML: &str = "report.html";

/// What was run, and with what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct RunInfo {
    /// [`FORMAT`] when it was written.
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
    /// Time between two steps of the controller, s.
    pub step: f64,
    /// Robot, gains, planner and limits.
    pub controller_parameters: ControllerParameters,
    /// Robot, start and imperfections.
    pub plant_parameters: PlantParameters,
}

/// Where controller or plant came from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
    /// [`RunFolderError::Write`].
    pub fn write(&self, folder: &Path) -> Result<(), RunFolderError> {
        self.write_watched(folder, || Ok(()))
    }

    /// As [`write`](Self::write); `row_done` is called after each row and may give the whole up.
    ///
    /// # Errors
    /// [`RunFolderError::Write`]; nothing is left then, and what stood there is untouched.
    pub fn write_watched(
        &self,
        folder: &Path,
        row_done: impl FnMut() -> io::Result<()>,
    ) -> Result<(), RunFolderError> {
        make(folder)?;
        let csv =
            Part::write(&folder.join(RUN_CSV), |file| Ok(self.table.write_csv_watched(file, row_done)?))?;
        let json = Part::write(&folder.join(RUN_JSON), |file| {
            serde_json::to_writer_pretty(&mut *file, &self.info)?;
            writeln!(file)
        })?;
        forget(folder)?;
        csv.settle()?;
        json.settle()
    }

    /// Reads both files.
    ///
    /// # Errors
    /// [`RunFolderError`] with the file, the place in it and what was expected.
    pub fn read(folder: &Path) -> Result<Self, RunFolderError> {
        Self::read_through(folder, |file| file)
    }

    /// As [`read`](Self::read), `run.csv` through a reader of its own.
    ///
    /// # Errors
    /// As of [`read`](Self::read).
    pub fn read_through<R: Read>(
        folder: &Path,
        reader: impl FnOnce(File) -> R,
    ) -> Result<Self, RunFolderError> {
        let (json, csv) = (folder.join(RUN_JSON), folder.join(RUN_CSV));
        let text = read_text(&json).map_err(|reason| RunFolderError::Read { path: json.clone(), reason })?;
        let info = parse(&text, &json)?;
        let file = File::open(&csv).map_err(|reason| RunFolderError::Read { path: csv.clone(), reason })?;
        let table =
            Table::read_csv(reader(file)).map_err(|reason| RunFolderError::Csv { path: csv, reason })?;
        Ok(Self { info, table })
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
        let cables = |name: &str| all([1, 2, 3, 4, 5, 6], |i| column(format!("{name}[{i}]")));
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

/// Makes the folder and sees whether both files can be written there: to be called before the work.
///
/// # Errors
/// [`RunFolderError::Write`].
pub fn make(folder: &Path) -> Result<(), RunFolderError> {
    fs::create_dir_all(folder).map_err(|reason| RunFolderError::Write { path: folder.to_owned(), reason })?;
    [RUN_CSV, RUN_JSON].iter().try_for_each(|name| probe(&folder.join(name)))
}

/// Removes what is left of another run, if the folder held one: `run.json`, without which the rest is no run, and its report.
fn forget(folder: &Path) -> Result<(), RunFolderError> {
    if !folder.join(RUN_JSON).is_file() {
        return Ok(());
    }
    for path in [REPORT_HTML, RUN_JSON].map(|name| folder.join(name)) {
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
fn slack(tension: &[Vec<f64>; CABLES]) -> [Vec<f64>; CABLES] {
    std::array::from_fn(|i| tension[i].iter().map(|u| f64::from(u8::from(*u <= 0.0))).collect())
}

/// The smallest of each row.
fn smallest(tension: &[Vec<f64>; CABLES]) -> Vec<f64> {
    let of_row = |row: usize| tension.iter().map(|column| column[row]).fold(f64::INFINITY, f64::min);
    (0..tension[0].len()).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::recording::columns;

    fn run_folder(controller: Model) -> RunFolder {
        let mut table = Table::new(columns());
        for k in 0..3 {
            let values: Vec<_> =
                (1..table.names().len()).map(|column| f64::from(k) + column as f64).collect();
            table.push(0.1 * f64::from(k), &values);
        }
        let info = RunInfo {
            format: FORMAT,
            program_version: "0.1.0".to_owned(),
            title: "A run".to_owned(),
            scenario: None,
            controller,
            plant: Model::Library,
            rig: "Table I".to_owned(),
            step: 0.1,
            controller_parameters: ControllerParameters::default(),
            plant_parameters: PlantParameters::default(),
        };
        RunFolder { info, table }
    }

    /// What is said of a folder with one text of one file replaced.
    fn refusal(file: &str, from: &str, to: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        run_folder(Model::Library).write(folder.path()).unwrap();
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{from} is not in {text}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let refused = RunFolder::read(folder.path()).map_err(|e| e.to_string());
        let refused = refused.and_then(|read| {
            read.run().map_err(|reason| RunFolderError::Csv { path: path.clone(), reason }.to_string())
        });
        let error = refused.expect_err(to);
        assert!(error.contains(path.to_str().unwrap()), "{error}");
        error
    }

    #[test]
    fn what_is_written_is_read_back_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/run");
        let fmu = Model::Fmu { path: "a.fmu".into(), name: "A".to_owned(), fmi_version: "3.0".to_owned() };
        let written = run_folder(fmu);
        written.write(&path).unwrap();
        written.write(&path).unwrap();
        assert_eq!(RunFolder::read(&path).unwrap(), written);
        let mut files: Vec<_> = fs::read_dir(&path).unwrap().map(|file| file.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, [RUN_CSV, RUN_JSON]);
        let run = written.run().unwrap();
        assert_eq!(run.position[1], written.table.column("plant.encoderPose.y").unwrap());
        assert_eq!(run.slack[5], written.table.column("plant.slack[6]").unwrap());
    }

    #[test]
    fn a_new_run_leaves_neither_the_report_nor_the_json_of_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let report = folder.path().join(REPORT_HTML);
        fs::write(&report, "of somebody else").unwrap();
        run_folder(Model::Library).write(folder.path()).unwrap();
        assert!(report.is_file(), "no run was there before");
        run_folder(Model::Rig).write(folder.path()).unwrap();
        assert!(!report.exists());

        fs::write(&report, "of the old run").unwrap();
        let given_up = || Err(io::Error::other("given up"));
        assert!(run_folder(Model::Library).write_watched(folder.path(), given_up).is_err());
        assert_eq!(RunFolder::read(folder.path()).unwrap().info.controller, Model::Rig);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left of what was given up");
    }

    #[test]
    fn a_folder_where_a_file_must_go_is_said_before_the_work() {
        for name in [RUN_CSV, RUN_JSON] {
            let folder = tempfile::tempdir().unwrap();
            fs::create_dir(folder.path().join(name)).unwrap();
            let error = make(folder.path()).unwrap_err().to_string();
            assert!(error.contains(name) && error.ends_with("it is a folder, a file is wanted"), "{error}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = make(&file.path().join("run")).unwrap_err().to_string();
        assert!(error.starts_with(&format!("cannot write {}", file.path().display())), "{error}");
    }

    #[test]
    fn broken_files_are_named_with_line_and_what_was_expected() {
        let json = refusal(RUN_JSON, "\"title\": \"A run\",", "\"title\": ,");
        assert!(json.contains("expected value at line 4 column 12"), "{json}");
        let json = refusal(RUN_JSON, "\"step\": 0.1,", "");
        assert!(json.contains("missing field `step` at line"), "{json}");
        let json = refusal(RUN_JSON, "\"step\": 0.1", "\"step\": \"short\"");
        assert!(json.contains("expected f64 at line"), "{json}");
        let format = refusal(RUN_JSON, "\"format\": 1", "\"format\": 2");
        assert!(format.ends_with("format = 2; this program reads format 1"), "{format}");
        let gain = refusal(RUN_JSON, "\"lambda\": 3.0", "\"lambda\": -3.0");
        assert!(
            gain.contains("controllerParameters: parameter lambda = -3 is not allowed: must be"),
            "{gain}"
        );
        let step = refusal(RUN_JSON, "\"step\": 0.1", "\"step\": 0.0");
        assert!(step.contains("run.json: run: parameter step = 0 is not allowed"), "{step}");
        let csv = refusal(RUN_CSV, "\n0.1,", "\nsoon,");
        assert!(csv.ends_with("line 3, column 1 (time): \"soon\" is not a finite number"), "{csv}");
        let csv = refusal(RUN_CSV, "controller.setPoint.y", "setPoint.y");
        assert!(csv.ends_with("line 1: there is no column \"controller.setPoint.y\""), "{csv}");
        let missing = RunFolder::read(Path::new("no/such")).unwrap_err().to_string();
        assert!(missing.starts_with("cannot read no/such/run.json: "), "{missing}");
    }

    #[test]
    fn an_fmu_from_elsewhere_may_tell_less() {
        let fmu = Model::Fmu { path: "a.fmu".into(), name: "A".to_owned(), fmi_version: "3.0".to_owned() };
        let RunFolder { info, table } = run_folder(fmu);
        let of_ours = |name: &&String| {
            !name.starts_with("controller.") || name.contains("motor") || name.contains("goalPose")
        };
        let kept: Vec<String> = table.names()[1..].iter().filter(of_ours).cloned().collect();
        let mut less = Table::new(kept.clone());
        for row in 0..table.rows() {
            let values: Vec<_> = kept.iter().map(|name| table.column(name).unwrap()[row]).collect();
            less.push(table.column("time").unwrap()[row], &values);
        }
        let run = RunFolder { info: info.clone(), table: less.clone() }.run().unwrap();
        assert_eq!(run.set_point[2], table.column("controller.goalPose.z").unwrap());
        assert_eq!(run.tension_margin, table.column("plant.measuredTension[1]").unwrap());
        assert_eq!((run.at_goal, run.set_point_index), (vec![0.0; 3], vec![0.0; 3]));
        let ours = RunFolder { info: RunInfo { controller: Model::Library, ..info }, table: less };
        assert!(ours.run().is_err(), "ours tells everything");
    }
}
