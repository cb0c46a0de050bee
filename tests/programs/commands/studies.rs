//! The studies of the command line at a small size: what docs/studies.md claims at full size.

use std::process::Command;

use serde_json::Value;

fn study(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .arg("study")
        .args(arguments)
        .arg("--json")
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A hundredth of the ten million cases of each domain.
#[test]
fn no_admitted_step_takes_a_tension_to_its_limit() {
    for domain in ["exact", "certificate"] {
        let found = study(&["soundness", "--domain", domain, "--cases", "100000"]);
        let counts = ["admitted", "broken"].map(|count| found[count].as_u64());
        assert_eq!(counts, [Some(100_000), Some(0)], "{domain}: {found}");
        // Cases come near the limits: there is something to be missed.
        assert!(found["smallest_per_weight"].as_f64().unwrap() < 1e-4, "{domain}: {found}");
    }
}

/// On the packed plant FMU; `cargo fmu build` makes it.
#[test]
fn steps_accepted_with_margins_slacken_no_cable_of_an_imperfect_plant() {
    for version in ["fmi2", "fmi3"] {
        let plant = format!("target/fmu/{version}/CableRobotPlant.fmu");
        let found = study(&["margins", "--steps", "200", "--plant", &plant]);
        let counts = ["accepted", "slack", "outside"].map(|count| found[count].as_u64());
        assert_eq!(counts, [Some(200), Some(0), Some(0)], "{version}: {found}");
        assert!(found["admissible"].as_u64() > Some(200), "margins cost something: {found}");
    }
}

#[test]
fn the_exact_domain_accepts_all_that_is_admissible_and_the_bounded_one_a_part() {
    let found = study(&["tightness", "--pairs", "500"]);
    let cells = found["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 12);
    for cell in cells {
        assert_eq!(cell["exact"], cell["admissible"], "{cell}");
        assert_eq!(cell["wrong"], 0, "{cell}");
        assert!(cell["bounded"].as_u64() < cell["admissible"].as_u64().map(|n| n.max(1)), "{cell}");
    }
}

#[test]
fn exact_from_any_state_is_the_fastest() {
    let found = study(&["time", "--pairs", "100"]);
    for gain in found["rows"].as_array().unwrap().chunks(3) {
        let mean: Vec<f64> = gain.iter().map(|row| row["mean"].as_f64().unwrap()).collect();
        assert!(mean[2] <= mean[1] && mean[1] < mean[0], "{gain:?}");
        assert_eq!(gain[2]["reached"], 100);
    }
}

#[test]
fn margins_outside_the_projects_folder_says_what_is_needed() {
    let elsewhere = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
    let output = command.args(["study", "margins"]).current_dir(elsewhere.path()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("--plant target/fmu/") && said.contains("cargo fmu build"), "{said}");
    assert!(said.contains("in the project's folder"), "{said}");
}

/// A hundredth and a twentieth of the runs on the page.
#[test]
fn held_and_late_commands_slacken_no_cable() {
    for (arguments, is_perfect) in
        [(&["held", "--runs", "100"][..], true), (&["held", "--runs", "100", "--imperfect"], false)]
    {
        let found = study(arguments);
        let count = |name: &str| -> u64 {
            found["classes"].as_array().unwrap().iter().map(|class| class[name].as_u64().unwrap()).sum()
        };
        assert_eq!((count("slack"), count("lost")), (0, 0), "{found}");
        for class in found["classes"].as_array().unwrap().iter().filter(|_| is_perfect) {
            assert!(class["margin_exceeds_per_weight"].as_f64().unwrap() < 1e-6, "{class}");
        }
        for class in found["classes"].as_array().unwrap().iter().filter(|_| is_perfect) {
            assert!(class["margin_exceeds_per_weight"].as_f64().unwrap() < 1e-6, "{class}");
        }
        assert!(count("runs") > 30 && count("reached") * 20 > count("goals") * 17, "{found}");
    }
}

/// A fiftieth of the goals on the page. Those that are not reached say so.
#[test]
fn every_goal_is_reached_the_straight_way_to_which_can_be_rested_at() {
    let found = study(&["liveness", "--goals", "200"]);
    let kinds: Vec<_> = found["kinds"].as_array().unwrap().iter().collect();
    assert_eq!(kinds.len(), 4);
    for kind in kinds.iter().filter(|kind| kind["way"] == "can be rested at") {
        assert!(kind["count"].as_u64().unwrap() > 50 && kind["reached"] == kind["count"], "{found}");
    }
    let ended = |kind: &Value| kind["reached"].as_u64().unwrap() + kind["unreachable"].as_u64().unwrap();
    assert!(
        kinds.iter().all(|kind| kind["slack"] == 0 && Some(ended(kind)) == kind["count"].as_u64()),
        "{found}"
    );
}
