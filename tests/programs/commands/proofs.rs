//! Proof files: what `certify --proof` and `plan --proof` write and refuse.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

const FROM: [&str; 3] = ["certify", "--from", "0,0,1"];

/// Exit code, stdout and stderr.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the binary is built");
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (output.status.code(), out, err)
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_proof_is_written_and_changes_nothing_of_what_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (to, code, verdict) in [("0.1,0.05,0.9", 0, "admissible"), ("0.3,0,1", 3, "not admissible")] {
        let plain = [&FROM[..], &["--to", to]].concat();
        let (_, without, _) = run(folder.path(), &plain);
        let (ended, with, said) = run(folder.path(), &[&plain[..], &["--proof", "x.json"]].concat());
        assert_eq!((ended, with), (Some(code), without), "{said}");
        let proof = read(&folder.path().join("x.json"));
        assert_eq!(proof["verdict"], verdict);
        assert!(said.contains("x.json") && said.contains(proof["sha256"].as_str().unwrap()), "{said}");
    }
}

#[test]
fn a_proof_that_cannot_be_written_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&FROM[..], &["--to", "0.1,0,1", "--proof", "missing/x.json"]].concat();
    let (code, out, err) = run(folder.path(), &arguments);
    assert_eq!((code, out.as_str()), (Some(1), ""));
    assert!(err.contains("cannot write missing/x.json"), "{err}");
}

#[test]
fn of_an_undecided_step_no_proof_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        [&FROM[..], &["--to", "0,0,1,0,0,3.2", "--rates", "0,0,0,0,0,5", "--proof", "x.json"]].concat();
    let (code, out, err) = run(folder.path(), &arguments);
    assert!(code == Some(3) && out.starts_with("undecided"), "{out}");
    assert!(err.contains("x.json is not written: nothing is proved"), "{err}");
    assert!(!folder.path().join("x.json").exists());
}

#[test]
fn a_proof_with_margins_says_which_and_how_far_the_robot_may_be_off() {
    let folder = tempfile::tempdir().unwrap();
    for (to, code) in [("0.06,0.03,1", 0), ("0.3,0,1", 3), ("0.2,0,1", 3)] {
        let margins = ["--mass-error", "0.005", "--force", "0.1", "--sample-period", "0.001"];
        let plain = [&FROM[..], &["--to", to], &margins].concat();
        let (_, without, _) = run(folder.path(), &plain);
        let (ended, with, said) = run(folder.path(), &[&plain[..], &["--proof", "x.json"]].concat());
        assert_eq!((ended, with), (Some(code), without.clone()), "{said}");
        if without.starts_with("undecided") {
            continue;
        }
        let proof = read(&folder.path().join("x.json"));
        assert_eq!(proof["problem"]["margins"]["force"], "0x1.999999999999ap-4");
        assert_eq!(proof["tube"].is_object(), code == 0);
        assert_eq!(proof["instant"].is_object(), code == 3);
    }
}

#[test]
fn a_proof_with_margins_of_eight_cables_says_how_near_the_law_is() {
    let folder = tempfile::tempdir().unwrap();
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml");
    let step = ["certify", "--rig", rig, "--from", "0,0,2", "--to", "0.3,0.2,1.9", "--force", "2"];
    let (code, out, err) = run(folder.path(), &[&step[..], &["--proof", "x.json"]].concat());
    assert_eq!((code, &out), (Some(0), &run(folder.path(), &step).1), "{err}");
    let proof = read(&folder.path().join("x.json"));
    assert!(proof["problem"]["margins"]["lawMargin"].is_string() && proof["tube"]["intrusion"].is_string());
    for span in proof["spans"].as_array().unwrap() {
        assert!(span["distance"].is_string() && span["multipliers"].as_array().unwrap().len() == 6);
    }
}

#[test]
fn a_plan_is_proved_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let plan = ["plan", "--from", "0,0,1", "--to", "0.15,0.15,1"];
    let with = [&plan[..], &["--proof", "steps"]].concat();
    let (code, out, err) = run(folder.path(), &with);
    assert_eq!((code, &out), (Some(0), &run(folder.path(), &plan).1), "{err}");
    let mut at = Value::Null;
    for i in 1..=4 {
        let proof = read(&folder.path().join(format!("steps/step-{i}.proof.json")));
        assert_eq!(proof["verdict"], "admissible");
        assert!(i == 1 || proof["problem"]["step"]["start"] == at, "step {i}");
        at = proof["problem"]["step"]["setPoint"].clone();
    }
    assert_eq!(fs::read_dir(folder.path().join("steps")).unwrap().count(), 4);
    let (code, _, err) = run(folder.path(), &with);
    assert!(code == Some(1) && err.contains("steps: the folder holds files already"), "{err}");
}

#[test]
fn a_motion_in_minimum_time_is_proved_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let plan = ["plan", "--from", "0,0,1", "--to", "0.15,0.15,1"];
    for (k, more) in [
        &["--planner", "minimum-time"][..],
        &["--planner", "minimum-time", "--lift", "0.1"],
        &["--planner", "minimum-time", "--max-tension-rate", "300"],
        &["--through", "0.08,0.05,0.98"],
    ]
    .into_iter()
    .enumerate()
    {
        let (name, plain) = (k.to_string(), [&plan[..], more].concat());
        let with = [&plain[..], &["--proof", &name]].concat();
        let (code, out, err) = run(folder.path(), &with);
        assert_eq!((code, &out), (Some(0), &run(folder.path(), &plain).1), "{err}");
        let proof = read(&folder.path().join(&name).join("motion.proof.json"));
        let pieces = proof["problem"]["motion"]["pieces"].as_array().unwrap();
        let spans = proof["spans"].as_array().unwrap();
        assert_eq!(proof["verdict"], "admissible");
        assert_eq!(spans[spans.len() - 2]["piece"], pieces.len());
        assert!(spans[spans.len() - 1]["piece"].is_null() && spans[spans.len() - 1]["from"].is_null());
    }
}

#[test]
fn random_proofs_have_both_verdicts_and_are_small() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, err) = run(folder.path(), &["study", "proofs", "--cases", "60"]);
    assert_eq!(code, Some(0), "{err}");
    let (mut counts, mut tubes) = ([0; 4], 0);
    for line in out.lines() {
        assert!(line.len() < 200_000);
        let proof: Value = serde_json::from_str(line).unwrap();
        let is_six = proof["problem"]["rig"]["cables"].as_array().unwrap().len() == 6;
        counts[2 * usize::from(is_six) + usize::from(proof["verdict"] == "admissible")] += 1;
        tubes += usize::from(proof["tube"].is_object());
    }
    assert!(counts.iter().all(|count| *count > 3) && tubes > 0, "{counts:?} {tubes}\n{err}");
}
