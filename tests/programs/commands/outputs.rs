//! What the commands of `cable-robot` write, and what they leave alone.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

fn cable_robot(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
    command.current_dir(folder);
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    cable_robot(folder).args(arguments).output().unwrap()
}

/// What is said by a command that is refused before it does anything.
fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let done = run(folder, arguments);
    assert_eq!((done.status.code(), done.stdout), (Some(1), vec![]), "{arguments:?}");
    String::from_utf8(done.stderr).unwrap()
}

fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let done = run(folder, arguments);
    assert!(done.status.success(), "{done:?}");
    String::from_utf8(done.stdout).unwrap()
}

/// Starts a command and ends it by Ctrl-C while it is at work: sooner where it was done before.
fn interrupt(folder: &Path, arguments: &[&str], again: impl Fn()) {
    for wait in [50, 25, 12, 6, 3] {
        again();
        let mut child = cable_robot(folder).args(arguments).stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        if child.wait().unwrap().code() != Some(0) {
            return;
        }
    }
    panic!("{arguments:?} was done too soon, or Ctrl-C is ignored here (a job in the background)");
}

fn names(folder: &Path) -> Vec<String> {
    let name = |file: std::io::Result<fs::DirEntry>| file.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

const SHORT: [&str; 5] = ["simulate", "--to", "0.1,0,1", "--duration", "0.1"];

#[test]
fn ctrl_c_leaves_the_old_picture_of_a_workspace() {
    let folder = tempfile::tempdir().unwrap();
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml");
    let old = || fs::write(folder.path().join("w.svg"), "old").unwrap();
    interrupt(folder.path(), &["workspace", "--rig", rig, "--svg", "w.svg"], old);
    assert_eq!(fs::read_to_string(folder.path().join("w.svg")).unwrap(), "old");
    assert_eq!(names(folder.path()), ["w.svg"]);
}

#[test]
fn ctrl_c_leaves_no_part_of_a_figure() {
    let folder = tempfile::tempdir().unwrap();
    let nothing =
        || names(folder.path()).iter().for_each(|name| fs::remove_file(folder.path().join(name)).unwrap());
    interrupt(folder.path(), &["figure", "8"], nothing);
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_folder_in_the_place_of_a_file_is_said_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    for (name, arguments) in [
        ("figure-8.svg", &["figure", "8"][..]),
        ("w.svg", &["workspace", "--svg", "w.svg"]),
        ("run/run.csv", &[&SHORT[..], &["--output", "run"]].concat()),
        ("run/run.json", &[&SHORT[..], &["--output", "run"]].concat()),
    ] {
        fs::create_dir_all(folder.path().join(name)).unwrap();
        let said = refusal(folder.path(), arguments);
        assert!(said.contains(&format!("{name}: it is a folder, a file is wanted")), "{said}");
        assert!(!said.contains("set points"), "{said}");
        fs::remove_dir(folder.path().join(name)).unwrap();
    }
}

#[test]
fn a_report_that_cannot_be_written_is_said_before_the_run_is_read() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &[&SHORT[..], &["--output", "run"]].concat());
    fs::write(folder.path().join("run/run.csv"), "broken").unwrap();
    let said = refusal(folder.path(), &["report", "run", "--output", "nodir/x.html"]);
    assert!(said.contains("cannot write nodir/x.html") && !said.contains("run.csv"), "{said}");
}

#[test]
fn a_new_run_does_not_lie_beside_the_report_of_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        succeed(folder.path(), &[&SHORT[..], &["--output", "run"]].concat());
        assert_eq!(names(&folder.path().join("run")), ["run.csv", "run.json"]);
        succeed(folder.path(), &["report", "run"]);
    }
}

#[test]
fn an_fmu_that_is_refused_leaves_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let said = refusal(folder.path(), &["simulate", "paper", "--output", "run", "--fmu", "no.fmu"]);
    assert!(said.contains("no.fmu") && names(folder.path()).is_empty(), "{said}");
}

#[test]
fn report_and_figure_speak_to_machines() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &[&SHORT[..], &["--output", "run"]].concat());
    let said: Value = serde_json::from_str(&succeed(folder.path(), &["report", "run", "--json"])).unwrap();
    let bytes = fs::metadata(folder.path().join("run/report.html")).unwrap().len();
    assert_eq!((&said["report"], &said["rows"]), (&"run/report.html".into(), &101.into()));
    assert_eq!(said["bytes"].as_u64(), Some(bytes));

    let said: Value = serde_json::from_str(&succeed(folder.path(), &["figure", "2", "--json"])).unwrap();
    let figure = &said["figures"][0];
    assert_eq!((&figure["figure"], said["figures"].as_array().unwrap().len()), (&"2".into(), 1));
    for ending in ["svg", "png", "csv"] {
        assert!(folder.path().join(figure[ending].as_str().unwrap()).is_file(), "{figure}");
    }
    assert!(!figure["findings"].as_array().unwrap().is_empty());
}

#[test]
fn many_goals_are_not_a_line_each() {
    let folder = tempfile::tempdir().unwrap();
    let goal = |k: u32| format!("[[goals]]\ntime = 0.{k:02}\npose = [0.0{k:02}, 0, 1]\n");
    let goals: String = (0..40).map(goal).collect();
    fs::write(folder.path().join("way.toml"), format!("title = \"way\"\nduration = 0.5\n{goals}")).unwrap();
    let said = String::from_utf8(run(folder.path(), &["simulate", "way.toml", "--json"]).stderr).unwrap();
    assert_eq!(said.matches("given at").count(), 10, "{said}");
    assert!(said.contains("\n... 30 more goals\n"), "{said}");
}

#[test]
fn a_huge_line_is_not_echoed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("huge.toml"), format!("title = {}", "x".repeat(1_000_000))).unwrap();
    let said = refusal(folder.path(), &["simulate", "huge.toml"]);
    assert!(said.len() < 5_000 && said.contains("line 1"), "{} bytes", said.len());
}
