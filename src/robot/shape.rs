//! Whether a rig is the paper's: two equilateral triangles, wherever they stand and however the cables are numbered.
//!
//! Only `reach` and `plan` ask, to take a closed form that the general way would also give.

use nalgebra::{Matrix3, Rotation3, Unit, Vector2, Vector3};
use thiserror::Error;

use super::triangles::{self, SIX};
use super::{Coordinates, Pose, Rig, RobotParameters};

/// Ends of cables may be this far from the paper's places, as a share of the rig's radius.
const TOLERANCE: f64 = 1e-4;
/// Numbers are taken for rounded decimals of this many units.
const DECIMALS: f64 = 1e12;

/// The paper's robot in a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Table I.
    pub robot: RobotParameters,
    /// Greatest distance of an anchor or attachment from where the paper's would be, m.
    pub residual: f64,
    /// Number, from 0, of the rig's cable that is the paper's cable i.
    pub order: [usize; SIX],
    /// The paper's base frame in the rig's.
    base: Frame,
    /// The paper's platform frame in the rig's.
    platform: Rotation3<f64>,
}

/// A frame: `rotation` takes its vectors to the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frame {
    origin: Vector3<f64>,
    rotation: Rotation3<f64>,
}

/// What keeps a rig from being the paper's.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OtherShape {
    /// It has more cables.
    #[error("the rig has {0} cables, the paper's 6")]
    Cables(usize),
    /// It has pulleys.
    #[error("cable {0} runs over a pulley")]
    Pulley(usize),
    /// Nothing pulls downwards.
    #[error("there is no gravity")]
    NoGravity,
    /// An end of a cable is somewhere else.
    #[error("the {end} of cable {cable} is {} mm from where two equilateral triangles would have it", *.distance * 1e3)]
    Elsewhere {
        /// `anchor` or `attachment`.
        end: &'static str,
        /// Number of the cable, from 1.
        cable: usize,
        /// m.
        distance: f64,
    },
}

impl Shape {
    /// Finds the paper's robot in `rig`: exactly where it stands, else up to a turn, a shift and the numbering of the cables. Of
    /// several matches (the shape comes to itself in a turn of 120 degrees, Eq. (15) does not) one without a turn comes first, then one that
    /// keeps the cable numbers, then the smallest turn.
    ///
    /// # Errors
    /// [`OtherShape`]: what differs.
    pub fn of(rig: &Rig) -> Result<Self, OtherShape> {
        let count = rig.cables.len();
        if count != SIX {
            return Err(OtherShape::Cables(count));
        }
        if let Some(i) = rig.cables.iter().position(|cable| cable.pulley.is_some()) {
            return Err(OtherShape::Pulley(i + 1));
        }
        if rig.gravity == Vector3::zeros() {
            return Err(OtherShape::NoGravity);
        }
        if let Some(exact) = as_it_stands(rig) {
            return Ok(exact);
        }
        let tolerance = TOLERANCE * rig.radius();
        let fits: Vec<Fit> = candidates(rig).collect();
        let closest = fits.iter().min_by(|a, b| a.misfit.distance.total_cmp(&b.misfit.distance));
        let good = fits.iter().filter(|fit| fit.misfit.distance <= tolerance);
        let preferred = good.min_by(|a, b| {
            let rank = |fit: &Fit| (fit.turn > TOLERANCE, fit.shape.order != NUMBERED, fit.turn);
            rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal)
        });
        match (preferred, closest) {
            (Some(fit), _) => Ok(fit.shape),
            (None, Some(Fit { misfit: Misfit { end, cable, distance }, .. })) => {
                Err(OtherShape::Elsewhere { end, cable: cable + 1, distance: *distance })
            }
            (None, None) => Err(OtherShape::Elsewhere { end: "anchor", cable: 1, distance: rig.radius() }),
        }
    }

    /// Whether the rig stands as the paper's does, so that poses are the same in both frames.
    pub fn is_in_place(&self) -> bool {
        self.base.origin == Vector3::zeros()
            && self.base.rotation == Rotation3::identity()
            && self.is_parallel()
    }

    /// A pose of the rig's frame in the paper's.
    pub fn to_paper(&self, pose: &Pose) -> Pose {
        if self.is_in_place() {
            return *pose;
        }
        let position = self.base.rotation.inverse() * (pose.position() - self.base.origin);
        // Zero orientation stays exactly that.
        if self.is_parallel() && pose.angles() == Vector3::zeros() {
            return Pose::at(position.x, position.y, position.z);
        }
        let rotation = self.base.rotation.inverse() * pose.rotation() * self.platform;
        Pose::from_parts(&position, &rotation)
    }

    /// A pose of the paper's frame in the rig's.
    pub fn to_rig(&self, pose: &Pose) -> Pose {
        if self.is_in_place() {
            return *pose;
        }
        let position = self.base.rotation * pose.position() + self.base.origin;
        if self.is_parallel() && pose.angles() == Vector3::zeros() {
            return Pose::at(position.x, position.y, position.z);
        }
        let rotation = self.base.rotation * pose.rotation() * self.platform.inverse();
        Pose::from_parts(&position, &rotation)
    }

    /// The velocity of the centre of mass in the paper's frame, m/s, of rates in the rig's.
    pub fn velocity(&self, rates: &Coordinates) -> Vector3<f64> {
        let velocity = rates.fixed_rows::<3>(0).into_owned();
        if self.base.rotation == Rotation3::identity() {
            velocity
        } else {
            self.base.rotation.inverse() * velocity
        }
    }

    /// A point of the paper's base frame in the rig's, m.
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.base.rotation * point + self.base.origin
    }

    /// Whether zero orientation is the same in both.
    fn is_parallel(&self) -> bool {
        self.platform == self.base.rotation
    }
}

