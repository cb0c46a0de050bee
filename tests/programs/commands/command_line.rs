//! What all commands of `cable-robot` have in common: arguments, files, help, output.

use std::fs;
use std::process::Command;

use serde_json::Value;

use super::program::{json, number, run, written};

/// The refusal of a rig file with this text.
fn refused_rig(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my rig.toml");
    fs::write(&path, text).unwrap();
    let (out, err) = written(1, &["workspace", "--rig", path.to_str().unwrap()]);
    assert!(out.is_empty() && err.contains("my rig.toml"), "{err}");
    err
}

#[test]
fn rigs_that_make_no_sense_are_refused_with_line_field_and_cause() {
    let paper = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    let error = refused_rig(&paper.replace("mass = 6.0", "mass = -6.0"));
    let line = paper.lines().position(|line| line.starts_with("mass")).unwrap() + 1;
    assert!(error.contains(&format!("line {line}: platform.mass = -6")) && error.contains("greater than 0"));
    let error = refused_rig(&paper.replace("gravity = 9.81", "gravitas = 9.81"));
    assert!(error.contains("gravitas") && error.contains("gravity"), "{error}");
    assert_eq!(error.matches("unknown field").count(), 1, "{error}");
    let error = refused_rig(&paper.replace("home = [0.0, 0.0, 1.0]", "home = [0.0, 0.0, 0.0]"));
    assert!(error.contains("in one plane"), "{error}");
    let error = refused_rig(&paper.replace("gravity = 9.81", "gravity = 0.0"));
    assert!(error.contains("gravity = 0 is not allowed"), "{error}");
    let error = refused_rig(&paper.replace("min = 0.0", "min = 200.0"));
    assert!(
        error.contains("tension.max = 100 is not allowed: must be greater than the least tension"),
        "{error}"
    );
    let error =
        refused_rig(&paper.replace(", -0.45, 0.0]", ", 0.0, 0.0]").replace(", 0.45, 0.0]", ", 0.0, 0.0]"));
    assert!(error.contains("anchors all lie on one line"), "{error}");
    let (_, error) = written(1, &["workspace", "--rig", "no/such.toml"]);
    assert!(error.contains("no/such.toml"), "{error}");
}

#[test]
fn the_papers_planner_refuses_a_rig_of_another_shape_and_says_what_differs() {
    let arguments = ["--rig", "rigs/eight.toml", "--to", "0.1,0,2", "--from", "0,0,2"];
    let (_, error) = written(1, &[&["reach"], &arguments[..]].concat());
    assert!(error.contains("the rig has 8 cables, the paper's 6"), "{error}");
    for task in ["plan", "simulate"] {
        let (_, error) = written(1, &[&[task], &arguments[..], &["--planner", "bounded"]].concat());
        assert!(error.contains("the rig has 8 cables, the paper's 6"), "{error}");
    }
    let (text, _) = written(0, &[&["plan"], &arguments[..]].concat());
    assert!(text.contains("the goal is reached"), "{text}");
}

#[test]
fn simulate_writes_csv_and_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let arguments = ["simulate", "--to", "0.05,0,1", "--duration", "4", "--step", "0.01"];
    let (to_stdout, summary) = written(0, &arguments);
    assert!(summary.contains("slack cables: none"), "{summary}");
    let with_file = [&arguments[..], &["--output", path.to_str().unwrap()]].concat();
    let found = json(0, &with_file);
    assert_eq!(found["status"], "AtGoal");
    assert_eq!(fs::read_to_string(path.join("run.csv")).unwrap(), to_stdout);

    let mut reader = csv::Reader::from_reader(to_stdout.as_bytes());
    let columns = reader.headers().unwrap().len();
    let rows: Vec<Vec<f64>> = reader.deserialize().map(Result::unwrap).collect();
    assert!(rows.len() == 401 && rows.iter().all(|row| row.len() == columns));
    let last = &rows[400];
    assert!((last[0] - 4.0).abs() < 1e-12 && (last[1] - 0.05).abs() < 2e-3, "{last:?}");

    written(3, &["simulate", "--to", "0,0.4,1", "--duration", "1", "--step", "0.01"]);
}

#[test]
fn bad_arguments_are_refused_with_what_is_allowed() {
    for (pose, cause) in [
        ("0,nan,1", "not a finite number"),
        ("0,0,inf", "not a finite number"),
        ("0,1", "2 numbers given"),
        ("0,0,1,0", "4 numbers given"),
        ("0,zero,1", "not a number"),
    ] {
        let (out, error) = written(2, &["plan", "--from", "0,0,1", "--to", pose]);
        assert!(out.is_empty() && error.contains(cause) && error.contains("--to"), "{pose}: {error}");
    }
    // What lies below the anchors the rig says.
    for pose in ["0,0,-1", "0,0,0"] {
        let (out, error) = written(1, &["plan", "--from", "0,0,1", "--to", pose]);
        assert!(
            out.is_empty() && error.contains("--to: z = ") && error.contains("below the anchors"),
            "{error}"
        );
    }
    written(2, &["simulate", "--to", "0,0,1", "--step", "0"]);
    written(2, &["workspace", "--height", "high"]);
    written(2, &[]);
    let (_, error) = written(1, &["simulate", "--to", "0,0,1", "--duration", "1e300"]);
    assert!(error.contains("steps"), "{error}");
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_work() {
    let (out, error) = written(1, &["simulate", "--to", "0.1,0,1", "--output", "no/such/folder/run.csv"]);
    assert!(
        out.is_empty() && error.contains("no/such/folder/run.csv") && !error.contains("set points"),
        "{error}"
    );
    let (out, error) = written(1, &["workspace", "--svg", "no/such/folder/w.svg"]);
    assert!(out.is_empty() && error.contains("no/such/folder/w.svg"), "{error}");
}

#[test]
fn a_result_that_cannot_be_written_is_an_error_that_names_the_place() {
    let (out, error) = written(1, &["workspace", "--svg", "/dev/full"]);
    assert!(out.is_empty() && error.contains("cannot write /dev/full: No space left"), "{error}");
    for arguments in
        [&["reach", "--from", "0,0,1"][..], &["simulate", "--to", "0.1,0,1", "--duration", "0.1"]]
    {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        let output = command.args(arguments).stdout(full).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert!(error.contains("cannot write to stdout: No space left"), "{error}");
    }
}

#[test]
fn a_pipe_that_nobody_reads_does_not_change_the_exit_code() {
    for (code, goal) in [(0, "0.08,0.08,1"), (3, "0.15,0.15,1")] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
            .args(["reach", "--from", "0,0,1", "--to", goal])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr), (Some(code), vec![]), "{goal}");
    }
}

