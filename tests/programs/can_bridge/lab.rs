//! A simulated rig behind a pseudo-terminal, the program under test, and its operator.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use cable_robot::robot::RigFile;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::cia402::DriveState;
use cable_robot_fieldbus::simulated::{Link, Mishap, SimulatedRig};
use cable_robot_fieldbus::transport::{LinkError, Transport, now, pseudo_terminal};
use serde_json::Value;
use tempfile::TempDir;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};

/// Nothing takes this long.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The example at a rate and with limits that a busy machine keeps.
pub fn rig_text() -> String {
    let mut text = include_str!("../../../rigs/can/akd.toml").to_owned();
    for (from, to) in [
        ("rate = 250.0", "rate = 100.0"),
        ("timeout = 0.1 ", "timeout = 2.0 "),
        ("drive_watchdog = 0.1", "drive_watchdog = 1.0"),
        ("enable = 0.5", "enable = 2.0"),
        ("ramp = 2.0", "ramp = 0.5"),
        ("lost_cycles = 4", "lost_cycles = 30"),
        ("cable_speed = 2.0", "cable_speed = 20.0"),
        ("disagreement_time = 0.1", "disagreement_time = 0.5"),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let lab = concat!("rig = \"", env!("CARGO_MANIFEST_DIR"), "/../rigs/can/lab.toml\"");
    text.replacen("rig = \"lab.toml\"", lab, 1)
}

/// The packed controller.
pub fn packed() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/fmu/fmi3/CableRobotController.fmu");
    assert!(Path::new(path).is_file(), "{path} is missing: run `cargo fmu build` first");
    path.to_owned()
}

pub fn config() -> Config {
    Config::parse(&rig_text(), &RigFile::parse(include_str!("../../../rigs/can/lab.toml")).unwrap()).unwrap()
}

/// A simulated rig in a thread, and the device to which its adapter answers.
pub struct Lab {
    rig: Arc<Mutex<SimulatedRig>>,
    pub device: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Lab {
    pub fn start() -> Self {
        Self::start_as(config())
    }

    /// A rig that may be another than the bridge believes.
    pub fn start_as(mut truth: Config) -> Self {
        // The hand is slow: where the machine stalls the bridge for a second no encoder seems to have jumped.
        truth.limits.cable_speed = 2.0;
        let imperfections = PlantParameters {
            friction: 0.2,
            motor_lag: 2e-3,
            load_cell_noise: 0.005,
            ..PlantParameters::default()
        };
        let rig = Arc::new(Mutex::new(SimulatedRig::new(truth, imperfections).unwrap()));
        let (mut adapter, device) = pseudo_terminal().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let (shared, stopped) = (Arc::clone(&rig), Arc::clone(&stop));
        let thread = thread::spawn(move || {
            hurry();
            let (start, mut out) = (now(), vec![]);
            while !stopped.load(Ordering::Relaxed) {
                let came = adapter.receive(now() + 1_000_000);
                let mut rig = shared.lock().unwrap();
                let time = now() - start;
                rig.tick(time, &mut out);
                match came {
                    Ok(Some(received)) => rig.on_frame(0, &received.frame, time, &mut out),
                    Ok(None) => {}
                    // Nobody has opened it yet, or whoever did is gone.
                    Err(error) => {
                        assert_eq!(error, LinkError::Removed);
                        thread::sleep(Duration::from_millis(1));
                    }
                }
                drop(rig);
                out.drain(..).for_each(|(_, frame)| send(&mut adapter, &frame));
            }
        });
        Self { rig, device, stop, thread: Some(thread) }
    }

    /// Something happens, in the words of `rig-sim`.
    pub fn suffer(&self, text: &str) {
        let mishap = Mishap::parse(text, 6).unwrap();
        self.rig().suffer(mishap, &mut Link::new(1), 0, &mut vec![]);
    }

    pub fn rig(&self) -> std::sync::MutexGuard<'_, SimulatedRig> {
        self.rig.lock().unwrap()
    }

    pub fn unplug(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }

    pub fn all_drives_are(&self, state: DriveState) -> bool {
        self.rig().drives.iter().all(|drive| drive.state() == state)
    }
}

/// Waits for room, but not for somebody who does not read.
pub fn send(adapter: &mut impl Transport, frame: &cable_robot_fieldbus::Frame) {
    for _ in 0..200 {
        if adapter.send(frame) != Err(LinkError::BufferFull) {
            return;
        }
        thread::sleep(Duration::from_micros(100));
    }
}

