//! `cable-robot man`: the pages that `man` shows.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, CommandFactory, ValueHint};

use crate::command::{Arguments, Outcome, print};

pub const EXAMPLE: &str = "\
Example: cable-robot man ~/.local/share/man/man1
Of the other programs: can-bridge --man > ~/.local/share/man/man1/can-bridge.1, and the same of rig-sim.";

#[derive(Args)]
pub struct Man {
    /// Folder to write them into, made where it is missing
    #[arg(value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    folder: PathBuf,
}

impl Man {
    pub fn run(&self) -> Result<Outcome> {
        let place = || format!("cannot write into {}", self.folder.display());
        fs::create_dir_all(&self.folder).with_context(place)?;
        clap_mangen::generate_to(Arguments::command(), &self.folder).with_context(place)?;
        print(&self.folder.join("cable-robot.1").display().to_string())?;
        Ok(Outcome::Done)
    }
}
