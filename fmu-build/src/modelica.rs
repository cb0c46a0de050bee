//! `cargo modelica`: the Modelica package with its library, ready to be opened by a Modelica tool.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::{library, project_root};

/// Copies the package to target/modelica, builds its library into it, and returns where it is.
pub fn build() -> Result<PathBuf> {
    let root = project_root();
    let (from, to) = (root.join("modelica/CableRobot"), root.join("target/modelica/CableRobot"));
    if to.exists() {
        fs::remove_dir_all(&to).with_context(|| format!("cannot empty {}", to.display()))?;
    }
    copy(&from, &to)?;
    let folder = match std::env::consts::OS {
        "linux" => "linux64",
        "windows" => "win64",
        other => bail!("no name is agreed on for the libraries of {other}"),
    };
    let library = library::build("cable-robot-modelica", &root.join("target"))?;
    let place = to.join("Resources/Library").join(folder);
    fs::create_dir_all(&place).with_context(|| format!("cannot make {}", place.display()))?;
    let name = format!("{}CableRobot{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    fs::copy(&library, place.join(name)).with_context(|| format!("cannot copy {}", library.display()))?;
    let licences = to.join("Resources/Licenses");
    fs::create_dir_all(&licences)?;
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(root.join(name), licences.join(name)).with_context(|| format!("cannot copy {name}"))?;
    }
    Ok(to)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    for entry in fs::read_dir(from).with_context(|| format!("cannot read {}", from.display()))? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), &target).with_context(|| format!("cannot write {}", target.display()))?;
        }
    }
    Ok(())
}
