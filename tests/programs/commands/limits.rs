//! What no program reads: files without end, and pipes to which nobody writes.

use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// What every door that takes a text says of this file.
fn refusals(file: &Path) -> Vec<(&'static str, String)> {
    let file = file.to_str().unwrap();
    let [robot, bridge, sim] =
        [env!("CARGO_BIN_EXE_cable-robot"), env!("CARGO_BIN_EXE_can-bridge"), env!("CARGO_BIN_EXE_rig-sim")];
    let akd = "rigs/can/akd.toml";
    let doors: [(&str, &str, &[&str]); 6] = [
        ("scenario", robot, &["simulate", file]),
        ("rig", robot, &["workspace", "--rig", file]),
        ("fieldbus file", bridge, &[file, "--check"]),
        ("goals", bridge, &[akd, "--scenario", file, "--no-realtime", "--bus", "can0=slcan:/dev/null"]),
        ("bench", sim, &[file]),
        ("script", sim, &[akd, "--script", file]),
    ];
    let said = |(name, program, arguments): (&'static str, &str, &[&str])| {
        let output = Command::new(program).args(arguments).current_dir(ROOT).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{name}");
        (name, String::from_utf8(output.stderr).unwrap())
    };
    doors.map(said).into()
}

/// As of a file with holes, which costs nothing: memory ran out, or the disk's cache.
#[test]
fn ten_gigabytes_given_as_a_text_are_refused_with_their_number() {
    let file = tempfile::NamedTempFile::new().unwrap();
    file.as_file().set_len(10_000_000_000).unwrap();
    for (name, said) in refusals(file.path()) {
        assert!(said.contains("it has 10000000000 bytes; at most 67108864 are read"), "{name}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_given_as_a_text_was_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for (name, said) in refusals(&pipe) {
        assert!(said.contains("it is a pipe, to which nobody may ever write"), "{name}: {said}");
    }
}

#[test]
fn ten_gigabytes_given_as_a_controller_are_refused_with_their_number() {
    let file = tempfile::Builder::new().suffix(".fmu").tempfile().unwrap();
    file.as_file().set_len(10_000_000_000).unwrap();
    let mut bridge = Command::new(env!("CARGO_BIN_EXE_can-bridge"));
    bridge.args(["rigs/can/akd.toml", "--check", "--controller"]).arg(file.path()).current_dir(ROOT);
    let said = String::from_utf8(bridge.output().unwrap().stderr).unwrap();
    assert!(said.contains("it has 10000000000 bytes; at most 1073741824 are read"), "{said}");
}
