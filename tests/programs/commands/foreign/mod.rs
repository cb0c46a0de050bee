//! FMUs that crash, hang, end their process, write where they should not, and say what nobody says: nothing is lost, and nothing is taken for success.

use std::env::consts::{ARCH, OS};
use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use cable_robot_report::{Digest, RunFolder, html};
use tempfile::TempDir;

const MOVE_TO: [&str; 6] = ["simulate", "--from", "0,0,1", "--to", "0.05,0,1", "--duration"];

/// What is called otherwise: the steps of a run of half a second, at the time of which `ON_STEP` begins, and the rows until then.
const LATER: &str = "if (time > 0.0995)";
const ROWS: usize = 101;

/// An FMU in a folder of its own.
struct Foreign {
    folder: TempDir,
    fmu: PathBuf,
}

enum Role {
    Plant,
    Controller,
}

/// An FMU in this role, with C in its calls.
fn foreign(role: Role, code: &[(&str, &str)]) -> Foreign {
    foreign_of(&description(role, "Foreign"), code)
}

fn foreign_of(description: &str, code: &[(&str, &str)]) -> Foreign {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("Foreign.so");
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-w", &format!("-I{root}/fmi-headers/2.0"), "-o"]).arg(&library);
    cc.args(code.iter().map(|(call, code)| format!("-D{call}={code}")));
    cc.arg(format!("{root}/tests/programs/commands/foreign/foreign.c"));
    assert!(cc.status().unwrap().success(), "{code:?}");
    let fmu = folder.path().join("foreign.fmu");
    let mut zip = zip::ZipWriter::new(fs::File::create(&fmu).unwrap());
    let platform = if ARCH == "x86_64" { "linux64".to_owned() } else { format!("{ARCH}-{OS}") };
    let binary = (format!("binaries/{platform}/Foreign.so"), fs::read(&library).unwrap());
    for (name, bytes) in [("modelDescription.xml".to_owned(), description.as_bytes().to_vec()), binary] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
    Foreign { folder, fmu }
}

fn description(role: Role, identifier: &str) -> String {
    let (pulls, stands, status) = match role {
        Role::Plant => ("input", "output", ""),
        Role::Controller => (
            "output",
            "input",
            "<ScalarVariable name='status' valueReference='0' causality='output'><Integer/></ScalarVariable>",
        ),
    };
    let number = |(reference, (name, causality)): (usize, (String, &str))| {
        format!(
            "<ScalarVariable name='{name}' valueReference='{reference}' causality='{causality}'><Real/></ScalarVariable>"
        )
    };
    let cables = (1..=6).map(|i| (format!("motorTension[{i}]"), pulls));
    let pose = ["x", "y", "z", "roll", "pitch", "yaw"].map(|axis| (format!("encoderPose.{axis}"), stands));
    let numbers: String = cables.chain(pose).enumerate().map(number).collect();
    format!(
        "<fmiModelDescription fmiVersion='2.0' modelName='Foreign' guid='g'><CoSimulation modelIdentifier='{identifier}'/>\
         <ModelVariables>{numbers}{status}</ModelVariables></fmiModelDescription>"
    )
}

impl Foreign {
    /// A move with it, for so many seconds of simulation; its temporary files lie in its folder.
    fn command(&self, duration: &str, more: &[&str]) -> Command {
        let temporary = self.folder.path().join("temporary");
        fs::create_dir_all(&temporary).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        command.args(MOVE_TO).args([duration, "--fmu"]).arg(&self.fmu).args(more).env("TMPDIR", temporary);
        command
    }

    /// How half a second with it ends, the run in a folder: what was said, and the rows.
    fn ends(&self, code: i32, more: &[&str]) -> (String, usize) {
        let run = self.run();
        let mut command = self.command("0.5", more);
        let (out, said) = ended(command.arg("--output").arg(&run).output().unwrap(), code);
        assert!(out.is_empty(), "{out}");
        (said, RunFolder::read(&run).unwrap().table.rows())
    }

    fn run(&self) -> PathBuf {
        self.folder.path().join("run")
    }

