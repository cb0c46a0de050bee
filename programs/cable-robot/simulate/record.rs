//! The rows of a simulation: in memory for its summary, and written as they come.

use std::io::{Stdout, stdout};
use std::path::PathBuf;

use anyhow::{Context, Error, Result};
use cable_robot::sim::Moment;
use cable_robot_report::run_folder::{GrowingRun, RunInfo};
use cable_robot_report::{Recording, Rows, Table};

use crate::is_closed_pipe;

/// Where the rows go.
pub enum Sink {
    Nowhere,
    Stdout,
    Folder(PathBuf, Box<RunInfo>),
}

/// What is taken down of a simulation.
pub struct Record {
    recording: Recording,
    /// Of the recording's columns after `time` those that the models fill.
    filled: Vec<usize>,
    names: Vec<String>,
    written: Written,
}

/// The sink, once the first row has come: until then what an earlier run left is untouched.
enum Written {
    Not(Sink),
    Stdout(Rows<Stdout>),
    Folder(GrowingRun),
}

impl Record {
    /// Of a rig with so many cables, without the columns `lacking`.
    pub fn new(cables: usize, lacking: &[String], sink: Sink) -> Self {
        let recording = Recording::new(cables);
        let all = recording.names();
        let filled = (1..all.len()).filter(|k| !lacking.contains(&all[*k])).map(|k| k - 1).collect();
        let names = all.iter().filter(|name| !lacking.contains(name)).cloned().collect();
        Self { recording, filled, names, written: Written::Not(sink) }
    }

    /// Adds a row, and writes it.
    pub fn push(&mut self, moment: &Moment) -> Result<()> {
        let numbers = self.recording.push(moment)?;
        let row = [moment.time].into_iter().chain(self.filled.iter().map(|k| numbers[*k]));
        match self.write(&row.collect::<Vec<_>>()) {
            // Whoever reads has seen enough; how the run ends is told all the same.
            Err(error) if is_closed_pipe(&error) => self.written = Written::Not(Sink::Nowhere),
            written => written?,
        }
        Ok(())
    }

    fn write(&mut self, row: &[f64]) -> Result<()> {
        if let Written::Not(sink) = &mut self.written {
            self.written = match std::mem::replace(sink, Sink::Nowhere) {
                Sink::Nowhere => return Ok(()),
                Sink::Stdout => {
                    Written::Stdout(Rows::begin(stdout(), &self.names).context("cannot write to stdout")?)
                }
                Sink::Folder(folder, info) => {
                    Written::Folder(GrowingRun::begin(&folder, &info, &self.names)?)
                }
            };
        }
        match &mut self.written {
            Written::Not(_) => Ok(()),
            Written::Stdout(rows) => {
                let added = rows.add(row).map_err(Error::from).and_then(|()| Ok(rows.flush()?));
                added.context("cannot write to stdout")
            }
            Written::Folder(run) => Ok(run.add(row)?),
        }
    }

    /// What was taken down.
    pub fn into_table(self, lacking: &[String]) -> Table {
        let mut table = self.recording.into_table();
        table.drop_columns(lacking);
        table
    }
}
