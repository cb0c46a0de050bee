//! `cargo wheel`: the Python package with the FMUs and the command `cable-robot`, to be installed with pip.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cable_robot_fmi::MODELS;
use cable_robot_fmi::describe::VERSIONS;

use crate::platforms::{self, GLIBC};
use crate::{library, pack, project_root, python};

/// The folder of the package, whose sources lie in its folder python.
const PACKAGE: &str = "crates/python";

/// Builds the FMUs and the wheel; its path below target/wheels. For tests a debug build will do.
pub fn build(release: bool) -> Result<PathBuf> {
    let target = project_root().join("target");
    pack::build()?;
    copy_fmus(&target)?;
    let wheels = target.join("wheels").join(if release { "release" } else { "debug" });
    built(&wheels, maturin()?.args(release.then_some("--release")))
}

/// With the FMUs for all platforms, for a C library of Linux as old as theirs; its path below target/platforms/wheels.
pub fn build_for_all() -> Result<PathBuf> {
    pack::build_for_all()?;
    copy_fmus(&platforms::folder())?;
    let mut maturin = maturin()?;
    maturin.env("PATH", platforms::path_with(&platforms::zig()?)).args([
        "--release",
        "--zig",
        "--compatibility",
    ]);
    maturin.arg(format!("manylinux_{}", GLIBC.replace('.', "_")));
    built(&platforms::folder().join("wheels"), &mut maturin)
}

fn maturin() -> Result<Command> {
    let package = project_root().join(PACKAGE);
    let environment = python::environment(&package.join("requirements.txt"), "maturin")?;
    let mut maturin = Command::new(environment.join("bin/maturin"));
    maturin.args(["build", "--quiet"]).current_dir(package);
    Ok(maturin)
}

/// The wheel, alone in this folder.
fn built(wheels: &Path, maturin: &mut Command) -> Result<PathBuf> {
    if wheels.exists() {
        fs::remove_dir_all(wheels).with_context(|| wheels.display().to_string())?;
    }
    library::run(maturin.arg("--out").arg(wheels), "building the wheel")?;
    let mut built = fs::read_dir(wheels).with_context(|| wheels.display().to_string())?;
    Ok(built.next().context("maturin built no wheel")??.path())
}

/// Those of the paper's rig below this folder, to where the package takes its data from.
fn copy_fmus(target: &Path) -> Result<()> {
    let package = project_root().join(PACKAGE).join("python/cable_robot/fmus");
    for version in VERSIONS {
        let folder = package.join(version.name());
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        for model in MODELS {
            let from = pack::path_below(target, model, version);
            let to = folder.join(from.file_name().context("an FMU has a name")?);
            fs::copy(&from, &to)
                .with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
        }
    }
    Ok(())
}
