//! How much of what `Exact` leaves for what is not known is caution: it goes to the border of what it leaves, with the worst robot within the
//! tolerances that a search finds.

use cable_robot::control::{static_margin, static_tensions};
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::robot::{Pose, Rig, RobotParameters, TensionLimits};
use cable_robot::sim::{ClosedLoop, PlantParameters};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const MASS: f64 = 0.01;
const ACCURACY: f64 = 1e-3;
const ENCODERS: f64 = 5e-5;

/// A uniform disc, gains of 5.
fn parameters() -> ControllerParameters {
    let robot = RobotParameters { i1: 0.125, i2: 0.125, i3: 0.25, ..RobotParameters::default() };
    let mut rig = Rig::paper(&robot, TensionLimits { min: 0.0, max: 100.0 });
    rig.accuracy = ACCURACY;
    ControllerParameters {
        planner: PlannerKind::Exact,
        lambda: 5.0,
        eta: 5.0,
        mass_tolerance: MASS,
        encoder_resolution: ENCODERS,
        ..ControllerParameters::of(&rig)
    }
}

/// From rest, after a second in which the observer settles, towards a goal that cannot be reached.
struct Move {
    start: Pose,
    goal: Pose,
}

impl Move {
    fn random(rng: &mut Pcg64, rig: &Rig) -> Self {
        loop {
            let mut point = || Pose::at(rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3), 1.0);
            let (start, goal) = (point(), point());
            if static_margin(rig, &start) > 3.0 && static_margin(rig, &goal) < -0.5 {
                return Self { start, goal };
            }
        }
    }

    /// Smallest tension commanded in five seconds of 1 ms steps by the controller of `parameters`, N; 0 if a cable is slack.
    fn smallest(&self, parameters: &ControllerParameters, truth: Rig) -> f64 {
        let plant = PlantParameters {
            rig: truth,
            initial_pose: self.start,
            encoder_resolution: ENCODERS,
            ..PlantParameters::default()
        };
        let mut run = ClosedLoop::new(*parameters, plant, self.start).unwrap();
        let mut smallest = f64::INFINITY;
        for k in 0..5000 {
            if k == 1000 {
                run.goal = self.goal;
            }
            let moment = run.step(1e-3).unwrap();
            if moment.plant.slack != [false; 6] {
                return 0.0;
            }
            smallest = moment.controller.motor_tension.iter().copied().fold(smallest, f64::min);
        }
        smallest
    }
}

/// The rig with the mass off by `MASS`, more or less, and both ends of all cables by `ACCURACY` in these directions.
fn off(rig: &Rig, sign: f64, ways: &[Vector3<f64>; 12]) -> Rig {
    let mut off = *rig;
    off.mass *= 1.0 + sign * MASS;
    for (cable, ways) in off.cables.iter_mut().zip(ways.as_chunks::<2>().0) {
        cable.anchor += ways[0] * ACCURACY;
        cable.attachment += ways[1] * ACCURACY;
    }
    off
}

/// The directions in which the tension of a cable at rest falls most.
fn steepest(rig: &Rig, pose: &Pose, cable: usize) -> [Vector3<f64>; 12] {
    let none = [Vector3::zeros(); 12];
    let tension =
        |ways: &[Vector3<f64>; 12]| static_tensions(&off(rig, 0.0, ways), pose, 0.0).unwrap()[cable];
    std::array::from_fn(|end| {
        let slope = Vector3::from_fn(|k, _| {
            let mut moved = none;
            moved[end][k] = 1e-3;
            tension(&moved) - tension(&none)
        });
        -slope.try_normalize(0.0).unwrap_or_default()
    })
}

#[test]
fn the_worst_robot_found_within_the_tolerances_keeps_its_cables_taut() {
    let mut rng = Pcg64::seed_from_u64(17);
    let parameters = parameters();
    let mut shares = vec![];
    for _ in 0..4 {
        let way = Move::random(&mut rng, &parameters.rig);
        let aim = Planner::from(parameters).aim(&way.start, &way.goal);
        let left = way.smallest(&parameters, parameters.rig);
        let at = |sign: f64, ways: &[Vector3<f64>; 12]| {
            way.smallest(&parameters, off(&parameters.rig, sign, ways))
        };
        let mut worst = (f64::INFINITY, 1.0, [Vector3::zeros(); 12]);
        for (cable, sign) in (0..6).flat_map(|cable| [(cable, 1.0), (cable, -1.0)]) {
            let ways = steepest(&parameters.rig, &aim, cable);
            let tension = at(sign, &ways);
            if tension < worst.0 {
                worst = (tension, sign, ways);
            }
        }
        for _ in 0..25 {
            let bent = |way: Vector3<f64>| {
                (way + Vector3::from_fn(|_, _| rng.random_range(-0.5..0.5))).try_normalize(0.0).unwrap_or(way)
            };
            let ways = worst.2.map(bent);
            let tension = at(worst.1, &ways);
            if tension < worst.0 {
                worst = (tension, worst.1, ways);
            }
        }
        println!("{:.3} N are left, {:.3} N by the worst robot found", left, worst.0);
        assert!(worst.0 > 0.0);
        shares.push(1.0 - worst.0 / left);
    }
    let most = shares.iter().copied().fold(0.0, f64::max);
    println!("at most {:.0} % of what is left is used up", 100.0 * most);
    assert!(most > 0.1, "the search finds nothing");
}
