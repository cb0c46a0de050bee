//! The rig that a command is about.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use cable_robot::control::{barrier, static_margin, static_tensions};
use cable_robot::plan::planner::{FAR, Planner};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{ParameterError, Pose, Rig, RigFile, TensionLimits};
use cable_robot_files::read_text;
use clap::{Args, ValueHint};
use serde::Deserialize;
use toml::Spanned;

use crate::command::{metres, number};

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

    /// Both.
    pub fn read_with_controller(
        &self,
        planner: Option<PlannerKind>,
    ) -> Result<(RigFile, ControllerParameters)> {
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
///
/// # Errors
/// What cannot be read, or the line that makes no sense.
pub fn read(path: &Path) -> Result<RigFile> {
    let text = read_text(path).with_context(|| format!("cannot read {}", path.display()))?;
    RigFile::parse(&text).with_context(|| path.display().to_string())
}

/// Reads a rig file and makes the controller for the rig; what is refused is named with its file, a gain with its line.
pub fn read_with_controller(
    path: &Path,
    planner: Option<PlannerKind>,
) -> Result<(RigFile, ControllerParameters)> {
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

/// The controller for a rig, with the planner that serves it if none is given.
///
/// # Errors
/// A gain that makes no sense, or a planner that is not for this rig.
pub fn controller(file: &RigFile, planner: Option<PlannerKind>) -> Result<ControllerParameters> {
    let RigFile { rig, lambda, eta, .. } = file;
    let of_rig = ControllerParameters::of(rig);
    let planner = planner.unwrap_or(of_rig.planner);
    let parameters = ControllerParameters { lambda: *lambda, eta: *eta, planner, ..of_rig };
    parameters.validate()?;
    Ok(parameters)
}

/// Refuses a pose above all anchors; `name` is what the user calls it.
///
/// # Errors
/// Which coordinate, and what would be right.
pub fn require_below(rig: &Rig, name: &str, pose: &Pose) -> Result<()> {
    if rig.can_be_at(pose) {
        return Ok(());
    }
    let z = number(pose.0[2]);
    if rig.gravity.z < 0.0 {
        bail!("{name}: z = {z}: z points up, a pose below the anchors has a lesser z than they (m)")
    }
    bail!("{name}: z = {z}: z points down, a pose below the anchors has a greater z than they (m)")
}

/// Refuses a start where the platform cannot rest; `name` is what the user calls it.
///
/// # Errors
/// Why, and which cable.
pub fn require_rest(parameters: &ControllerParameters, name: &str, from: &Pose) -> Result<()> {
    let rig = &parameters.rig;
    require_below(rig, name, from)?;
    let place = from.0.iter().map(|c| number(*c)).collect::<Vec<_>>().join(", ");
    ensure!(
        Planner::from(*parameters).is_near(from),
        "{name} ({place}) is farther than {} m ({FAR} radii of the rig) from the anchors, where nothing is looked for",
        metres(FAR * rig.radius()).trim()
    );
    ensure!(
        static_margin(&rig.with_limits(TensionLimits::default()), from) > 0.0,
        "{name} ({place}) lies outside the static workspace: a cable is slack there, so there is no rest to start from"
    );
    if static_margin(rig, from) >= 0.0 {
        return Ok(());
    }
    let Some(barrier) = barrier(rig, from) else {
        bail!("{name} ({place}): the wrench matrix is singular there")
    };
    let tension = static_tensions(rig, from, 0.0).map_or(f64::NAN, |tension| tension[barrier.cable - 1]);
    bail!(
        "{name} ({place}): at rest there cable {} pulls {tension:.3} N, beyond its limits of {}",
        barrier.cable,
        limits_in_words(rig.cables[barrier.cable - 1].limits)
    )
}

fn limits_in_words(TensionLimits { min, max }: TensionLimits) -> String {
    if max.is_finite() { format!("{min} to {max} N") } else { format!("{min} N and more") }
}
