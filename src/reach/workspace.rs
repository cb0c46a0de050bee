//! Eq. (16): where all tensions are positive at rest, with zero orientation.

use nalgebra::Vector2;

use super::HalfPlane;
use crate::robot::RobotParameters;
use crate::robot::triangles::{FACET_NORMALS, SIX};

/// The hexagon of apothem a/2, one half-plane a cable; the same at every height below the base.
pub fn static_workspace(robot: &RobotParameters) -> [HalfPlane; SIX] {
    FACET_NORMALS.map(|normal| HalfPlane { normal, bound: robot.a / 2.0 })
}

/// Whether every cable is in tension at rest at (x, y).
pub fn in_static_workspace(robot: &RobotParameters, point: &Vector2<f64>) -> bool {
    static_workspace(robot).iter().all(|facet| facet.slack(point) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::static_tensions;
    use crate::reach::polygon;
    use crate::robot::{Pose, Rig, TensionLimits};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn facet_i_is_where_cable_i_goes_slack() {
        let robot = RobotParameters::default();
        let rig = Rig::paper(&robot, TensionLimits::default());
        let facets = static_workspace(&robot);
        let mut rng = rand_pcg::Pcg64::seed_from_u64(16);
        for _ in 0..10_000 {
            let point = Vector2::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5));
            let pose = Pose::at(point.x, point.y, rng.random_range(0.3..3.0));
            let tension = static_tensions(&rig, &pose, 0.0).unwrap();
            for i in 0..6 {
                assert_eq!(tension[i] > 0.0, facets[i].slack(&point) > 0.0, "cable {} at {point}", i + 1);
            }
        }
    }

    #[test]
    fn is_a_hexagon() {
        let vertices = polygon(&static_workspace(&RobotParameters::default()), 10.0);
        assert_eq!(vertices.len(), 6);
        for v in vertices {
            assert!((v.norm() - 0.225 / (std::f64::consts::PI / 6.0).cos()).abs() < 1e-12);
        }
    }
}
