//! What Ctrl-C leaves of `cable-robot simulate`.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use cable_robot_report::RunFolder;

/// A simulation of so many seconds in steps of a millisecond, into `folder`.
fn simulation(duration: &str, folder: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(["simulate", "--to", "0.15,0.15,1", "--duration", duration, "--output"])
        .arg(folder)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn press_ctrl_c(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Waits until something is so.
fn wait_until(is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().map(|file| file.unwrap().path()).collect()
}

/// Exit code and what was said.
fn end(mut child: Child) -> (Option<i32>, String) {
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    (child.wait().unwrap().code(), said)
}

#[test]
fn ctrl_c_leaves_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("run");
    let child = simulation("1000", &output);
    wait_until(|| output.is_dir());
    std::thread::sleep(Duration::from_millis(300));
    press_ctrl_c(&child);
    let (code, said) = end(child);
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("set points") && said.contains("interrupted: 1000 s"), "{said}");
    let rows = RunFolder::read(&output).unwrap().table.rows();
    assert!((2..1_000_000).contains(&rows), "{rows} rows");
    assert_eq!(files(&output).len(), 2, "nothing half written");
}

#[test]
fn a_second_ctrl_c_leaves_every_row_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let child = simulation("200", folder.path());
    wait_until(|| !files(folder.path()).is_empty());
    press_ctrl_c(&child);
    // Two signals at once would be one.
    std::thread::sleep(Duration::from_millis(50));
    press_ctrl_c(&child);
    let (code, said) = end(child);
    assert_eq!(code, Some(130), "{said}");
    assert!(RunFolder::read(folder.path()).unwrap().table.rows() > 0, "{said}");
    assert_eq!(files(folder.path()).len(), 2, "nothing half written");
}

/// Whoever watches a run may read it while it lasts.
#[test]
fn rows_are_there_while_the_run_lasts() {
    let folder = tempfile::tempdir().unwrap();
    let child = simulation("1000", folder.path());
    let rows = || RunFolder::read(folder.path()).map_or(0, |run| run.table.rows());
    wait_until(|| rows() > 0);
    let before = rows();
    wait_until(|| rows() > before);
    press_ctrl_c(&child);
    assert_eq!(end(child).0, Some(130));
}