const NUMBERED: [usize; SIX] = [0, 1, 2, 3, 4, 5];

/// The rig as [`Rig::paper`] makes it, bit for bit.
fn as_it_stands(rig: &Rig) -> Option<Shape> {
    let first = &rig.cables[0];
    let (a, b) = (half_side(&first.anchor), half_side(&first.attachment));
    // The number that somebody wrote, if that gives the same points.
    let written = |value: f64| (value * DECIMALS).round() / DECIMALS;
    let same = |a: f64, b: f64| {
        let ends = triangles::ends(a, b);
        rig.cables
            .iter()
            .zip(ends)
            .all(|(cable, (anchor, attachment))| cable.anchor == anchor && cable.attachment == attachment)
    };
    let near = |value: f64| [written(value), value, value.next_up(), value.next_down()];
    let down = rig.gravity.x == 0.0 && rig.gravity.y == 0.0 && rig.gravity.z > 0.0;
    let mut pairs = near(a).into_iter().flat_map(|a| near(b).into_iter().map(move |b| (a, b)));
    let (a, b) = pairs.find(|(a, b)| down && same(*a, *b))?;
    let base = Frame { origin: Vector3::zeros(), rotation: Rotation3::identity() };
    let robot = table(rig, a, b, &Rotation3::identity());
    Some(Shape { robot, residual: 0.0, order: NUMBERED, base, platform: Rotation3::identity() })
}

fn half_side(vertex: &Vector3<f64>) -> f64 {
    0.5 * 3f64.sqrt() * vertex.norm()
}

/// Table I of a rig whose platform's axes are turned by `platform` against the paper's.
fn table(rig: &Rig, a: f64, b: f64, platform: &Rotation3<f64>) -> RobotParameters {
    let inertia = platform.matrix().transpose() * rig.inertia * platform.matrix();
    RobotParameters {
        a,
        b,
        m: rig.mass,
        i1: inertia[(0, 0)],
        i2: inertia[(1, 1)],
        i3: inertia[(2, 2)],
        g: rig.gravity.norm(),
    }
}

/// A match that may be good or not.
struct Fit {
    shape: Shape,
    misfit: Misfit,
    /// By how much the paper's base is turned about gravity, rad.
    turn: f64,
}

/// The end that is farthest from its place.
#[derive(Clone, Copy)]
struct Misfit {
    end: &'static str,
    cable: usize,
    distance: f64,
}

/// Every way of laying the paper's triangles on the rig: three turns about gravity, and for each vertex of the base which of its two
/// cables is which.
fn candidates(rig: &Rig) -> impl Iterator<Item = Fit> {
    let down = Unit::new_normalize(rig.gravity);
    let upright = Rotation3::rotation_between(&Vector3::z(), &down)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let origin = rig.middle();
    let flat = rig.cables.map(|cable| (upright.inverse() * (cable.anchor - origin)).xy());
    // The paper's base vertices stand at 60, 180 and 300 degrees: three times their azimuth is half a turn.
    let cubed: Vector2<f64> = flat.iter().map(turned_by_thrice).sum();
    let first = libm::atan2(-cubed.y, -cubed.x) / 3.0;
    (0..3).flat_map(move |third| {
        let turn = first + f64::from(third) * std::f64::consts::TAU / 3.0;
        let base = Frame { origin, rotation: upright * Rotation3::from_axis_angle(&Vector3::z_axis(), turn) };
        let turn = libm::atan2(libm::sin(turn), libm::cos(turn)).abs();
        (0..8).filter_map(move |choice| {
            let (shape, misfit) = fit(rig, base, order(rig, &base, choice)?)?;
            Some(Fit { shape, misfit, turn })
        })
    })
}

