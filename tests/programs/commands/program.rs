//! The built `cable-robot`, as a user runs it.

use std::process::{Command, Output};

use serde_json::Value;

/// In the project's folder.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
    command.args(arguments).current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    command
}

pub fn run(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the binary is built")
}

/// What a command that must end with `code` wrote to stdout and stderr.
pub fn written(code: i32, arguments: &[&str]) -> (String, String) {
    let output = run(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{out}\n{err}");
    (out, err)
}

pub fn json(code: i32, arguments: &[&str]) -> Value {
    let (out, _) = written(code, &[arguments, &["--json"]].concat());
    serde_json::from_str(&out).unwrap()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}
