//! `cable-robot report`: one HTML file of a run, or of two side by side.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cable_robot_report::files::{probe, write_whole};
use cable_robot_report::run_folder::{COMPARISON_HTML, REPORT_HTML, RUN_CSV};
use cable_robot_report::{Digest, compare, html};
use clap::{Args, ValueHint};
use serde_json::json;

use crate::command::progress::WatchedFile;
use crate::command::{Outcome, opener, print, print_json};

pub const EXAMPLE: &str = "\
Examples: cable-robot simulate paper --output run && cable-robot report run --open
          cable-robot simulate paper --planner exact --output exact && cable-robot report run exact";

#[derive(Args)]
pub struct Report {
    /// Run folder, with run.csv and run.json, as `simulate` writes it
    #[arg(value_name = "RUN", value_hint = ValueHint::DirPath)]
    run: PathBuf,
    /// A second run folder, of the same rig: one page compares both
    #[arg(value_name = "OTHER", value_hint = ValueHint::DirPath)]
    other: Option<PathBuf>,
    /// The file to be written; without it report.html, of two runs comparison.html, in the (first) run folder
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Shows it in the browser
    #[arg(long)]
    open: bool,
    /// Prints where the report lies, and of what, for machines
    #[arg(long)]
    json: bool,
}

impl Report {
    pub fn run(&self) -> Result<Outcome> {
        let name = if self.other.is_some() { COMPARISON_HTML } else { REPORT_HTML };
        let path = self.output.clone().unwrap_or_else(|| self.run.join(name));
        // Without a run there is no folder to write into either; that the run is missing says more.
        if self.output.is_some() || self.run.is_dir() {
            probe(&path)?;
        }
        let run = read(&self.run)?;
        let mut said = json!({ "report": path, "title": run.folder.info.title, "rows": run.rows });
        let page = match &self.other {
            None => html(&run).with_context(|| self.run.join(RUN_CSV).display().to_string())?,
            Some(other) => {
                let second = read(other)?;
                said["other"] = json!({ "title": second.folder.info.title, "rows": second.rows });
                let names = || format!("A = {}, B = {}", self.run.display(), other.display());
                compare([&run, &second]).with_context(names)?
            }
        };
        said["bytes"] = page.len().into();
        write_whole(&path, |file| file.write_all(page.as_bytes()))?;
        if self.json {
            print_json(&said)?;
        } else {
            print(&path.display().to_string())?;
        }
        if self.open {
            opener::open(&path)?;
        }
        Ok(Outcome::Done)
    }
}

fn read(folder: &Path) -> Result<Digest> {
    Ok(Digest::read(folder, WatchedFile::new)?)
}
