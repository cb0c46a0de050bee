//! `cable-robot schema`: what a file may say and what commands print with `--json`, as JSON Schema.

use anyhow::Result;
use cable_robot::robot::rig_file;
use cable_robot::sim::scenario_file;
use cable_robot_report::run_folder::RunInfo;
use clap::{Args, ValueEnum};

use crate::command::{Outcome, certify, plan, print_json, proof, reach, simulate, tensions, workspace};
use crate::output_schema;

pub const EXAMPLE: &str = "\
Example: cable-robot schema rig
An editor with Taplo (\"Even Better TOML\") checks a file whose first line is `#:schema rig.schema.json`.";

#[derive(Args)]
pub struct Schema {
    /// Which file, or whose result
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
    /// What `plan --json` prints
    Plan,
    /// What `reach --json` prints
    Reach,
    /// What `certify --json` prints
    Certify,
    /// What `workspace --json` prints
    Workspace,
    /// What `simulate --json` prints
    Simulate,
    /// What `tensions --json` prints
    Tensions,
    /// `run.json` of a run folder
    Run,
}

impl Schema {
    pub fn run(&self) -> Result<Outcome> {
        print_json(&match self.of {
            Kind::Rig => rig_file::schema().to_value(),
            Kind::Scenario => scenario_file::schema().to_value(),
            Kind::Proof => proof::schema().to_value(),
            Kind::Plan => output_schema::<plan::answer::Answer>(),
            Kind::Reach => output_schema::<reach::Answer>(),
            Kind::Certify => output_schema::<certify::Answer>(),
            Kind::Workspace => output_schema::<workspace::answer::Answer>(),
            Kind::Simulate => output_schema::<simulate::answer::OneOrSeveral>(),
            Kind::Tensions => output_schema::<tensions::Answer>(),
            Kind::Run => output_schema::<RunInfo>(),
        })?;
        Ok(Outcome::Done)
    }
}
