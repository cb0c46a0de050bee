//! What explains the tensions: the point p, and what the closed form had predicted.

use super::history::History;
use cable_robot::control::{Reference, Response, tensions};
use cable_robot::plan::PlannerKind;
use cable_robot::robot::{Coordinates, PerCable, Pose};

/// p = P + P'' z/(g - z''), m, in the base plane: where the line of the net force that the cables shall give meets it.
///
/// P'' is what the law (4) demands of the estimated state. A controller that does not tell its estimate leaves the net force of the
/// measured tensions, which cannot leave the facets. `None` where neither makes sense, and for another rig than the paper's, of which p
/// tells nothing.
pub fn moving_point(history: &History, row: usize) -> Option<[f64; 2]> {
    history.paper.as_ref()?;
    let force = match &history.estimate {
        Some(estimate) if history.law_at_work(row) => demanded(history, &estimate[row], row),
        Some(_) => return None,
        None => measured(history, row),
    };
    let pose = &history.pose[row].0;
    // Along the force from the platform up to z = 0.
    let up = pose[2] / force[2];
    let p = [0, 1].map(|k| pose[k] - force[k] * up);
    (force[2] < 0.0 && p.iter().all(|x| x.is_finite())).then_some(p)
}

/// The force that the law demands of the cables, for each unit of mass: in the middle of the interval for which the command is held, if it is
/// computed for that.
fn demanded(history: &History, (pose, rates): &(Pose, Coordinates), row: usize) -> [f64; 3] {
    let parameters = &history.info.controller_parameters;
    let middle = if parameters.hold_compensation { 0.5 * history.info.step } else { 0.0 };
    let response = Response::at(&parameters.gains(), middle);
    let resting = Reference::resting(&history.set_point[row]);
    let led = history.reference.as_ref().map_or(resting, |reference| reference[row]);
    let [_, _, back] = response.error_of(&pose.minus(&led.pose), &(rates - led.rates));
    let demand = led.accelerations + back;
    let believed = history.believed_force[row];
    [0, 1, 2].map(|k| demand[k] - parameters.rig.gravity[k] - believed[k] / parameters.rig.mass)
}

/// The force of the measured tensions.
fn measured(history: &History, row: usize) -> [f64; 3] {
    let pose = &history.pose[row];
    let tension: Vec<f64> = history.run.tension.iter().map(|cable| cable[row]).collect();
    history.info.plant_parameters.rig.cables_at(pose).wrench(&tension).0.into()
}

/// Tensions of the closed form (12), (13) from the state in which the active set point was given, N, at each of `rows` (in order); of a motion that the law
/// followed those of that motion. `None` where the law is not at work; the whole is `None` if the controller does not tell its estimate.
pub fn predicted(history: &History, rows: &[usize]) -> Option<Vec<Option<PerCable<f64>>>> {
    let estimate = history.estimate.as_ref()?;
    let parameters = &history.info.controller_parameters;
    let gains = parameters.gains();
    let given = history.set_point_rows();
    let at = |row: usize| {
        if let (PlannerKind::MinimumTime, Some(reference)) = (parameters.planner, &history.reference) {
            let Reference { pose, rates, accelerations } = &reference[row];
            return tensions(&parameters.rig, pose, rates, accelerations, 0.0);
        }
        let start = given[given.partition_point(|g| *g <= row) - 1];
        let ((pose, rates), set_point) = (&estimate[start], &history.set_point[row]);
        let response = Response::at(&gains, history.run.times[row] - history.run.times[start]);
        let (pose, rates, accelerations) = response.motion_of(pose, rates, set_point);
        tensions(&parameters.rig, &pose, &rates, &accelerations, 0.0)
    };
    Some(rows.iter().map(|row| history.law_at_work(*row).then(|| at(*row)).flatten()).collect())
}

