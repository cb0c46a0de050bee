//! `cable-robot modelica`: what it refuses. What it writes is simulated in fmpy-tests/test_modelica.py.

use std::fs;
use std::process::{Command, Output};

fn modelica(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .arg("modelica")
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .unwrap()
}

fn refusal(arguments: &[&str]) -> String {
    let output = modelica(arguments);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_name_that_is_none_and_a_pulley_are_refused() {
    let said = refusal(&["--name", "2 cranes"]);
    assert!(said.contains("--name 2 cranes is no name of a Modelica class"), "{said}");
    let rig = tempfile::NamedTempFile::new().unwrap();
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    let with_pulley =
        "attachment = [-0.14433756729740646, -0.25, 0.0]\npulley = { radius = 0.02, axis = [0, 0, 1] }";
    fs::write(rig.path(), text.replacen("attachment = [-0.14433756729740646, -0.25, 0.0]", with_pulley, 1))
        .unwrap();
    let said = refusal(&["--rig", rig.path().to_str().unwrap()]);
    assert!(said.contains("cable 1 has a pulley: the plant in Modelica knows none"), "{said}");
}

#[test]
fn the_plant_of_the_package_is_what_the_command_writes() {
    let written = String::from_utf8(modelica(&["--rig", "rigs/paper.toml"]).stdout).unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../modelica/CableRobot/Plants/Plant.mo");
    let packaged = fs::read_to_string(path).unwrap();
    assert_eq!(packaged, written.replacen("within ;", "within CableRobot.Plants;", 1));
}
