//! Any rig: cables from anchors on a base to attachments on a platform, with limits of tension.

use nalgebra::{Matrix3, Matrix6xX, Vector3, Vector6};
use thiserror::Error;

use super::{CABLES, Geometry, Pose, RobotParameters};

/// A rig is degenerate at a pose if the smallest singular value of its wrench matrix, torques taken at the platform's radius, is
/// less than this share of the largest: errors of the geometry would show in the tensions a million times larger.
pub const SINGULARITY_THRESHOLD: f64 = 1e-6;
/// Points count as lying on a line or in a plane within this share of their extent.
const FLATNESS: f64 = 1e-9;
/// How closely anchors and attachments must agree with the paper's for a rig to be of its shape, m.
const SAME_SHAPE: f64 = 1e-9;

/// Tensions that the drives and cables allow, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionLimits {
    /// Least tension of a cable; at zero it is slack.
    pub min: f64,
    /// Greatest tension of a cable.
    pub max: f64,
}

/// A rig of six or more cables. Cable i runs from `anchors[i]` to `attachments[i]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// What people call it.
    pub name: String,
    /// Anchors in the base frame (z down), m.
    pub anchors: Vec<Vector3<f64>>,
    /// Attachments in the platform's frame, whose origin is the centre of mass, m.
    pub attachments: Vec<Vector3<f64>>,
    /// Mass of the platform, kg.
    pub mass: f64,
    /// Principal moments of inertia about the centre of mass along the platform's axes, kg m².
    pub inertia: Vector3<f64>,
    /// Gravitational acceleration along +z, m/s².
    pub g: f64,
    /// What each cable may pull.
    pub limits: TensionLimits,
}

/// Why the cables of a rig cannot hold a platform.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DegenerateRig {
    /// A body has six degrees of freedom.
    #[error("cables: {count} given, at least 6 are needed to hold a body in space")]
    TooFewCables {
        /// How many there are.
        count: usize,
    },
    /// All anchors or all attachments lie on a line.
    #[error("{ends} all lie on one line: no tensions give a torque about it")]
    Collinear {
        /// `anchors` or `attachments`.
        ends: &'static str,
    },
    /// All cables lie in one plane.
    #[error(
        "anchors and attachments all lie in one plane at the home pose: no tensions give a force across it"
    )]
    Coplanar,
    /// Both ends of a cable are at the same place.
    #[error("cable {cable} has no length at the home pose")]
    NoLength {
        /// Cable number, from 1.
        cable: usize,
    },
    /// The wrench matrix lacks rank for another reason.
    #[error(
        "the wrench matrix is singular at the home pose: its smallest singular value is {ratio:.1e} of the largest, at least \
         {SINGULARITY_THRESHOLD:.0e} is needed; there is a force or torque that no tensions give"
    )]
    Singular {
        /// Smallest over largest singular value.
        ratio: f64,
    },
}

impl Rig {
    /// The paper's rig with other numbers in Table I, and these limits.
    pub fn triangular(robot: &RobotParameters, limits: TensionLimits) -> Self {
        let geometry = Geometry::new(robot);
        Self {
            name: "Oh and Agrawal".to_owned(),
            anchors: geometry.anchor.to_vec(),
            attachments: geometry.attachment.to_vec(),
            mass: robot.m,
            inertia: Vector3::new(robot.i1, robot.i2, robot.i3),
            g: robot.g,
            limits,
        }
    }

