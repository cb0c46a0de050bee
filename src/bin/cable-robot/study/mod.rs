//! `cable-robot study`: the claims about the reachable domains, as figures that anyone can make again.

mod soundness;
mod tightness;
mod time;

use anyhow::Result;
use clap::Subcommand;

use crate::Outcome;

#[derive(Subcommand)]
pub enum Study {
    /// Random cases that the exact domain admits, looked at densely for a slack cable
    #[command(after_help = soundness::EXAMPLE)]
    Soundness(soundness::Soundness),
    /// Share of the truly admissible steps that the bounded and the exact domain accept
    #[command(after_help = tightness::EXAMPLE)]
    Tightness(tightness::Tightness),
    /// Time to the goal with each planner
    #[command(after_help = time::EXAMPLE)]
    Time(time::Time),
}

impl Study {
    pub fn run(&self) -> Result<Outcome> {
        match self {
            Study::Soundness(study) => study.run(),
            Study::Tightness(study) => study.run(),
            Study::Time(study) => study.run(),
        }
    }
}
