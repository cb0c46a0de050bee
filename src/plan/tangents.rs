//! The tensions' tangents at a resting pose, and the step over them that comes nearest to a goal.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::planner::{Planner, STEEPEST};
use crate::control::active_set::{MOST_NORMALS, MOST_UNKNOWNS, Outcome, Point, Programme, Row};
use crate::control::distribution::{Distribution, Solutions, reference};
use crate::robot::pose::PITCH;
use crate::robot::{LEAST_CABLES, PerCable, Pose};

/// For differences of tensions and ways, rad, and as a share of the rig's radius m.
const DIFFERENCE: f64 = 1e-6;
/// Tension that the programme keeps beside what it must, as a share of the weight, so that rounding does not matter.
const SPARE: f64 = 1e-6;
/// The goal is looked at from no farther than this many reaches.
const FARTHEST: f64 = 1e4;
/// What a change of all tensions by the weight counts against a step of the reach, where the cables may share the load in many ways.
const SHARING: f64 = 1e-3;
/// The programme may exceed a row by this share of the reach.
const TOLERANCE: f64 = 1e-12;

/// What a small step d in the first `free` coordinates does, and a change z of how the cables share the load.
///
/// The square of the distance of `Planner::distance` from a goal is |J d - r|²/n, with the ways r of the attachments to the goal; with J'J/n = L L' and
/// y = L' d it is |y - L⁻¹J'r/n|² and a constant. Tensions change by U d + N z.
pub(super) struct Tangents {
    at: Pose,
    free: usize,
    /// Tensions at rest, N.
    here: PerCable<f64>,
    /// U, N/m and N/rad: a row for each cable.
    pulls: PerCable<Vector6<f64>>,
    /// N: orthonormal columns.
    sharing: PerCable<Point>,
    /// J: the ways of the attachments for each coordinate.
    slopes: [PerCable<Vector3<f64>>; 6],
    /// L, with ones for the coordinates that are not free.
    lower: Matrix6<f64>,
}

impl Tangents {
    /// `None` where the wrench matrix is singular.
    pub fn new(planner: &Planner, at: &Pose, free: usize) -> Option<Self> {
        let rig = planner.rig();
        let (wrench, radius, count) = (rig.static_wrench(), rig.platform_radius(), rig.cables.len());
        let solutions = |pose: &Pose, wrench: &Vector6<f64>| {
            Solutions::new(&rig.cables_at(pose).wrench_matrix(), wrench, radius)
        };
        let all = solutions(at, &wrench)?;
        let here = farthest_from_limits(planner, &all);
        let mut pulls = PerCable::filled(count, Vector6::zeros());
        let mut slopes = [PerCable::filled(count, Vector3::zeros()); 6];
        for k in 0..free {
            let step = if k < 3 { DIFFERENCE * rig.radius() } else { DIFFERENCE };
            let moved = |by: f64| {
                let mut pose = *at;
                pose.0[k] += by;
                pose
            };
            let (before, after) = (moved(-step), moved(step));
            // The least change of the tensions that makes up for what W u changes by.
            let lacking = |pose: &Pose| {
                let columns = rig.cables_at(pose).wrench_matrix();
                let given: Vector6<f64> = columns.iter().zip(&here).map(|(column, u)| column * *u).sum();
                solutions(pose, &(wrench - given)).map(|change| *change.least())
            };
            let (low, high) = (lacking(&before)?, lacking(&after)?);
            let ways = planner.ways(&before, &after);
            for i in 0..count {
                pulls[i][k] = (high[i] - low[i]) / (2.0 * step);
                slopes[k][i] = ways[i] / (2.0 * step);
            }
        }
        let product = |j: usize, k: usize| -> f64 {
            (0..count).map(|i| slopes[j][i].dot(&slopes[k][i])).sum::<f64>() / count as f64
        };
        let gram = Matrix6::from_fn(|j, k| match (j < free, k < free) {
            (true, true) => product(j, k),
            _ => f64::from(u8::from(j == k)),
        });
        let lower = gram.cholesky()?.l();
        Some(Self { at: *at, free, here, pulls, sharing: all.null_space(), slopes, lower })
    }

