//! `can-bridge --survey`: a person places the platform, the program says what is wrong with the files.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use cable_robot::robot::Pose;
use cable_robot_fieldbus::Config;

use super::lab::{Lab, PATIENCE, Program, can_bridge, config, replay, rig_text};

const ACCURACY: &str = "--survey=0.001,0.002";

/// The pose that the last message asks for, as `rig-sim` writes it.
fn asked(messages: &str) -> Option<String> {
    let (_, asked) = messages.rsplit_once("put the platform at ")?;
    let (position, rest) = asked.split_once(", yaw ")?;
    let yaw: f64 = rest.split(',').next()?.parse().ok()?;
    Some(format!("place {position} 0 0 {}", yaw.to_radians()))
}

/// Measures every pose that is asked for, from Homing on.
fn measure_poses(lab: &Lab, program: &mut Program) {
    program.until("state", "TakingUpSlack", Some("home"));
    program.until("state", "Ready", Some("home"));
    let begun = Instant::now();
    while !program.messages().contains("every pose was measured") {
        assert!(begun.elapsed() < PATIENCE, "{}", program.messages());
        let measured = program.messages().matches("measured at").count();
        asked(&program.messages()).iter().for_each(|place| lab.suffer(place));
        // The hand takes its time; what is said while the platform still moves is refused.
        while program.messages().matches("measured at").count() == measured && begun.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(500));
            if !moves(lab) {
                program.tell("placed");
                thread::sleep(Duration::from_millis(500));
            }
        }
    }
}

fn moves(lab: &Lab) -> bool {
    let pose = || lab.rig().plant().encoder_pose;
    let before = pose();
    thread::sleep(Duration::from_millis(100));
    pose() != before
}

/// Waits until so many messages say it, giving `command` again and again.
fn until_said(program: &mut Program, what: &str, times: usize, command: Option<&str>) {
    let begun = Instant::now();
    while program.messages().matches(what).count() < times {
        assert!(begun.elapsed() < PATIENCE, "{what}: {}", program.messages());
        command.into_iter().for_each(|command| program.tell(command));
        thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_survey_of_a_rig_that_stands_elsewhere_names_what_is_wrong_and_never_enables() {
    let lab = Lab::start_as(Config { home: Pose::at(0.05, 0.0, 1.0), ..config() });
    let mut program = Program::start_commissioned(tempfile::tempdir().unwrap(), &lab.device, &[ACCURACY]);
    program.until("state", "Homing", None);
    measure_poses(&lab, &mut program);
    program.tell("enable");
    program.tell("shutdown");
    assert_eq!(program.exit_code(), Some(8), "{}", program.messages());
    let said = program.messages();
    assert!(said.contains("THE FILES ARE WRONG") && said.contains("home, x: +"), "{said}");
    assert!(said.contains("refused: ") && !said.contains("Enabled\n"), "{said}");
    assert!(said.contains("still to be commissioned: zero (never passed), pull 1"), "{said}");
    assert!(
        said.contains("fitted together (an offer;") && said.contains("rig.calibration.json written"),
        "{said}"
    );
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
}

/// Load cells, motors, watchdogs, poses; then the rig may move, with these files and drives only.
#[test]
fn a_rig_is_commissioned_and_only_then_enabled_and_only_as_it_was() {
    let lab = Lab::start();
    let folder = tempfile::tempdir().unwrap();
    let mut program = Program::start_commissioned(folder, &lab.device, &[ACCURACY]);
    program.until("state", "Homing", None);
    (1..=6).for_each(|cable| lab.suffer(&format!("cable {cable} slack 20")));
    thread::sleep(Duration::from_millis(200));
    until_said(&mut program, "zero enough", 1, Some("zero"));
    for cable in 1..=6 {
        until_said(
            &mut program,
            &format!("yes (key y) if you saw cable {cable}"),
            1,
            Some(&format!("pull {cable}")),
        );
        program.tell("release");
        program.tell("yes");
        until_said(&mut program, &format!("encoder of cable {cable} are its own"), 1, None);
    }
    program.tell("watchdog");
    until_said(&mut program, "every drive stopped by itself", 1, None);
    until_said(&mut program, "] Homing", 9, None);
    thread::sleep(Duration::from_millis(500));
    measure_poses(&lab, &mut program);
    lab.suffer("place 0 0 1 0 0 0");
    thread::sleep(Duration::from_secs(5));
    until_said(&mut program, "right within the", 1, Some("weigh"));
    until_said(&mut program, "] Ready", 2, Some("weigh"));
    program.tell("shutdown");
    let code = program.exit_code();
    print!("{}", program.messages());
    assert_eq!(code, Some(0), "{}", program.messages());
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");

    let numbers = fs::read_to_string(program.folder.path().join("rig.calibration.json")).unwrap();
    let numbers: serde_json::Value = serde_json::from_str(&numbers).unwrap();
    assert_eq!(numbers["zero"]["reading"].as_array().unwrap().len(), 6, "{numbers}");
    assert!(numbers["pulls"]["6"]["came_in"][5].as_f64().unwrap() > 0.004, "{numbers}");
    assert_eq!(numbers["poses"]["offered"]["anchors"].as_array().unwrap().len(), 6, "{numbers}");
    assert_eq!(numbers["weight"]["rank"], 6, "{numbers}");
    for gain in numbers["weight"]["gains"].as_array().unwrap() {
        assert!((gain[0].as_f64().unwrap() - 1.0).abs() < 0.05, "{numbers}");
    }

    let record = fs::read_to_string(program.folder.path().join("rig.commissioned.json")).unwrap();
    let commissioned = |text: &str, more: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("rig.commissioned.json"), &record).unwrap();
        let path = folder.path().join("rig.toml");
        fs::write(&path, text).unwrap();
        let bus = "--bus=can0=slcan:/nowhere";
        let output = can_bridge(&[&[path.to_str().unwrap(), bus], more].concat());
        String::from_utf8(output.stderr).unwrap()
    };
    // Of a comment nothing depends, of the home pose the poses do.
    assert!(commissioned(&format!("# mine\n{}", rig_text()), &[]).contains("/nowhere"));
    let moved = rig_text().replacen("home = [0.0, ", "home = [0.001, ", 1);
    let refused = commissioned(&moved, &[]);
    assert!(refused.contains("poses (the files say something else than then)"), "{refused}");
    assert!(!refused.contains("pull"), "{refused}");
    let skipped = commissioned(&moved, &["--uncommissioned"]);
    assert!(
        skipped.contains("NOT COMMISSIONED, skipped: poses") && skipped.contains("/nowhere"),
        "{skipped}"
    );

    drop(lab);
    let lab = Lab::start();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rig.commissioned.json"), &record).unwrap();
    let mut program = Program::start_commissioned(folder, &lab.device, &[]);
    program.move_away();
    program.tell("release");
    program.until("state", "Safe", None);
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_rig_that_was_not_commissioned_is_not_moved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    fs::write(&path, rig_text()).unwrap();
    let output = can_bridge(&[path.to_str().unwrap(), "--bus=can0=slcan:/nowhere"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("not commissioned: steps are missing: zero (never passed), pull 1"), "{said}");
}

#[test]
fn check_says_what_a_survey_would_tell() {
    let fieldbus = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml");
    let output = can_bridge(&[fieldbus, "--check", ACCURACY]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.contains("of 83 mistakes looked for 83 show"), "{said}");
    let output = can_bridge(&[fieldbus, "--survey", "1"]);
    assert_eq!(output.status.code(), Some(2));
}
