//! `can-bridge` against a simulated rig behind an slcan pseudo-terminal, in real time. Times are those of a busy machine and are
//! never asserted.
#![cfg(target_os = "linux")]

mod lab;
mod survey;

use std::fs;
use std::io::Write;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::State;
use cable_robot_fieldbus::cia402::DriveState;
use cable_robot_fieldbus::simulated::{Bench, Support};
use cable_robot_fieldbus::transport::{Transport, now, pseudo_terminal};
use cable_robot_report::{Digest, RunFolder, html};
use serde_json::Value;

use lab::{Lab, PATIENCE, Program, can_bridge, config, hurry, packed, replay, replay_with, rig_text, send};

#[test]
fn the_papers_move_is_made_recorded_and_replayed_bit_for_bit() {
    let lab = Lab::start();
    let mut program = Program::start(&lab.device, &[]);
    program.move_away();
    program.until("controller", "AtGoal", Some("enable"));
    let there = lab.rig().plant().encoder_pose.position();
    assert!((there - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm() < 0.01, "{there}");
    program.tell("release");
    program.until("state", "Safe", None);
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
    assert!(lab.all_drives_are(DriveState::SwitchOnDisabled));
    print!("{}", program.messages());

    let folder = RunFolder::read(&program.run_folder()).unwrap();
    let table = &folder.table;
    let status = table.column("controller.status").unwrap();
    // With the platform on its cables: at the start it still is on its stand, at the end the operator has let go.
    let (first, last) =
        (status.iter().position(|s| *s == 3.0).unwrap(), status.iter().rposition(|s| *s == 4.0).unwrap());
    for i in 1..=6 {
        let tensions = table.column(&format!("plant.measuredTension[{i}]")).unwrap();
        let least = tensions[first..last].iter().copied().fold(f64::INFINITY, f64::min);
        println!("cable {i}: at least {least:.3} N");
        assert!(least > 0.0, "cable {i}: {least} N");
    }
    assert!(html(&Digest::of(&folder).unwrap()).unwrap().contains("a rig with drives and load cells"));

    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
    println!("{said}");

    // A log that was cut in a line is replayed as far as it goes, one without frames shows nothing.
    let path = program.run_folder().join("frames.log");
    let log = fs::read_to_string(&path).unwrap();
    fs::write(&path, &log[..log.rfind(" T\n").unwrap() - 10]).unwrap();
    let (code, said) = replay(&program.run_folder());
    assert!(code == Some(0) && said.contains("frames.log ends within this cycle"), "{said}");
    fs::write(&path, "").unwrap();
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("frames.log holds none of the frames that cycles.csv tells of"), "{said}");
    fs::write(&path, &log).unwrap();

    // One encoder's count more in one frame, and the replay commands something else.
    let place = log.match_indices(" 182#").nth(600).unwrap().0 + 5 + 4;
    let digit = if log[place..].starts_with('0') { "8" } else { "0" };
    fs::write(&path, format!("{}{digit}{}", &log[..place], &log[place + 1..])).unwrap();
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(4), "{said}");
    assert!(said.contains("differs: "), "{said}");
}

/// A recording of some seconds before anything moves, with this program's own or with another controller.
fn short_recording(more: &[&str]) -> (Lab, Program) {
    let lab = Lab::start();
    let mut program = Program::start(&lab.device, more);
    program.until("state", "Homing", None);
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
    (lab, program)
}

/// A folder of data ran the FMU that its fieldbus.toml named.
#[test]
fn a_recorded_folder_runs_no_code_that_it_names() {
    let (_lab, program) = short_recording(&[]);
    let path = program.run_folder().join("fieldbus.toml");
    let text = fs::read_to_string(&path).unwrap();
    // A library that leaves a trace when it is loaded would be named here; that the file does not even exist is no failure.
    fs::write(
        &path,
        text.replacen(
            "[controller.parameters]",
            "[controller]\nfmu = \"evil.fmu\"\n[controller.parameters]",
            1,
        ),
    )
    .unwrap();
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = replay_with(&program.run_folder(), &["--controller", &packed()]);
    assert!(code == Some(1) && said.contains("own controller: leave out --controller"), "{said}");
}

