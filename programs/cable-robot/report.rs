//! `cable-robot report`: one HTML file of a run.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cable_robot_report::files::{probe, write_whole};
use cable_robot_report::run_folder::{REPORT_HTML, RUN_CSV};
use cable_robot_report::{RunFolder, html};
use clap::{Args, ValueHint};
use serde_json::json;

use crate::progress::WatchedFile;
use crate::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot simulate paper --output run && cable-robot report run";

#[derive(Args)]
pub struct Report {
    /// Run folder, with run.csv and run.json, as `simulate` writes it
    #[arg(value_name = "RUN", value_hint = ValueHint::DirPath)]
    run: PathBuf,
    /// The file to be written; without it report.html in the run folder
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Prints where the report lies, and of what, for machines
    #[arg(long)]
    json: bool,
}

impl Report {
    pub fn run(&self) -> Result<Outcome> {
        let path = self.output.clone().unwrap_or_else(|| self.run.join(REPORT_HTML));
        // Without a run there is no folder to write into either; that the run is missing says more.
        if self.output.is_some() || self.run.is_dir() {
            probe(&path)?;
        }
        let folder = RunFolder::read_through(&self.run, WatchedFile::new)?;
        let page = html(&folder).with_context(|| self.run.join(RUN_CSV).display().to_string())?;
        write_whole(&path, |file| file.write_all(page.as_bytes()))?;
        if self.json {
            let (title, rows) = (&folder.info.title, folder.table.rows());
            print_json(&json!({ "report": path, "title": title, "rows": rows, "bytes": page.len() }))?;
        } else {
            print(&path.display().to_string())?;
        }
        Ok(Outcome::Done)
    }
}
