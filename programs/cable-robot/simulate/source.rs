//! Where a scenario comes from: the program itself, a file, or the arguments.

use std::path::Path;

use crate::errors::similar;
use anyhow::{Context, Result};
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::{BUNDLED, Goal, PlantParameters, Scenario, ScenarioFile};
use cable_robot_files::read_text;

use super::settings::{Setting, applied};
use super::summary::place;
use crate::command::rig;

/// The scenario of this name, or in this file, with these fields set.
///
/// # Errors
/// What cannot be read, or the line that makes no sense.
pub fn named(name: &str, settings: &[Setting]) -> Result<Scenario> {
    let bundled = BUNDLED.iter().find(|(known, _)| *known == name);
    let Some((_, text)) = bundled else { return from_file(Path::new(name), settings) };
    parse(text, Path::new(""), settings).with_context(|| format!("bundled scenario {name}"))
}

fn from_file(path: &Path, settings: &[Setting]) -> Result<Scenario> {
    let names = BUNDLED.map(|(name, _)| name);
    let text = read_text(path).with_context(|| {
        let given = path.display().to_string();
        let meant = similar(&given, names);
        let question = meant.map_or(String::new(), |meant| format!("; did you mean {meant}?"));
        format!("cannot read the scenario {given} (bundled ones are: {}{question})", names.join(", "))
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(&text, folder, settings).with_context(|| path.display().to_string())
}

/// `folder` is where the path of a rig begins.
fn parse(text: &str, folder: &Path, settings: &[Setting]) -> Result<Scenario> {
    let file = if settings.is_empty() {
        ScenarioFile::parse(text)?
    } else {
        ScenarioFile::parse(&applied(text, settings)?).context("with --set")?
    };
    let (rig, base) = match file.rig() {
        Some((line, path)) => rig::read_with_controller(&folder.join(path), None)
            .with_context(|| format!("line {line}: rig = {path:?}"))?,
        None => (RigFile::default(), ControllerParameters::default()),
    };
    let scenario = file.scenario(&rig.name, rig.home, base)?;
    let start = match (file.start_line(), file.rig()) {
        (Some(line), _) => format!("line {line}: start"),
        (None, Some((line, path))) => format!("line {line}: rig = {path:?}: home"),
        (None, None) => "home".to_owned(),
    };
    rig::require_rest(&scenario.controller, &start, &scenario.plant.initial_pose)?;
    Ok(scenario)
}

/// One goal of a robot that rests at `from`; an ideal rig.
pub fn of_goal(
    file: &RigFile,
    controller: ControllerParameters,
    (from, to): (Pose, Pose),
    (duration, step): (f64, f64),
) -> Scenario {
    Scenario {
        title: format!("From {} to {}", place(&from), place(&to)),
        rig: file.name.clone(),
        plant: PlantParameters { rig: controller.rig, initial_pose: from, ..Default::default() },
        controller,
        orbit: None,
        goals: vec![Goal::new(0.0, to)],
        disturbances: vec![],
        duration,
        step,
    }
}

/// Names and titles of the bundled scenarios.
pub fn list() -> Result<Vec<(&'static str, String)>> {
    BUNDLED.iter().map(|(name, text)| Ok((*name, ScenarioFile::parse(text)?.title().to_owned()))).collect()
}
