//! A rig: what it is, tensions at a pose, the static workspace.

use std::path::PathBuf;

use anyhow::anyhow;
use cable_robot::control::distribution::{share, widest_margin};
use cable_robot::reach::Slice;
use cable_robot::robot::dynamics::required_wrench;
use cable_robot::robot::{Coordinates, RigFile};
use cable_robot_programs::command;
use nalgebra::Vector3;
use pyo3::prelude::*;

use crate::{Six, pose, refused};

/// A rig as its file says.
#[pyclass(frozen)]
pub struct Rig {
    pub file: RigFile,
}

/// A cable as its rig file says: base frame and platform's frame, m; limits in N.
#[derive(IntoPyObject)]
struct Cable {
    anchor: [f64; 3],
    attachment: [f64; 3],
    least: f64,
    greatest: f64,
    pulley_radius: Option<f64>,
}

/// Lengths (m) and tensions (N) at a pose; how far these are inside their limits, and how far any are (N).
#[derive(IntoPyObject)]
struct Tensions {
    length: Vec<f64>,
    tension: Vec<f64>,
    margin: f64,
    widest_margin: f64,
}

/// The static workspace at one height: margins (N) on a grid (m), row by row of y; corners of its border (m), its area (m²).
#[derive(IntoPyObject)]
struct Workspace {
    x: Vec<f64>,
    y: Vec<f64>,
    margin: Vec<Vec<f64>>,
    border: Vec<[f64; 2]>,
    area: f64,
    deepest: [f64; 2],
    greatest_margin: f64,
}

#[pymethods]
impl Rig {
    /// That of a rig file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { file: command::read(&path).map_err(refused)? })
    }

    /// That of a rig file's text.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        Ok(Self { file: RigFile::parse(text).map_err(refused)? })
    }

    /// The paper's, Table I.
    #[staticmethod]
    fn paper() -> Self {
        Self { file: RigFile::default() }
    }

    #[getter]
    fn name(&self) -> &str {
        &self.file.name
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.file.rig.mass
    }

    #[getter]
    fn home(&self) -> Six {
        self.file.home.0.into()
    }

    #[getter]
    fn gains(&self) -> (f64, f64) {
        (self.file.lambda, self.file.eta)
    }

    #[getter]
    fn cables(&self) -> Vec<Cable> {
        let cable = |cable: &cable_robot::robot::Cable| Cable {
            anchor: cable.anchor.into(),
            attachment: cable.attachment.into(),
            least: cable.limits.min,
            greatest: cable.limits.max,
            pulley_radius: cable.pulley.map(|pulley| pulley.radius),
        };
        self.file.rig.cables.iter().map(cable).collect()
    }

    fn tensions(&self, at: Six, rates: Six, accelerations: Six) -> PyResult<Tensions> {
        let (rig, at) = (&self.file.rig, pose(at));
        let cables = rig.cables_at(&at);
        let columns = cables.wrench_matrix();
        let wrench = required_wrench(rig, &at, &Coordinates::from(rates), &Coordinates::from(accelerations));
        let singular = || {
            refused(anyhow!(
                "the wrench matrix is singular there: there is a force or torque that no tensions give"
            ))
        };
        let tension = share(rig, &columns, &wrench, 0.0).ok_or_else(singular)?;
        let margins = tension.iter().zip(&rig.cables).map(|(u, cable)| cable.limits.margin(*u));
        Ok(Tensions {
            length: cables.length.to_vec(),
            margin: margins.fold(f64::INFINITY, f64::min),
            tension: tension.to_vec(),
            widest_margin: widest_margin(rig, &columns, &wrench),
        })
    }

    /// `None` where the cables hold the platform nowhere.
    fn workspace(&self, py: Python, height: f64, angles: [f64; 3]) -> Option<Workspace> {
        let slice = Slice { rig: &self.file.rig, height, angles: Vector3::from(angles) };
        let found = py.detach(|| command::find(&slice, &self.file, || ()))?;
        Some(Workspace {
            x: found.grid.x,
            y: found.grid.y,
            margin: found.grid.margin,
            border: found.corners.iter().map(|corner| [corner.x, corner.y]).collect(),
            area: found.area,
            deepest: found.deepest.0.into(),
            greatest_margin: found.deepest.1,
        })
    }
}
