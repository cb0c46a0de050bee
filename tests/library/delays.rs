//! Commands that act earlier or later than was said: the controller finds out, and takes nothing else for a delay.

use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Coordinates, Pose};
use cable_robot::sim::{ClosedLoop, PlantParameters};

type Imperfect = fn(&mut PlantParameters);

/// How much later than was said commands act, s, found within 6 s of two goals.
fn found(
    (planner, gain, step): (PlannerKind, f64, f64),
    is_late: bool,
    said: f64,
    imperfect: Imperfect,
) -> Option<f64> {
    let parameters =
        ControllerParameters { planner, lambda: gain, eta: gain, command_delay: said, ..Default::default() };
    let mut plant = PlantParameters::default();
    imperfect(&mut plant);
    let mut run = ClosedLoop::new(parameters, plant, Pose::default()).unwrap();
    run.is_late = is_late;
    let goals = match planner {
        PlannerKind::Bounded => [Pose::at(0.1, 0.05, 1.0); 2],
        PlannerKind::MinimumTime => [Pose::at(0.1, 0.05, 0.9), Pose::at(-0.08, 0.06, 1.1)],
        PlannerKind::Exact => {
            [Pose::at(0.1, 0.05, 0.9), Pose(Coordinates::new(-0.08, 0.06, 1.1, 0.05, 0.0, 0.3))]
        }
    };
    for _ in 0..(6.0 / step) as usize {
        run.goal = goals[usize::from(run.moment().time > 2.0)];
        run.step(step).unwrap();
    }
    run.controller.late()
}

/// Every setting that is tried.
fn settings() -> impl Iterator<Item = (PlannerKind, f64, f64)> {
    PlannerKind::ALL.into_iter().flat_map(|planner| {
        [(3.0, 1e-3), (3.0, 4e-3), (8.0, 1e-3), (8.0, 4e-3)].map(|(g, h)| (planner, g, h))
    })
}

#[test]
fn a_step_late_or_early_is_found() {
    for setting in settings() {
        let step = setting.2;
        let late = found(setting, true, 0.0, |_| ()).unwrap();
        let early = found(setting, false, step, |_| ()).unwrap();
        println!("{setting:?}: {:.2} and {:.2} steps", late / step, early / step);
        assert!((0.5..1.5).contains(&(late / step)) && (-1.5..-0.5).contains(&(early / step)));
    }
}

/// A first-order lag of the motors is a delay of its time constant.
#[test]
fn motors_that_lag_are_found() {
    for setting in settings() {
        let late = found(setting, false, 0.0, |plant| plant.motor_lag = 5e-3).unwrap();
        println!("{setting:?}: {:.1} ms", 1e3 * late);
        assert!((2.5e-3..7.5e-3).contains(&late), "{late}");
    }
}

#[test]
fn nothing_else_is_taken_for_a_delay() {
    let imperfections: [(&str, Imperfect); 7] = [
        ("nothing", |_| ()),
        ("5 % more mass", |plant| plant.rig.mass *= 1.05),
        ("30 % more inertia", |plant| plant.rig.inertia *= 1.3),
        ("friction", |plant| plant.friction = 0.3),
        ("encoders", |plant| plant.encoder_resolution = 1e-4),
        ("anchors off", |plant| plant.rig.cables[2].anchor.z += 2e-3),
        ("noisy cells", |plant| plant.load_cell_noise = 0.1),
    ];
    for setting in settings() {
        for (name, imperfect) in imperfections {
            assert_eq!(found(setting, false, 0.0, imperfect), None, "{name}, {setting:?}");
        }
        assert_eq!(found(setting, true, setting.2, |_| ()), None, "late as was said, {setting:?}");
    }
}
