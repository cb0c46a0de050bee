//! Coming to rest: where a robot in motion can stop soonest with every cable taut, and the tensions of that when no pose is known any more.

use serde::{Deserialize, Serialize};

use super::planner::{MOST_SPANS, Planner, Situation};
use crate::control::{Response, static_tensions, tensions};
use crate::robot::memory::are_finite;
use crate::robot::{Coordinates, PerCable, Pose};

/// How far ahead stops are tried, as a part of the way at which the law does not brake at first: hard stops come first.
const TRIED: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A stop under way: it follows the closed form from the last known state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Stop {
    /// The last known state, and its time, s.
    pub pose: Pose,
    pub rates: Coordinates,
    pub since: f64,
    /// Where it ends.
    pub at: Pose,
}

impl Stop {
    /// Whether a run can have left this.
    pub fn is_sound(&self) -> bool {
        [&self.pose.0, &self.rates, &self.at.0].into_iter().all(are_finite) && self.since.is_finite()
    }
}

impl Planner {
    /// The nearest set point straight ahead to which the certificate proves the way; the active one, which was proved once, if there is none.
    pub(super) fn stop(&self, now: &Situation) -> Pose {
        let gains = self.parameters.gains();
        let ahead = now.rates * ((gains.lambda + gains.eta) / gains.omega_n_squared());
        let mut spans = MOST_SPANS;
        TRIED
            .into_iter()
            .map(|share| Pose(now.pose.0 + ahead * share))
            .find(|at| self.rests_at(at, 0.0) && self.is_proved(now, at, 0.0, &mut spans))
            .unwrap_or(*now.set_point)
    }

    /// The tensions of a stop at a time, s, N.
    pub(super) fn tensions_of(&self, stop: &Stop, time: f64) -> Option<PerCable<f64>> {
        let response = Response::at(&self.parameters.gains(), (time - stop.since).max(0.0));
        let (pose, rates, acceleration) = response.motion_of(&stop.pose, &stop.rates, &stop.at);
        let margin = self.allowance();
        tensions(self.rig(), &pose, &rates, &acceleration, margin)
            .or_else(|| static_tensions(self.rig(), &stop.at, margin))
    }
}