/// The columns of rows that may be missing, one per cable.
pub fn columns(rows: &[Option<PerCable<f64>>], cables: usize) -> Vec<Vec<Option<f64>>> {
    let of = |i: usize| rows.iter().map(|row| row.map(|tension| tension[i])).collect();
    (0..cables).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::run;
    use cable_robot::robot::triangles::FACET_NORMALS;

    /// The identity of the paper notes: u = m l (g - z'') (a/2 - n·p) / (3 a z) with zero orientation, here at constant height.
    #[test]
    fn p_is_as_far_inside_each_facet_as_the_cable_is_taut() {
        let folder = run(PlannerKind::Bounded, 3.0, 0.0);
        let history = History::new(&folder).unwrap();
        let (robot, rig) = (history.paper.unwrap(), &history.info.plant_parameters.rig);
        for row in (1..history.len()).step_by(10) {
            let (p, pose) = (moving_point(&history, row).unwrap(), &history.pose[row]);
            let length = rig.cables_at(pose).length;
            for i in 0..6 {
                let inside = robot.a / 2.0 - FACET_NORMALS[i].x * p[0] - FACET_NORMALS[i].y * p[1];
                let tension = robot.m * robot.g * length[i] * inside / (3.0 * robot.a * pose.0[2]);
                let recorded = history.run.tension[i][row];
                assert!((tension - recorded).abs() < 0.02, "row {row}, u{}: {tension} {recorded}", i + 1);
            }
        }
    }

    #[test]
    fn without_an_estimate_p_comes_from_the_tensions_and_is_the_same() {
        let folder = run(PlannerKind::Exact, 2.0, 0.0);
        let mut history = History::new(&folder).unwrap();
        let told: Vec<_> = (0..history.len()).map(|row| moving_point(&history, row).unwrap()).collect();
        history.estimate = None;
        for (row, told) in told.iter().enumerate().skip(1) {
            let found = moving_point(&history, row).unwrap();
            assert!((0..2).all(|k| (found[k] - told[k]).abs() < 1e-3), "row {row}: {found:?} {told:?}");
        }
        assert_eq!(predicted(&history, &[0]), None);
    }

    #[test]
    fn an_ideal_rig_pulls_what_was_predicted() {
        let folder = run(PlannerKind::Bounded, 6.0, 0.0);
        let history = History::new(&folder).unwrap();
        let rows: Vec<_> = (0..history.len()).collect();
        let predicted = predicted(&history, &rows).unwrap();
        let mut worst = 0f64;
        for row in rows {
            let tension = predicted[row].unwrap();
            worst = (0..6).map(|i| (tension[i] - history.run.tension[i][row]).abs()).fold(worst, f64::max);
        }
        assert!(worst < 0.05, "{worst} N apart");
    }

    /// The report drew the closed form towards the goal beside the fastest motion, and p far outside.
    #[test]
    fn the_fastest_motion_is_explained_by_the_reference() {
        let folder = run(PlannerKind::MinimumTime, 1.0, 0.0);
        let history = History::new(&folder).unwrap();
        let rows: Vec<_> = (0..history.len()).collect();
        let predicted = predicted(&history, &rows).unwrap();
        let (robot, mut apart) = (history.paper.unwrap(), 0);
        for row in rows.into_iter().skip(1) {
            let tension = predicted[row].unwrap();
            let worst = (0..6).map(|i| (tension[i] - history.run.tension[i][row]).abs()).fold(0.0, f64::max);
            // In the step of a switch it is the mean that is commanded.
            apart += usize::from(worst > 0.5);
            let p = moving_point(&history, row).unwrap();
            let inside = FACET_NORMALS.iter().map(|n| robot.a / 2.0 - n.x * p[0] - n.y * p[1]);
            assert!(inside.fold(f64::INFINITY, f64::min) > 0.0, "row {row}: {p:?}");
        }
        assert!(apart <= 3, "{apart} rows apart");
    }

    #[test]
    fn an_idle_law_explains_nothing() {
        let folder = run(PlannerKind::Bounded, 0.1, 0.0);
        let mut history = History::new(&folder).unwrap();
        history.status.as_mut().unwrap()[5] = 1;
        assert_eq!((moving_point(&history, 5), predicted(&history, &[5]).unwrap()[0]), (None, None));
        assert!(moving_point(&history, 6).is_some());
    }
}