    /// The parameters that make the paper's rig this one; `None` if its cables do not run as the paper's do.
    pub fn as_triangular(&self) -> Option<RobotParameters> {
        let half_side = |end: &Vector3<f64>| 0.5 * 3f64.sqrt() * end.norm();
        let robot = RobotParameters {
            a: half_side(self.anchors.first()?),
            b: half_side(self.attachments.first()?),
            m: self.mass,
            i1: self.inertia.x,
            i2: self.inertia.y,
            i3: self.inertia.z,
            g: self.g,
        };
        let same = |ours: &[Vector3<f64>], theirs: &[Vector3<f64>]| {
            ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(a, b)| (a - b).amax() < SAME_SHAPE)
        };
        let shape = Geometry::new(&robot);
        (same(&self.anchors, &shape.anchor) && same(&self.attachments, &shape.attachment)).then_some(robot)
    }

    /// Greatest distance of an attachment from the centre of mass, m.
    pub fn platform_radius(&self) -> f64 {
        self.attachments.iter().map(|b| b.norm()).fold(0.0, f64::max)
    }

    /// Tensions to (force, torque about the centre of mass), base frame: a column a cable. Not finite where a cable has no length.
    pub fn wrench_matrix(&self, pose: &Pose) -> Matrix6xX<f64> {
        let (position, rotation) = (pose.position(), pose.rotation());
        let mut matrix = Matrix6xX::zeros(self.anchors.len());
        for i in 0..self.anchors.len() {
            let arm = rotation * self.attachments[i];
            let along = self.anchors[i] - position - arm;
            let direction = along / along.norm();
            matrix.fixed_view_mut::<3, 1>(0, i).copy_from(&direction);
            matrix.fixed_view_mut::<3, 1>(3, i).copy_from(&arm.cross(&direction));
        }
        matrix
    }

    /// The wrench that the cables must give at rest: the weight, upwards. (N, N m).
    pub fn static_wrench(&self) -> Vector6<f64> {
        Vector6::new(0.0, 0.0, -self.mass * self.g, 0.0, 0.0, 0.0)
    }

    /// Smallest over largest singular value of the wrench matrix, torques taken at the platform's radius: below
    /// [`SINGULARITY_THRESHOLD`] there is a force or torque that no tensions give.
    pub fn regularity(&self, pose: &Pose) -> f64 {
        let mut matrix = self.wrench_matrix(pose);
        matrix.rows_mut(3, 3).unscale_mut(self.platform_radius());
        let singular_values = matrix.singular_values();
        singular_values.min() / singular_values.max()
    }

    /// Whether the cables can hold the platform at `home` against any small force and torque, limits apart.
    ///
    /// # Errors
    /// [`DegenerateRig`] with the cause.
    pub fn check(&self, home: &Pose) -> Result<(), DegenerateRig> {
        let count = self.anchors.len();
        if count < CABLES {
            return Err(DegenerateRig::TooFewCables { count });
        }
        let (position, rotation) = (home.position(), home.rotation());
        let ends: Vec<_> = self.attachments.iter().map(|b| position + rotation * b).collect();
        for (name, points) in [("anchors", &self.anchors), ("attachments", &ends)] {
            if dimensions(points) < 2 {
                return Err(DegenerateRig::Collinear { ends: name });
            }
        }
        let short =
            |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).norm() <= FLATNESS * self.platform_radius();
        if let Some(i) = self.anchors.iter().zip(&ends).position(short) {
            return Err(DegenerateRig::NoLength { cable: i + 1 });
        }
        if dimensions(&[self.anchors.clone(), ends].concat()) < 3 {
            return Err(DegenerateRig::Coplanar);
        }
        let ratio = self.regularity(home);
        if ratio >= SINGULARITY_THRESHOLD { Ok(()) } else { Err(DegenerateRig::Singular { ratio }) }
    }
}

/// 1 for points on a line, 2 in a plane, 3 in space; 0 for a single place.
fn dimensions(points: &[Vector3<f64>]) -> usize {
    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let scatter: Matrix3<f64> = points.iter().map(|p| (p - centre) * (p - centre).transpose()).sum();
    let spread = scatter.symmetric_eigenvalues().map(|square| square.max(0.0).sqrt());
    let extent = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
    spread.iter().filter(|s| **s > FLATNESS * extent).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper() -> Rig {
        Rig::triangular(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 })
    }

    #[test]
    fn wrench_matrix_is_that_of_the_papers_geometry() {
        let pose = Pose(Vector6::new(0.05, 0.02, 1.1, 0.1, 0.2, -0.1));
        let cables = Geometry::new(&RobotParameters::default()).cables(&pose.position(), &pose.rotation());
        assert!((paper().wrench_matrix(&pose) - cables.wrench_matrix()).amax() < 1e-15);
    }

    #[test]
    fn the_papers_shape_is_recognised() {
        let robot = RobotParameters { a: 0.7, b: 0.2, m: 3.0, ..RobotParameters::default() };
        let limits = TensionLimits { min: 0.0, max: 100.0 };
        let found = Rig::triangular(&robot, limits).as_triangular().unwrap();
        assert!((found.a - 0.7).abs() < 1e-15 && (found.b - 0.2).abs() < 1e-15 && found.m == 3.0);
        let mut bent = paper();
        bent.anchors[4].y += 1e-6;
        assert_eq!(bent.as_triangular(), None);
        let mut low = paper();
        low.attachments.iter_mut().for_each(|b| b.z += 0.01);
        assert_eq!(low.as_triangular(), None);
    }

    #[test]
    fn each_degenerate_rig_is_refused_with_its_cause() {
        let home = Pose::default();
        let cause = |change: fn(&mut Rig)| {
            let mut rig = paper();
            change(&mut rig);
            rig.check(&home).unwrap_err()
        };
        assert_eq!(paper().check(&home), Ok(()));
        let five = |rig: &mut Rig| {
            rig.anchors.pop();
            rig.attachments.pop();
        };
        assert_eq!(cause(five), DegenerateRig::TooFewCables { count: 5 });
        let on_a_line = |rig: &mut Rig| rig.anchors.iter_mut().for_each(|a| (a.y, a.z) = (2.0 * a.x, 0.1));
        assert_eq!(cause(on_a_line), DegenerateRig::Collinear { ends: "anchors" });
        let rod = |rig: &mut Rig| rig.attachments.iter_mut().for_each(|b| (b.y, b.z) = (0.0, 0.0));
        assert_eq!(cause(rod), DegenerateRig::Collinear { ends: "attachments" });
        let flat = |rig: &mut Rig| rig.anchors.iter_mut().for_each(|a| a.z = 1.0);
        assert_eq!(cause(flat), DegenerateRig::Coplanar);
        let none = |rig: &mut Rig| rig.anchors[3] = rig.attachments[3] + Vector3::z();
        assert_eq!(cause(none), DegenerateRig::NoLength { cable: 4 });
        // Anchor and attachment of every cable one above the other: nothing holds the platform sideways.
        let parallel = |rig: &mut Rig| rig.anchors = rig.attachments.clone();
        assert!(matches!(cause(parallel), DegenerateRig::Singular { ratio } if ratio < 1e-12));
    }
}
