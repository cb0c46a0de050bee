//! How small a tension will get on the way to the active set point.

use serde::{Deserialize, Serialize};

use crate::control::{Gains, Response, response, tensions};
use crate::robot::{Coordinates, Pose, Rig};

/// Instants looked at, denser at the start.
const INSTANTS: usize = 32;

/// Smallest tension of any cable from each of a row of instants on, along the closed form (12), (13) of all six coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    made_at: f64,
    horizon: f64,
    smallest: [f64; INSTANTS],
}

impl Prediction {
    /// Predicts from this state at `time` to rest at the set point; more than six cables keep `margin` (N) from their limits. Where the wrench matrix is singular no tension counts as
    /// sure: zero.
    pub fn new(
        rig: &Rig,
        gains: &Gains,
        (pose, rates): (&Pose, &Coordinates),
        set_point: &Pose,
        time: f64,
        margin: f64,
    ) -> Self {
        let horizon = response::time_to_rest(gains);
        let mut prediction = Self { made_at: time, horizon, smallest: [0.0; INSTANTS] };
        let mut smallest = f64::INFINITY;
        for (k, t) in response::instants(horizon, INSTANTS).enumerate().rev() {
            let (pose, rates, acceleration) = Response::at(gains, t).motion_of(pose, rates, set_point);
            let tension = tensions(rig, &pose, &rates, &acceleration, margin);
            smallest = tension.map_or(smallest.min(0.0), |u| u.into_iter().fold(smallest, f64::min));
            prediction.smallest[k] = smallest;
        }
        prediction
    }

    /// Smallest tension predicted from `time` on, N.
    pub fn smallest_from(&self, time: f64) -> f64 {
        let share = ((time - self.made_at) / self.horizon).clamp(0.0, 1.0);
        let before = share.sqrt() * (INSTANTS - 1) as f64;
        self.smallest[before as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RigFile;

    #[test]
    fn a_step_to_the_papers_goal_ends_with_its_static_tension() {
        let rig = RigFile::default().rig;
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        let (start, goal) = (Pose::default(), Pose::at(0.15, 0.15, 1.0));
        let of = |goal: &Pose, time| {
            Prediction::new(&rig, &gains, (&start, &Coordinates::zeros()), goal, time, 0.0)
        };
        let prediction = of(&goal, 2.0);
        // NOTES.md: the one-step move is admissible with a margin of 1.05 N, though (15) cannot tell.
        assert!((prediction.smallest_from(2.0) - 1.050).abs() < 1e-3, "{prediction:?}");
        let far = Pose::at(0.0, 0.4, 1.0);
        let prediction = of(&far, 0.0);
        assert!(prediction.smallest_from(0.0) < 0.0);
    }
}