#[test]
fn a_recording_of_a_packed_controller_is_replayed_with_that_one_only() {
    let (_lab, program) = short_recording(&["--controller", &packed()]);
    let (code, said) = replay(&program.run_folder());
    assert!(code == Some(1) && said.contains("an FMU with sha256:"), "{said}");
    let (code, said) = replay_with(&program.run_folder(), &["--controller", &packed()]);
    assert!(code == Some(0) && said.contains("the same commands"), "{said}");
    let other = packed().replace("fmi3", "fmi2");
    let (code, said) = replay_with(&program.run_folder(), &["--controller", &other]);
    assert!(code == Some(1) && said.contains("an FMU with sha256:"), "{said}");
}

/// "The same commands, bit for bit", exit 0, was said of these.
#[test]
fn nothing_in_a_recording_is_left_unlooked_at() {
    let (_lab, program) = short_recording(&[]);
    let folder = program.run_folder();
    let changed = |name: &str, change: &dyn Fn(&str) -> String| {
        let path = folder.join(name);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, change(&text)).unwrap();
        let outcome = replay(&folder);
        fs::write(&path, text).unwrap();
        outcome
    };
    let (code, said) = replay(&folder);
    assert_eq!(code, Some(0), "{said}");
    let middle = |text: &str| text.lines().nth(text.lines().count() / 2).unwrap().to_owned();
    let (code, said) = changed("frames.log", &|text| format!("{text}\0\0\0"));
    assert!(code == Some(1) && said.contains("something behind the last frame"), "{said}");
    let (code, said) = changed("inputs.csv", &|text| format!("{text}18446744073709551615,release,\n"));
    assert!(code == Some(1) && said.contains("there is no cycle 18446744073709551615"), "{said}");
    let (code, said) = changed("frames.log", &|text| {
        let line = middle(text);
        text.replacen(&line, &line.replacen('(', "(9", 1), 1)
    });
    let is_found =
        |said: &str| said.contains("frames.log: line") || said.contains("does not follow on the cycle");
    assert!(code == Some(1) && is_found(&said), "{said}");
    let (code, said) = changed("cycles.csv", &|text| {
        let line = middle(text);
        text.replacen(&line, &format!("9{line}"), 1)
    });
    // Some seconds more are whole periods: then it is the frames that do not follow, or the bridge, which had no cycle for so long.
    assert!((code == Some(1) && is_found(&said)) || (code == Some(4) && said.contains("differs")), "{said}");
    let (code, said) = changed("cycles.csv", &|text| text.replacen(&middle(text), "nonsense", 1));
    assert!(code == Some(1) && said.contains("cycles.csv"), "{said}");
    fs::remove_file(folder.join("frames.log")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.join("frames.log")).status().unwrap().success());
    let (code, said) = replay(&folder);
    assert!(code == Some(1) && said.contains("frames.log is no regular file"), "{said}");
}

#[test]
fn after_kill_the_drives_stop_by_themselves_and_the_recording_can_be_replayed() {
    let lab = Lab::start();
    let mut program = Program::start(&lab.device, &[]);
    program.move_away();
    // Long enough that every file was handed to the system.
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(2) {
        program.tell("enable");
        thread::sleep(Duration::from_millis(50));
    }
    program.signal("KILL");
    assert_eq!(program.exit_code(), None);
    let begun = Instant::now();
    while lab.rig().motor_tension() != [0.0; 6] {
        assert!(begun.elapsed() < PATIENCE);
        thread::sleep(Duration::from_millis(20));
    }
    assert!(lab.all_drives_are(DriveState::Fault), "their heartbeat consumers (0x1016) act");
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
    // Whole rows only, and the report opens it.
    for name in ["frames.log", "inputs.csv", "cycles.csv", "run.csv"] {
        let text = fs::read_to_string(program.run_folder().join(name)).unwrap();
        assert!(text.ends_with('\n'), "{name} ends with {:?}", text.lines().last());
    }
    RunFolder::read(&program.run_folder()).unwrap();
}

#[test]
fn a_signal_while_moving_leads_to_the_safe_output_and_drives_that_are_off() {
    let lab = Lab::start();
    let mut program = Program::start(&lab.device, &[]);
    program.move_away();
    program.signal("INT");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
    assert!(lab.all_drives_are(DriveState::SwitchOnDisabled));
    let said = program.messages();
    assert!(said.contains("Stopping") && said.contains("Off"), "{said}");
}

