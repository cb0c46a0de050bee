//! The static workspace of any rig at a given height and orientation: where the cables can hold the platform within their limits.

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use crate::control::static_margin;
use crate::robot::{Coordinates, Pose, Rig};

/// Distance from the true border at which the bisection ends, as a share of the rig's radius.
const BORDER_TOLERANCE: f64 = 1e-9;
/// Steps of a ray before it has crossed the whole box that is looked at.
const RAY_STEPS: usize = 200;

/// Poses of a rig at one height and one orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Slice<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// z of the centre of mass, m.
    pub height: f64,
    /// (roll, pitch, yaw), rad.
    pub angles: Vector3<f64>,
}

/// Margins on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Coordinates of the columns, m, rising.
    pub x: Vec<f64>,
    /// Coordinates of the rows, m, rising.
    pub y: Vec<f64>,
    /// A row for each y: how far inside their limits the tensions can be, N; less than 0 outside.
    pub margin: Vec<Vec<f64>>,
}

impl Grid {
    /// The point with the greatest margin (m, N), if that is 0 or greater.
    pub fn best(&self) -> Option<(Vector2<f64>, f64)> {
        let cells = self.points().filter(|(_, margin)| *margin >= 0.0);
        cells.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Every point with its margin.
    pub fn points(&self) -> impl Iterator<Item = (Vector2<f64>, f64)> {
        let row = |(y, row): (&f64, &Vec<f64>)| {
            let y = *y;
            self.x.iter().zip(row.clone()).map(move |(x, margin)| (Vector2::new(*x, y), margin))
        };
        self.y.iter().zip(&self.margin).flat_map(row)
    }
}

impl Slice<'_> {
    /// The pose over (x, y), m.
    pub fn pose(&self, point: &Vector2<f64>) -> Pose {
        let (roll, pitch, yaw) = (self.angles.x, self.angles.y, self.angles.z);
        Pose(Coordinates::new(point.x, point.y, self.height, roll, pitch, yaw))
    }

    /// How far inside their limits the tensions can be at rest at (x, y), N.
    pub fn margin(&self, point: &Vector2<f64>) -> f64 {
        static_margin(self.rig, &self.pose(point))
    }

    /// Lower and upper corner of the box looked at, m: the anchors', wider by the platform's radius.
    pub fn extent(&self) -> (Vector2<f64>, Vector2<f64>) {
        let wider = Vector2::repeat(self.rig.platform_radius());
        let corner = |pick: fn(f64, f64) -> f64| {
            let anchors = self.rig.cables.iter().map(|cable| cable.anchor.xy());
            anchors.reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default()
        };
        (corner(f64::min) - wider, corner(f64::max) + wider)
    }

    /// The margins on a grid of `count` by `count` points from corner `low` to corner `high` (m); `row_done` is called after each
    /// row, from any thread.
    pub fn grid(
        &self,
        (low, high): (Vector2<f64>, Vector2<f64>),
        count: usize,
        row_done: impl Fn() + Sync,
    ) -> Grid {
        let last = (count.max(2) - 1) as f64;
        let line = |k: usize| -> Vec<f64> {
            (0..count).map(|i| low[k] + (high[k] - low[k]) * (i as f64 / last)).collect()
        };
        let (x, y) = (line(0), line(1));
        let row = |y: &f64| {
            let margins = x.iter().map(|x| self.margin(&Vector2::new(*x, *y))).collect();
            row_done();
            margins
        };
        let margin = y.par_iter().map(row).collect();
        Grid { x, y, margin }
    }

    /// Where `count` rays from an interior point first leave the workspace, in order round it. A part of the workspace that cannot be
    /// seen from there is not included.
    pub fn boundary(&self, interior: &Vector2<f64>, count: usize) -> Vec<Vector2<f64>> {
        let (low, high) = self.extent();
        let stride = (high - low).norm() / RAY_STEPS as f64;
        (0..count)
            .into_par_iter()
            .map(|k| {
                let azimuth = std::f64::consts::TAU * k as f64 / count as f64;
                let direction = Vector2::new(libm::cos(azimuth), libm::sin(azimuth));
                interior + direction * self.first_exit(interior, &direction, stride)
            })
            .collect()
    }

