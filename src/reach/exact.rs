//! Exactly the set points that slacken no cable: for every translation, from rest or from any velocity. Proofs: docs/exact.md.

use nalgebra::{Vector2, Vector3};

use super::{Curve, HalfPlane};
use crate::control::Gains;
use crate::robot::triangles::{FACET_NORMALS, SIX};
use crate::robot::{RobotParameters, TensionLimits};

/// What the search along a segment aims to leave to the limit, as a part of g a/2: the search ends this near to the border.
const RAY_TOLERANCE: f64 = 1e-9;
/// The search needs four or five cuts; where it would need more it stops at the last point found admissible.
const MOST_CUTS: usize = 40;

/// Set points x_d (x, y, z; zero orientation) from which the translation that starts at `position` with `velocity` keeps every
/// tension within the limits for all time.
///
/// Cable i pulls u_i = m l_i G_i/(3 a z) with G_i = (g - z'')(a/2 - n_i·P_xy) - z n_i·P_xy''. Each G_i is a [`Curve`], affine in x_d: the
/// set is convex. With u_min = 0 and u_max out of reach it is exact; other limits are met with z ≤ l_i ≤ κ z, so that no accepted set point breaks
/// them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactDomain {
    robot: RobotParameters,
    gains: Gains,
    limits: TensionLimits,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
}

/// Limits of tension that are no limits but zero: cables must not be slack.
pub const NEVER_SLACK: TensionLimits = TensionLimits { min: 0.0, max: f64::INFINITY };

impl ExactDomain {
    /// The domain from this position (m, z greater than 0) and velocity (m/s).
    pub fn new(
        robot: &RobotParameters,
        gains: &Gains,
        limits: TensionLimits,
        position: Vector3<f64>,
        velocity: Vector3<f64>,
    ) -> Self {
        Self { robot: *robot, gains: *gains, limits, position, velocity }
    }

    /// Whether the set point is admissible: necessary and sufficient.
    pub fn contains(&self, x_d: &Vector3<f64>) -> bool {
        if self.height(x_d).extremes(&self.gains).min <= 0.0 {
            return false;
        }
        let (least, greatest) = (self.least(), self.greatest(&[*x_d]));
        (0..SIX).all(|i| {
            let extremes = self.facet(i, x_d).extremes(&self.gains);
            extremes.min > least && extremes.max < greatest
        })
    }

    /// G_i along the motion to `x_d`, m²/s².
    pub fn facet(&self, cable: usize, x_d: &Vector3<f64>) -> Curve {
        let (n, g) = (FACET_NORMALS[cable], self.robot.g);
        let error = self.position - x_d;
        let h = self.robot.a / 2.0 - n.dot(&x_d.xy());
        let (alpha, beta) = (n.dot(&error.xy()), n.dot(&self.velocity.xy()));
        let (gamma, delta) = (error.z, self.velocity.z);
        // G = g h - g (α f + β φ) - κ₁ f'' - κ₂ φ'' + (γ β - δ α) S exp(-S t); the products of f and φ cancel but for the last.
        let (kappa_1, kappa_2) = (h * gamma + x_d.z * alpha, h * delta + x_d.z * beta);
        let sum = self.gains.lambda + self.gains.eta;
        let omega2 = self.gains.omega_n_squared();
        // f'' = -ω² f + ω² S φ and φ'' = -S f + (S² - ω²) φ.
        Curve {
            a: g * h,
            b: -g * alpha + omega2 * kappa_1 + sum * kappa_2,
            c: -g * beta - omega2 * sum * kappa_1 - (sum * sum - omega2) * kappa_2,
            d: (gamma * beta - delta * alpha) * sum,
        }
    }

    /// From rest, at constant height: the domain as half-planes, two a cable, in (x_d, y_d). p moves on the segment between its values
    /// for the extremes of ψ = f + (z/g) f''. Limits of tension other than zero are left to [`contains`](Self::contains).
    pub fn half_planes(&self) -> [HalfPlane; 2 * SIX] {
        let omega2 = self.gains.omega_n_squared();
        let c = self.position.z / self.robot.g;
        let sum = self.gains.lambda + self.gains.eta;
        let psi = Curve { a: 0.0, b: 1.0 - c * omega2, c: c * omega2 * sum, d: 0.0 }.extremes(&self.gains);
        let from = self.position.xy();
        std::array::from_fn(|row| {
            let normal = FACET_NORMALS[row / 2];
            let psi = if row % 2 == 0 { psi.min } else { psi.max };
            // n·(x_d (1 - ψ) + x₀ ψ) < a/2
            HalfPlane { normal: normal * (1.0 - psi), bound: self.robot.a / 2.0 - psi * normal.dot(&from) }
        })
    }

