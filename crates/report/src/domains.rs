//! The reachable domain out of which a set point was chosen, as an outline in the plane.

use nalgebra::{Vector2, Vector3};

use super::history::History;
use cable_robot::plan::PlannerKind;
use cable_robot::reach::{BoundedDomain, ExactDomain, HalfPlane, exact::NEVER_SLACK, polygon};

/// Rays to the border of an exact domain.
const RAYS: u32 = 48;
/// The exact domain is of translations: of poses turned by less than this, rad.
const LEVEL: f64 = 1e-2;

/// The domain in which the planner looked when it gave the set point of `row`: (15) from the set point before, the exact domain from
/// the state of that moment, each at the height of the set point. `None` if that is not known or the planner looked nowhere.
pub fn domain(history: &History, before: usize, row: usize) -> Option<Vec<[f64; 2]>> {
    let estimate = history.estimate.as_ref()?;
    let parameters = &history.info.controller_parameters;
    let (robot, gains) = (history.paper.as_ref()?, parameters.gains());
    let from = history.set_point[before].position();
    match parameters.planner {
        PlannerKind::Bounded => {
            let domain = BoundedDomain::new(robot, &gains, from.xy(), from.z);
            vertices(&domain.half_planes(), 2.0 * robot.a)
        }
        // It looks for a motion, not for a set point.
        PlannerKind::MinimumTime => None,
        PlannerKind::Exact => {
            let (pose, rates) = &estimate[row];
            if [pose, &history.set_point[row]].iter().any(|pose| pose.angles().amax() > LEVEL) {
                return None;
            }
            let velocity = rates.fixed_rows::<3>(0).into_owned();
            let domain = ExactDomain::new(robot, &gains, NEVER_SLACK, pose.position(), velocity);
            let middle = Vector3::new(from.x, from.y, history.set_point[row].0[2]);
            rays(&domain, &middle, 2.0 * robot.a)
        }
    }
}

/// Vertices of what the half-planes bound.
fn vertices(half_planes: &[HalfPlane], extent: f64) -> Option<Vec<[f64; 2]>> {
    let vertices = polygon(half_planes, extent);
    (!vertices.is_empty()).then(|| vertices.iter().map(|v| [v.x, v.y]).collect())
}

/// How far the convex set goes on rays from a point in it.
fn rays(domain: &ExactDomain, middle: &Vector3<f64>, extent: f64) -> Option<Vec<[f64; 2]>> {
    let border = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(RAYS);
        let end = middle + Vector2::new(angle.cos(), angle.sin()).push(0.0) * extent;
        let point = middle + (end - middle) * domain.farthest(middle, &end)?;
        Some([point.x, point.y])
    };
    (0..RAYS).map(border).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::run;

    /// Whether the point is on the inner side of every edge.
    fn surrounds(outline: &[[f64; 2]], point: &Vector2<f64>) -> bool {
        let edges = outline.iter().zip(outline.iter().cycle().skip(1));
        edges
            .map(|(a, b)| (Vector2::from(*a), Vector2::from(*b)))
            .all(|(a, b)| (b - a).perp(&(point - a)) > 0.0)
    }

    #[test]
    fn each_set_point_lies_in_the_domain_that_it_was_chosen_from() {
        for planner in [PlannerKind::Bounded, PlannerKind::Exact] {
            let folder = run(planner, 6.0, 0.0);
            let history = History::new(&folder).unwrap();
            let rows = history.set_point_rows();
            assert!(rows.len() >= 3, "{planner:?}: {rows:?}");
            for pair in rows.windows(2) {
                let outline = domain(&history, pair[0], pair[1]).unwrap();
                let set_point = history.set_point[pair[1]].position().xy();
                assert!(surrounds(&outline, &set_point), "{planner:?} {set_point} {outline:?}");
                assert!(!surrounds(&outline, &(set_point * 4.0)), "{planner:?} {outline:?}");
            }
        }
    }

    #[test]
    fn rays_find_the_closed_form_of_rest() {
        let folder = run(PlannerKind::Exact, 0.1, 0.0);
        let gains = folder.info.controller_parameters.gains();
        let robot = cable_robot::robot::RobotParameters::default();
        let from = Vector3::new(0.05, -0.02, 1.0);
        let domain = ExactDomain::new(&robot, &gains, NEVER_SLACK, from, Vector3::zeros());
        for point in rays(&domain, &from, 0.9).unwrap() {
            let slack =
                domain.half_planes().iter().map(|h| h.slack(&point.into())).fold(f64::INFINITY, f64::min);
            assert!(slack.abs() < 1e-6, "{point:?}: {slack}");
        }
    }
}
