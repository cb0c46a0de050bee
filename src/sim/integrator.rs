//! Dormand and Prince's Runge-Kutta pair of orders 5 and 4 with controlled error, for the 13 states of a rigid body.

use nalgebra::SVector;

use super::body::State;

/// Error allowed a step: absolute (m, m/s, 1, rad/s) plus relative. Small enough that results do not depend on how a time span is
/// cut into communication steps.
const ABSOLUTE: f64 = 1e-11;
const RELATIVE: f64 = 1e-11;
/// Steps tried before a motion counts as one that cannot be followed.
const MOST_STEPS: usize = 100_000;

/// Nodes, weights and error weights of the pair (Dormand and Prince 1980).
const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const A: [&[f64]; 7] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Fifth order weights minus fourth order weights.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Where and why an integration stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopped {
    /// Seconds after the start.
    pub time: f64,
    /// Why.
    pub cause: &'static str,
}

/// The state `span` seconds after `state` under `derivative(t, state)`, t counted from the start.
///
/// # Errors
/// [`Stopped`] if the motion leaves the finite numbers or needs too many steps.
pub fn integrate(
    state: &State,
    span: f64,
    derivative: impl Fn(f64, &State) -> State,
) -> Result<State, Stopped> {
    let (mut t, mut y, mut h) = (0.0, *state, span);
    for _ in 0..MOST_STEPS {
        h = h.min(span - t);
        let (next, error) = attempt(t, &y, h, &derivative);
        if !error.is_finite() && h < span * 1e-12 {
            return Err(Stopped { time: t, cause: "the motion leaves the finite numbers" });
        }
        if error <= 1.0 {
            t += h;
            y = next;
            if t >= span {
                return Ok(y);
            }
        }
        // An error that is no number shrinks the step as much as possible.
        h *= (0.9 * libm::pow(error, -0.2)).clamp(0.1, 5.0).max(0.1);
        if t + h == t {
            return Err(Stopped { time: t, cause: "the motion is too fast to be followed" });
        }
    }
    Err(Stopped { time: t, cause: "it takes more than 100000 integration steps" })
}

/// One step of length `h`: the new state, and its error in units of what is allowed.
fn attempt(t: f64, y: &State, h: f64, derivative: &impl Fn(f64, &State) -> State) -> (State, f64) {
    let mut k = [State::zeros(); 7];
    let mut next = *y;
    for stage in 0..7 {
        next = A[stage].iter().zip(&k).fold(*y, |sum, (a, k)| sum + k * (a * h));
        k[stage] = derivative(t + C[stage] * h, &next);
    }
    // The last stage stands at the fifth order result.
    let error: State = E.iter().zip(&k).fold(SVector::zeros(), |sum, (e, k)| sum + k * (e * h));
    let allowed = y.zip_map(&next, |a, b| ABSOLUTE + RELATIVE * a.abs().max(b.abs()));
    (next, error.component_div(&allowed).amax())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_comes_back_after_ten_turns() {
        let derivative = |_: f64, y: &State| {
            let mut rate = State::zeros();
            (rate[0], rate[1]) = (y[1], -y[0]);
            rate
        };
        let mut start = State::zeros();
        start[0] = 1.0;
        let end = integrate(&start, 20.0 * std::f64::consts::PI, derivative).unwrap();
        assert!((end - start).amax() < 1e-8, "{}", (end - start).amax());
    }

    #[test]
    fn a_motion_that_explodes_is_an_error() {
        let derivative = |_: f64, y: &State| y.map(|v| v * v);
        let stopped = integrate(&State::repeat(1.0), 2.0, derivative).unwrap_err();
        assert!(stopped.time > 0.9 && stopped.time <= 1.0, "{stopped:?}");
    }
}
