//! Random cases, a rig with a state and a set point, that a domain admits, and the tensions along their motion.

use cable_robot::control::response::instants;
use cable_robot::control::{Gains, Response, static_margin, tensions};
use cable_robot::plan::{ControllerParameters, Planner};
use cable_robot::reach::ExactDomain;
use cable_robot::reach::certificate::{Margins, Step, Verdict, certify};
use cable_robot::robot::{Coordinates, PerCable, Pose, Pulley, Rig, RigFile, RobotParameters, TensionLimits};
use clap::ValueEnum;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::random_point;

const EIGHT: &str = include_str!("../../../rigs/eight.toml");

/// What says which steps are admissible.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Domain {
    /// The exact domain: translations, rigs like the paper's
    Exact,
    /// The certificate: any six cables, all six coordinates
    Certificate,
}

/// A step of a rig.
pub struct Case {
    pub rig: Rig,
    pub step: Step,
}

impl Domain {
    /// Draws a case; `None` if the domain does not admit it.
    pub fn draw(self, rng: &mut Pcg64) -> Option<Case> {
        match self {
            Self::Exact => translation(rng),
            Self::Certificate => {
                let (rig, step) = any_step(rng);
                let is_admissible = matches!(certify(&rig, &step), Ok(Verdict::Admissible { .. }));
                is_admissible.then_some(Case { rig, step })
            }
        }
    }
}

/// A translation of a rig like the paper's: half of them from rest, a third at constant height.
fn translation(rng: &mut Pcg64) -> Option<Case> {
    let robot = random_robot(rng);
    let limits = random_limits(rng, &robot);
    let gains = random_gains(rng, 0.5..10.0);
    let speed = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..robot.a) };
    // Within the static workspace, and some way outside: a robot in motion may be there.
    let mut point = || random_point(rng, &robot, -0.1 * robot.a).push(rng.random_range(0.5..4.0) * robot.a);
    let (start, mut x_d) = (point(), point());
    let mut velocity = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * speed;
    if rng.random_range(0..3) == 0 {
        (x_d.z, velocity.z) = (start.z, 0.0);
    }
    if !ExactDomain::new(&robot, &gains, limits, start, velocity).contains(&x_d) {
        return None;
    }
    let mut rates = Coordinates::zeros();
    rates.fixed_rows_mut::<3>(0).copy_from(&velocity);
    let pose = |p: Vector3<f64>| Pose::at(p.x, p.y, p.z);
    Some(Case {
        rig: Rig::paper(&robot, limits),
        step: Step { start: pose(start), rates, set_point: pose(x_d), gains },
    })
}

/// Any step of any rig: the ends of the cables out of order and out of their planes, the centre of mass off, turning as well as
/// moving from a start in motion.
fn any_step(rng: &mut Pcg64) -> (Rig, Step) {
    let robot = random_robot(rng);
    let mut rig = Rig::paper(&robot, random_limits(rng, &robot));
    let disorder = rng.random_range(0.0..0.5);
    let mut displacement = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
    let offset = displacement(0.2 * robot.b);
    for cable in rig.cables.iter_mut() {
        cable.anchor += displacement(disorder * robot.a);
        cable.attachment += displacement(disorder * robot.b) + offset;
    }
    let moments = Vector3::from_fn(|_, _| rng.random_range(0.05..0.8)) * (robot.m * robot.b * robot.b);
    rig.inertia = Matrix3::from_diagonal(&moments);

    let size = rng.random_range(0.02..0.3);
    let mut pose = || {
        let q = Coordinates::from_fn(|_, _| rng.random_range(-size..size));
        let [x, y, z, roll, pitch, yaw]: [f64; 6] = q.into();
        Pose(Coordinates::new(x * robot.a, y * robot.a, (1.8 + 3.0 * z) * robot.a, roll, pitch, yaw))
    };
    let (start, set_point) = (pose(), pose());
    let mut rates = Coordinates::from_fn(|_, _| rng.random_range(-1.0..1.0)) * rng.random_range(0.0..0.7);
    rates.fixed_rows_mut::<3>(0).scale_mut(robot.a);
    (rig, Step { start, rates, set_point, gains: random_gains(rng, 0.5..6.0) })
}

/// Any step of any rig of six cables, or of one near the bundled rig of eight; each fourth has pulleys.
pub fn any_problem(rng: &mut Pcg64, case: u64) -> (Rig, Step) {
    let (mut rig, step) = if case.is_multiple_of(2) { any_step(rng) } else { step_of_eight(rng) };
    if case % 8 < 2 {
        let radius = rng.random_range(0.01..0.05) * rig.radius();
        for cable in rig.cables.iter_mut() {
            let axis = rig.gravity.normalize() + Vector3::from_fn(|_, _| rng.random_range(-0.2..0.2));
            cable.pulley = Some(Pulley { radius, axis: axis.normalize() });
        }
    }
    (rig, step)
}

/// Margins, each there or not, of which some leave enough for a step and some do not.
pub fn any_margins(rng: &mut Pcg64, rig: &Rig, step: &Step) -> Margins {
    let size = log_uniform(rng, 1e-4, 1e-2);
    let mut any = |of: f64| if rng.random_bool(0.5) { of * rng.random_range(0.0..size) } else { 0.0 };
    let (weight, radius) = (rig.weight(), rig.platform_radius());
    Margins {
        mass: any(1.0),
        centre_of_mass: any(0.01 * radius),
        force: any(0.1 * weight),
        torque: any(0.01 * weight * radius),
        friction: any(0.01 * weight),
        law_margin: Planner::from(ControllerParameters::of(rig)).allowance(),
        accuracy: any(0.01 * radius),
        sample_period: any(0.3 / step.fast_rate()),
        delay: any(0.3 / step.fast_rate()),
    }
}

