//! Eq. (15): the paper's reachable domain, for a step in x, y or both, in all four quadrants.

use nalgebra::Vector2;

use super::HalfPlane;
use crate::control::Gains;
use crate::robot::RobotParameters;
use crate::robot::triangles::{FACET_NORMALS, SIX};

/// Set points x_d that a step from rest at x₀ (height z_c and zero orientation kept) may be given.
///
/// Cable i is in tension when nᵢ·p < a/2 for p = x + x'' z_c/g. Each coordinate of x and of x'' is bounded apart, Eq. (14):
/// with c = z_c ω_n²/g a coordinate of p lies between x₀ - c Z_M d and x_d + c d, where d = x_d - x₀. Every facet is asked
/// the worst corner of that rectangle. Strictly inside is admissible; on the border a tension could touch zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedDomain {
    from: Vector2<f64>,
    c: f64,
    z_m: f64,
    bound: f64,
}

impl BoundedDomain {
    /// The domain of a step from rest at `from` (m) at height `z_c` (m, greater than 0).
    pub fn new(robot: &RobotParameters, gains: &Gains, from: Vector2<f64>, z_c: f64) -> Self {
        Self { from, c: z_c * gains.omega_n_squared() / robot.g, z_m: gains.z_m(), bound: robot.a / 2.0 }
    }

    /// Whether the step to `x_d` is admissible.
    pub fn contains(&self, x_d: &Vector2<f64>) -> bool {
        let d = x_d - self.from;
        let push = x_d + d * self.c;
        let pull = self.from - d * (self.c * self.z_m);
        FACET_NORMALS.iter().all(|normal| {
            let worst = |k: usize| (normal[k] * push[k]).max(normal[k] * pull[k]);
            worst(0) + worst(1) < self.bound
        })
    }

    /// The same set as half-planes in x_d. For each facet both coordinates may take either end of their interval: the printed
    /// rows of (15) are the ones that bind for x_d ≥ x₀, y_d ≥ y₀, the others those of the other quadrants.
    pub fn half_planes(&self) -> [HalfPlane; 4 * SIX] {
        let push = (1.0 + self.c, -self.c); // x_d + c d = (1 + c) x_d - c x₀
        let pull = (-self.c * self.z_m, 1.0 + self.c * self.z_m); // x₀ - c Z_M d
        std::array::from_fn(|row| {
            let normal = FACET_NORMALS[row / 4];
            let (x_d, x_0) = if row & 1 == 0 { push } else { pull };
            let (y_d, y_0) = if row & 2 == 0 { push } else { pull };
            HalfPlane {
                normal: Vector2::new(normal.x * x_d, normal.y * y_d),
                bound: self.bound - normal.x * x_0 * self.from.x - normal.y * y_0 * self.from.y,
            }
        })
    }

    /// The farthest admissible step from x₀ along `direction`, as a multiple of it (the border itself, not admissible).
    /// Along an axis this is the submotion x or y. Zero if x₀ is outside the static workspace.
    pub fn ray(&self, direction: &Vector2<f64>) -> f64 {
        self.half_planes().iter().map(|h| h.ray(&self.from, direction)).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Response;
    use crate::control::tensions;
    use crate::robot::{Coordinates, Pose, Rig, TensionLimits};
    use rand::{RngExt, SeedableRng};

    const TABLE_I: Gains = Gains { lambda: 3.0, eta: 3.0 };

    fn random_point(rng: &mut rand_pcg::Pcg64) -> Vector2<f64> {
        Vector2::new(rng.random_range(-0.26..0.26), rng.random_range(-0.26..0.26))
    }

    /// Rows of (15) as printed and mended, for x_d ≥ x₀ and y_d ≥ y₀.
    fn printed_rows(a: f64, c: f64, z_m: f64, x: &Vector2<f64>, x0: &Vector2<f64>) -> bool {
        let s3 = 3f64.sqrt();
        let hi = |d: f64, o: f64| d + c * (d - o);
        let lo = |d: f64, o: f64| o - c * z_m * (d - o);
        let (xh, xl, yh, yl) = (hi(x.x, x0.x), lo(x.x, x0.x), hi(x.y, x0.y), lo(x.y, x0.y));
        yh < s3 * xl + a
            && yh < a / 2.0
            && yl > -a / 2.0
            && yl > -s3 * xl - a
            && yh < -s3 * xh + a
            && yl > s3 * xh - a
    }

    #[test]
    fn is_the_printed_matrix_in_the_first_quadrant() {
        let robot = RobotParameters::default();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(15);
        let mut inside = 0;
        for _ in 0..20_000 {
            let (x0, step) = (random_point(&mut rng), random_point(&mut rng).abs());
            let domain = BoundedDomain::new(&robot, &TABLE_I, x0, 1.0);
            let expected = printed_rows(robot.a, 9.0 / 9.81, (-2f64).exp(), &(x0 + step), &x0);
            assert_eq!(domain.contains(&(x0 + step)), expected);
            inside += usize::from(expected);
        }
        assert!(inside > 500, "too few cases inside to mean anything: {inside}");
    }

    #[test]
    fn half_planes_and_rays_are_the_same_set() {
        let robot = RobotParameters::default();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(24);
        for _ in 0..20_000 {
            let (x0, x_d) = (random_point(&mut rng), random_point(&mut rng));
            let domain = BoundedDomain::new(&robot, &TABLE_I, x0, rng.random_range(0.3..3.0));
            let inside = domain.contains(&x_d);
            assert_eq!(domain.half_planes().iter().all(|h| h.slack(&x_d) > 0.0), inside);
            assert_eq!(domain.ray(&(x_d - x0)) > 1.0, inside);
        }
    }

    #[test]
    fn submotions_x_and_y_reach_as_far_as_the_domain_does() {
        let robot = RobotParameters::default();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
        for _ in 0..2000 {
            let x0 = random_point(&mut rng);
            let domain = BoundedDomain::new(&robot, &TABLE_I, x0, 1.0);
            for direction in [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()] {
                let reach = domain.ray(&direction);
                assert_eq!(reach > 0.0, crate::reach::in_static_workspace(&robot, &x0));
                assert!(reach == 0.0 || domain.contains(&(x0 + direction * reach * 0.999_999)));
                assert!(!domain.contains(&(x0 + direction * reach * 1.000_001)));
            }
        }
    }

    #[test]
    fn no_step_that_it_admits_slackens_a_cable() {
        let robot = RobotParameters::default();
        let rig = Rig::paper(&robot, TensionLimits::default());
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        let mut admitted = 0;
        while admitted < 500 {
            let gains = Gains { lambda: rng.random_range(1.0..8.0), eta: rng.random_range(1.0..8.0) };
            let z = rng.random_range(0.5..2.0);
            let (x0, x_d) = (random_point(&mut rng), random_point(&mut rng));
            if !BoundedDomain::new(&robot, &gains, x0, z).contains(&x_d) {
                continue;
            }
            admitted += 1;
            for k in 0..200 {
                let response = Response::at(&gains, 0.02 * f64::from(k));
                let (x, y) = (response.motion(x0.x, 0.0, x_d.x), response.motion(x0.y, 0.0, x_d.y));
                let of = |d: usize| Coordinates::new(x[d], y[d], 0.0, 0.0, 0.0, 0.0);
                let u = tensions(&rig, &Pose::at(x[0], y[0], z), &of(1), &of(2), 0.0).unwrap();
                assert!(u.iter().all(|u| *u > 0.0), "{u:?} from {x0} to {x_d}");
            }
        }
    }
}
