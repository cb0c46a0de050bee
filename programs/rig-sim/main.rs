//! `rig-sim`: drives, load cells and the platform on a CAN bus, so that `can-bridge` can be tried without hardware.

#[cfg(target_os = "linux")]
mod port;
#[cfg(target_os = "linux")]
mod run;

use std::io::Write;
use std::process::ExitCode;

#[cfg(target_os = "linux")]
fn main() -> ExitCode {
    match run::main() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Whoever read it may be gone.
            let said = cable_robot_programs::errors::in_words("rig-sim", &error);
            let _ = writeln!(std::io::stderr(), "{said}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn main() -> ExitCode {
    let _ = writeln!(std::io::stderr(), "rig-sim needs Linux: its CAN links are those of Linux");
    ExitCode::FAILURE
}
