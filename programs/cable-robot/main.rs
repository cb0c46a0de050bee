//! `cable-robot`: workspaces, reachable domains, plans and simulations from the command line.

use std::process::ExitCode;

use cable_robot_programs::command::{Installation, run};

fn main() -> ExitCode {
    run(std::env::args_os(), Installation::default()).into()
}