    /// Marches until the limits are broken, then halves the last stride.
    fn first_exit(&self, from: &Vector2<f64>, direction: &Vector2<f64>, stride: f64) -> f64 {
        let holds = |length: f64| self.margin(&(from + direction * length)) >= 0.0;
        let (mut inside, mut outside) = (0.0, stride);
        for _ in 0..RAY_STEPS {
            if !holds(outside) {
                break;
            }
            (inside, outside) = (outside, outside + stride);
        }
        let tolerance = BORDER_TOLERANCE * self.rig.radius();
        while outside - inside > tolerance {
            let middle = 0.5 * (inside + outside);
            if holds(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}

/// The corners of a closed line of points. Where two straight parts meet between two points, the corner is where they would
/// cross; a curved part keeps its points. Straight is what deviates by no more than `tolerance` (m).
pub fn corners(points: &[Vector2<f64>], tolerance: f64) -> Vec<Vector2<f64>> {
    let count = points.len();
    let at = |k: usize| points[k % count];
    let straight = |k: usize| !turns(&at(k), &at(k + 1), &at(k + 2), tolerance);
    let mut sharp = vec![];
    for k in 0..count {
        // The straight parts k, k+1, k+2 and k+3, k+4, k+5, with the corner between k+2 and k+3.
        sharp.push(at(k + 2));
        if straight(k) && straight(k + 3) && !(straight(k + 1) && straight(k + 2)) {
            sharp.extend(crossing(&at(k + 1), &at(k + 2), &at(k + 3), &at(k + 4)));
        }
    }
    // A corner that is a point already was found again from either side.
    sharp.dedup_by(|a, b| (*a - *b).norm() <= tolerance);
    if sharp.len() > 1 && (sharp[0] - sharp[sharp.len() - 1]).norm() <= tolerance {
        sharp.pop();
    }
    without_straight(&sharp, tolerance)
}

/// Drops the points of a closed line that lie between their neighbours.
fn without_straight(points: &[Vector2<f64>], tolerance: f64) -> Vec<Vector2<f64>> {
    let count = points.len();
    let at = |k: usize| points[k % count];
    let Some(first) = (0..count).find(|k| turns(&at(k + count - 1), &at(*k), &at(k + 1), tolerance)) else {
        return points.to_vec();
    };
    let mut corners = vec![at(first)];
    for k in first + 1..first + count {
        if turns(&corners[corners.len() - 1], &at(k), &at(k + 1), tolerance) {
            corners.push(at(k));
        }
    }
    corners
}

/// Whether `point` lies farther than `tolerance` from the line through `before` and `after`.
fn turns(before: &Vector2<f64>, point: &Vector2<f64>, after: &Vector2<f64>, tolerance: f64) -> bool {
    let chord = after - before;
    (chord.perp(&(point - before)) / chord.norm()).abs() > tolerance
}

/// Where the lines through a, b and through c, d cross; `None` if they are parallel.
fn crossing(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>, d: &Vector2<f64>) -> Option<Vector2<f64>> {
    let (along, other) = (b - a, d - c);
    let point = a + along * ((c - a).perp(&other) / along.perp(&other));
    point.iter().all(|x| x.is_finite()).then_some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reach::{in_static_workspace, polygon, static_workspace};
    use crate::robot::{RigFile, RobotParameters, TensionLimits};

    fn paper() -> Rig {
        Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 })
    }

    fn slice(rig: &Rig) -> Slice<'_> {
        Slice { rig, height: 1.0, angles: Vector3::zeros() }
    }

    #[test]
    fn paper_rig_has_the_hexagon_of_equation_16() {
        let (robot, rig) = (RobotParameters::default(), paper());
        let slice = slice(&rig);
        let grid = slice.grid(slice.extent(), 41, || {});
        for (point, margin) in grid.points() {
            assert_eq!(margin > 0.0, in_static_workspace(&robot, &point), "{point}");
        }
        let (best, margin) = grid.best().unwrap();
        assert!(best.norm() < 0.03 && margin > 9.0, "{margin} N at {best}");

        let border = slice.boundary(&best, 360);
        for point in &border {
            let slack = static_workspace(&robot).iter().map(|facet| facet.slack(point)).fold(1.0, f64::min);
            assert!((0.0..3e-9).contains(&slack), "{slack}");
        }
        let found = corners(&border, 1e-6);
        let expected = polygon(&static_workspace(&robot), 1.0);
        assert_eq!(found.len(), 6, "{found:?}");
        for vertex in expected {
            assert!(found.iter().any(|corner| (corner - vertex).norm() < 1e-7), "{vertex}");
        }
    }

    #[test]
    fn a_least_tension_shrinks_the_workspace() {
        let rig = paper().with_limits(TensionLimits { min: 5.0, max: 100.0 });
        let border = slice(&rig).boundary(&Vector2::zeros(), 60);
        for point in border {
            let margin = slice(&rig).margin(&point);
            assert!((0.0..1e-6).contains(&margin) && point.norm() < 0.2);
        }
        let rig = paper().with_limits(TensionLimits { min: 11.0, max: 100.0 });
        assert_eq!(slice(&rig).grid(slice(&rig).extent(), 21, || {}).best(), None);
    }

    /// `workspace` called this rig's workspace empty: the tolerance of a solver was taken for a proof.
    #[test]
    fn a_greatest_tension_that_never_binds_changes_nothing() {
        let file = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
        let points = [0.0, 0.7, 1.4, 1.9].map(|x| Vector2::new(x, 0.3 * x));
        let with = |max: f64| {
            let rig = file.rig.with_limits(TensionLimits { min: 5.0, max });
            points.map(|point| Slice { rig: &rig, height: 2.0, angles: Vector3::zeros() }.margin(&point))
        };
        let infinite = with(f64::INFINITY);
        assert!(infinite[0] > 10.0 && infinite[3] < 0.0, "{infinite:?}");
        for max in [1e5, 1e8, 1e13] {
            for (found, expected) in with(max).iter().zip(infinite) {
                assert!(
                    (found - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                    "{max}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_circle_keeps_its_corners_and_a_square_loses_all_but_four() {
        let on_circle = |k: i32| Vector2::new((f64::from(k) * 0.1047).cos(), (f64::from(k) * 0.1047).sin());
        let circle: Vec<_> = (0..60).map(on_circle).collect();
        assert_eq!(corners(&circle, 1e-6).len(), 60);
        let side = |k: usize| (k % 10) as f64 / 10.0;
        let square: Vec<_> = (0..40)
            .map(|k| match k / 10 {
                0 => Vector2::new(side(k), 0.0),
                1 => Vector2::new(1.0, side(k)),
                2 => Vector2::new(1.0 - side(k), 1.0),
                _ => Vector2::new(0.0, 1.0 - side(k)),
            })
            .collect();
        assert_eq!(corners(&square, 1e-9).len(), 4);
    }
}
