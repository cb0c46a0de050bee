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
