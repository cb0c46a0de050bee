//! The rig that a command is about.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::report::files::read_text;
use cable_robot::robot::dynamics::static_tensions;
use cable_robot::robot::{Geometry, ParameterError, Pose, RigFile};
use clap::{Args, ValueHint};
use serde::Deserialize;
use toml::Spanned;

use crate::number;

#[derive(Args)]
pub struct RigArgument {
    /// Rig file (TOML, see docs/rigs.md); without it the paper's rig, Table I
    #[arg(long = "rig", id = "rig", value_name = "FILE", value_hint = ValueHint::FilePath)]
    path: Option<PathBuf>,
}

impl RigArgument {
    /// Reads the file.
    pub fn read(&self) -> Result<RigFile> {
        self.path.as_deref().map_or_else(|| Ok(RigFile::default()), read)
    }

    /// The controller for the rig, which must have the shape of the paper's.
    pub fn controller(&self, planner: PlannerKind) -> Result<ControllerParameters> {
        Ok(self.read_with_controller(planner)?.1)
    }

    /// Both.
    pub fn read_with_controller(&self, planner: PlannerKind) -> Result<(RigFile, ControllerParameters)> {
        match &self.path {
            Some(path) => read_with_controller(path, planner),
            None => {
                let file = RigFile::default();
                let controller = controller(&file, planner)?;
                Ok((file, controller))
            }
        }
    }

    /// What a user calls the rig's home.
    pub fn name_of_home(&self) -> String {
        self.path.as_ref().map_or("home".to_owned(), |path| format!("{}: home", path.display()))
    }
}

/// Reads a rig file.
pub fn read(path: &Path) -> Result<RigFile> {
    let text = read_text(path).with_context(|| format!("cannot read {}", path.display()))?;
    RigFile::parse(&text).with_context(|| path.display().to_string())
}

/// Reads a rig file and makes the controller for the rig; what is refused is named with its file, a gain with its line.
pub fn read_with_controller(path: &Path, planner: PlannerKind) -> Result<(RigFile, ControllerParameters)> {
    let file = read(path)?;
    let made = controller(&file, planner).map_err(|refused| at_its_line(path, refused));
    let controller = made.with_context(|| path.display().to_string())?;
    Ok((file, controller))
}

/// A refused gain with its line. A rig file may hold any; the controller cannot do with any.
fn at_its_line(path: &Path, refused: Error) -> Error {
    #[derive(Deserialize)]
    struct File {
        gains: HashMap<String, Spanned<f64>>,
    }
    let line = |name: &str| {
        let text = read_text(path).ok()?;
        let at = toml::from_str::<File>(&text).ok()?.gains.get(name)?.span().start;
        Some(text[..at].matches('\n').count() + 1)
    };
    let Some(ParameterError { name, value, allowed }) = refused.downcast_ref() else { return refused };
    match line(name) {
        Some(line) => anyhow!("line {line}: gains.{name} = {value} is not allowed: {allowed}"),
        None => refused,
    }
}

/// The controller for a rig, which must have the shape of the paper's.
fn controller(file: &RigFile, planner: PlannerKind) -> Result<ControllerParameters> {
    let RigFile { rig, lambda, eta, .. } = file;
    let Some(robot) = rig.as_triangular() else {
        bail!(
            "rig {:?} has {} cables that do not run as the paper's six do between two triangles; planner and \
             controller know that shape only (`cable-robot workspace` knows any)",
            rig.name,
            rig.anchors.len()
        );
    };
    let parameters = ControllerParameters {
        robot,
        lambda: *lambda,
        eta: *eta,
        min_tension: rig.limits.min,
        max_tension: rig.limits.max,
        planner,
        ..ControllerParameters::default()
    };
    parameters.validate()?;
    Ok(parameters)
}

/// Refuses a start where the platform cannot rest; `name` is what the user calls it.
pub fn require_rest(parameters: &ControllerParameters, name: &str, from: &Pose) -> Result<()> {
    let ControllerParameters { robot, min_tension, max_tension, .. } = parameters;
    let tensions = static_tensions(robot, &Geometry::new(robot), from);
    let place = from.0.iter().map(|c| number(*c)).collect::<Vec<_>>().join(", ");
    ensure!(
        tensions.is_some_and(|tensions| tensions.into_iter().all(|u| u > 0.0)),
        "{name} ({place}) lies outside the static workspace: a cable is slack there, so there is no rest to start from"
    );
    for (i, u) in tensions.into_iter().flatten().enumerate() {
        ensure!(
            (*min_tension..=*max_tension).contains(&u),
            "{name} ({place}): at rest there cable {} pulls {u:.3} N, beyond the limits of {min_tension} to {max_tension} N",
            i + 1
        );
    }
    Ok(())
}
