//! What tensions that are held from one command to the next may leave a motion in arcs by. Derived in docs/minimum-time.md.

use super::arc::Timing;
use super::line::Line;
use crate::control::Gains;
use crate::robot::triangles::SIX;

/// Arcs that are a smaller share of the motion change what counts with the switches.
const SHORT: f64 = 1e-4;

/// At most this much, N, where the tensions have these derivatives on every arc (N/s, N/s²) and change by so much in all (N), for commands that are held
/// for h and act d after they were computed, `span` = h (h + d) in s². To second order: an arc's tensions change smoothly, a switch of arcs displaces
/// the platform by an eighth of what it changes the acceleration by times h².
pub fn cost_of_holding(gains: &Gains, span: f64, [first, second, change]: [f64; 3]) -> f64 {
    let sum = gains.lambda + gains.eta;
    let of_switches = gains.omega_n_squared() * change / 8.0;
    span * (sum * first / 8.0 + (1.0 + 2.0 * gains.z_m()) * second / 24.0 + of_switches)
}

impl Line {
    /// The greatest first and second derivative of a tension on an arc, N/s and N/s²: of the parabola through its ends and its middle.
    pub fn derivatives(&self, timing: &Timing) -> [f64; 2] {
        let (mut first, mut second) = (0.0f64, 0.0f64);
        for (arc, length) in timing.spans() {
            // The differences of a shorter one are rounding.
            if length < SHORT * timing.duration {
                continue;
            }
            let [start, middle, end] = [0.0, 0.5, 1.0].map(|share| {
                let [s, _, a] = arc.at(share * length);
                self.tensions(s, a)
            });
            for i in 0..SIX {
                let bend = start[i] - 2.0 * middle[i] + end[i];
                first = first.max(((end[i] - start[i]).abs() + 2.0 * bend.abs()) / length);
                second = second.max(4.0 * bend.abs() / (length * length));
            }
        }
        [first, second]
    }

    /// What the tension of a cable changes by at most on the way, and the greatest of all, N: at the ends of the arcs.
    pub fn extent(&self, timing: &Timing) -> [f64; 2] {
        let (mut least, mut greatest) = ([f64::INFINITY; SIX], [f64::NEG_INFINITY; SIX]);
        let mut include = |tension: [f64; SIX]| {
            for i in 0..SIX {
                least[i] = least[i].min(tension[i]);
                greatest[i] = greatest[i].max(tension[i]);
            }
        };
        for (arc, length) in timing.spans() {
            for at in [0.0, length] {
                let [s, _, a] = arc.at(at);
                include(self.tensions(s, a));
            }
        }
        let change = (0..SIX).map(|i| greatest[i] - least[i]).fold(0.0, f64::max);
        [change, greatest.into_iter().fold(0.0, f64::max)]
    }
}