/// As a dying shell and the kernel do with SIGHUP, and `timeout` with SIGTERM.
#[test]
fn a_signal_that_comes_twice_at_once_does_not_drop_the_platform() {
    for name in ["HUP", "TERM"] {
        let lab = Lab::start();
        let mut program = Program::start(&lab.device, &[]);
        program.move_away();
        program.signal(name);
        program.signal(name);
        assert_eq!(program.exit_code(), Some(0), "{name}: {}", program.messages());
        assert!(program.messages().contains("Stopping"), "{name}: {}", program.messages());
    }
}

#[test]
fn the_end_of_the_operators_input_lets_the_platform_down() {
    let lab = Lab::start();
    let mut program = Program::start(&lab.device, &[]);
    program.move_away();
    drop(program.child.stdin.take());
    program.until("state", "Lowering", None);
    program.until("state", "Homing", None);
    assert_eq!(lab.rig().support(), Support::Stand);
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
}

#[test]
fn a_link_that_is_gone_is_a_fault_and_a_full_disk_is_none() {
    let mut lab = Lab::start();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("run")).unwrap();
    symlink("/dev/full", folder.path().join("run/frames.log")).unwrap();
    let mut program = Program::start_in(folder, &lab.device, &[]);
    program.move_away();
    // Whoever writes the recording may come to it late.
    let begun = Instant::now();
    while !program.messages().contains("THE RECORDING STOPS, control goes on: No space left") {
        assert!(begun.elapsed() < PATIENCE, "{}", program.messages());
        program.tell("enable");
        thread::sleep(Duration::from_millis(50));
    }
    lab.unplug();
    program.until("state", "Fault", None);
    assert_eq!(program.latest("fault"), "bus 0: the link is gone");
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(5), "{}", program.messages());
}

#[test]
fn a_terminal_that_is_gone_does_not_drop_the_platform() {
    let mut lab = Lab::start();
    let folder = tempfile::tempdir().unwrap();
    let mut program = Program::start_telling(Stdio::piped(), folder, &lab.device, &[]);
    drop(program.child.stderr.take());
    fs::write(program.folder.path().join("stderr"), "nobody reads").unwrap();
    program.move_away();
    program.signal("HUP");
    assert_eq!(program.exit_code(), Some(0));
    assert_eq!(program.latest("fault"), Value::Null);
    lab.unplug();
}

