//! The fault matrix: what fails at the rig, how soon the safe output is there, how the drives end, what the program says.
//!
//! `cargo faults` prints it as one table. Three kinds of rows:
//!
//! - [`simulated`]: bridge and simulated rig in one process and in simulated time, to the cycle;
//! - [`programs`]: `can-bridge` with the packed controller and `rig-sim`, over a pseudo-terminal;
//! - [`machine_rows`]: the same on the CAN of a real kernel, in a virtual machine (left out without `--include-ignored`).
#![cfg(target_os = "linux")]

mod failures;
mod lab;
#[path = "../virtual_machine/machine.rs"]
mod machine;
mod machine_rows;
mod programs;
mod simulated;
mod table;

use std::sync::{Arc, Mutex};

use libtest_mimic::{Arguments, Failed, Trial};

use table::Row;

fn main() {
    let mut arguments = Arguments::from_args();
    // Programs that share processors with others would be late for no fault of theirs.
    arguments.test_threads.get_or_insert(1);
    let rows: Arc<Mutex<Vec<Row>>> = Arc::default();
    let trials =
        simulated::cases().into_iter().chain(programs::cases()).chain(machine_rows::cases()).map(|case| {
            let rows = Arc::clone(&rows);
            Trial::test(format!("{}: {}", case.kind, case.name), move || {
                let row = (case.run)().map_err(Failed::from)?;
                rows.lock().map_err(|_| "a row failed")?.push(row);
                Ok(())
            })
            .with_ignored_flag(case.kind == "virtual machine")
        });
    let conclusion = libtest_mimic::run(&arguments, trials.collect());
    if let Ok(rows) = rows.lock() {
        table::print(&rows);
    }
    conclusion.exit();
}

/// What the virtual machine needs.
const NEEDS: &str =
    "the virtual machine needs the Debian packages qemu-system-x86 busybox-static can-utils cpio iproute2";

/// One row of the matrix and how it comes about.
pub struct Case {
    /// What fails.
    pub name: &'static str,
    /// Where.
    pub kind: &'static str,
    /// Makes it happen; what was seen, or what is not as it must be.
    pub run: Box<dyn FnOnce() -> Result<Row, String> + Send>,
}

/// `otherwise` is what to say if it does not hold.
pub fn ensure(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}
