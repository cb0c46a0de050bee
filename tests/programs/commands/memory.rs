//! How much memory runs take that are long.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Most memory that a child was seen to have at any time, bytes. (What the system says of one that has ended counts this process in.)
fn peak(command: &mut Command) -> u64 {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let (place, mut most) = (format!("/proc/{}/status", child.id()), 0);
    loop {
        if let Some(ended) = child.try_wait().unwrap() {
            assert!(ended.success() && most > 0, "{command:?}");
            return most * 1024;
        }
        let status = fs::read_to_string(&place).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok());
        most = most.max(kilobytes.unwrap_or(0));
        sleep(Duration::from_millis(1));
    }
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

/// All rows were held: 760 bytes for each and more, so a million took 749 MB in `simulate` and 1 GB in `report`.
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
