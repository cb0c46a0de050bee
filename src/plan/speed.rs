//! Limits of speeds: set points so near that the motion to them keeps the limits. Derived in docs/exact.md.

use super::exact::Way;
use super::planner::{Planner, Situation};
use crate::reach::Curve;
use crate::robot::{Coordinates, Pose};

/// Halvings of the way to the goal.
const HALVINGS: usize = 40;

impl Planner {
    /// The farthest set point on the straight way from the active one to `goal` on the way to which no speed exceeds its limit; the active one
    /// where there is none.
    pub(super) fn within_speed(&self, now: &Situation, goal: &Pose) -> Pose {
        if self.keeps_speeds(now, goal) {
            return *goal;
        }
        let way = Way { from: now.set_point, goal };
        let (mut too_far, mut near) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (too_far + near);
            *(if self.keeps_speeds(now, &way.at(middle)) { &mut near } else { &mut too_far }) = middle;
        }
        if near == 1.0 { *now.set_point } else { way.at(near) }
    }

    /// Whether the closed form from the present state keeps the limits of speeds.
    pub(super) fn keeps_speeds(&self, now: &Situation, set_point: &Pose) -> bool {
        let parameters = &self.parameters;
        let (speed, spin) = (parameters.max_speed, parameters.max_angular_rate);
        let cable = parameters.max_cable_speed;
        if speed == 0.0 && spin == 0.0 && cable == 0.0 {
            return true;
        }
        let fastest = self.fastest(now, set_point);
        let linear = fastest.fixed_rows::<3>(0).norm();
        // Each angle turns the platform about an axis of its own.
        let angular = fastest.fixed_rows::<3>(3).sum();
        // A cable's end moves no faster than its attachment.
        let end = linear + angular * self.rig().platform_radius();
        [(linear, speed), (angular, spin), (end, cable)]
            .into_iter()
            .all(|(value, limit)| limit == 0.0 || value <= limit)
    }

    /// The greatest absolute rate of each coordinate: x' = v f - (λη e + (λ+η) v) φ, the derivative of (12) with φ' = f - (λ+η) φ.
    fn fastest(&self, now: &Situation, set_point: &Pose) -> Coordinates {
        let gains = self.parameters.gains();
        let error = now.pose.minus(set_point);
        Coordinates::from_fn(|k, _| {
            let rate = now.rates[k];
            let of_phi = -gains.omega_n_squared() * error[k] - (gains.lambda + gains.eta) * rate;
            let extremes = Curve { a: 0.0, b: rate, c: of_phi, d: 0.0 }.extremes(&gains);
            extremes.max.max(-extremes.min)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Response;
    use crate::plan::{ControllerParameters, PlannerKind};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn no_rate_of_the_closed_form_is_greater_than_is_said() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        for _ in 0..300 {
            let mut any = |size: f64| Coordinates::from_fn(|_, _| rng.random_range(-size..size));
            let (pose, rates, set_point) = (Pose(any(0.5)), any(1.0), Pose(any(0.5)));
            let (lambda, eta) = (rng.random_range(0.5..10.0), rng.random_range(0.5..10.0));
            let planner = Planner::from(ControllerParameters {
                planner: PlannerKind::Exact,
                lambda,
                eta,
                ..Default::default()
            });
            let now = Situation {
                pose: &pose,
                rates: &rates,
                set_point: &set_point,
                hold: 1e-3,
                rest: planner.rest,
            };
            let said = planner.fastest(&now, &set_point);
            let mut seen = Coordinates::zeros();
            for k in 0..=4000 {
                let response = Response::at(&planner.parameters.gains(), 2.5e-3 * f64::from(k));
                let (_, rates, _) = response.motion_of(&pose, &rates, &set_point);
                seen = seen.zip_map(&rates, |most, rate| most.max(rate.abs()));
            }
            assert!((0..6).all(|k| seen[k] <= said[k] + 1e-12 && said[k] < seen[k] + 1e-3), "{seen} {said}");
        }
    }
}