/// A pipe that is full: whatever is written there waits for ever.
#[test]
fn an_output_that_nobody_reads_stops_neither_the_recording_nor_the_end() {
    let lab = Lab::start();
    let folder = tempfile::tempdir().unwrap();
    let (rig, run) = (folder.path().join("rig.toml"), folder.path().join("run"));
    fs::write(&rig, rig_text()).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_can-bridge"))
        .arg(&rig)
        .arg(format!("--bus=can0=slcan:{}", lab.device.display()))
        .arg(format!("--record={}", run.display()))
        .args(["--status", "-", "--uncommissioned"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // More than a pipe holds, each line answered on stderr; the status fills stdout.
    let mut operator = child.stdin.take().unwrap();
    let flood = thread::spawn(move || (0..3000).all(|_| writeln!(operator, "nonsense").is_ok()));
    thread::sleep(Duration::from_secs(10));
    let recorded = || fs::metadata(run.join("cycles.csv")).unwrap().len();
    let before = recorded();
    thread::sleep(Duration::from_secs(3));
    let is_recording = recorded() > before;
    Command::new("kill").arg(child.id().to_string()).status().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(10) {
        thread::sleep(Duration::from_millis(20));
    }
    let ended = child.try_wait().unwrap();
    child.kill().unwrap();
    assert!(is_recording, "cycles.csv stays at {before} bytes");
    assert_eq!(ended.and_then(|status| status.code()), Some(7), "the status stream is not whole");
    flood.join().unwrap();
    let (code, said) = replay(&run);
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_dry_run_computes_beside_another_controller_and_sends_nothing() {
    let (mut adapter, device) = pseudo_terminal().unwrap();
    let sent = Arc::new(AtomicUsize::new(0));
    let (stop, counted) = (Arc::new(AtomicBool::new(false)), Arc::clone(&sent));
    let stopped = Arc::clone(&stop);
    // The other controller and its rig; what it hears is heard by whoever listens.
    let other = thread::spawn(move || {
        hurry();
        let mut bench = Bench::new(config(), PlantParameters::default()).unwrap();
        assert!(bench.run_until(State::Homing, 20.0));
        let mut due = now();
        while !stopped.load(Ordering::Relaxed) {
            due += bench.bridge.config().period;
            while let Ok(Some(_)) = adapter.receive(due) {
                counted.fetch_add(1, Ordering::Relaxed);
            }
            thread::sleep(Duration::from_nanos(due.saturating_sub(now())));
            bench.cycle();
            bench.heard().iter().for_each(|(_, frame)| send(&mut adapter, frame));
        }
    });
    let mut program = Program::start(&device, &["--dry-run"]);
    program.until("state", "Shadow", None);
    program.until("controller", "AtGoal", None);
    thread::sleep(Duration::from_secs(3));
    let tension = program.latest("tension");
    let pulls = tension.as_array().unwrap().iter().map(|u| u.as_f64().unwrap());
    assert!(pulls.clone().sum::<f64>() > 10.0, "what would hold the platform: {tension}");
    program.signal("TERM");
    assert_eq!(program.exit_code(), Some(0), "{}", program.messages());
    stop.store(true, Ordering::Relaxed);
    other.join().unwrap();
    assert_eq!(sent.load(Ordering::Relaxed), 0, "frames sent");
    let (code, said) = replay(&program.run_folder());
    assert_eq!(code, Some(0), "{said}");
    println!("{said}");
}

#[test]
fn an_earlier_recording_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig-file.toml");
    fs::write(&rig, rig_text()).unwrap();
    for name in ["cycles.csv", "run.csv"] {
        let run = folder.path().join(name.replace('.', "-"));
        fs::create_dir(&run).unwrap();
        fs::write(run.join(name), "precious").unwrap();
        // No such bus: it must not even be opened.
        let record = format!("--record={}", run.display());
        let output = can_bridge(&[rig.to_str().unwrap(), "--bus=can0=slcan:/nowhere", &record]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(&format!("already holds a recording ({name})")), "{said}");
        assert_eq!(fs::read_to_string(run.join(name)).unwrap(), "precious");
        assert_eq!(fs::read_dir(&run).unwrap().count(), 1);
    }
}

#[test]
fn check_prints_what_fits_and_a_kilohertz_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let check = |text: &str| {
        let path = folder.path().join("rig.toml");
        fs::write(&path, text).unwrap();
        let output = can_bridge(&[path.to_str().unwrap(), "--check"]);
        let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), said)
    };
    let (code, [said, _]) = check(&rig_text());
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("19 frames, 2005 bits") && said.contains("349 Hz"), "{said}");
    let (code, [_, refused]) = check(&rig_text().replacen("rate = 100.0", "rate = 1000.0", 1));
    assert_eq!(code, Some(3));
    assert!(refused.contains("200.5 %") && refused.contains("349 Hz"), "{refused}");
    for (from, to, expected) in [
        ("forceLoop = true", "forceLop = true", "controller.parameters.forceLop: the controller has "),
        ("forceLoop = true", "forceLoop = 1.0", "controller.parameters.forceLoop = 1: it is a Boolean"),
        ("\"CableLengths\"", "\"Cables\"", "poseSource = Cables: it is one of EncoderPose, CableLengths"),
        ("forceLoop = true", "minTension = 1.0", "minTension = 1 is not allowed: the rig file says it"),
        ("rate = 100.0", "rate = 0.0", "line 7: rate = 0 is not allowed"),
    ] {
        let (code, [_, refused]) = check(&rig_text().replacen(from, to, 1));
        assert_eq!(code, Some(1), "{to}");
        assert!(refused.contains(expected), "{to}: {refused}");
    }
    for (name, expected) in [
        ("CableRobotPlant.fmu", "CableRobotPlant.fmu is a plant, no controller"),
        ("Nothing.fmu", "Nothing.fmu cannot be opened as an FMU: No such file"),
    ] {
        let path = folder.path().join("rig.toml");
        fs::write(&path, rig_text()).unwrap();
        let other = packed().replace("CableRobotController.fmu", name);
        let output = can_bridge(&[path.to_str().unwrap(), "--check", "--controller", &other]);
        let refused = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{name}");
        assert!(refused.contains(expected), "{name}: {refused}");
    }
    let full = fs::File::create("/dev/full").unwrap();
    let rig = folder.path().join("rig.toml");
    fs::write(&rig, rig_text()).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_can-bridge"))
        .arg(&rig)
        .arg("--check")
        .stdout(full)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write to stdout: No space left"), "{said}");
    let wrong = can_bridge(&["--replay", "x", "--check"]);
    assert_eq!(wrong.status.code(), Some(2));
}
