//! How much memory runs take that are long.
#![allow(unsafe_code)]

use std::path::Path;
use std::process::{Command, Stdio};

/// Most memory that a child had at any time, bytes.
fn peak(command: &mut Command) -> u64 {
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut status = 0;
    // SAFETY: a plain struct of numbers, which the system fills.
    let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
    // SAFETY: the child is this one's, and nobody else waits for it.
    let ended = unsafe { libc::wait4(child.id() as i32, &mut status, 0, &mut usage) };
    assert_eq!((ended, status), (child.id() as i32, 0), "{command:?}");
    usage.ru_maxrss as u64 * 1024
}

/// Of a run of so many steps, of `simulate` and of `report`.
fn of_run(folder: &Path, steps: u32) -> [u64; 2] {
    let run = folder.join(steps.to_string());
    let (program, seconds) = (env!("CARGO_BIN_EXE_cable-robot"), f64::from(steps) * 1e-3);
    let mut simulate = Command::new(program);
    simulate.args(["simulate", "--from", "0,0,1", "--to", "0.15,0.15,1", "--duration", &seconds.to_string()]);
    let simulated = peak(simulate.arg("--output").arg(&run));
    [simulated, peak(Command::new(program).arg("report").arg(&run))]
}

/// All rows were held: 760 bytes for each in `simulate`, 1,000 in `report`.
#[test]
fn a_run_of_a_million_steps_took_a_gigabyte() {
    let folder = tempfile::tempdir().unwrap();
    let [short, long] = [4_000, 16_000].map(|steps| of_run(folder.path(), steps));
    for (program, short, long) in [("simulate", short[0], long[0]), ("report", short[1], long[1])] {
        let each = long.saturating_sub(short) / 12_000;
        println!("{program}: {short} and {long} bytes, {each} for each row");
        assert!(each < 300, "{program}: {each} bytes for each row, so {short} and {long}");
    }
}
