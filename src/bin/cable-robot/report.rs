//! `cable-robot report`: one HTML file of a run.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cable_robot::report::run_folder::{RUN_CSV, write_whole};
use cable_robot::report::{RunFolder, html};
use clap::Args;

use crate::{Outcome, print};

pub const EXAMPLE: &str = "\
Example: cable-robot simulate paper --output run && cable-robot report run";

#[derive(Args)]
pub struct Report {
    /// Run folder, with run.csv and run.json, as `simulate` writes it
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// The file to be written; without it report.html in the run folder
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Report {
    pub fn run(&self) -> Result<Outcome> {
        let folder = RunFolder::read(&self.run)?;
        let page = html(&folder).with_context(|| self.run.join(RUN_CSV).display().to_string())?;
        let path = self.output.clone().unwrap_or_else(|| self.run.join("report.html"));
        write_whole(&path, |file| file.write_all(page.as_bytes()))?;
        print(&path.display().to_string())?;
        Ok(Outcome::Done)
    }
}