/// A vector of the same length at three times the azimuth.
fn turned_by_thrice(p: &Vector2<f64>) -> Vector2<f64> {
    let azimuth = 3.0 * libm::atan2(p.y, p.x);
    Vector2::new(libm::cos(azimuth), libm::sin(azimuth)) * p.norm()
}

/// The rig's cables in the order of the paper's, by the base vertex that each is nearest to; bit v of `choice` exchanges the two at vertex
/// v. `None` if they are not two at each.
fn order(rig: &Rig, base: &Frame, choice: usize) -> Option<[usize; SIX]> {
    let vertices = triangles::ends(1.0, 1.0);
    let mut order = [usize::MAX; SIX];
    for (i, cable) in rig.cables.iter().enumerate() {
        let local = base.rotation.inverse() * (cable.anchor - base.origin);
        let along = |v: &usize| local.dot(&vertices[2 * v].0);
        let vertex = (0..3).max_by(|v, w| along(v).total_cmp(&along(w)))?;
        let exchanged = choice >> vertex & 1;
        let places = [2 * vertex + exchanged, 2 * vertex + 1 - exchanged];
        let free = places.into_iter().find(|place| order[*place] == usize::MAX)?;
        order[free] = i;
    }
    Some(order)
}

/// The sizes and the platform's frame that fit best; the base's axes, if they serve the platform as well.
fn fit(rig: &Rig, base: Frame, order: [usize; SIX]) -> Option<(Shape, Misfit)> {
    let units = triangles::ends(0.5 * 3f64.sqrt(), 0.5 * 3f64.sqrt());
    let anchor = |i: usize| base.rotation.inverse() * (rig.cables[order[i]].anchor - base.origin);
    let attachment = |i: usize| rig.cables[order[i]].attachment;
    let a = (0..SIX).map(|i| anchor(i).dot(&units[i].0)).sum::<f64>() / SIX as f64 * 0.5 * 3f64.sqrt();
    let of = |platform: Rotation3<f64>| {
        let along = |i: usize| attachment(i).dot(&(platform * units[i].1));
        let b = (0..SIX).map(along).sum::<f64>() / SIX as f64 * 0.5 * 3f64.sqrt();
        let places = triangles::ends(a, b);
        let far = |i: usize| {
            let at_anchor =
                Misfit { end: "anchor", cable: order[i], distance: (anchor(i) - places[i].0).norm() };
            let distance = (attachment(i) - platform * places[i].1).norm();
            [at_anchor, Misfit { end: "attachment", cable: order[i], distance }]
        };
        let misfit = (0..SIX).flat_map(far).max_by(|x, y| x.distance.total_cmp(&y.distance))?;
        let shape =
            Shape { robot: table(rig, a, b, &platform), residual: misfit.distance, order, base, platform };
        (a > 0.0 && b > 0.0).then_some((shape, misfit))
    };
    let parallel = of(base.rotation);
    if parallel.as_ref().is_some_and(|(_, misfit)| misfit.distance <= TOLERANCE * rig.radius()) {
        return parallel;
    }
    let covariance: Matrix3<f64> = (0..SIX).map(|i| attachment(i) * units[i].1.transpose()).sum();
    of(nearest_rotation(&covariance)?)
}

