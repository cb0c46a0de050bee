//! When the goal cannot be reached: the admissible set point nearest to it.

use nalgebra::Vector2;

use crate::reach::quadratic_program::{SolverError, minimise};
use crate::reach::{BoundedDomain, HalfPlane, static_workspace};
use crate::robot::RobotParameters;
use crate::robot::triangles::SIX;

/// A condition that a set point must meet for one cable's sake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Cable number, from 1.
    pub cable: usize,
    /// Where the cable is in tension.
    pub half_plane: HalfPlane,
}

/// The admissible point nearest to a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Where, m.
    pub point: Vector2<f64>,
    /// How far from the goal, m; zero if the goal itself is admissible.
    pub distance: f64,
    /// The cable (from 1) whose facet holds the point back most; `None` if the goal is admissible.
    pub cable: Option<usize>,
}

/// The facets of the static workspace (16).
pub fn workspace_facets(robot: &RobotParameters) -> Vec<Facet> {
    let facet = |(i, half_plane)| Facet { cable: i + 1, half_plane };
    static_workspace(robot).into_iter().enumerate().map(facet).collect()
}

/// The facets of the reachable domain (15).
pub fn domain_facets(domain: &BoundedDomain) -> Vec<Facet> {
    let rows = domain.half_planes();
    let each = rows.len() / SIX;
    let facet = |(row, half_plane)| Facet { cable: row / each + 1, half_plane };
    rows.into_iter().enumerate().map(facet).collect()
}

/// The point at least `margin` (m, 0 or greater) inside every facet that is nearest to `goal`; `None` if there is no such point.
///
/// # Errors
/// [`SolverError`] if clarabel gives no answer.
pub fn nearest_admissible(
    goal: &Vector2<f64>,
    facets: &[Facet],
    margin: f64,
) -> Result<Option<Nearest>, SolverError> {
    // Slack that is left at the goal, in units of the facet's normal.
    let slack = |facet: &Facet| facet.half_plane.slack(goal) - margin * facet.half_plane.normal.norm();
    if facets.iter().all(|facet| slack(facet) >= 0.0) {
        return Ok(Some(Nearest { point: *goal, distance: 0.0, cable: None }));
    }
    // Slack in metres; the deepest breach is the unit of length, so that the solver's tolerances are relative to the answer.
    let in_metres = |facet: &Facet| slack(facet) / facet.half_plane.normal.norm();
    let unit = -facets.iter().map(in_metres).fold(f64::INFINITY, f64::min);
    // In d = (x - goal)/unit: minimise |d|²/2 subject to n·d ≤ slack, n of length one.
    let (rows, bounds): (Vec<_>, Vec<_>) = facets
        .iter()
        .map(|facet| {
            let normal = facet.half_plane.normal.normalize();
            (vec![normal.x, normal.y], in_metres(facet) / unit)
        })
        .unzip();
    let optimum = minimise(&[1.0; 2], &[0.0; 2], &rows, &bounds)?;
    Ok(optimum.map(|optimum| {
        let back = Vector2::new(optimum.x[0], optimum.x[1]) * unit;
        let held_back_by = optimum.multipliers.iter().zip(facets).max_by(|a, b| a.0.total_cmp(b.0));
        let cable = held_back_by.map(|(_, facet)| facet.cable);
        Nearest { point: goal + back, distance: back.norm(), cable }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Gains;
    use crate::reach::{in_static_workspace, polygon};
    use rand::{RngExt, SeedableRng};

    /// By projection on every edge of the polygon.
    fn by_edges(goal: &Vector2<f64>, vertices: &[Vector2<f64>]) -> f64 {
        let edge = |k: usize| {
            let (from, to) = (vertices[k], vertices[(k + 1) % vertices.len()]);
            let along = ((goal - from).dot(&(to - from)) / (to - from).norm_squared()).clamp(0.0, 1.0);
            (from + (to - from) * along - goal).norm()
        };
        (0..vertices.len()).map(edge).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn is_as_near_as_the_nearest_edge_of_the_polygon() {
        let robot = RobotParameters::default();
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        let mut moved = 0;
        for _ in 0..1000 {
            let mut point = || Vector2::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5));
            let (from, goal) = (point() * 0.3, point());
            let mut facets = workspace_facets(&robot);
            facets.extend(domain_facets(&BoundedDomain::new(&robot, &gains, from, 1.0)));
            let planes: Vec<_> = facets.iter().map(|facet| facet.half_plane).collect();
            let nearest = nearest_admissible(&goal, &facets, 0.0).unwrap().unwrap();
            let inside = planes.iter().all(|plane| plane.slack(&goal) >= 0.0);
            let expected = if inside { 0.0 } else { by_edges(&goal, &polygon(&planes, 1.0)) };
            assert!((nearest.distance - expected).abs() < 1e-6, "{nearest:?}, not {expected}");
            assert_eq!(nearest.cable.is_none(), inside);
            assert!(planes.iter().all(|plane| plane.slack(&nearest.point) > -1e-7));
            moved += usize::from(!inside);
        }
        assert!(moved > 300, "{moved}");
    }

    #[test]
    fn names_the_cable_that_forbids_the_goal() {
        let robot = RobotParameters::default();
        // Beyond facet 5, whose outward normal has azimuth 30 degrees.
        let goal = Vector2::new(30f64.to_radians().cos(), 30f64.to_radians().sin()) * 0.3;
        let nearest = nearest_admissible(&goal, &workspace_facets(&robot), 1e-3).unwrap().unwrap();
        assert_eq!(nearest.cable, Some(5));
        assert!((nearest.distance - 0.076).abs() < 1e-6, "{nearest:?}");
        assert!(in_static_workspace(&robot, &nearest.point));
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        let domain = domain_facets(&BoundedDomain::new(&robot, &gains, Vector2::zeros(), 1.0));
        assert_eq!(nearest_admissible(&goal, &domain, 0.0).unwrap().unwrap().cable, Some(5));
    }

    #[test]
    fn a_margin_wider_than_the_workspace_leaves_nothing() {
        let facets = workspace_facets(&RobotParameters::default());
        assert_eq!(nearest_admissible(&Vector2::new(1.0, 0.0), &facets, 0.3).unwrap(), None);
    }
}
