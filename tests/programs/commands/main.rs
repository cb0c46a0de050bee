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
mod modelica;
mod orbit;
mod outputs;
mod packed;
mod pages;
mod proofs;
mod report;
mod scenarios;
mod studies;
mod told_truly;