/// The rotation R with the greatest trace of Rᵀ `covariance` (Kabsch).
fn nearest_rotation(covariance: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let proper = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    Some(Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&proper) * v_t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{PerCable, Pulley, TensionLimits};

    const LIMITS: TensionLimits = TensionLimits { min: 0.0, max: 100.0 };

    fn paper() -> Rig {
        Rig::paper(&RobotParameters::default(), LIMITS)
    }

    /// The rig moved as a whole: the base frame turned and shifted, the platform's axes with it.
    fn moved(rig: &Rig, rotation: &Rotation3<f64>, shift: &Vector3<f64>) -> Rig {
        let mut rig = *rig;
        rig.gravity = rotation * rig.gravity;
        for cable in rig.cables.iter_mut() {
            cable.anchor = rotation * cable.anchor + shift;
            cable.attachment = rotation * cable.attachment;
        }
        rig.inertia = rotation.matrix() * rig.inertia * rotation.matrix().transpose();
        rig
    }

    #[test]
    fn the_papers_rig_is_found_bit_for_bit() {
        for (a, b) in [(0.45, 0.25), (0.7, 0.2), (0.001, 0.0003), (12.0, 7.25)] {
            let robot = RobotParameters { a, b, ..RobotParameters::default() };
            let shape = Shape::of(&Rig::paper(&robot, LIMITS)).unwrap();
            assert_eq!((shape.robot, shape.residual, shape.order), (robot, 0.0, NUMBERED));
            let pose = Pose(Coordinates::new(0.1, 0.2, 1.0, 0.1, -0.2, 0.3));
            assert_eq!((shape.to_paper(&pose), shape.to_rig(&pose)), (pose, pose));
        }
    }

    #[test]
    fn a_rig_turned_and_shifted_keeps_its_cable_numbers() {
        let pose = Pose(Coordinates::new(0.1, 0.05, 1.1, 0.1, -0.2, 0.3));
        // Turned by 120 degrees it is the paper's with other numbers: tests/recognised_rigs.rs.
        for degrees in [-150.0_f64, -119.0, -30.0, 90.0, 119.0, 179.0] {
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
            let shift = Vector3::new(1.0, -2.0, 0.5);
            let shape = Shape::of(&moved(&paper(), &turn, &shift)).unwrap();
            assert!(shape.residual < 1e-14 && shape.order == NUMBERED, "{degrees}: {shape:?}");
            assert!((shape.robot.a - 0.45).abs() < 1e-14 && (shape.robot.b - 0.25).abs() < 1e-14);
            let there = Pose::from_parts(
                &(turn * pose.position() + shift),
                &(turn * pose.rotation() * turn.inverse()),
            );
            assert!(shape.to_paper(&there).minus(&pose).norm() < 1e-13, "{degrees}");
            assert!(shape.to_rig(&pose).minus(&there).norm() < 1e-13, "{degrees}");
            let level = shape.to_paper(&Pose::at(1.0, -2.0, 1.5));
            assert_eq!(level.angles(), Vector3::zeros());
        }
    }

    #[test]
    fn a_rig_with_z_up_is_found_and_so_is_one_numbered_otherwise() {
        let half_turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let shape = Shape::of(&moved(&paper(), &half_turn, &Vector3::new(0.0, 0.0, 3.0))).unwrap();
        assert!((shape.to_paper(&Pose::at(0.0, 0.0, 2.0)).position() - Vector3::z()).norm() < 1e-14);
        let mut exchanged = paper();
        exchanged.cables.swap(0, 1);
        let shape = Shape::of(&exchanged).unwrap();
        assert_eq!(shape.order, [1, 0, 2, 3, 4, 5]);
        assert!(shape.base.rotation.angle() < 1e-12);
    }

    #[test]
    fn measured_coordinates_are_recognised_up_to_a_ten_thousandth() {
        let mut rig = paper();
        rig.cables[4].anchor.y += 4e-5;
        let shape = Shape::of(&rig).unwrap();
        assert!(shape.residual > 2e-5 && shape.residual < 5e-5, "{}", shape.residual);
        assert!(shape.to_paper(&Pose::default()).minus(&Pose::default()).norm() < 1e-4);
        rig.cables[4].anchor.y += 1e-2;
        let error = Shape::of(&rig).unwrap_err();
        assert!(matches!(error, OtherShape::Elsewhere { end: "anchor", cable: 5, .. }), "{error}");
        assert!(error.to_string().contains("the anchor of cable 5 is"), "{error}");
    }

    #[test]
    fn other_rigs_are_refused_with_what_differs() {
        let mut low = paper();
        low.cables.iter_mut().for_each(|cable| cable.attachment.z += 0.01);
        assert!(matches!(Shape::of(&low), Err(OtherShape::Elsewhere { end: "attachment", .. })));
        let mut seven = paper();
        seven.cables = PerCable::from_fn(7, |i| paper().cables[i % 6]);
        assert_eq!(Shape::of(&seven), Err(OtherShape::Cables(7)));
        let mut wheel = paper();
        wheel.cables[2].pulley = Some(Pulley { radius: 0.05, axis: Vector3::z() });
        assert_eq!(Shape::of(&wheel), Err(OtherShape::Pulley(3)));
    }
}