    /// The pose nearest to `goal`, or to this one if there is none, whose tensions are `kept` (N) within the limits as far as tangents tell,
    /// and no coordinate of y farther than `reach` (m).
    pub fn step(&self, planner: &Planner, goal: Option<&Pose>, kept: f64, reach: f64) -> Option<Pose> {
        let target = goal.map_or(Vector6::zeros(), |goal| self.towards(planner, goal) / reach);
        let target = target * (FARTHEST / target.norm()).min(1.0);
        // In units of the reach: x = (y - target, SHARING z/weight).
        let unit = planner.rig().weight() / (SHARING * reach);
        let mut rows = Rows {
            normals: [[0.0; MOST_UNKNOWNS]; MOST_NORMALS],
            rows: [Row::default(); MOST_NORMALS],
            count: 0,
        };
        let mut add = |row: &Vector6<f64>, shares: &dyn Fn(usize) -> f64, low: f64, high: f64| {
            let in_y = self.lower.solve_lower_triangular(row).unwrap_or(*row);
            let mut normal = [0.0; MOST_UNKNOWNS];
            normal[..self.free].copy_from_slice(&in_y.as_slice()[..self.free]);
            for k in 0..self.sharing.len() {
                normal[self.free + k] = shares(k) * unit;
            }
            let done = in_y.dot(&target);
            rows.add(normal, low / reach - done, high / reach - done);
        };
        let kept = kept + SPARE * planner.rig().weight();
        for (i, limits) in planner.limits(kept).into_iter().enumerate() {
            let (low, high) = (limits.min - self.here[i], limits.max - self.here[i]);
            add(&self.pulls[i], &|k| self.sharing[k][i], low, high);
        }
        if self.free > PITCH {
            let pitch = Vector6::from_fn(|k, _| f64::from(u8::from(k == PITCH)));
            add(&pitch, &|_| 0.0, -STEEPEST - self.at.0[PITCH], STEEPEST - self.at.0[PITCH]);
        }
        for k in 0..self.free {
            let mut normal = [0.0; MOST_UNKNOWNS];
            normal[k] = 1.0;
            rows.add(normal, -1.0 - target[k], 1.0 - target[k]);
        }
        let unknowns = self.free + self.sharing.len();
        let (normals, rows) = (&rows.normals[..rows.count / 2], &rows.rows[..rows.count]);
        let Outcome::Nearest(x) =
            (Programme { unknowns, rank: unknowns, normals, rows, tolerance: TOLERANCE }).solve()
        else {
            return None;
        };
        let y = Vector6::from_fn(|k, _| if k < self.free { (x[k] + target[k]) * reach } else { 0.0 });
        let step = self.lower.tr_solve_lower_triangular(&y)?;
        Some(Pose(self.at.0 + step))
    }

    /// L⁻¹J'r/n.
    fn towards(&self, planner: &Planner, goal: &Pose) -> Vector6<f64> {
        let ways = planner.ways(&self.at, goal);
        let along =
            |k: usize| ways.iter().zip(&self.slopes[k]).map(|(way, slope)| way.dot(slope)).sum::<f64>();
        let target = Vector6::from_fn(|k, _| if k < self.free { along(k) / ways.len() as f64 } else { 0.0 });
        self.lower.solve_lower_triangular(&target).unwrap_or(target)
    }
}

/// Rows in pairs: a normal, and both of its bounds.
struct Rows {
    normals: [Point; MOST_NORMALS],
    rows: [Row; MOST_NORMALS],
    count: usize,
}

impl Rows {
    /// low ≤ normal·x ≤ high, the normal brought to length one.
    fn add(&mut self, normal: Point, low: f64, high: f64) {
        let size = normal.iter().map(|value| value * value).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let index = self.count / 2;
        self.normals[index] = normal.map(|value| value / size);
        let row = |sign: f64, bound: f64| Row { normal: index, sign, bound: bound / size, compliance: 0.0 };
        self.rows[self.count] = row(-1.0, -low);
        self.rows[self.count + 1] = row(1.0, high);
        self.count += 2;
    }
}

/// The tensions at rest that are farthest inside the limits, N: the only ones of six cables.
fn farthest_from_limits(planner: &Planner, all: &Solutions) -> PerCable<f64> {
    let rig = planner.rig();
    if rig.cables.len() == LEAST_CABLES {
        return *all.least();
    }
    let limits = rig.limits();
    let margin = all.widest_margin(&limits).min(rig.weight());
    match all.distribute(&limits, &reference(rig), margin) {
        Distribution::Feasible(tensions) | Distribution::Infeasible { nearest: tensions, .. } => tensions,
    }
}