/// The bundled rig of eight cables with every number changed, and any step from a moving start.
fn step_of_eight(rng: &mut Pcg64) -> (Rig, Step) {
    let mut rig = RigFile::parse(EIGHT).expect("a test reads the file").rig;
    let mut jitter = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
    for cable in rig.cables.iter_mut() {
        cable.anchor += jitter(0.2);
        cable.attachment += jitter(0.05);
    }
    rig.mass *= rng.random_range(0.5..1.5);
    rig.inertia = Matrix3::from_diagonal(&Vector3::from_fn(|_, _| rng.random_range(0.5..2.0)));
    let limits = TensionLimits { min: rng.random_range(0.0..10.0), max: rng.random_range(150.0..400.0) };
    let mut pose = || {
        let mut q = Coordinates::from_fn(|k, _| if k < 3 { 1.1 } else { 0.25 } * rng.random_range(-1.0..1.0));
        q[2] = 2.0 + 0.5 * q[2];
        Pose(q)
    };
    let (start, set_point) = (pose(), pose());
    let rates = Coordinates::from_fn(|_, _| rng.random_range(-0.3..0.3));
    (rig.with_limits(limits), Step { start, rates, set_point, gains: random_gains(rng, 1.0..5.0) })
}

pub fn random_robot(rng: &mut Pcg64) -> RobotParameters {
    let a = rng.random_range(0.2..2.0);
    RobotParameters {
        a,
        b: rng.random_range(0.1..0.95) * a,
        m: rng.random_range(0.5..50.0),
        g: rng.random_range(1.6..10.0),
        ..Default::default()
    }
}

/// Half of them only that no cable is slack.
fn random_limits(rng: &mut Pcg64, robot: &RobotParameters) -> TensionLimits {
    let weight = robot.m * robot.g;
    if rng.random_bool(0.5) {
        return TensionLimits { min: 0.0, max: 1e3 * weight };
    }
    TensionLimits { min: rng.random_range(0.0..0.05) * weight, max: rng.random_range(0.5..2.0) * weight }
}

/// A third of them equal.
fn random_gains(rng: &mut Pcg64, range: std::ops::Range<f64>) -> Gains {
    let lambda = rng.random_range(range.clone());
    let eta = if rng.random_range(0..3) == 0 { lambda } else { rng.random_range(range) };
    Gains { lambda, eta }
}

/// The rigs of `study held` and `study liveness`, with their homes: half of them Table I's.
pub fn random_rig_of_held(rng: &mut Pcg64) -> (Rig, Pose) {
    if rng.random_bool(0.5) {
        let limits = TensionLimits { min: 0.0, max: 100.0 };
        return (Rig::paper(&RobotParameters::default(), limits), Pose::default());
    }
    loop {
        let robot = random_robot(rng);
        let weight = robot.m * robot.g;
        let mut rig = Rig::paper(&robot, TensionLimits { min: 0.0, max: 5.0 * weight });
        let disorder = rng.random_range(0.0..0.4);
        for cable in rig.cables.iter_mut() {
            for (end, size) in [(&mut cable.anchor, robot.a), (&mut cable.attachment, robot.b)] {
                *end += Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * (disorder * size);
            }
        }
        let moments = Vector3::from_fn(|_, _| rng.random_range(0.05..0.8)) * (robot.m * robot.b * robot.b);
        rig.inertia = Matrix3::from_diagonal(&moments);
        let home = Pose::at(0.0, 0.0, rng.random_range(1.0..3.5) * robot.a);
        let is_a_body = moments.sum() > 2.0 * moments.max();
        if is_a_body && rig.validate().is_ok() && static_margin(&rig, &home) > 0.03 * weight {
            return (rig, home);
        }
    }
}

/// Their gains: a third of them equal.
pub fn random_gains_of_held(rng: &mut Pcg64) -> Gains {
    let lambda = log_uniform(rng, 0.3, 15.0);
    let eta = if rng.random_range(0..3) == 0 { lambda } else { log_uniform(rng, 0.3, 15.0) };
    Gains { lambda, eta }
}

pub fn log_uniform(rng: &mut Pcg64, least: f64, most: f64) -> f64 {
    least * (most / least).powf(rng.random_range(0.0..1.0))
}

impl Case {
    /// Smallest distance of a tension from a limit at `count` instants, denser at the start, N: negative beyond it.
    pub fn smallest_margin(&self, count: usize) -> f64 {
        let TensionLimits { min, max } = self.rig.common_limits();
        let margin = |u: f64| (u - min).min(max - u);
        // A singular wrench matrix counts as beyond.
        instants(12.0 / self.step.slow_rate(), count)
            .map(|t| {
                self.tensions_at(t)
                    .map_or(f64::NEG_INFINITY, |u| u.into_iter().map(margin).fold(f64::INFINITY, f64::min))
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The tensions `t` seconds after the start, N, by the 6x6 inverse dynamics.
    fn tensions_at(&self, t: f64) -> Option<PerCable<f64>> {
        let Step { start, rates, set_point, gains } = &self.step;
        let (pose, rates, acceleration) = Response::at(gains, t).motion_of(start, rates, set_point);
        tensions(&self.rig, &pose, &rates, &acceleration, 0.0)
    }
}