    /// Names of what lies in the folder for temporary files.
    fn temporary(&self) -> Vec<PathBuf> {
        fs::read_dir(self.folder.path().join("temporary"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect()
    }
}

fn ended(output: Output, code: i32) -> (String, String) {
    let [out, said] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(code), "{out}\n{said}");
    (out, said)
}

fn wait_until(mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn an_fmu_that_crashes_loses_no_row() {
    let crashing = foreign(Role::Plant, &[("ON_STEP", &format!("{LATER} *(volatile int *)0 = 1"))]);
    let (said, rows) = crashing.ends(5, &[]);
    let sentence = "cable-robot: the plant stopped at 0.1 s: plant: the step from 0.1 s by 0.001 s: the FMU's process crashed (signal: 11 (SIGSEGV)";
    assert!(said.contains(sentence) && rows == ROWS, "{said}{rows} rows");
    assert!(said.contains("slack cables"), "the summary of what there is: {said}");
    let (out, _) = ended(crashing.command("0.5", &[]).output().unwrap(), 5);
    assert_eq!(out.lines().count(), 1 + ROWS, "to stdout as well");
    assert_eq!(crashing.temporary(), Vec::<PathBuf>::new(), "nothing is left of the unpacked FMU");
}

#[test]
fn an_fmu_that_ends_its_process_is_no_success() {
    let ended_itself = "the FMU ended its process by itself (exit status: 0)";
    let (said, rows) = foreign(Role::Plant, &[("ON_STEP", &format!("{LATER} exit(0)"))]).ends(5, &[]);
    assert!(said.contains(ended_itself) && rows == ROWS, "{said}{rows} rows");
    let forking =
        format!("{LATER} {{ if (fork() == 0) {{ close(1); close(2); sleep(30); _exit(0); }} exit(0); }}");
    let begun = Instant::now();
    let (said, rows) = foreign(Role::Plant, &[("ON_STEP", &forking)]).ends(5, &[]);
    assert!(said.contains(ended_itself) && rows == ROWS, "{said}{rows} rows");
    assert!(begun.elapsed() < Duration::from_secs(20), "what it has started holds the socket open");
    for call in ["ON_LOAD", "ON_INSTANTIATE"] {
        let ending = foreign(Role::Plant, &[(call, "exit(0)")]);
        let (out, said) = ended(ending.command("0.5", &[]).output().unwrap(), 5);
        let sentence = format!("cable-robot: plant: instantiating: {ended_itself}\n");
        assert_eq!((out.as_str(), said), ("", sentence), "{call}");
    }
}

#[test]
fn an_fmu_that_hangs_is_given_up_with_its_rows() {
    for hang in ["hang()", "for (;;)", "for (;;) complain(\"again\")"] {
        let hanging = foreign(Role::Controller, &[("ON_STEP", &format!("{LATER} {hang}"))]);
        let (said, rows) = hanging.ends(6, &["--fmu-timeout", "0.5"]);
        let sentence = "the FMU did not return within 0.5 s; its process was killed";
        assert!(said.contains(sentence) && rows == ROWS, "{said}{rows} rows");
        assert_eq!(hanging.temporary(), Vec::<PathBuf>::new());
    }
    let hanging = foreign(Role::Plant, &[("ON_LOAD", "hang()")]);
    let (_, said) = ended(hanging.command("0.5", &["--fmu-timeout", "0.5"]).output().unwrap(), 6);
    assert!(said.starts_with("cable-robot: plant: instantiating: the FMU did not return"), "{said}");
}

#[test]
fn the_first_ctrl_c_ends_a_run_whose_fmu_hangs_and_keeps_its_rows() {
    let hanging = foreign(Role::Plant, &[("ON_STEP", &format!("{LATER} hang()"))]);
    let mut command = hanging.command("0.5", &[]);
    let child = command.arg("--output").arg(hanging.run()).stderr(Stdio::piped()).spawn().unwrap();
    let rows = || RunFolder::read(&hanging.run()).map_or(0, |run| run.table.rows());
    wait_until(|| rows() == ROWS);
    signal(&child, "-INT");
    let begun = Instant::now();
    let (_, said) = ended(child.wait_with_output().unwrap(), 130);
    assert!(begun.elapsed() < Duration::from_secs(10), "not the minute that a call may take");
    assert!(said.ends_with("interrupted: 0.5 s were to be simulated\n") && rows() == ROWS, "{said}");
}

#[test]
fn an_fmu_that_hangs_while_it_is_freed_loses_no_finished_run() {
    let (said, rows) = foreign(Role::Plant, &[("ON_FREE", "hang()")]).ends(0, &["--fmu-timeout", "0.5"]);
    assert!(
        said.contains("\nplant: freeing: the FMU did not return within 0.5 s; its process was killed\n"),
        "{said}"
    );
    assert_eq!(rows, 501);
}

/// A process that ends at once, as if its power were cut.
#[test]
fn a_killed_program_leaves_whole_rows_and_no_process() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("pid");
    let step = format!("{LATER} {{ leave(\"{}\"); hang(); }}", place.display());
    let hanging = foreign(Role::Plant, &[("ON_STEP", &step)]);
    let mut command = hanging.command("0.5", &[]);
    let child = command.arg("--output").arg(hanging.run()).stderr(Stdio::piped()).spawn().unwrap();
    let pid = || fs::read_to_string(&place).ok().filter(|pid| !pid.is_empty());
    wait_until(|| pid().is_some());
    assert_ne!(pid().unwrap(), child.id().to_string(), "the FMU has a process of its own");
    let unpacked = hanging.temporary();
    assert_eq!(unpacked.len(), 1);
    let mode = fs::metadata(&unpacked[0]).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o700, "nobody else may look into it");
    signal(&child, "-KILL");
    child.wait_with_output().unwrap();
    assert_eq!(RunFolder::read(&hanging.run()).unwrap().table.rows(), ROWS);
    wait_until(|| !Path::new("/proc").join(pid().unwrap()).exists());

