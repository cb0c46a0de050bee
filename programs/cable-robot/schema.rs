//! `cable-robot schema`: what a file may say, as JSON Schema.

use anyhow::Result;
use cable_robot::robot::rig_file;
use cable_robot::sim::scenario_file;
use clap::{Args, ValueEnum};

use crate::command::{Outcome, print_json, proof};

pub const EXAMPLE: &str = "\
Example: cable-robot schema rig
An editor with Taplo (\"Even Better TOML\") checks a file whose first line is `#:schema rig.schema.json`.";

#[derive(Args)]
pub struct Schema {
    /// Which file
    of: Kind,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// What `--rig` takes
    Rig,
    /// What `simulate` takes
    Scenario,
    /// What `certify --proof` writes
    Proof,
}

impl Schema {
    pub fn run(&self) -> Result<Outcome> {
        print_json(&match self.of {
            Kind::Rig => rig_file::schema().to_value(),
            Kind::Scenario => scenario_file::schema().to_value(),
            Kind::Proof => proof::schema().to_value(),
        })?;
        Ok(Outcome::Done)
    }
}
