//! How small a tension will get on the way to the active set point.

use serde::{Deserialize, Serialize};

use crate::control::{Gains, Response, lyapunov};
use crate::robot::{Coordinates, Geometry, Pose, RobotParameters, tensions};

/// Instants looked at, denser at the start.
const INSTANTS: usize = 32;
/// Time constants of the slower gain after which the robot is taken to rest.
const TIME_CONSTANTS: f64 = 20.0;

/// Smallest tension of any cable from each of a row of instants on, along the closed form (12), (13) of all six coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    made_at: f64,
    horizon: f64,
    smallest: [f64; INSTANTS],
}

impl Prediction {
    /// Predicts from this state at `time` to rest at the set point. Where the wrench matrix is singular no tension counts as
    /// sure: zero.
    pub fn new(
        robot: &RobotParameters,
        geometry: &Geometry,
        gains: &Gains,
        (pose, rates): (&Pose, &Coordinates),
        set_point: &Pose,
        time: f64,
    ) -> Self {
        let mut prediction = Self {
            made_at: time,
            horizon: TIME_CONSTANTS / gains.lambda.min(gains.eta),
            smallest: [0.0; INSTANTS],
        };
        let error = pose.minus(set_point);
        let mut smallest = f64::INFINITY;
        for k in (0..INSTANTS).rev() {
            let response = Response::at(gains, prediction.instant(k));
            let moved = |i: usize| response.motion(set_point.0[i] + error[i], rates[i], set_point.0[i]);
            let mut state = [Coordinates::zeros(); 2];
            for i in 0..6 {
                let [x, v, _] = moved(i);
                (state[0][i], state[1][i]) = (x, v);
            }
            let (pose, rates) = (Pose(state[0]), state[1]);
            let acceleration = lyapunov::acceleration(gains, &pose, &rates, set_point);
            let tension = tensions(robot, geometry, &pose, &rates, &acceleration).unwrap_or_default();
            smallest = tension.iter().copied().fold(smallest, f64::min);
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

    /// Seconds from the prediction to its instant `k`.
    fn instant(&self, k: usize) -> f64 {
        self.horizon * (k as f64 / (INSTANTS - 1) as f64).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_to_the_papers_goal_ends_with_its_static_tension() {
        let robot = RobotParameters::default();
        let geometry = Geometry::new(&robot);
        let gains = Gains { lambda: 3.0, eta: 3.0 };
        let (start, goal) = (Pose::default(), Pose::at(0.15, 0.15, 1.0));
        let prediction =
            Prediction::new(&robot, &geometry, &gains, (&start, &Coordinates::zeros()), &goal, 2.0);
        // NOTES.md: the one-step move is admissible with a margin of 1.05 N, though (15) cannot tell.
        assert!((prediction.smallest_from(2.0) - 1.050).abs() < 1e-3, "{prediction:?}");
        let far = Pose::at(0.0, 0.4, 1.0);
        let prediction =
            Prediction::new(&robot, &geometry, &gains, (&start, &Coordinates::zeros()), &far, 0.0);
        assert!(prediction.smallest_from(0.0) < 0.0);
    }
}
