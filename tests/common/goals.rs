//! Random goals.

use cable_robot::robot::Pose;
use nalgebra::Vector2;
use rand::RngExt;
use rand_pcg::Pcg64;

/// A goal at least `margin` m inside the static workspace, at a height around `z`.
pub fn random_goal(rng: &mut Pcg64, z: f64, margin: f64) -> Pose {
    loop {
        let point = Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26));
        let facets = cable_robot::reach::static_workspace(&Default::default());
        if facets.iter().all(|facet| facet.slack(&point) > margin) {
            return Pose::at(point.x, point.y, z * rng.random_range(0.9..1.1));
        }
    }
}