    /// From rest: the largest s with x₀ + s `direction` not slackening a cable, in closed form (the border itself, not admissible); zero if
    /// x₀ itself cannot be rested at. Limits of tension other than zero are left to [`farthest`](Self::farthest).
    pub fn ray(&self, direction: &Vector3<f64>) -> f64 {
        let g = self.robot.g;
        let (sum, omega2) = (self.gains.lambda + self.gains.eta, self.gains.omega_n_squared());
        let to_base = if direction.z < 0.0 { -self.position.z / direction.z } else { f64::INFINITY };
        FACET_NORMALS.iter().fold(to_base, |nearest, normal| {
            let h = self.robot.a / 2.0 - normal.dot(&self.position.xy());
            let nu = normal.dot(&direction.xy());
            let kappa = direction.z * h + self.position.z * nu;
            // G = g h - s (ν g (1 - f) - κ f''): affine in s.
            let loss = Curve { a: nu * g, b: -nu * g + kappa * omega2, c: -kappa * omega2 * sum, d: 0.0 };
            let most = loss.extremes(&self.gains).max;
            if h <= 0.0 {
                0.0
            } else if most <= 0.0 {
                nearest
            } else {
                nearest.min(g * h / most)
            }
        })
    }

    /// From any state: the largest s in [0, 1] with `from` + s (`to` - `from`) admissible, to within a billionth of the way; `None` if
    /// `from` is not.
    ///
    /// G_i at a fixed time is affine in s, so the worst time of a point outside cuts off everything beyond where G_i vanishes
    /// there: Newton's method on a concave function, from outside.
    pub fn farthest(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<f64> {
        if !self.contains(from) {
            return None;
        }
        let at = |s: f64| from + (to - from) * s;
        let aim = self.least() + RAY_TOLERANCE * self.robot.g * self.robot.a / 2.0;
        let greatest = self.greatest(&[*from, *to]);
        let mut s = 1.0;
        for _ in 0..MOST_CUTS {
            let x_d = at(s);
            let mut cut = s;
            for i in 0..SIX {
                let extremes = self.facet(i, &x_d).extremes(&self.gains);
                if extremes.min <= self.least() {
                    let inside = self.facet(i, from).at(&self.gains, extremes.argmin);
                    cut = cut.min(crossing(s, inside, extremes.min, aim));
                }
                if extremes.max >= greatest {
                    // A limit from above has no worst time at hand: halve.
                    cut = cut.min(0.5 * s);
                }
            }
            if self.height(&x_d).extremes(&self.gains).min <= 0.0 {
                cut = cut.min(0.5 * s);
            }
            if cut == s {
                // What overflowed was not seen above.
                return Some(if self.contains(&x_d) { s } else { 0.0 });
            }
            s = cut;
        }
        Some(0.0)
    }

    fn height(&self, x_d: &Vector3<f64>) -> Curve {
        Curve { a: x_d.z, b: self.position.z - x_d.z, c: self.velocity.z, d: 0.0 }
    }

    /// G below which a tension may be less than u_min: l_i ≥ z.
    fn least(&self) -> f64 {
        3.0 * self.robot.a * self.limits.min / self.robot.m
    }

    /// G above which a tension may exceed u_max on the way to one of `set_points`: l_i ≤ κ z, κ from the farthest and highest that the
    /// platform gets.
    fn greatest(&self, set_points: &[Vector3<f64>]) -> f64 {
        if self.limits.max == f64::INFINITY {
            return f64::INFINITY;
        }
        let hump = 1.0 / (self.gains.lambda + self.gains.eta); // (λ₀ + η₀) φ < 1
        let swing = self.velocity.norm() * hump;
        let radius = |p: &Vector3<f64>| p.xy().norm();
        let far = set_points.iter().map(radius).fold(radius(&self.position), f64::max) + swing;
        let high = set_points.iter().map(|p| p.z).fold(self.position.z, f64::min) - swing;
        if high <= 0.0 {
            return 0.0;
        }
        // Base and platform vertices lie 2a/√3 and 2b/√3 from their centres.
        let sideways = far + 2.0 * (self.robot.a + self.robot.b) / 3f64.sqrt();
        let kappa = Vector2::new(sideways / high, 1.0).norm();
        3.0 * self.robot.a * self.limits.max / (self.robot.m * kappa)
    }
}

/// Where a line with `inside` at 0 and `outside` at `s` meets `aim`; 0 if it does not in between.
fn crossing(s: f64, inside: f64, outside: f64, aim: f64) -> f64 {
    if inside <= aim { 0.0 } else { s * (inside - aim) / (inside - outside) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Response;
    use crate::control::tensions;
    use crate::reach::{BoundedDomain, in_static_workspace};
    use crate::robot::{Coordinates, PerCable, Pose, Rig};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    struct Case {
        robot: RobotParameters,
        gains: Gains,
        position: Vector3<f64>,
        velocity: Vector3<f64>,
        x_d: Vector3<f64>,
    }

    impl Case {
        fn random(rng: &mut Pcg64, speed: f64) -> Self {
            let a = rng.random_range(0.3..0.6);
            let robot = RobotParameters {
                a,
                b: rng.random_range(0.3..0.9) * a,
                m: rng.random_range(1.0..20.0),
                ..Default::default()
            };
            let lambda = rng.random_range(1.0..8.0);
            let eta = if rng.random_range(0..3) == 0 { lambda } else { rng.random_range(1.0..8.0) };
            let mut point = || {
                let radius = 0.6 * robot.a;
                Vector3::new(
                    rng.random_range(-radius..radius),
                    rng.random_range(-radius..radius),
                    rng.random_range(0.5..2.0),
                )
            };
            let (position, x_d) = (point(), point());
            let velocity = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * speed;
            Self { robot, gains: Gains { lambda, eta }, position, velocity, x_d }
        }

        fn domain(&self) -> ExactDomain {
            ExactDomain::new(&self.robot, &self.gains, NEVER_SLACK, self.position, self.velocity)
        }

        /// Tensions at `t` by the inverse dynamics, and the height there.
        fn tensions(&self, t: f64) -> (PerCable<f64>, Vector3<f64>) {
            let response = Response::at(&self.gains, t);
            let of = |k: usize| response.motion(self.position[k], self.velocity[k], self.x_d[k]);
            let (x, y, z) = (of(0), of(1), of(2));
            let d = |k: usize| Coordinates::new(x[k], y[k], z[k], 0.0, 0.0, 0.0);
            let rig = Rig::paper(&self.robot, NEVER_SLACK);
            let u = tensions(&rig, &Pose(d(0)), &d(1), &d(2), 0.0).unwrap();
            (u, Vector3::new(x[0], y[0], z[0]))
        }
    }

    #[test]
    fn facets_are_the_tensions_of_the_inverse_dynamics() {
        let mut rng = Pcg64::seed_from_u64(31);
        for _ in 0..5000 {
            let case = Case::random(&mut rng, 0.5);
            let t = rng.random_range(0.0..2.0);
            let (u, position) = case.tensions(t);
            let rig = Rig::paper(&case.robot, NEVER_SLACK);
            let lengths = rig.cables(&position, &Pose::default().rotation()).length;
            for i in 0..SIX {
                let g = case.domain().facet(i, &case.x_d).at(&case.gains, t);
                let expected = case.robot.m * lengths[i] * g / (3.0 * case.robot.a * position.z);
                assert!(
                    (u[i] - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                    "cable {}: {} {expected}",
                    i + 1,
                    u[i]
                );
            }
        }
    }

    /// Smallest tension of dense samples.
    fn sampled_minimum(case: &Case) -> f64 {
        let instants =
            (0..400).map(|k| 10.0 / case.gains.lambda.min(case.gains.eta) * (f64::from(k) / 399.0).powi(2));
        instants
            .map(|t| case.tensions(t).0.into_iter().fold(f64::INFINITY, f64::min))
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn is_necessary_and_sufficient() {
        let mut rng = Pcg64::seed_from_u64(32);
        let (mut inside, mut outside) = (0, 0);
        for case in 0..6000 {
            let case = Case::random(&mut rng, if case % 2 == 0 { 0.0 } else { 0.3 });
            let sampled = sampled_minimum(&case);
            if case.domain().contains(&case.x_d) {
                assert!(sampled > 0.0, "{sampled} N");
                inside += 1;
            } else {
                // Nothing admissible is refused, but for what lies between two samples.
                assert!(sampled < 0.02, "refused with {sampled} N");
                outside += 1;
            }
        }
        assert!(inside > 500 && outside > 500, "{inside} inside, {outside} outside");
    }

    #[test]
    fn every_pair_of_the_static_workspace_is_one_step_if_omega_squared_z_is_at_most_g() {
        let mut rng = Pcg64::seed_from_u64(33);
        let mut pairs = 0;
        while pairs < 5000 {
            let mut case = Case::random(&mut rng, 0.0);
            case.x_d.z = case.position.z;
            let inside = |p: &Vector3<f64>| in_static_workspace(&case.robot, &p.xy());
            let k = case.gains.omega_n_squared() * case.position.z / case.robot.g;
            if k <= 1.0 && inside(&case.position) && inside(&case.x_d) {
                assert!(case.domain().contains(&case.x_d));
                pairs += 1;
            }
        }
    }

    #[test]
    fn psi_lies_between_0_and_1_if_omega_squared_z_is_at_most_g() {
        let mut rng = Pcg64::seed_from_u64(34);
        for _ in 0..100_000 {
            let gains = Gains { lambda: rng.random_range(0.1..20.0), eta: rng.random_range(0.1..20.0) };
            let k = rng.random_range(0.0..=1.0);
            let [f, _, f2] = Response::at(&gains, rng.random_range(0.0..5.0)).step_error();
            let psi = f + k / gains.omega_n_squared() * f2;
            assert!((-1e-12..=1.0 + 1e-12).contains(&psi), "{psi}");
        }
    }

    #[test]
    fn half_planes_and_rays_from_rest_are_the_same_set() {
        let mut rng = Pcg64::seed_from_u64(35);
        for _ in 0..20_000 {
            let mut case = Case::random(&mut rng, 0.0);
            let reach = case.domain().ray(&(case.x_d - case.position));
            if in_static_workspace(&case.robot, &case.position.xy()) {
                assert_eq!(reach > 1.0, case.domain().contains(&case.x_d));
            } else {
                assert_eq!(reach, 0.0);
            }
            case.x_d.z = case.position.z;
            let inside = case.domain().contains(&case.x_d);
            assert_eq!(case.domain().half_planes().iter().all(|h| h.slack(&case.x_d.xy()) > 0.0), inside);
        }
    }

    #[test]
    fn farthest_ends_at_the_border_from_any_state() {
        let mut rng = Pcg64::seed_from_u64(36);
        let mut partial = 0;
        for _ in 0..20_000 {
            let case = Case::random(&mut rng, 0.3);
            let domain = case.domain();
            let start = case.position;
            let Some(s) = domain.farthest(&start, &case.x_d) else {
                assert!(!domain.contains(&start));
                continue;
            };
            let at = |s: f64| start + (case.x_d - start) * s;
            assert!(domain.contains(&at(s)));
            if s < 1.0 {
                assert!(!domain.contains(&at(s + 1e-6)), "stopped short at {s}");
                partial += 1;
            }
        }
        assert!(partial > 2000, "{partial}");
    }

    #[test]
    fn limits_in_newtons_are_kept() {
        let mut rng = Pcg64::seed_from_u64(37);
        let mut accepted = 0;
        while accepted < 500 {
            let case = Case::random(&mut rng, 0.2);
            let weight = case.robot.m * case.robot.g;
            let limits = TensionLimits { min: 0.03 * weight, max: 0.5 * weight };
            let domain = ExactDomain::new(&case.robot, &case.gains, limits, case.position, case.velocity);
            if domain.contains(&case.x_d) {
                accepted += 1;
                for k in 0..300 {
                    let (u, _) = case.tensions(0.01 * f64::from(k));
                    assert!(u.iter().all(|u| (limits.min..=limits.max).contains(u)), "{u:?} {limits:?}");
                }
            }
        }
    }

    #[test]
    fn contains_all_that_the_bounded_domain_does() {
        let mut rng = Pcg64::seed_from_u64(38);
        let mut both = 0;
        for _ in 0..20_000 {
            let mut case = Case::random(&mut rng, 0.0);
            case.x_d.z = case.position.z;
            let bounded = BoundedDomain::new(&case.robot, &case.gains, case.position.xy(), case.position.z);
            if bounded.contains(&case.x_d.xy()) {
                assert!(case.domain().contains(&case.x_d));
                both += 1;
            }
        }
        assert!(both > 500, "{both}");
    }
}
