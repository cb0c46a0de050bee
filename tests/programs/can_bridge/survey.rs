//! `can-bridge --survey`: a person places the platform, the program says what is wrong with the files.

use std::thread;
use std::time::{Duration, Instant};

use cable_robot::robot::Pose;
use cable_robot_fieldbus::Config;

use super::lab::{Lab, PATIENCE, Program, can_bridge, config, replay};

const ACCURACY: &str = "--survey=0.001,0.002";

/// The pose that the last message asks for, as `rig-sim` writes it.
fn asked(messages: &str) -> Option<String> {
    let (_, asked) = messages.rsplit_once("put the platform at ")?;
    let (position, rest) = asked.split_once(", yaw ")?;
    let yaw: f64 = rest.split(',').next()?.parse().ok()?;
    Some(format!("place {position} 0 0 {}", yaw.to_radians()))
}

/// Through the whole survey of a rig. Exit code and messages.
fn survey(truth: Config) -> (Option<i32>, String, Program) {
    let lab = Lab::start_as(truth);
    let mut program = Program::start(&lab.device, &[ACCURACY]);
    program.until("state", "Homing", None);
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
            if !moves(&lab) {
                program.tell("placed");
                thread::sleep(Duration::from_millis(500));
            }
        }
    }
    program.tell("enable");
    program.tell("shutdown");
    let code = program.exit_code();
    (code, program.messages(), program)
}

fn moves(lab: &Lab) -> bool {
    let pose = || lab.rig().plant().encoder_pose;
    let before = pose();
    thread::sleep(Duration::from_millis(100));
    pose() != before
}

#[test]
fn a_survey_of_a_rig_that_stands_elsewhere_names_what_is_wrong_and_never_enables() {
    let truth = Config { home: Pose::at(0.05, 0.0, 1.0), ..config() };
    let (code, said, program) = survey(truth);
    print!("{said}");
    assert_eq!(code, Some(8), "{said}");
    assert!(said.contains("THE FILES ARE WRONG") && said.contains("home, x: +"), "{said}");
    assert!(said.contains("refused: ") && !said.contains("Enabled\n"), "{said}");
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_survey_of_a_rig_that_is_as_its_files_say_ends_well() {
    let (code, said, _) = survey(config());
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("agree as the files say"), "{said}");
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
