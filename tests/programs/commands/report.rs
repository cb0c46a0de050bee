//! `cable-robot report` as a person meets it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn cable_robot(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cable-robot")).args(arguments).output().unwrap()
}

/// A second of the paper's move, recorded into `folder`.
fn record(folder: &Path) {
    let folder = folder.to_str().unwrap();
    let done = cable_robot(&["simulate", "--to", "0.15,0.15,1", "--duration", "1", "--output", folder]);
    assert!(done.status.success(), "{done:?}");
}

/// What is said when it is refused.
fn refusal(arguments: &[&str]) -> String {
    let done = cable_robot(arguments);
    assert_eq!(done.status.code(), Some(1), "{done:?}");
    String::from_utf8(done.stderr).unwrap()
}

#[test]
fn a_run_becomes_one_file_beside_it_or_where_it_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let (run, other) = (folder.path().join("run"), folder.path().join("other.html"));
    record(&run);
    let done = cable_robot(&["report", run.to_str().unwrap()]);
    let path = run.join("report.html");
    assert_eq!(String::from_utf8(done.stdout).unwrap().trim(), path.to_str().unwrap());
    assert!(
        cable_robot(&["report", run.to_str().unwrap(), "--output", other.to_str().unwrap()]).status.success()
    );
    let page = fs::read_to_string(&path).unwrap();
    assert_eq!(page, fs::read_to_string(other).unwrap());
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
}

/// As [`record`], of another rig.
fn record_heavier(folder: &Path, rig: &Path) {
    let paper = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    fs::write(rig, paper.replace("mass = 6.0", "mass = 5.0")).unwrap();
    let [folder, rig] = [folder, rig].map(|path| path.to_str().unwrap());
    let done = cable_robot(&[
        "simulate",
        "--rig",
        rig,
        "--to",
        "0.15,0.15,1",
        "--duration",
        "1",
        "--output",
        folder,
    ]);
    assert!(done.status.success(), "{done:?}");
}

#[test]
fn two_runs_become_one_page_beside_the_first_unless_their_rigs_differ() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, heavier] = ["a", "b", "heavier"].map(|name| folder.path().join(name));
    record(&a);
    record(&b);
    let names = |other: &Path| ["report", a.to_str().unwrap(), other.to_str().unwrap()].map(str::to_owned);
    let done = cable_robot(&names(&b).each_ref().map(String::as_str));
    let path = a.join("comparison.html");
    assert_eq!(String::from_utf8(done.stdout).unwrap().trim(), path.to_str().unwrap());
    assert!(fs::read_to_string(&path).unwrap().trim_end().ends_with("</html>"));
    assert!(!a.join("report.html").exists());

    record_heavier(&heavier, &folder.path().join("rig.toml"));
    let said = refusal(&names(&heavier).each_ref().map(String::as_str));
    assert!(said.contains("the runs are of different rigs: mass = 6 kg in A, 5 kg in B"), "{said}");
    record(&a);
    assert!(!path.exists(), "the comparison was of the old run");
}

/// A `PATH` on which there is nothing, or an `xdg-open` of these lines.
#[cfg(target_os = "linux")]
fn opened(run: &Path, opener: Option<&str>) -> Output {
    use std::os::unix::fs::PermissionsExt;
    let path = tempfile::tempdir().unwrap();
    if let Some(lines) = opener {
        let file = path.path().join("xdg-open");
        fs::write(&file, format!("#!/bin/sh\n{lines}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
    command.args(["report", run.to_str().unwrap(), "--open"]).env("PATH", path.path()).output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_is_opened_by_the_platform_or_it_is_said_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let (run, told) = (folder.path().join("run"), folder.path().join("told"));
    record(&run);
    let page = run.join("report.html");
    let done = opened(&run, Some(&format!("echo \"$1\" > {}", told.display())));
    assert!(done.status.success(), "{done:?}");
    assert_eq!(fs::read_to_string(&told).unwrap().trim(), page.to_str().unwrap());
    let instead = format!("open {} in a browser yourself", page.display());
    for (opener, why) in [(None, "there is no xdg-open here"), (Some("exit 3"), "exit status: 3")] {
        let done = opened(&run, opener);
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(done.status.code() == Some(1) && said.contains(why) && said.contains(&instead), "{said}");
    }
}

#[test]
fn what_cannot_be_read_or_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let name = run.to_str().unwrap();
    assert!(refusal(&["report", name]).contains(&format!("cannot read {name}/run.json")));
    record(&run);
    let file = folder.path().join("no/such/report.html");
    assert!(refusal(&["report", name, "--output", file.to_str().unwrap()]).contains("cannot write"));
    let csv = fs::read_to_string(run.join("run.csv")).unwrap();
    fs::write(run.join("run.csv"), csv.replace("\n0.5,", "\nhalf,")).unwrap();
    let said = refusal(&["report", name]);
    assert!(said.contains("run.csv: line 502, column 1 (time): \"half\" is not a finite number"), "{said}");
    fs::write(run.join("run.csv"), csv.replace("plant.encoderPose.pitch", "pitch")).unwrap();
    let said = refusal(&["report", name]);
    assert!(said.contains("run.csv: line 1: there is no column \"plant.encoderPose.pitch\""), "{said}");
}
