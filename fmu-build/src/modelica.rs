//! `cargo modelica`: the Modelica package with its library, ready to be opened by a Modelica tool.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::platforms::{self, PLATFORMS};
use crate::{check, library, project_root};

/// The package of the library.
const LIBRARY: &str = "cable-robot-modelica";

/// Copies the package to target/modelica with a library for this machine, and returns where it is.
pub fn build() -> Result<PathBuf> {
    let to = package(&project_root().join("target/modelica"))?;
    let folder = match std::env::consts::OS {
        "linux" => "linux64",
        "windows" => "win64",
        other => bail!("no name is agreed on for the libraries of {other}"),
    };
    let library = library::build(LIBRARY, &[], &project_root().join("target"))?;
    let name = format!("{}CableRobot{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    place(&library, &to, folder, &name)?;
    Ok(to)
}

/// The same with libraries for x86_64 Linux and Windows, in target/platforms/modelica.
pub fn build_for_all() -> Result<PathBuf> {
    let to = package(&platforms::folder().join("modelica"))?;
    for platform in PLATFORMS.iter().filter(|platform| platform.target.starts_with("x86_64")) {
        let library = platform.build_library(LIBRARY, "libCableRobot.so")?;
        if platform.is_windows() {
            place(&library, &to, "win64", "CableRobot.dll")?;
            import_library(&library, &to.join("Resources/Library/win64"))?;
        } else {
            place(&library, &to, "linux64", "libCableRobot.so")?;
        }
    }
    Ok(to)
}

/// The package without library, in a folder.
fn package(folder: &Path) -> Result<PathBuf> {
    let (from, to) = (project_root().join("modelica/CableRobot"), folder.join("CableRobot"));
    if to.exists() {
        fs::remove_dir_all(&to).with_context(|| format!("cannot empty {}", to.display()))?;
    }
    copy(&from, &to)?;
    let licences = to.join("Resources/Licenses");
    fs::create_dir_all(&licences)?;
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(project_root().join(name), licences.join(name))
            .with_context(|| format!("cannot copy {name}"))?;
    }
    Ok(to)
}

fn place(library: &Path, package: &Path, folder: &str, name: &str) -> Result<()> {
    let place = package.join("Resources/Library").join(folder);
    fs::create_dir_all(&place).with_context(|| format!("cannot make {}", place.display()))?;
    fs::copy(library, place.join(name)).with_context(|| format!("cannot copy {}", library.display()))?;
    Ok(())
}

/// What linkers of Windows take in place of CableRobot.dll: CableRobot.lib.
fn import_library(dll: &Path, folder: &Path) -> Result<()> {
    let listed = check::output(Command::new("x86_64-w64-mingw32-objdump").arg("-p").arg(dll))?;
    let exports = listed.lines().map(str::trim).filter(|line| line.starts_with('['));
    let words = exports.filter_map(|line| line.split_whitespace().last());
    let names: BTreeSet<_> = words.filter(|word| word.starts_with("cable_robot_")).collect();
    let definition = folder.join("CableRobot.def");
    let list: String = names.iter().map(|name| format!("{name}\n")).collect();
    fs::write(&definition, format!("LIBRARY CableRobot.dll\nEXPORTS\n{list}"))?;
    let mut tool = Command::new("x86_64-w64-mingw32-dlltool");
    tool.arg("-d").arg(&definition).arg("-l").arg(folder.join("CableRobot.lib"));
    library::run(&mut tool, "making CableRobot.lib")?;
    Ok(fs::remove_file(definition)?)
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
