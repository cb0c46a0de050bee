//! The programs themselves: signals, killing, a link that goes, a controller that fails, a disk that is full.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use cable_robot_fieldbus::Nanoseconds;

use crate::lab::{Lab, Setup, text};
use crate::table::Row;
use crate::{Case, ensure};

const USUAL: Setup = Setup { fmu: None, full: &[], script: "" };
/// Of the fieldbus file that [`Lab`] uses.
const WATCHDOG: Nanoseconds = 500_000_000;
/// Between two steps of `rig-sim`, a cycle, and a heartbeat that came with an earlier cycle than the last torque.
const GRAIN: Nanoseconds = 30_000_000;

/// All of them.
pub fn cases() -> Vec<Case> {
    type Run = fn(&str) -> Result<Row, String>;
    let cases: [(&'static str, Run); 10] = [
        ("SIGTERM", |name| {
            asked(name, |lab| lab.signal_bridge("TERM"), "the program ends: to the safe output", 0)
        }),
        ("operator lets go", |name| {
            asked(
                name,
                |lab| {
                    lab.tell("release");
                    lab.is_pressed = false;
                    Ok(())
                },
                "the operator let go: to the safe output",
                0,
            )
        }),
        ("operator's input ends", |name| {
            asked(
                name,
                |lab| {
                    lab.walk_away();
                    Ok(())
                },
                "the operator wants the platform down: to the safe output",
                0,
            )
        }),
        ("drive fault with EMCY", |name| {
            asked(
                name,
                |lab| {
                    lab.suffer("drive 5 emcy 0x2310");
                    Ok(())
                },
                "to the safe output, since node 5",
                5,
            )
        }),
        ("link removed: terminal hangs up", |name| {
            asked(
                name,
                |lab| {
                    lab.suffer("hang-up");
                    Ok(())
                },
                "to the safe output, since bus 0: the link is gone",
                5,
            )
        }),
        ("bridge stopped for 0.3 s (overrun)", |name| {
            asked(name, stopped_for_a_while, "to the safe output, since no cycle for", 5)
        }),
        ("FMU returns Error", |name| {
            controller_fails(name, "-DANSWERS_ERROR", "to the safe output, since the controller failed")
        }),
        ("FMU returns NaN", |name| {
            controller_fails(name, "-DANSWERS_NAN", "to the safe output, since the controller asks for NaN N")
        }),
        ("kill -9", killed),
        ("log disk full", disk_full),
    ];
    cases
        .into_iter()
        .map(|(name, run)| Case { name, kind: "programs", run: Box::new(move || run(name)) })
        .collect()
}

/// Something ends the controller's tensions; the safe output follows, and after SIGTERM the program ends with `exit`.
fn asked(
    name: &str,
    happens: impl FnOnce(&mut Lab) -> Result<(), String>,
    said: &str,
    exit: i32,
) -> Result<Row, String> {
    ends(name, Lab::moving(&USUAL)?, happens, said, exit)
}

fn ends(
    name: &str,
    mut lab: Lab,
    happens: impl FnOnce(&mut Lab) -> Result<(), String>,
    said: &str,
    exit: i32,
) -> Result<Row, String> {
    let begin = lab.now();
    happens(&mut lab)?;
    lab.wait_for("the safe output", |lab| matches!(lab.state(), "Safe" | "Fault" | "Lowering" | "Off"))?;
    let line = lab.messages.iter().find(|line| line.starts_with(said)).cloned();
    let line = line.ok_or_else(|| format!("{said:?} was not said, but {:?}", lab.messages))?;
    // The link may be gone, and then the drives see to it themselves.
    let since = lab.now();
    lab.wait_for("the drives' watchdogs", |lab| lab.now() > since + 1.0)?;
    let drives = lab.drives();
    // A second signal would cut the torque off.
    if name != "SIGTERM" {
        lab.signal_bridge("TERM")?;
    }
    let status = lab.bridge_exit()?;
    ensure(status.code() == Some(exit), || format!("ended with {status}, not {exit}: {:?}", lab.messages))?;
    let time = |states: &[&str]| Some(((lab.entered(begin, states)? - begin).max(0.0) * 1e9) as Nanoseconds);
    let (ended, safe) = (time(&["Stopping", "Safe", "Fault", "Off"]), time(&["Safe", "Fault", "Off"]));
    let oldest = lab.oldest_command()?;
    ensure(oldest <= WATCHDOG + GRAIN, || {
        format!("a motor followed a command for {} ms", oldest / 1_000_000)
    })?;
    Ok(Row {
        name: name.to_owned(),
        stated: "1 cycle, not asserted".to_owned(),
        ended,
        safe,
        oldest: Some(oldest),
        drives,
        down: "-".to_owned(),
        exit: status.code(),
        line,
    })
}

fn stopped_for_a_while(lab: &mut Lab) -> Result<(), String> {
    lab.signal_bridge("STOP")?;
    std::thread::sleep(Duration::from_millis(300));
    lab.signal_bridge("CONT")
}

/// The packed controller, until a file appears.
fn controller_fails(name: &str, how: &str, said: &str) -> Result<Row, String> {
    let folder = tempfile::tempdir().map_err(text)?;
    let flag = folder.path().join("fails");
    let fmu = failing_fmu(folder.path(), &flag, how)?;
    let lab = Lab::moving(&Setup { fmu: Some(fmu.display().to_string()), ..USUAL })?;
    ends(name, lab, |_| std::fs::write(&flag, "").map_err(text), said, 5)
}

/// The packed controller behind a library that lets it work as long as there is no `flag`.
fn failing_fmu(folder: &Path, flag: &Path, how: &str) -> Result<PathBuf, String> {
    let packed = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/fmu/fmi3/CableRobotController.fmu");
    let archive = std::fs::File::open(packed)
        .map_err(|error| format!("{packed}: {error}: run `cargo fmu build` first"))?;
    let inside = folder.join("fmu");
    zip::ZipArchive::new(archive).and_then(|mut archive| archive.extract(&inside)).map_err(text)?;
    let binaries = inside.join(format!("binaries/{}-linux", std::env::consts::ARCH));
    let library = binaries.join("CableRobotController.so");
    std::fs::rename(&library, binaries.join("packed.so")).map_err(text)?;
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", how, &format!("-DFLAG=\"{}\"", flag.display()), "-o"])
        .arg(&library)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/programs/fault_matrix/failing.c"))
        .arg(format!("-L{}", binaries.display()))
        .args(["-Wl,--no-as-needed", "-l:packed.so", "-Wl,-rpath,$ORIGIN"])
        .status()
        .map_err(text)?;
    ensure(status.success(), || format!("cc: {status}"))?;
    let fmu = folder.join("CableRobotController.fmu");
    let mut writer = zip::ZipWriter::new(std::fs::File::create(&fmu).map_err(text)?);
    let packed = ["CableRobotController.so", "packed.so"]
        .map(|file| (format!("binaries/{}-linux/{file}", std::env::consts::ARCH), binaries.join(file)));
    let description = ("modelDescription.xml".to_owned(), inside.join("modelDescription.xml"));
    for (name, file) in packed.into_iter().chain([description]) {
        writer.start_file(name, zip::write::SimpleFileOptions::default()).map_err(text)?;
        std::io::Write::write_all(&mut writer, &std::fs::read(file).map_err(text)?).map_err(text)?;
    }
    writer.finish().map_err(text)?;
    Ok(fmu)
}

