//! `cargo fmu build`: packs the FMUs and checks what it packed.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cable_robot_fmi::archive::{self, Files};
use cable_robot_fmi::describe::{VERSIONS, Version, checked_in};
use cable_robot_fmi::models::node::NODES;
use cable_robot_fmi::{MODELS, Model, can};
use cable_robot_import::{FmiVersion, platform};

use crate::platforms::{self, PLATFORMS, Platform};
use crate::{check, library, project_root};

/// The package whose library the FMUs carry.
const LIBRARY: &str = "cable-robot-fmi";
/// The fieldbus file whose nodes are packed.
const FIELDBUS: &str = "rigs/can/akd.toml";

/// Builds, packs and checks controller and plants; returns their paths.
pub fn build() -> Result<Vec<PathBuf>> {
    build_below(&project_root().join("target"))
}

/// The same with the library compiled below another folder, which also gets the FMUs.
fn build_below(target: &Path) -> Result<Vec<PathBuf>> {
    let bytes = built(&[], target)?;
    pack(target, |model, version| own(model, version, &bytes))
}

/// The nodes on CAN buses as well, for the fieldbus file that is the example; all below another folder.
pub fn build_everything_below(target: &Path) -> Result<Vec<PathBuf>> {
    let mut packed = build_below(target)?;
    let bytes = built(&["can"], target)?;
    let files = cable_robot_fieldbus::Files::read(&project_root().join(FIELDBUS))?;
    for kind in NODES {
        let (model, version) = (Model::Node(kind), Version::Fmi3);
        let path = path_below(target, model, version);
        write_checked(&path, model, &can::contents(kind, &files, &own(model, version, &bytes)))?;
        packed.push(path);
    }
    Ok(packed)
}

/// The library with these features.
fn built(features: &[&str], target: &Path) -> Result<Vec<u8>> {
    let library = library::build(LIBRARY, features, target)?;
    check::symbols(&library)?;
    read(&library)
}

/// A library where an FMU for this machine has it.
fn own(model: Model, version: Version, library: &[u8]) -> Files {
    let folder = platform(match version {
        Version::Fmi2 => FmiVersion::V2,
        Version::Fmi3 => FmiVersion::V3,
    });
    let name = format!("{}{}", model.identifier(), std::env::consts::DLL_SUFFIX);
    Files::from([(format!("binaries/{folder}/{name}"), library.to_vec())])
}

/// The same with libraries for all platforms, into target/platforms/fmu.
pub fn build_for_all() -> Result<Vec<PathBuf>> {
    let libraries = PLATFORMS
        .iter()
        .map(|platform| {
            let library = platform.build_library(LIBRARY, "libcable_robot_fmi.so")?;
            check::of_platform(platform, &library).with_context(|| platform.target)?;
            Ok((platform, read(&library)?))
        })
        .collect::<Result<Vec<_>>>()?;
    pack(&platforms::folder(), |model, version| {
        let place = |(platform, bytes): &(&Platform, Vec<u8>)| {
            let folder = platform.folders[usize::from(version == Version::Fmi3)];
            (format!("binaries/{folder}/{}{}", model.identifier(), platform.library), bytes.clone())
        };
        libraries.iter().map(place).collect()
    })
}

fn read(library: &Path) -> Result<Vec<u8>> {
    fs::read(library).with_context(|| format!("cannot read {}", library.display()))
}

/// Packs and checks the FMUs of both versions, each model's after the other's.
fn pack(target: &Path, libraries: impl Fn(Model, Version) -> Files) -> Result<Vec<PathBuf>> {
    let mut packed = vec![];
    for version in VERSIONS {
        for model in MODELS {
            let path = path_below(target, model, version);
            let files = archive::contents(&model.interface(), version, &libraries(model, version), &[]);
            write_checked(&path, model, &files)?;
            packed.push(path);
        }
    }
    Ok(packed)
}

fn write_checked(path: &Path, model: Model, files: &Files) -> Result<()> {
    archive::write(path, files).with_context(|| format!("cannot pack {}", path.display()))?;
    check::packed(path, model).with_context(|| format!("{} is not as it should be", path.display()))
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

pub fn path_below(target: &Path, model: Model, version: Version) -> PathBuf {
    target.join("fmu").join(version.name()).join(model.identifier()).with_extension("fmu")
}
