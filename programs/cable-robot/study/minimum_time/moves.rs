//! Random moves of the kinds that the planner `MinimumTime` knows, planned with nothing left to the limits.

use std::sync::LazyLock;

use cable_robot::control::static_margin;
use cable_robot::plan::minimum_time::path::{Path, Work};
use cable_robot::plan::minimum_time::{Arc, Line, Timing, Track};
use cable_robot::reach::certificate::section::Section;
use cable_robot::robot::{Coordinates, Pose, Rig, RigFile, RobotParameters, Shape, TensionLimits};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::super::cases::{random_rig_of_held, random_robot};
use super::super::random_point;
use super::polynomial::Piece;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The paper's shape of any size, half of them turned and tilted in space, along lines: in closed form.
    Line,
    /// The same, in place, along the same lines on the grid.
    Grid,
    /// Six cables, in all six coordinates.
    Turned,
    /// Eight cables, `rigs/eight.toml`, in all six coordinates.
    Eight,
    /// The paper's shape on ways that are bent upwards.
    Lift,
    /// By one to three way points, half of them of the paper's shape without a turn, the others of six cables in all six coordinates.
    Through,
}

/// A planned move.
pub struct Move {
    pub rig: Rig,
    pub way: Way,
    pub timing: Timing,
    /// Where the rig is the paper's and the platform is not turned.
    pub robot: Option<RobotParameters>,
}

/// Of its kinds.
#[allow(clippy::large_enum_variant, reason = "a study holds one at a time")]
pub enum Way {
    /// With where it is in the rig's frame and in the paper's.
    Line { line: Line, in_rig: Section, in_paper: Section },
    /// Of any rig.
    Path(Path),
}

static EIGHT: LazyLock<Option<RigFile>> =
    LazyLock::new(|| RigFile::parse(include_str!("../../../../rigs/eight.toml")).ok());

impl Kind {
    pub const ALL: [Self; 6] = [Self::Line, Self::Grid, Self::Turned, Self::Eight, Self::Lift, Self::Through];

    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "lines",
            Self::Grid => "lines on the grid",
            Self::Turned => "turned, six cables",
            Self::Eight => "turned, eight cables",
            Self::Lift => "bent upwards",
            Self::Through => "by way points",
        }
    }

    /// Of every hundred moves: lines are quick to plan.
    pub fn of_move(k: u64) -> Self {
        match k % 100 {
            0..88 => Self::Line,
            88..91 => Self::Grid,
            91..94 => Self::Turned,
            94 => Self::Eight,
            95..97 => Self::Lift,
            _ => Self::Through,
        }
    }

    /// A move; `None` where none is planned between the ends that were drawn.
    pub fn draw(self, rng: &mut Pcg64) -> Option<Move> {
        match self {
            Self::Line => line(rng),
            Self::Grid => level(rng, |_, from, to| Some(Track::straight(from, to))),
            Self::Lift => level(rng, |rng, from, to| {
                let rise = -rng.random_range(0.0..0.3) * from.0[2].min(to.0[2]);
                Some(Track::bent(from, to, &Coordinates::new(0.0, 0.0, rise, 0.0, 0.0, 0.0)))
            }),
            Self::Turned => {
                let (rig, home) = random_rig_of_held(rng);
                any_way(rng, &rig, &home, 2)
            }
            Self::Eight => {
                let RigFile { rig, home, .. } = EIGHT.as_ref()?;
                any_way(rng, rig, home, 2)
            }
            Self::Through => through(rng),
        }
    }
}

impl Move {
    /// The stop from a place with a speed; `None` where none is proved that ends before the motion does.
    pub fn stop(&self, s: f64, v: f64) -> Option<Timing> {
        match &self.way {
            Way::Line { line, .. } => line.stop(s, v),
            Way::Path(path) => path.stop(&self.rig, s, v),
        }
    }

    /// s at the end of the way.
    pub fn end(&self) -> f64 {
        match &self.way {
            Way::Line { line, .. } => line.length(),
            Way::Path(_) => 1.0,
        }
    }

    /// The section of an arc, in the rig's frame.
    pub fn section(&self, arc: &Arc) -> &Section {
        match &self.way {
            Way::Line { in_rig, .. } => in_rig,
            Way::Path(path) => path.way.section(arc.s),
        }
    }

    /// The motion on an arc, for polynomials.
    pub fn piece(&self, arc: &Arc, duration: f64) -> Piece {
        match &self.way {
            Way::Line { in_paper, .. } => Piece::of_line(in_paper, arc, duration),
            Way::Path(path) => Piece::of_constant_acceleration(path.way.section(arc.s), arc, duration),
        }
    }
}