    // The lock tells that nobody uses what is left, once it is a minute old.
    let lock = fs::File::open(unpacked[0].join(".lock")).unwrap();
    lock.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
    let next = foreign(Role::Plant, &[]);
    let mut command = next.command("0.5", &["--json"]);
    ended(command.env("TMPDIR", unpacked[0].parent().unwrap()).output().unwrap(), 0);
    assert_eq!(hanging.temporary(), Vec::<PathBuf>::new(), "the next run clears it away");
}

#[test]
fn what_an_fmu_prints_and_reads_is_not_in_the_way_of_the_rows() {
    let printing = foreign(
        Role::Plant,
        &[("ON_STEP", "{ puts(\"printed\"); fflush(stdout); if (getchar() != EOF) abort(); }")],
    );
    let (out, said) = ended(printing.command("0.5", &[]).output().unwrap(), 0);
    assert!(out.lines().count() == 502 && !out.contains("printed"), "{out}");
    assert_eq!(said.matches("printed\n").count(), 500);
}

/// With its last words, however it ends.
#[test]
fn what_an_fmu_prints_commands_no_terminal() {
    let step = format!(
        "{LATER} {{ printf(\"\\033]0;owned\\007\"); fflush(stdout); fputs(\"\\033[2J\\377\", stderr); exit(0); }}"
    );
    let (said, rows) = foreign(Role::Plant, &[("ON_STEP", &step)]).ends(5, &[]);
    assert!(said.contains(r"\u001b]0;owned\u0007\u001b[2J") && rows == ROWS, "{said}");
    assert_eq!(said.chars().find(|c| c.is_control() && *c != '\n'), None, "{said:?}");
}

#[test]
fn an_fmu_that_writes_into_every_file_does_no_harm() {
    for garbage in ["\\377\\377\\377\\377 a length of four gigabytes", "\\004\\0\\0\\0\\377\\377\\377\\377"] {
        let step = format!("{LATER} for (int fd = 3; fd < 100; fd++) write(fd, \"{garbage}\", 20)");
        let (said, rows) = foreign(Role::Plant, &[("ON_STEP", &step)]).ends(5, &[]);
        assert!(said.ends_with("the FMU's process sent no answer but something else\n"), "{said}");
        assert_eq!(rows, ROWS);
    }
}

