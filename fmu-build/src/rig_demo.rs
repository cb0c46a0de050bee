//! `cargo demo --rig`: the paper's experiment (Section VII) with `can-bridge` and the packed controller on one side of a
//! pseudo-terminal, `rig-sim` with friction, motor lag and noise on the other.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use cable_robot_report::files::write_whole;
use cable_robot_report::run_folder::{self, RUN_CSV};
use cable_robot_report::{Digest, html};
use serde_json::Value;

use crate::{demo, pack, project_root};

const RIG: &str = "rigs/can/akd.toml";
const SCENARIO: &str = "scenarios/experiment.toml";
/// Those of [`SCENARIO`], but for the noise: at the rates of a CAN bus the cells' amplifiers have to filter it (docs/rig.md, "Limits seen").
const IMPERFECTIONS: [&str; 6] = ["--friction", "0.5", "--motor-lag", "0.005", "--load-cell-noise", "0.01"];
/// The run ends when the robot has rested at the goal for a while.
const REST: Duration = Duration::from_secs(2);
/// A long run goes there and back, with so much time for each way.
const WAY: Duration = Duration::from_secs(8);
const GOALS: [&str; 2] = ["goal 0 0 1", "goal 0.15 0.15 1"];

/// How long, and how often a second.
pub struct Wishes {
    /// Minutes of going there and back; none for one move.
    pub minutes: Option<f64>,
    /// Cycles a second; that of the fieldbus file if there is none.
    pub rate: Option<f64>,
}

/// Builds both programs, runs them, prints what came of it, writes the report.
pub fn run(wishes: &Wishes) -> Result<()> {
    let root = project_root();
    let folder = root.join("target/demo-rig");
    if folder.exists() {
        fs::remove_dir_all(&folder).context("cannot remove the demo before")?;
    }
    run_folder::make(&folder)?;
    pack::build()?;
    build(&root)?;
    let rig_file = folder.join("wishes.toml");
    fs::write(&rig_file, fieldbus_text(&root, wishes)?).context("cannot write the fieldbus file")?;
    let rig = Command::new(root.join("target/release/rig-sim"))
        .arg(&rig_file)
        .args(IMPERFECTIONS)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start rig-sim")?;
    let mut rig = Ended(rig);
    let mut said = BufReader::new(rig.0.stdout.take().context("rig-sim has no output")?).lines();
    let address = said.next().context("rig-sim said nothing")??;
    let bridge = Command::new(root.join("target/release/can-bridge"))
        .current_dir(&root)
        .arg(&rig_file)
        .args(["--controller", "target/fmu/fmi3/CableRobotController.fmu"])
        .args(["--bus", &address, "--scenario", SCENARIO, "--status", "-", "--uncommissioned", "--record"])
        .arg(&folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start can-bridge")?;
    let mut bridge = Ended(bridge);
    let fault = operate(&mut bridge.0, wishes.minutes)?;
    let status = bridge.0.wait()?;
    rig.end()?;
    said.map_while(Result::ok).filter(|line| !line.contains(" s  ")).for_each(|line| println!("{line}"));
    if let Some(fault) = fault {
        bail!("the run ended early: {fault}");
    }
    ensure!(status.success(), "can-bridge ended with {status}");
    report(&folder)
}

/// Builds what the demo runs. What the compiler says is shown only if it fails.
fn build(root: &Path) -> Result<()> {
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args([
            "build",
            "--release",
            "--package",
            "cable-robot-programs",
            "--bin",
            "can-bridge",
            "--bin",
            "rig-sim",
        ])
        .current_dir(root)
        .output()
        .context("cannot start cargo")?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Ok(())
}

/// The example, with another rate if one is wished. A long run bridges a tenth of a second: it measures the machine, and is not
/// to end when that is late for once.
fn fieldbus_text(root: &Path, wishes: &Wishes) -> Result<String> {
    let mut text = fs::read_to_string(root.join(RIG)).context(RIG)?;
    let mut replace = |field: &str, value: String| {
        let line =
            text.lines().find(|line| line.starts_with(field)).context("the fieldbus file lacks a field")?;
        text = text.replacen(line, &format!("{field}{value}"), 1);
        anyhow::Ok(())
    };
    let rig = root.join("rigs/can/lab.toml");
    replace("rig = ", format!("{:?}", rig.display().to_string()))?;
    if let Some(rate) = wishes.rate {
        replace("rate = ", format!("{rate:?}"))?;
    }
    if wishes.minutes.is_some() {
        replace("lost_cycles = ", "25".to_owned())?;
        replace("drive_watchdog = ", "0.5".to_owned())?;
        replace("timeout = ", "0.5".to_owned())?;
        replace("enable = ", "2.0".to_owned())?;
    }
    Ok(text)
}

/// What an operator does: confirms the home pose, keeps enable pressed, gives goals, ends it. The fault if there was one.
fn operate(bridge: &mut Child, minutes: Option<f64>) -> Result<Option<String>> {
    let mut operator = bridge.stdin.take().context("can-bridge has no input")?;
    let status = BufReader::new(bridge.stdout.take().context("can-bridge has no output")?);
    let (mut enabled, mut rested): (Option<Instant>, Option<Instant>) = (None, None);
    let (mut ways, mut fault) = (1, None);
    for line in status.lines() {
        let status: Value = serde_json::from_str(&line?).context("the status of can-bridge")?;
        match status["state"].as_str() {
            Some("Homing" | "TakingUpSlack") => tell(&mut operator, "home")?,
            Some("Ready") => tell(&mut operator, "enable")?,
            Some("Enabled") => {
                tell(&mut operator, "enable")?;
                let since = enabled.get_or_insert_with(Instant::now).elapsed();
                let is_at_goal = status["controller"] == "AtGoal" && since > WAY / 4;
                rested = if is_at_goal { rested.or_else(|| Some(Instant::now())) } else { None };
                let is_over = match minutes {
                    Some(minutes) => since.as_secs_f64() > 60.0 * minutes,
                    None => rested.is_some_and(|rested| rested.elapsed() > REST) || since > 4 * WAY,
                };
                if is_over {
                    tell(&mut operator, "shutdown")?;
                } else if minutes.is_some() && since > ways * WAY {
                    tell(&mut operator, GOALS[(ways + 1) as usize % 2])?;
                    ways += 1;
                }
            }
            Some("Fault") => {
                fault = status["fault"].as_str().map(str::to_owned);
                tell(&mut operator, "shutdown")?;
            }
            _ => {}
        }
    }
    Ok(fault)
}

fn tell(operator: &mut ChildStdin, line: &str) -> Result<()> {
    writeln!(operator, "{line}").context("can-bridge does not listen")
}

/// The recorded run, opened like any other.
fn report(folder: &Path) -> Result<()> {
    let recorded = Digest::read(folder, |file| file)?;
    demo::print(&recorded.summary);
    let page = html(&recorded).with_context(|| folder.join(RUN_CSV).display().to_string())?;
    let path = folder.join("report.html");
    write_whole(&path, |file| file.write_all(page.as_bytes()))?;
    println!("recording: {}; replay it with can-bridge --replay", folder.display());
    println!("report: {}", path.display());
    Ok(())
}

/// A program that does not outlive the demo.
struct Ended(Child);

impl Ended {
    /// As with Ctrl-C, so that it sums up.
    fn end(&mut self) -> Result<()> {
        Command::new("kill").args(["-s", "INT", &self.0.id().to_string()]).status().context("kill")?;
        self.0.wait()?;
        Ok(())
    }
}

impl Drop for Ended {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
