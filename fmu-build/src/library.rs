//! Shared libraries: the one that both FMUs carry, and the one of the Modelica package.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use indicatif::ProgressBar;

use crate::project_root;

/// Builds the library of a package below `target` and returns its path. What the compiler says is shown only if it fails.
pub fn build(package: &str, target: &Path) -> Result<PathBuf> {
    // Shown on a terminal only.
    let spinner = ProgressBar::new_spinner().with_message("building the library");
    spinner.enable_steady_tick(Duration::from_millis(100));
    // Only a library that is a cdylib and nothing else is optimised across crates; the symbol table is of no use in an FMU.
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["rustc", "--release", "--package", package, "--lib", "--crate-type", "cdylib"])
        .arg("--target-dir")
        .arg(target)
        .args(["--", "-C", "strip=symbols"])
        .current_dir(project_root())
        .output()
        .context("cannot start cargo")?;
    spinner.finish_and_clear();
    if !output.status.success() {
        bail!("the library does not build:\n{}", String::from_utf8_lossy(&output.stderr));
    }
    let name = package.replace('-', "_");
    let name = format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(target.join("release").join(name))
}
