//! The rows of a simulation, written as they come; in memory are only what they come to and the newest.

use std::io::{Stdout, stdout};
use std::path::PathBuf;

use anyhow::{Context, Error, Result};
use cable_robot::sim::{Moment, Scenario};
use cable_robot_report::run_folder::{GrowingRun, RunInfo};
use cable_robot_report::{Recording, Rows};

use super::summary::Summary;
use crate::command::is_closed_pipe;

/// Where the rows go.
pub enum Sink {
    Nowhere,
    Stdout,
    Folder(PathBuf, Box<RunInfo>),
}

/// What is taken down of a simulation.
pub struct Record<'a> {
    recording: Recording,
    /// What they come to.
    pub summary: Summary<'a>,
    /// Of the recording's columns after `time` those that the models fill.
    filled: Vec<usize>,
    /// Each so many rows one is written; how many have come.
    every: u64,
    rows: u64,
    written: Written,
}

/// The sink, once the first row has come: until then what an earlier run left is untouched.
enum Written {
    Not(Sink),
    Stdout(Rows<Stdout>),
    Folder(GrowingRun),
}

impl<'a> Record<'a> {
    /// Of a scenario, without the columns `lacking`; of `every` rows the first is written.
    pub fn new(scenario: &'a Scenario, info: RunInfo, lacking: &[String], sink: Sink, every: u64) -> Self {
        let recording = Recording::new(scenario.plant.rig.cables.len());
        let all = recording.names();
        let filled = (1..all.len()).filter(|k| !lacking.contains(&all[*k])).map(|k| k - 1).collect();
        let names = all[1..].iter().filter(|name| !lacking.contains(name)).cloned();
        let summary = Summary::new(scenario, info, names);
        Self { summary, recording, filled, every, rows: 0, written: Written::Not(sink) }
    }

    /// Adds a row, and writes it.
    pub fn push(&mut self, moment: &Moment) -> Result<()> {
        let numbers = self.recording.finite(moment)?;
        let row = [moment.time].into_iter().chain(self.filled.iter().map(|k| numbers[*k]));
        let row: Vec<_> = row.collect();
        self.summary.add(&row);
        self.rows += 1;
        if !(self.rows - 1).is_multiple_of(self.every) {
            return Ok(());
        }
        match self.write(&row) {
            // Whoever reads has seen enough; how the run ends is told all the same.
            Err(error) if is_closed_pipe(&error) => self.written = Written::Not(Sink::Nowhere),
            written => written?,
        }
        Ok(())
    }

    fn write(&mut self, row: &[f64]) -> Result<()> {
        if let Written::Not(sink) = &mut self.written {
            let names = self.summary.names();
            self.written = match std::mem::replace(sink, Sink::Nowhere) {
                Sink::Nowhere => return Ok(()),
                Sink::Stdout => {
                    Written::Stdout(Rows::begin(stdout(), names).context("cannot write to stdout")?)
                }
                Sink::Folder(folder, info) => Written::Folder(GrowingRun::begin(&folder, &info, names)?),
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
}