#[test]
fn escape_sequences_of_an_fmu_and_of_a_title_do_not_reach_the_terminal() {
    let step = format!("{LATER} {{ complain(\"\\033]0;owned\\007\"); return fmi2Error; }}");
    let (said, _) = foreign(Role::Plant, &[("ON_STEP", &step)]).ends(1, &[]);
    assert!(said.contains(r"plant: \u001b]0;owned\u0007"), "{said}");
    assert!(said.contains(r#"gave Error: "\u001b]0;owned\u0007""#), "{said}");
    let name = description(Role::Plant, "Foreign").replace("motorTension[1]", "motorTension[1]&#27;[2J");
    let named = foreign_of(&name.replace("modelIdentifier='", "modelIdentifier='&#155;"), &[]);
    let (_, refused) = ended(named.command("0.5", &[]).output().unwrap(), 1);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("title.toml");
    fs::write(&file, "title = \"\\u001b]0;owned\\u0007\\u009b2J\"\nduration = 0.1\n").unwrap();
    let titled = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        ended(command.args(["simulate", file.to_str().unwrap()]).args(more).output().unwrap(), 0)
    };
    let ((_, text), (json, _)) = (titled(&[]), titled(&["--json"]));
    assert!(text.starts_with(r"\u001b]0;owned\u0007\u009b2J"), "{text}");
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found["title"], "\u{1b}]0;owned\u{7}\u{9b}2J");
    for shown in [said, refused, text, json] {
        let sent = shown.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(sent, None, "{shown:?}");
    }
}

#[test]
fn a_status_that_nobody_knows_is_shown_as_the_number() {
    let strange = foreign(Role::Controller, &[("ON_INSTANTIATE", "whole = 99999")]);
    let run = strange.run();
    let mut command = strange.command("0.5", &["--json"]);
    let (json, text) = ended(command.arg("--output").arg(&run).output().unwrap(), 0);
    assert!(text.contains("at the end, 0.500 s: unknown status 99999"), "{text}");
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found["status"], "unknown status 99999");
    let recorded = RunFolder::read(&run).unwrap();
    assert!(recorded.table.column("controller.status").unwrap().iter().all(|status| *status == 99999.0));
    let page = html(&Digest::of(&recorded).unwrap()).unwrap();
    assert!(page.contains("status at the end <b>unknown status 99999</b>"));
}

#[test]
fn a_model_identifier_that_is_a_path_loads_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = folder.path().join("loaded");
    let code = format!("leave(\"{}\")", loaded.display());
    let outside = foreign(Role::Plant, &[("ON_LOAD", &code)]);
    let library = outside.folder.path().join("Foreign");
    let path = format!("../../../../../../../../../..{}", library.display());
    let climbing = foreign_of(&description(Role::Plant, &path), &[]);
    let (_, said) = ended(climbing.command("0.5", &[]).output().unwrap(), 1);
    assert!(said.contains("it must be letters, digits and _, no digit first: it names the binary"), "{said}");
    assert!(!loaded.exists());
    ended(outside.command("0.5", &["--json"]).output().unwrap(), 0);
    assert!(loaded.exists(), "in its own archive it is loaded");
}

#[test]
fn a_worker_that_nobody_started_as_one_says_so() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
    let (_, said) = ended(command.arg("fmu-worker").stdin(Stdio::null()).output().unwrap(), 1);
    assert_eq!(said, "cable-robot: fmu-worker: stdin is no socket: other programs start this one\n");
}

#[test]
fn a_rig_of_a_hundred_thousand_cables_is_refused_with_its_number() {
    let rig = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml")).unwrap();
    let at = rig.find("[[cables]]").unwrap();
    let end = rig[at + 1..].find("[[cables]]").unwrap() + at + 1;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("many.toml");
    fs::write(&file, rig[..at].to_owned() + &rig[at..end].repeat(100_000)).unwrap();
    for command in [&["workspace", "--rig"][..], &["certify", "--from", "0,0,1", "--to", "0.1,0,1", "--rig"]]
    {
        let mut program = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        let output = program.args(command).arg(&file).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("100000 cables: at most 16 are supported"), "{said}");
    }
}