#[test]
fn numbers_of_any_size_fit_on_a_line() {
    let short = |text: &str| text.lines().all(|line| line.chars().count() < 200);
    let (_, error) = written(1, &["workspace", "--height", "1e300"]);
    assert!(error.contains("--height 1e300") && error.contains("parallel") && short(&error), "{error}");
    let (text, _) = written(3, &["plan", "--from", "0,0,1", "--to", "0,0.4,1e300"]);
    assert!(text.contains("1.000e300 m from the goal") && short(&text), "{text}");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(["simulate", "--to", "0.1,0,1", "--duration", "5"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(0) && said.starts_with("From (0, 0, 1)"), "{said}");
}

#[test]
fn help_of_every_command_has_an_example_and_the_exit_codes_stand_in_the_first() {
    let (help, _) = written(0, &["--help"]);
    assert!(help.contains("Exit codes: 0 done, 1 error, 2 wrong usage, 3 goal not reachable"), "{help}");
    for task in ["workspace", "reach", "plan", "simulate", "certify", "schema", "completions", "man"] {
        let (help, _) = written(0, &[task, "--help"]);
        let example = help.lines().find_map(|line| line.strip_prefix("Example: cable-robot ")).expect(task);
        let folder = tempfile::tempdir().unwrap();
        let rigs = folder.path().join("rigs");
        fs::create_dir(&rigs).unwrap();
        fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml"), rigs.join("eight.toml"))
            .unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        let output = command.args(example.split_whitespace()).current_dir(folder.path()).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 3)), "{example}: {output:?}");
    }
}

#[test]
fn what_the_pages_show_is_what_the_program_prints() {
    for (name, sessions) in [("README.md", 1), ("docs/command-line.md", 7)] {
        let page = fs::read_to_string(format!("{}/../{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let shown: Vec<_> =
            page.split("```").filter_map(|block| block.strip_prefix("\n$ cable-robot ")).collect();
        assert_eq!(shown.len(), sessions, "{name}");
        for block in shown {
            let (command, expected) = block.split_once('\n').unwrap();
            let output = run(&command.split_whitespace().collect::<Vec<_>>());
            assert_eq!(String::from_utf8(output.stdout).unwrap(), expected, "{command}");
        }
    }
}

#[test]
fn schema_prints_what_is_checked_in() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    for (name, path) in [("rig", "rigs/rig.schema.json"), ("proof", "docs/proof.schema.json")] {
        let (printed, _) = written(0, &["schema", name]);
        assert_eq!(printed, fs::read_to_string(format!("{root}/{path}")).unwrap());
    }
    let (_, error) = written(2, &["schema", "boat"]);
    assert!(error.contains("rig"), "{error}");
}

#[test]
fn degrees_are_not_taken_for_radians() {
    let goal = ["plan", "--from", "0,0,1", "--to", "0,0,1,0,0,30", "--planner", "exact"];
    assert!(written(2, &goal).1.contains("angles are in radians"));
    assert!(written(2, &["workspace", "--orientation", "30,0,0"]).1.contains("angles are in radians"));
}

#[test]
fn margins_that_make_no_sense_are_named_by_their_option() {
    for (option, value, expected) in [
        ("--mass-error", "5", "below 1"),
        ("--mass-error", "-1", "0 or greater"),
        ("--delay", "inf", "finite"),
    ] {
        let (_, error) = written(2, &["certify", "--from", "0,0,1", "--to", "0.1,0,1", option, value]);
        assert!(error.contains(option) && error.contains(expected), "{error}");
    }
}

#[test]
fn tensions_hold_the_weight_and_say_who_shares_how() {
    let rig = ["--rig", "rigs/eight.toml"];
    let at = ["tensions", "--pose", "0.3,0.2,2"];
    let law = json(0, &[&at[..], &rig[..]].concat());
    let widest = json(0, &[&at[..], &rig[..], &["--distribution", "widest"]].concat());
    let margin = |found: &Value| number(&found["margin"]);
    assert!(margin(&law) > 20.0 && margin(&widest) > margin(&law), "{law} {widest}");
    assert_eq!(law["cables"].as_array().unwrap().len(), 8);
    // Upwards faster: every cable of a suspended rig pulls more in sum.
    let sum = |found: &Value| -> f64 {
        found["cables"].as_array().unwrap().iter().map(|cable| number(&cable["tension"])).sum()
    };
    let lifted = json(0, &[&at[..], &rig[..], &["--acceleration", "0,0,-2,0,0,0"]].concat());
    assert!(sum(&lifted) > 1.1 * sum(&law), "{lifted}");
    let (text, _) = written(3, &["tensions", "--pose", "0.3,0.3,1"]);
    assert!(text.contains("each would have to be wider by 10.685 N"), "{text}");
}
