//! The rig that a command is about.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::reach::in_static_workspace;
use cable_robot::robot::{Pose, RigFile};
use clap::Args;

#[derive(Args)]
pub struct RigArgument {
    /// Rig file (TOML, see docs/rigs.md); without it the paper's rig, Table I
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
}

impl RigArgument {
    /// Reads the file.
    pub fn read(&self) -> Result<RigFile> {
        let Some(path) = &self.rig else { return Ok(RigFile::default()) };
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        RigFile::parse(&text).with_context(|| format!("{}", path.display()))
    }

    /// The controller for the rig, which must have the shape of the paper's.
    pub fn controller(&self, planner: PlannerKind) -> Result<ControllerParameters> {
        let RigFile { rig, lambda, eta, .. } = self.read()?;
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
            lambda,
            eta,
            min_tension: rig.limits.min,
            max_tension: rig.limits.max,
            planner,
            ..ControllerParameters::default()
        };
        parameters.validate()?;
        Ok(parameters)
    }
}

/// Refuses a start where the platform cannot rest.
pub fn require_rest(parameters: &ControllerParameters, from: &Pose) -> Result<()> {
    let start = from.position().xy();
    ensure!(
        in_static_workspace(&parameters.robot, &start),
        "--from ({}, {}) lies outside the static workspace: a cable is slack there, so there is no rest to start from",
        start.x,
        start.y
    );
    Ok(())
}
