//! Python environments of the project's own, below target/.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::project_root;

/// The environment `target/NAME` with what the file of requirements asks for, made anew when that changes.
pub fn environment(requirements: &Path, name: &str) -> Result<PathBuf> {
    let environment = project_root().join("target").join(name);
    let wanted = std::fs::read_to_string(requirements)
        .with_context(|| format!("cannot read {}", requirements.display()))?;
    let stamp = environment.join("requirements.txt");
    if std::fs::read_to_string(&stamp).ok().as_deref() != Some(&wanted) {
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
        let mut install = Command::new(environment.join("bin/python"));
        run(install.args(["-m", "pip", "install", "--quiet", "--requirement"]).arg(requirements))?;
        std::fs::write(&stamp, wanted)?;
    }
    Ok(environment)
}

/// The environment of the Python tests.
pub fn of_tests() -> Result<PathBuf> {
    environment(&project_root().join("fmpy-tests/requirements.txt"), "python")
}

fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    ensure!(status.success(), "{command:?} ended with {status}");
    Ok(())
}
