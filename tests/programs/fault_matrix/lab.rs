//! `can-bridge` and `rig-sim` as processes, joined by a pseudo-terminal, with somebody who keeps enable pressed.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use cable_robot_fieldbus::Nanoseconds;
use serde_json::Value;
use tempfile::TempDir;

use crate::ensure;
use crate::table::count;

/// Whoever waits longer than this waits for nothing. On a machine that stops the programs for some
/// milliseconds now and then, the paper's move of 9 s was seen to take 30 s: each late command turns the
/// platform, and the planner waits at each set point until it is level again.
const PATIENCE: Duration = Duration::from_secs(120);

const PACKED: &str = "target/fmu/fmi3/CableRobotController.fmu";

/// What is different from the example's fieldbus file.
pub struct Setup {
    /// The controller; the packed one if there is none.
    pub fmu: Option<String>,
    /// Files of the recording that are full disks.
    pub full: &'static [&'static str],
    /// What goes wrong from the start, for `rig-sim`.
    pub script: &'static str,
}

/// The two programs at work.
pub struct Lab {
    rig: Child,
    rig_lines: Receiver<String>,
    bridge: Child,
    bridge_lines: Receiver<String>,
    operator: Option<ChildStdin>,
    folder: TempDir,
    /// What the operator wants.
    pub is_pressed: bool,
    /// When the bridge's time was 0.
    start: Option<Instant>,
    /// The last status, and everything that was said.
    pub status: Value,
    pub messages: Vec<String>,
    /// What `rig-sim` said last of each drive.
    drives: BTreeMap<String, String>,
    rig_said: Vec<String>,
}