/// A third of them open above, a third with 0 below.
fn random_limits(rng: &mut Pcg64, robot: &RobotParameters) -> TensionLimits {
    let weight = robot.m * robot.g;
    let min = if rng.random_range(0..3) == 0 { 0.0 } else { rng.random_range(0.0..0.04) };
    let max = if rng.random_range(0..3) == 0 { 1e3 } else { rng.random_range(0.4..2.0) };
    TensionLimits { min: min * weight, max: max * weight }
}

/// Places within the static workspace, as many of them at one height as not.
fn random_places<const N: usize>(rng: &mut Pcg64, robot: &RobotParameters) -> [Pose; N] {
    let is_level = rng.random_bool(0.5);
    let first = rng.random_range(0.5..4.0) * robot.a;
    std::array::from_fn(|_| {
        let at = random_point(rng, robot, 0.02 * robot.a);
        let z = if is_level { first } else { first * rng.random_range(0.6..1.6) };
        Pose::at(at.x, at.y, z)
    })
}

fn line(rng: &mut Pcg64) -> Option<Move> {
    let robot = random_robot(rng);
    let limits = random_limits(rng, &robot);
    let mut rig = Rig::paper(&robot, limits);
    if rng.random_bool(0.5) {
        turn(rng, &mut rig);
    }
    let shape = Shape::of(&rig).ok()?;
    let [from, to] = random_places(rng, &robot).map(|place| shape.to_rig(&place));
    let [start, end] = [from, to].map(|pose| shape.to_paper(&pose).position());
    let line = Line::new(&shape.robot, limits, &start, &end);
    let timing = line.fastest(0.0, f64::INFINITY)?;
    let along = |from: &Pose, to: &Pose| Section::straight(from, &(to.minus(from) / line.length()));
    let at = |p: Vector3<f64>| Pose::at(p.x, p.y, p.z);
    let way = Way::Line { line, in_rig: along(&from, &to), in_paper: along(&at(start), &at(end)) };
    Some(Move { rig, way, timing, robot: Some(shape.robot) })
}

/// The whole rig, with what is down.
fn turn(rng: &mut Pcg64, rig: &mut Rig) {
    let mut any = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let (rotation, shift) = (Rotation3::new(any() * 2.0), any() * rig.radius());
    for cable in rig.cables.iter_mut() {
        cable.anchor = rotation * cable.anchor + shift;
        cable.attachment = rotation * cable.attachment;
    }
    rig.inertia = rotation.matrix() * rig.inertia * rotation.matrix().transpose();
    rig.gravity = rotation * rig.gravity;
}

fn level(rng: &mut Pcg64, way: fn(&mut Pcg64, &Pose, &Pose) -> Option<Track>) -> Option<Move> {
    let robot = random_robot(rng);
    let rig = Rig::paper(&robot, random_limits(rng, &robot));
    let [from, to] = random_places(rng, &robot);
    timed(rig, way(rng, &from, &to)?, Some(robot))
}

fn through(rng: &mut Pcg64) -> Option<Move> {
    let count = rng.random_range(3..=5);
    if rng.random_bool(0.5) {
        let (rig, home) = random_rig_of_held(rng);
        return any_way(rng, &rig, &home, count);
    }
    let robot = random_robot(rng);
    let rig = Rig::paper(&robot, random_limits(rng, &robot));
    let places = random_places::<5>(rng, &robot);
    timed(rig, Track::through(&places[..count], rig.platform_radius())?, Some(robot))
}

/// By so many poses about home, turned by up to 0.3 rad.
fn any_way(rng: &mut Pcg64, rig: &Rig, home: &Pose, count: usize) -> Option<Move> {
    let mut pose = || {
        let mut by = || {
            let size = |k: usize| if k < 3 { 0.25 * rig.radius() } else { 0.3 };
            Coordinates::from_fn(|k, _| rng.random_range(-1.0..1.0) * size(k))
        };
        let mut poses = std::iter::repeat_with(|| Pose(home.0 + by()));
        poses.find(|pose| static_margin(rig, pose) > 0.01 * rig.weight())
    };
    let poses: Vec<Pose> = (0..count).map(|_| pose()).collect::<Option<_>>()?;
    timed(*rig, Track::through(&poses, rig.platform_radius())?, None)
}

fn timed(rig: Rig, way: Track, robot: Option<RobotParameters>) -> Option<Move> {
    let path = Path { way, limits: rig.limits(), fastest: f64::INFINITY };
    let (timing, _) = path.timed(&rig, &mut Work::of_a_decision())?;
    Some(Move { rig, way: Way::Path(path), timing, robot })
}
