//! What a step asks of the cables: the extreme tensions along its closed-form response, looked at densely.

use super::minimum_time::Course;
use super::orbit::Trajectory;
use crate::control::{Gains, Reference, Response, response, tensions};
use crate::robot::{Coordinates, Pose, Rig};

/// Instants looked at, denser at the start.
const INSTANTS: usize = 4001;

/// A tension of one cable at one instant of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionAt {
    /// Cable number, from 1.
    pub cable: usize,
    /// N; negative where the cable would have to push.
    pub tension: f64,
    /// Seconds after the step was given.
    pub time: f64,
    /// Where the platform would be then.
    pub pose: Pose,
}

/// The extremes of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// The smallest tension of any cable.
    pub smallest: TensionAt,
    /// The greatest.
    pub greatest: TensionAt,
    /// The first to be at or below the lower limit or above the upper one, if any.
    pub first_outside: Option<TensionAt>,
}

/// The extremes of the step from rest at `from` to the set point `to`, along (12), (13) in all six coordinates; `None` if it meets a
/// singular pose. A breach shorter than 1/2000 of its time after the start may be missed.
pub fn extremes(rig: &Rig, gains: &Gains, from: &Pose, to: &Pose) -> Option<Extremes> {
    extremes_from(rig, gains, (from, &Coordinates::zeros()), to)
}

/// The same from a motion, pose and rates (m/s, rad/s).
pub fn extremes_from(
    rig: &Rig,
    gains: &Gains,
    (from, rates): (&Pose, &Coordinates),
    to: &Pose,
) -> Option<Extremes> {
    let motion = |time: f64| {
        let (pose, rates, accelerations) = Response::at(gains, time).motion_of(from, rates, to);
        Reference { pose, rates, accelerations }
    };
    along(rig, response::instants(response::time_to_rest(gains), INSTANTS), motion)
}

/// The extremes of a course that begins at 0 s.
pub fn extremes_of_course(rig: &Rig, course: &Course) -> Option<Extremes> {
    let share = course.end() / (INSTANTS - 1) as f64;
    along(rig, (0..INSTANTS).map(|k| share * k as f64), |time| course.at(time))
}

/// The extremes of an orbit that begins at 0 s: of start, first turn and stop.
pub fn extremes_of_orbit(rig: &Rig, trajectory: &Trajectory) -> Option<Extremes> {
    let within = |[from, to]: [f64; 2]| {
        (0..INSTANTS).map(move |k| from + (to - from) * k as f64 / (INSTANTS - 1) as f64)
    };
    along(rig, trajectory.pieces().into_iter().flat_map(within), |time| trajectory.at(time))
}

fn along(
    rig: &Rig,
    instants: impl Iterator<Item = f64>,
    motion: impl Fn(f64) -> Reference,
) -> Option<Extremes> {
    let mut found: Option<Extremes> = None;
    for time in instants {
        let Reference { pose, rates, accelerations } = motion(time);
        let tension = tensions(rig, &pose, &rates, &accelerations, 0.0)?;
        for (i, tension) in tension.into_iter().enumerate() {
            let here = TensionAt { cable: i + 1, tension, time, pose };
            let outside =
                (tension <= rig.cables[i].limits.min || tension > rig.cables[i].limits.max).then_some(here);
            let Some(so_far) = &mut found else {
                found = Some(Extremes { smallest: here, greatest: here, first_outside: outside });
                continue;
            };
            if tension < so_far.smallest.tension {
                so_far.smallest = here;
            }
            if tension > so_far.greatest.tension {
                so_far.greatest = here;
            }
            so_far.first_outside = so_far.first_outside.or(outside);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{RigFile, TensionLimits};

    const GAINS: Gains = Gains { lambda: 3.0, eta: 3.0 };
    fn of(to: Pose) -> Extremes {
        extremes(&RigFile::default().rig, &GAINS, &Pose::default(), &to).unwrap()
    }

    #[test]
    fn the_papers_move_in_one_step_ends_at_its_smallest_tension() {
        let found = of(Pose::at(0.15, 0.15, 1.0));
        assert_eq!((found.smallest.cable, found.first_outside), (5, None));
        assert!((found.smallest.tension - 1.050).abs() < 5e-4 && found.smallest.time > 5.0, "{found:?}");
    }

    #[test]
    fn a_goal_outside_breaks_the_limit_of_its_facet_when_the_platform_crosses_it() {
        let found = of(Pose::at(0.0, 0.4, 1.0));
        let first = found.first_outside.unwrap();
        assert_eq!((first.cable, found.smallest.cable), (2, 2));
        // Cable 2 is taut while y + y'' z/g < a/2: with (12), y_d (1 - (1 + wt) e) + y_d w² e (1 - wt) z/g.
        let p = |t: f64| {
            let e = (-3.0 * t).exp();
            0.4 * (1.0 - (1.0 + 3.0 * t) * e) + 0.4 * 9.0 * e * (1.0 - 3.0 * t) / 9.81
        };
        // Before, at the start, y'' alone carries p to 0.367.
        assert!(first.time == 0.0 && p(0.0) > 0.225, "{first:?}");
        let gains = Gains { lambda: 1.0, eta: 1.0 };
        let slow = extremes(&RigFile::default().rig, &gains, &Pose::default(), &Pose::at(0.0, 0.4, 1.0));
        let first = slow.unwrap().first_outside.unwrap();
        let y = 0.4 * (1.0 - (1.0 + first.time) * (-first.time).exp());
        let y2 = 0.4 * (-first.time).exp() * (1.0 - first.time);
        assert!((y + y2 / 9.81 - 0.225).abs() < 2e-3 && first.time > 1.0, "{first:?}");
    }

    #[test]
    fn the_upper_limit_counts_as_well() {
        let rig = RigFile::default().rig.with_limits(TensionLimits { min: 0.0, max: 15.0 });
        let found = extremes(&rig, &GAINS, &Pose::default(), &Pose::at(0.15, 0.15, 1.0)).unwrap();
        let first = found.first_outside.unwrap();
        assert!(first.tension > 15.0 && first.tension <= found.greatest.tension, "{found:?}");
    }
}
