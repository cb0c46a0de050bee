//! `cable-robot export`: a run in the formats of other viewers.

use std::path::PathBuf;

use anyhow::Result;
use cable_robot_report::export::{mcap, parquet};
use cable_robot_report::files::probe;
use clap::{ArgGroup, Args, ValueHint};
use serde_json::json;

use crate::command::progress::WatchedFile;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot simulate paper --output run && cable-robot export run --mcap run.mcap --parquet run.parquet";

#[derive(Args)]
#[command(group = ArgGroup::new("format").required(true).multiple(true))]
pub struct Export {
    /// Run folder, with run.csv and run.json, as `simulate` and `can-bridge --record` write it
    #[arg(value_name = "RUN", value_hint = ValueHint::DirPath)]
    run: PathBuf,
    /// Messages for Foxglove and PlotJuggler: the robot in three dimensions, every column, events of a rig
    #[arg(long, value_name = "FILE", group = "format", value_hint = ValueHint::FilePath)]
    mcap: Option<PathBuf>,
    /// The columns as a table for pandas, Polars, DuckDB and others
    #[arg(long, value_name = "FILE", group = "format", value_hint = ValueHint::FilePath)]
    parquet: Option<PathBuf>,
    /// Prints where the files lie, and how many rows the run has, for machines
    #[arg(long)]
    json: bool,
}

impl Export {
    pub fn run(&self) -> Result<Outcome> {
        let files = [&self.mcap, &self.parquet].into_iter().flatten();
        files.clone().try_for_each(|file| probe(file))?;
        let mut rows = 0;
        if let Some(file) = &self.mcap {
            rows = mcap(&self.run, file, WatchedFile::new)?;
        }
        if let Some(file) = &self.parquet {
            rows = parquet(&self.run, file, WatchedFile::new)?;
        }
        if self.json {
            print_json(&json!({ "mcap": self.mcap, "parquet": self.parquet, "rows": rows }))?;
        } else {
            files.map(|file| file.display().to_string()).try_for_each(|file| print(&file))?;
        }
        Ok(Outcome::Done)
    }
}
