//! What `cable-robot` says is so: regressions of answers that misled.

use std::fs;

use super::program::{json, written};

/// A scenario file with this text.
fn scenario(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    fs::write(file.path(), text).unwrap();
    file
}

/// Of six slack cables only the first was named, and the exit code was 0.
#[test]
fn every_slack_cable_is_named_and_the_exit_code_says_so() {
    let lifted =
        "title = \"x\"\nduration = 1.0\n[[disturbances]]\nfrom = 0.1\nuntil = 0.3\nforce = [0, 0, -100]\n";
    let file = scenario(lifted);
    let path = file.path().to_str().unwrap();
    let found = json(4, &["simulate", path]);
    let slack = found["slack"].as_array().unwrap();
    let cables: Vec<_> = slack.iter().map(|slack| slack["cable"].as_u64().unwrap()).collect();
    assert_eq!(cables, [1, 2, 3, 4, 5, 6]);
    assert!(
        slack
            .iter()
            .all(|slack| slack["first"].as_f64() > Some(0.1) && slack["duration"].as_f64() > Some(0.0))
    );
    let (_, text) = written(4, &["simulate", path]);
    assert!(text.contains("slack cables: cable 1 from ") && text.contains("; cable 6 from "), "{text}");
}

/// It ended turned by half a radian, and nothing said so.
#[test]
fn a_run_says_how_far_from_the_goal_and_how_much_turned_it_ends() {
    let arguments = ["simulate", "--to", "0.1,0,1", "--step", "0.3"];
    let found = json(0, &arguments);
    let [distance, turn] = ["goalDistance", "goalTurn"].map(|name| found[name].as_f64().unwrap());
    assert!(distance > 1e-3 && turn > 0.3, "{distance} m, {turn} rad");
    let (_, text) = written(0, &arguments);
    let said = format!("{distance:.4} m from the goal, turned by {turn:.4} rad from it");
    assert!(text.contains(&said), "{text}");
}

/// A height above the anchors ended with exit code 0.
#[test]
fn an_empty_workspace_has_an_exit_code_and_its_reason() {
    let (text, _) = written(3, &["workspace", "--height", "-1"]);
    assert!(text.contains("empty, no anchor is above the platform"), "{text}");
    assert_eq!(json(3, &["workspace", "--height", "-1"])["empty"], true);
}

/// The proof was of 13.333 s, when it had long been slack.
#[test]
fn certify_names_the_earliest_instant() {
    for from in ["0.3,0,1", "0,0,1"] {
        let found = json(3, &["certify", "--from", from, "--to", "0.3,0,1"]);
        assert!(found["time"].as_f64() == Some(0.0) && found["tension"].as_f64() < Some(0.0), "{found}");
    }
}

#[test]
fn certify_blames_no_singularity_for_margins_that_are_too_large() {
    let (text, _) = written(3, &["certify", "--from", "0,0,1", "--to", "0.1,0,1", "--force", "1e9"]);
    assert!(text.contains("margins allow") && !text.contains("singular"), "{text}");
}

#[test]
fn plan_gives_no_reason_that_is_false() {
    let (_, error) = written(1, &["plan", "--from", "0,0,100", "--to", "0,0,1"]);
    assert!(error.contains("farther than 51.9615 m") && error.contains("--from"), "{error}");
    let (text, _) = written(3, &["plan", "--from", "0,0,1", "--to", "0,0,1.2"]);
    assert!(text.contains("planner bounded keeps the height") && !text.contains("0.17 %"), "{text}");
}

#[test]
fn what_is_misspelt_gets_what_was_probably_meant() {
    let (_, error) = written(1, &["simulate", "papper"]);
    assert!(error.contains("did you mean paper?"), "{error}");
    let file = scenario("title = \"x\"\nduraton = 1.0\n");
    let (_, error) = written(1, &["simulate", file.path().to_str().unwrap()]);
    assert!(error.contains("did you mean duration?"), "{error}");
}

/// It was accepted, and never came.
#[test]
fn a_disturbance_after_the_end_is_refused() {
    let file = scenario("title = \"x\"\nduration = 1.0\n[[disturbances]]\nfrom = 1.5\nforce = [0, 1, 0]\n");
    let (_, error) = written(1, &["simulate", file.path().to_str().unwrap()]);
    assert!(
        error.contains("disturbances[1].from = 1.5 is not allowed: the run ends at duration = 1 (s)"),
        "{error}"
    );
}

#[test]
fn every_option_that_takes_angles_says_in_which_order_they_turn() {
    for task in ["workspace", "plan", "simulate", "certify", "tensions"] {
        let (help, _) = written(0, &[task, "--help"]);
        let joined = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(joined.contains("R = Rz(yaw) Ry(pitch) Rx(roll)"), "{help}");
    }
}