/// A rig does not wait for a busy machine; where that is not allowed it must be quick without.
pub fn hurry() {
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let _ = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, fifo);
}

/// The program under test, its operator, and what it says.
pub struct Program {
    pub child: Child,
    status: Arc<Mutex<Vec<Value>>>,
    pub folder: TempDir,
}

impl Program {
    pub fn start(device: &Path, more: &[&str]) -> Self {
        Self::start_in(tempfile::tempdir().unwrap(), device, more)
    }

    /// Records into `run` in the folder.
    pub fn start_in(folder: TempDir, device: &Path, more: &[&str]) -> Self {
        let stderr = fs::File::create(folder.path().join("stderr")).unwrap();
        Self::start_telling(stderr.into(), folder, device, more)
    }

    pub fn start_telling(stderr: Stdio, folder: TempDir, device: &Path, more: &[&str]) -> Self {
        Self::start_as(stderr, folder, device, &[&["--uncommissioned"], more].concat())
    }

    /// A rig that is to be commissioned, or was.
    pub fn start_commissioned(folder: TempDir, device: &Path, more: &[&str]) -> Self {
        let stderr = fs::File::create(folder.path().join("stderr")).unwrap();
        Self::start_as(stderr.into(), folder, device, more)
    }

    fn start_as(stderr: Stdio, folder: TempDir, device: &Path, more: &[&str]) -> Self {
        let rig = folder.path().join("rig.toml");
        fs::write(&rig, rig_text()).unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_can-bridge"))
            .arg(&rig)
            .arg(format!("--bus=can0=slcan:{}", device.display()))
            .arg(format!("--record={}", folder.path().join("run").display()))
            .args(["--status", "-"])
            .args(more)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(stderr)
            .spawn()
            .unwrap();
        let (lines, status) = (BufReader::new(child.stdout.take().unwrap()).lines(), Arc::default());
        let seen: Arc<Mutex<Vec<Value>>> = Arc::clone(&status);
        thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                seen.lock().unwrap().push(serde_json::from_str(&line).expect("a JSON object a line"));
            }
        });
        Self { child, status, folder }
    }

    pub fn run_folder(&self) -> PathBuf {
        self.folder.path().join("run")
    }

    pub fn messages(&self) -> String {
        fs::read_to_string(self.folder.path().join("stderr")).unwrap()
    }

    pub fn tell(&mut self, command: &str) {
        writeln!(self.child.stdin.as_mut().unwrap(), "{command}").unwrap();
    }

    /// The latest value that the status gives for this key.
    pub fn latest(&self, key: &str) -> Value {
        let status = self.status.lock().unwrap();
        status.iter().rev().find_map(|line| line.get(key)).cloned().unwrap_or_default()
    }

    /// Waits until the status says so, giving `command` again and again.
    pub fn until(&mut self, key: &str, value: &str, command: Option<&str>) {
        let begun = Instant::now();
        while self.latest(key) != value {
            assert!(
                begun.elapsed() < PATIENCE && self.child.try_wait().unwrap().is_none(),
                "{key} is {} and not {value}\n{}",
                self.latest(key),
                self.messages()
            );
            if let Some(command) = command {
                self.tell(command);
            }
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// From power-on to the controller's tensions, and on the paper's way.
    pub fn move_away(&mut self) {
        self.until("state", "Homing", None);
        self.until("state", "TakingUpSlack", Some("home"));
        self.until("state", "Ready", Some("home"));
        self.until("state", "Enabled", Some("enable"));
        self.until("controller", "AtGoal", Some("enable"));
        self.tell("goal 0.15 0.15 1");
        self.until("controller", "Moving", Some("enable"));
    }

    pub fn signal(&self, name: &str) {
        let done =
            Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status().unwrap();
        assert!(done.success());
    }

    pub fn exit_code(&mut self) -> Option<i32> {
        let begun = Instant::now();
        while self.child.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < PATIENCE, "{}", self.messages());
            thread::sleep(Duration::from_millis(20));
        }
        self.child.wait().unwrap().code()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn can_bridge(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_can-bridge")).args(arguments).output().unwrap()
}

pub fn replay(folder: &Path) -> (Option<i32>, String) {
    replay_with(folder, &[])
}

pub fn replay_with(folder: &Path, more: &[&str]) -> (Option<i32>, String) {
    let output = can_bridge(&[&["--replay", folder.to_str().unwrap()], more].concat());
    (
        output.status.code(),
        String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap(),
    )
}