impl Lab {
    /// Starts both.
    pub fn start(setup: &Setup) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(text)?;
        let (rig_file, script) = (folder.path().join("rig.toml"), folder.path().join("script"));
        std::fs::write(&rig_file, rig_text()?).map_err(text)?;
        std::fs::write(&script, setup.script).map_err(text)?;
        let mut rig = Command::new(env!("CARGO_BIN_EXE_rig-sim"))
            .args([&rig_file, Path::new("--script"), &script])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(text)?;
        let rig_lines = lines(rig.stdout.take());
        let address = rig_lines.recv_timeout(PATIENCE).map_err(|_| "rig-sim said nothing")?;
        let record = folder.path().join("record");
        std::fs::create_dir(&record).map_err(text)?;
        for name in setup.full {
            std::os::unix::fs::symlink("/dev/full", record.join(name)).map_err(text)?;
        }
        let mut bridge = Command::new(env!("CARGO_BIN_EXE_can-bridge"))
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
            .arg(&rig_file)
            .args(["--bus", &address, "--status", "-", "--uncommissioned", "--record"])
            .arg(&record)
            .args(["--controller", setup.fmu.as_deref().unwrap_or(PACKED)])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(text)?;
        Ok(Self {
            rig,
            rig_lines,
            bridge_lines: lines(bridge.stdout.take()),
            operator: bridge.stdin.take(),
            bridge,
            folder,
            is_pressed: true,
            start: None,
            status: Value::Null,
            messages: vec![],
            drives: BTreeMap::new(),
            rig_said: vec![],
        })
    }

    /// Half a second into the paper's move.
    pub fn moving(setup: &Setup) -> Result<Self, String> {
        let mut lab = Self::start(setup)?;
        lab.wait_for("the controller's tensions", |lab| {
            lab.state() == "Enabled"
                && matches!(lab.status["controller"].as_str(), Some("AtGoal" | "Holding"))
        })?;
        lab.tell("goal 0.15 0.15 1");
        lab.wait_for("the robot to move", |lab| lab.status["controller"] == "Moving")?;
        Ok(lab)
    }

    /// A line for the bridge.
    pub fn tell(&mut self, line: &str) {
        // A bridge that has ended is noticed elsewhere.
        let _ = self.operator.as_mut().map(|operator| writeln!(operator, "{line}"));
    }

    /// A line for `rig-sim`.
    pub fn suffer(&mut self, line: &str) {
        let _ = self.rig.stdin.as_mut().map(|input| writeln!(input, "{line}"));
    }

    /// Nobody tells the bridge anything any more.
    pub fn walk_away(&mut self) {
        self.operator = None;
    }

    pub fn signal_bridge(&self, signal: &str) -> Result<(), String> {
        signal_to(&self.bridge, signal)
    }

    /// Seconds since the bridge's start, as its recording counts.
    pub fn now(&self) -> f64 {
        self.start.map_or(0.0, |start| start.elapsed().as_secs_f64())
    }

    /// Reads on until something is so; the operator does what an operator does.
    pub fn wait_for(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) -> Result<(), String> {
        let end = Instant::now() + PATIENCE;
        while !is_so(self) {
            ensure(Instant::now() < end, || format!("waited for {what} in vain: {}", self.story()))?;
            match self.bridge_lines.recv_timeout(Duration::from_millis(20)) {
                Ok(line) => self.take(&line)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(Duration::from_millis(20)),
            }
            for line in self.rig_lines.try_iter() {
                if let Some((drive, state)) =
                    line.split_once(" s  drive ").and_then(|(_, t)| t.split_once(": "))
                {
                    self.drives.insert(drive.to_owned(), state.to_owned());
                }
                self.rig_said.push(line);
            }
        }
        Ok(())
    }

    fn story(&self) -> String {
        format!("{}; {:?}; rig-sim: {:?}", self.status, self.messages, self.rig_said)
    }

    fn take(&mut self, line: &str) -> Result<(), String> {
        let value: Value = serde_json::from_str(line).map_err(|error| format!("{line}: {error}"))?;
        if let Some(message) = value["message"].as_str() {
            self.messages.push(message.to_owned());
            return Ok(());
        }
        if let Some(time) = value["time"].as_f64() {
            let start = Instant::now().checked_sub(Duration::from_secs_f64(time));
            self.start = self.start.min(start).or(start);
        }
        self.status = value;
        match self.status["state"].as_str() {
            Some("Homing" | "TakingUpSlack") => self.tell("home"),
            Some("Ready" | "Enabled") if self.is_pressed => self.tell("enable"),
            _ => {}
        }
        Ok(())
    }

    /// The state of every drive, as `rig-sim` saw it.
    pub fn drives(&self) -> String {
        count(self.drives.values().cloned())
    }

    pub fn all_drives_are(&self, state: &str) -> bool {
        self.drives.len() == 6 && self.drives.values().all(|known| known == state)
    }

    pub fn state(&self) -> &str {
        self.status["state"].as_str().unwrap_or_default()
    }

    /// Waits for the bridge's end.
    pub fn bridge_exit(&mut self) -> Result<ExitStatus, String> {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.bridge.try_wait().map_err(text)? {
                while let Ok(line) = self.bridge_lines.recv_timeout(Duration::from_millis(200)) {
                    self.take(&line)?;
                }
                return Ok(status);
            }
            ensure(Instant::now() < end, || format!("can-bridge does not end: {}", self.story()))?;
            if let Ok(line) = self.bridge_lines.recv_timeout(Duration::from_millis(20)) {
                self.take(&line)?;
            }
        }
    }

    /// Ends `rig-sim`; the longest that a motor followed a command without a newer one.
    pub fn oldest_command(&mut self) -> Result<Nanoseconds, String> {
        signal_to(&self.rig, "TERM")?;
        self.rig.wait().map_err(text)?;
        let rest: Vec<String> = self.rig_lines.iter().collect();
        let line = rest.iter().find_map(|line| line.strip_prefix("oldest command that a motor followed: "));
        let milliseconds = line.and_then(|line| line.strip_suffix(" ms")?.parse::<f64>().ok());
        Ok((milliseconds.ok_or("rig-sim did not sum up")? * 1e6) as Nanoseconds)
    }

    /// Time of the first recorded cycle from `begin` (s) on in one of `states`, s.
    pub fn entered(&self, begin: f64, states: &[&str]) -> Option<f64> {
        let mut cycles = csv::Reader::from_path(self.folder.path().join("record/cycles.csv")).ok()?;
        let column = cycles.headers().ok()?.iter().position(|name| name == "state")?;
        cycles.records().flatten().find_map(|row| {
            let time: f64 = row.get(0)?.parse().ok()?;
            (time >= begin && states.contains(&row.get(column)?)).then_some(time)
        })
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        for child in [&mut self.bridge, &mut self.rig] {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The example, with times that a busy machine can keep and a quick start.
fn rig_text() -> Result<String, String> {
    let mut rig = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml"))
        .map_err(text)?;
    for (from, to) in [
        ("lost_cycles = 4 ", "lost_cycles = 25 "),
        ("timeout = 0.1 ", "timeout = 1.0 "),
        ("drive_watchdog = 0.1 ", "drive_watchdog = 0.5 "),
        ("service = 0.5 ", "service = 2.0 "),
        ("enable = 0.5 ", "enable = 2.0 "),
        ("ramp = 2.0 ", "ramp = 0.3 "),
    ] {
        ensure(rig.contains(from), || format!("the example no longer says {from:?}"))?;
        rig = rig.replacen(from, to, 1);
    }
    let lab = concat!("rig = \"", env!("CARGO_MANIFEST_DIR"), "/../rigs/can/lab.toml\"");
    rig = rig.replacen("rig = \"lab.toml\"", lab, 1);
    Ok(rig)
}

pub fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn signal_to(child: &Child, signal: &str) -> Result<(), String> {
    let status = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().map_err(text)?;
    ensure(status.success(), || format!("kill -s {signal}: {status}"))
}

/// Lines as they come; another thread waits for them.
fn lines(from: Option<impl Read + Send + 'static>) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let lines = from.into_iter().flat_map(|from| BufReader::new(from).lines());
        lines.map_while(Result::ok).all(|line| sender.send(line).is_ok())
    });
    receiver
}
