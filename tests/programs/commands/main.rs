//! The programs and the packed FMUs, as they are used.

mod command_line;
mod completions;
mod ctrl_c;
mod figures;
mod foreign;
#[cfg(target_os = "linux")]
mod limits;
#[cfg(target_os = "linux")]
mod memory;
mod misleading_answers;
mod modelica;
mod orbit;
mod outputs;
mod packed;
mod pages;
mod plan;
mod program;
mod proofs;
mod report;
mod scenarios;
mod studies;
mod workspace;
