//! Shared libraries: the one that both FMUs carry, and the one of the Modelica package.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use indicatif::ProgressBar;

use crate::project_root;

/// Builds the library of a package, with these features, below `target` and returns its path. What the compiler says is shown only if it fails.
///
/// It has a folder of its own: everything in it is compiled with [`anonymous`] paths, the programs are not.
pub fn build(package: &str, features: &[&str], target: &Path) -> Result<PathBuf> {
    let target = target.join("library");
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // Only a library that is a cdylib and nothing else is optimised across crates; the symbol table is of no use in an FMU.
    command
        .args(["rustc", "--release", "--package", package, "--lib", "--crate-type", "cdylib"])
        .args(["--features", &features.join(",")])
        .arg("--target-dir")
        .arg(&target)
        .env("CARGO_ENCODED_RUSTFLAGS", anonymous()?.join("\x1f"))
        .args(["--", "-C", "strip=symbols"])
        .current_dir(project_root());
    run(&mut command, "building the library")?;
    let name = package.replace('-', "_");
    let name = format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(target.join("release").join(name))
}

/// Flags with which no path of this machine stands in what is compiled: in the texts of panics.
pub fn anonymous() -> Result<Vec<String>> {
    let remapped = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.display());
    Ok(vec![
        remapped(&cargo_home()?.join("registry/src"), "crates"),
        remapped(&project_root(), "cable-robot"),
    ])
}

/// Where cargo keeps the sources of crates.
pub fn cargo_home() -> Result<PathBuf> {
    let home = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo"));
    std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(home)
        .context("neither CARGO_HOME nor HOME is set")
}

/// Runs a compiler. What it says is shown only if it fails.
pub fn run(command: &mut Command, what: &str) -> Result<()> {
    // Shown on a terminal only.
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    spinner.enable_steady_tick(Duration::from_millis(100));
    let output = command.output().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    spinner.finish_and_clear();
    ensure!(output.status.success(), "{what} failed:\n{}", String::from_utf8_lossy(&output.stderr));
    Ok(())
}
