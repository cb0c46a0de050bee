//! `cargo fmu build`: packs the four FMUs and checks what it packed.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cable_robot_fmi::archive::{self, Files};
use cable_robot_fmi::describe::{VERSIONS, Version, checked_in};
use cable_robot_fmi::{MODELS, Model};
use cable_robot_import::{FmiVersion, platform};

use crate::{check, library, project_root};

/// Builds, packs and checks the four FMUs; returns their paths.
pub fn build() -> Result<Vec<PathBuf>> {
    build_below(&project_root().join("target"))
}

/// The same with the library compiled below another folder, which also gets the FMUs.
pub fn build_below(target: &Path) -> Result<Vec<PathBuf>> {
    let library = library::build("cable-robot-fmi", target)?;
    check::symbols(&library)?;
    let library = fs::read(&library).with_context(|| format!("cannot read {}", library.display()))?;
    let mut packed = vec![];
    for version in VERSIONS {
        for model in MODELS {
            let path = path_below(target, model, version);
            let libraries = libraries(model, version, library.clone());
            archive::write(&path, &archive::contents(&model.interface(), version, &libraries, None))
                .with_context(|| format!("cannot pack {}", path.display()))?;
            check::packed(&path).with_context(|| format!("{} is not as it should be", path.display()))?;
            packed.push(path);
        }
    }
    Ok(packed)
}

/// Writes what a person may want to read to modelDescription/.
pub fn describe() -> Result<()> {
    for (name, bytes) in checked_in() {
        let path = project_root().join("modelDescription").join(name);
        fs::create_dir_all(path.parent().context("no folder")?)?;
        fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}

/// Where an FMU goes.
pub fn path(model: Model, version: Version) -> PathBuf {
    path_below(&project_root().join("target"), model, version)
}

fn path_below(target: &Path, model: Model, version: Version) -> PathBuf {
    target.join("fmu").join(version.name()).join(model.identifier()).with_extension("fmu")
}

/// The library by its path in the archive.
fn libraries(model: Model, version: Version, library: Vec<u8>) -> Files {
    let folder = platform(match version {
        Version::Fmi2 => FmiVersion::V2,
        Version::Fmi3 => FmiVersion::V3,
    });
    let path = format!("binaries/{folder}/{}{}", model.identifier(), std::env::consts::DLL_SUFFIX);
    Files::from([(path, library)])
}
