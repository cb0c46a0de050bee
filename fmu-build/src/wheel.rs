//! `cargo wheel`: the Python package with the FMUs and the command `cable-robot`, to be installed with pip.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cable_robot_fmi::MODELS;
use cable_robot_fmi::describe::VERSIONS;

use crate::{library, pack, project_root, python};

/// The folder of the package, whose sources lie in its folder python.
const PACKAGE: &str = "crates/python";

/// Builds the FMUs and the wheel; its path below target/wheels. For tests a debug build will do.
pub fn build(release: bool) -> Result<PathBuf> {
    let (root, package) = (project_root(), project_root().join(PACKAGE));
    pack::build()?;
    copy_fmus(&package.join("python/cable_robot/fmus"))?;
    let environment = python::environment(&package.join("requirements.txt"), "maturin")?;
    let wheels = root.join("target/wheels").join(if release { "release" } else { "debug" });
    if wheels.exists() {
        fs::remove_dir_all(&wheels).with_context(|| wheels.display().to_string())?;
    }
    let mut maturin = Command::new(environment.join("bin/maturin"));
    maturin.args(["build", "--quiet", "--out"]).arg(&wheels).current_dir(package);
    maturin.args(release.then_some("--release"));
    library::run(&mut maturin, "building the wheel")?;
    let mut built = fs::read_dir(&wheels).with_context(|| wheels.display().to_string())?;
    Ok(built.next().context("maturin built no wheel")??.path())
}

/// Those of the paper's rig, where the package takes its data from.
fn copy_fmus(folder: &Path) -> Result<()> {
    for version in VERSIONS {
        let folder = folder.join(version.name());
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        for model in MODELS {
            let from = pack::path(model, version);
            let to = folder.join(from.file_name().context("an FMU has a name")?);
            fs::copy(&from, &to)
                .with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
        }
    }
    Ok(())
}
