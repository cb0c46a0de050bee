//! Where a scenario comes from: the program itself, a file, or the arguments.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use cable_robot::plan::PlannerKind;
use cable_robot::robot::RigFile;
use cable_robot::sim::{BUNDLED, Scenario, ScenarioFile};

use crate::rig;

/// The scenario of this name, or in this file.
pub fn named(name: &str) -> Result<Scenario> {
    let bundled = BUNDLED.iter().find(|(known, _)| *known == name);
    let Some((_, text)) = bundled else { return from_file(Path::new(name)) };
    parse(text, Path::new("")).with_context(|| format!("bundled scenario {name}"))
}

fn from_file(path: &Path) -> Result<Scenario> {
    let names = BUNDLED.map(|(name, _)| name).join(", ");
    let text = fs::read_to_string(path).with_context(|| {
        format!("cannot read the scenario {} (bundled ones are: {names})", path.display())
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(&text, folder).with_context(|| format!("{}", path.display()))
}

/// `folder` is where the path of a rig begins.
fn parse(text: &str, folder: &Path) -> Result<Scenario> {
    let file = ScenarioFile::parse(text)?;
    let rig = file.rig().map_or_else(|| Ok(RigFile::default()), |path| rig::read(&folder.join(path)))?;
    let base = rig::controller(&rig, PlannerKind::Bounded)?;
    Ok(file.scenario(&rig.rig.name, rig.home, base)?)
}

/// Names and titles of the bundled scenarios.
pub fn list() -> Result<Vec<(&'static str, String)>> {
    BUNDLED.iter().map(|(name, text)| Ok((*name, ScenarioFile::parse(text)?.title().to_owned()))).collect()
}
