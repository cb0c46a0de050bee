//! The rig that a command is about.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::dynamics::static_tensions;
use cable_robot::robot::{Geometry, Pose, RigFile};

use clap::{Args, ValueHint};

use crate::number;

#[derive(Args)]
pub struct RigArgument {
    /// Rig file (TOML, see docs/rigs.md); without it the paper's rig, Table I
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    rig: Option<PathBuf>,
}

impl RigArgument {
    /// Reads the file.
    pub fn read(&self) -> Result<RigFile> {
        self.rig.as_deref().map_or_else(|| Ok(RigFile::default()), read)
    }

    /// The controller for the rig, which must have the shape of the paper's.
    pub fn controller(&self, planner: PlannerKind) -> Result<ControllerParameters> {
        controller(&self.read()?, planner)
    }
}

/// Reads a rig file.
pub fn read(path: &Path) -> Result<RigFile> {
    let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    RigFile::parse(&text).with_context(|| format!("{}", path.display()))
}

/// The controller for a rig, which must have the shape of the paper's.
pub fn controller(file: &RigFile, planner: PlannerKind) -> Result<ControllerParameters> {
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