/// Nothing is left to act but the drives.
fn killed(name: &str) -> Result<Row, String> {
    let mut lab = Lab::moving(&USUAL)?;
    lab.signal_bridge("KILL")?;
    let status = lab.bridge_exit()?;
    ensure(status.signal() == Some(9), || format!("ended with {status}"))?;
    lab.wait_for("the drives to stop by themselves", |lab| lab.all_drives_are("Fault"))?;
    let drives = lab.drives();
    let oldest = lab.oldest_command()?;
    ensure(oldest <= WATCHDOG + GRAIN, || {
        format!("a motor followed a command for {} ms", oldest / 1_000_000)
    })?;
    Ok(Row {
        name: name.to_owned(),
        stated: format!("{} ms", WATCHDOG / 1_000_000),
        ended: Some(oldest),
        safe: Some(oldest),
        oldest: Some(oldest),
        drives,
        down: "-".to_owned(),
        exit: None,
        line: "none".to_owned(),
    })
}

/// The recording ends; the robot does not.
fn disk_full(name: &str) -> Result<Row, String> {
    let mut lab = Lab::moving(&Setup { full: &["frames.log"], ..USUAL })?;
    lab.wait_for("the move", |lab| lab.status["controller"] == "AtGoal")?;
    ensure(lab.state() == "Enabled", || format!("in {}", lab.state()))?;
    let drives = lab.drives();
    let line = lab.messages.iter().find(|line| line.starts_with("THE RECORDING STOPS")).cloned();
    let line = line.ok_or_else(|| format!("nothing was said of the disk, but {:?}", lab.messages))?;
    lab.signal_bridge("TERM")?;
    let status = lab.bridge_exit()?;
    ensure(status.code() == Some(7), || format!("ended with {status}, not 7"))?;
    let oldest = Some(lab.oldest_command()?);
    let stated = "goes on".to_owned();
    Ok(Row {
        name: name.to_owned(),
        stated,
        ended: None,
        safe: None,
        oldest,
        drives,
        down: "-".to_owned(),
        exit: status.code(),
        line,
    })
}
