//! Any rig: cables from anchors on a base to attachments on a platform, what hangs from them, and what they may pull.

use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::parameters::{ParameterError, RobotParameters, require};
use super::per_cable::PerCable;
use super::pulley::Pulley;
use super::{Pose, triangles};

/// A body has six degrees of freedom: a rig needs at least as many cables.
pub const LEAST_CABLES: usize = 6;
/// A rig is degenerate at a pose if the smallest singular value of its wrench matrix, torques taken at the platform's radius, is
/// less than this share of the largest: errors of the geometry would show in the tensions a million times larger.
pub const SINGULARITY_THRESHOLD: f64 = 1e-6;
/// Points count as lying on a line or in a plane within this share of their extent.
const FLATNESS: f64 = 1e-9;

/// Tensions that the drive of a cable and the cable allow, N. By default a cable may pull with anything and be slack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TensionLimits {
    /// Least tension; at zero the cable is slack.
    pub min: f64,
    /// Greatest tension; infinite where nothing limits it.
    #[serde(with = "unlimited")]
    #[schemars(with = "Option<f64>")]
    pub max: f64,
}

/// Infinity as nothing: JSON knows no infinite numbers.
mod unlimited {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(max: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        max.is_finite().then_some(*max).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

impl TensionLimits {
    /// What is left with `margin` (N) kept from either limit.
    #[must_use]
    pub fn shrunk(&self, margin: f64) -> Self {
        Self { min: self.min + margin, max: self.max - margin }
    }

    /// How far inside the limits a tension is, N; negative outside.
    pub fn margin(&self, tension: f64) -> f64 {
        (tension - self.min).min(self.max - tension)
    }
}

impl Default for TensionLimits {
    fn default() -> Self {
        Self { min: 0.0, max: f64::INFINITY }
    }
}

/// One cable of a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cable {
    /// Where it leaves the base, m, base frame. With a pulley: the point on the pulley's swivel axis where the cable runs onto it.
    #[schemars(with = "[f64; 3]")]
    pub anchor: Vector3<f64>,
    /// Where it holds the platform, m, in the platform's frame, whose origin is the centre of mass.
    #[schemars(with = "[f64; 3]")]
    pub attachment: Vector3<f64>,
    /// What it may pull.
    pub limits: TensionLimits,
    /// The swivelling pulley at the anchor, if there is one.
    pub pulley: Option<Pulley>,
}

/// A rig of six or more cables: plain data.
///
/// The base frame is the user's: its origin is anywhere, and `gravity` says where down is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rig {
    /// In the order of the cable numbers.
    #[schemars(with = "Vec<Cable>")]
    pub cables: PerCable<Cable>,
    /// Mass of the platform, kg.
    pub mass: f64,
    /// Inertia of the platform about its centre of mass, platform frame, kg m²: symmetric.
    #[schemars(with = "[f64; 9]")]
    pub inertia: Matrix3<f64>,
    /// Gravitational acceleration, m/s², base frame.
    #[schemars(with = "[f64; 3]")]
    pub gravity: Vector3<f64>,
    /// Anchors and attachments lie within this distance of where they are said to be, m.
    pub accuracy: f64,
    /// What acts on the platform besides cables and weight: (force, torque about the centre of mass), N and N m, base frame. No rig file
    /// says it: the controller's observer estimates it.
    #[serde(default)]
    #[schemars(with = "[f64; 6]")]
    pub disturbance: Vector6<f64>,
}

/// Why the cables of a rig cannot hold a platform.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
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
    /// Both ends of a cable are at the same place, or its attachment is inside its pulley.
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
    /// The paper's rig with the numbers of Table I in `robot`, and the same limits for each cable.
    pub fn paper(robot: &RobotParameters, limits: TensionLimits) -> Self {
        let ends = triangles::ends(robot.a, robot.b);
        let cable = |i: usize| Cable { anchor: ends[i].0, attachment: ends[i].1, limits, pulley: None };
        Self {
            cables: PerCable::from_fn(ends.len(), cable),
            mass: robot.m,
            inertia: Matrix3::from_diagonal(&Vector3::new(robot.i1, robot.i2, robot.i3)),
            gravity: Vector3::new(0.0, 0.0, robot.g),
            accuracy: 0.0,
            disturbance: Vector6::zeros(),
        }
    }

    /// The limits of each cable.
    pub fn limits(&self) -> PerCable<TensionLimits> {
        self.cables.map(|cable| cable.limits)
    }

    /// The least tension of each cable, N.
    pub fn least_tensions(&self) -> PerCable<f64> {
        self.cables.map(|cable| cable.limits.min)
    }

    /// Tensions (N) as near as the limits of each cable let them be.
    pub fn clamped(&self, tensions: &PerCable<f64>) -> PerCable<f64> {
        PerCable::from_fn(tensions.len(), |i| {
            let TensionLimits { min, max } = self.cables[i].limits;
            tensions[i].clamp(min, max)
        })
    }

    /// The same rig with other limits, the same for each cable.
    #[must_use]
    pub fn with_limits(mut self, limits: TensionLimits) -> Self {
        self.cables.iter_mut().for_each(|cable| cable.limits = limits);
        self
    }

    /// Limits that are within those of every cable.
    pub fn common_limits(&self) -> TensionLimits {
        let all = TensionLimits::default();
        let both = |a: TensionLimits, b: TensionLimits| TensionLimits {
            min: a.min.max(b.min),
            max: a.max.min(b.max),
        };
        self.cables.iter().fold(all, |common, cable| both(common, cable.limits))
    }

    /// Greatest distance of an attachment from the centre of mass, m.
    pub fn platform_radius(&self) -> f64 {
        self.cables.iter().map(|cable| cable.attachment.norm()).fold(0.0, f64::max)
    }

    /// Middle of the anchors, m.
    pub fn middle(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.cables.iter().map(|cable| cable.anchor).sum();
        sum / self.cables.len() as f64
    }

    /// The rig's size: greatest distance of an anchor from the middle of the anchors, m.
    pub fn radius(&self) -> f64 {
        let middle = self.middle();
        self.cables.iter().map(|cable| (cable.anchor - middle).norm()).fold(0.0, f64::max)
    }

    /// m |g|, N.
    pub fn weight(&self) -> f64 {
        self.mass * self.gravity.norm()
    }

    /// The wrench that the cables must give at rest: the weight, upwards, and against the disturbance. (N, N m).
    pub fn static_wrench(&self) -> Vector6<f64> {
        let force = self.gravity * -self.mass;
        Vector6::new(force.x, force.y, force.z, 0.0, 0.0, 0.0) - self.disturbance
    }

    /// Names the first number that makes no sense, as the FMU's parameters are called.
    ///
    /// # Errors
    /// [`ParameterError`] with the parameter's name, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let count = self.cables.len() as f64;
        require(
            count >= LEAST_CABLES as f64,
            "cables",
            count,
            "at least 6 are needed to hold a body in space",
        )?;
        for (i, cable) in self.cables.iter().enumerate() {
            for (end, point) in [("anchor", &cable.anchor), ("attachment", &cable.attachment)] {
                for (axis, value) in ["x", "y", "z"].into_iter().zip(point.iter()) {
                    require(
                        value.is_finite(),
                        format!("{end}[{}].{axis}", i + 1),
                        *value,
                        "must be finite (m)",
                    )?;
                }
            }
        }
        let positive = |name: &'static str, value: f64| {
            require(value.is_finite() && value > 0.0, name, value, "must be finite and greater than 0")
        };
        positive("mass", self.mass)?;
        for (k, name) in ["inertia.xx", "inertia.yy", "inertia.zz"].into_iter().enumerate() {
            positive(name, self.inertia[(k, k)])?;
        }
        let allowed = "the inertia tensor must have principal moments greater than 0";
        require(self.inertia.cholesky().is_some(), "inertia.xy", self.inertia[(0, 1)], allowed)?;
        let gravity = self.gravity.norm();
        require(gravity.is_finite(), "gravity", gravity, "must be finite")?;
        let ok = self.accuracy.is_finite() && self.accuracy >= 0.0;
        require(ok, "accuracy", self.accuracy, "must be finite and 0 or greater (m)")?;
        self.validate_limits()
    }

    /// The limits alone; allocates for an error only.
    pub(crate) fn validate_limits(&self) -> Result<(), ParameterError> {
        let first = self.cables[0].limits;
        let alike = self.cables.iter().all(|cable| cable.limits == first);
        let named = |name: &str, i: usize| if alike { name.to_owned() } else { format!("{name}[{}]", i + 1) };
        for (i, TensionLimits { min, max }) in self.limits().into_iter().enumerate() {
            if !(min.is_finite() && min >= 0.0) {
                let allowed = "must be 0 or greater (N): cables cannot push";
                return require(false, named("minTension", i), min, allowed);
            }
            let is_above = max > min;
            if !is_above {
                return require(false, named("maxTension", i), max, "must be greater than minTension (N)");
            }
        }
        Ok(())
    }

    /// Whether a measured pose makes sense: finite, and with a cable that pulls against gravity. A platform above all its anchors has
    /// none.
    pub fn can_be_at(&self, pose: &Pose) -> bool {
        pose.0.iter().all(|coordinate| coordinate.is_finite()) && self.highest_anchor(pose) > 0.0
    }

    /// Height of the anchor that is highest above its attachment, m, against gravity; infinite without gravity.
    pub fn highest_anchor(&self, pose: &Pose) -> f64 {
        let (rotation, gravity) = (pose.rotation(), self.gravity.norm());
        if gravity == 0.0 {
            return f64::INFINITY;
        }
        let height = |cable: &Cable| {
            -(cable.anchor - pose.position() - rotation * cable.attachment).dot(&self.gravity) / gravity
        };
        self.cables.iter().map(height).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Smallest over largest singular value of the wrench matrix, torques taken at the platform's radius: below
    /// [`SINGULARITY_THRESHOLD`] there is a force or torque that no tensions give.
    pub fn regularity(&self, pose: &Pose) -> f64 {
        let columns = self.cables_at(pose).wrench_matrix();
        let radius = self.platform_radius();
        let scaled = |k: usize, i: usize| if k < 3 { columns[i][k] } else { columns[i][k] / radius };
        let singular_values = DMatrix::from_fn(6, columns.len(), scaled).singular_values();
        singular_values.min() / singular_values.max()
    }

    /// Whether the cables can hold the platform at `home` against any small force and torque, limits apart.
    ///
    /// # Errors
    /// [`DegenerateRig`] with the cause.
    pub fn check(&self, home: &Pose) -> Result<(), DegenerateRig> {
        let count = self.cables.len();
        if count < LEAST_CABLES {
            return Err(DegenerateRig::TooFewCables { count });
        }
        let (position, rotation) = (home.position(), home.rotation());
        let anchors: Vec<_> = self.cables.iter().map(|cable| cable.anchor).collect();
        let ends: Vec<_> = self.cables.iter().map(|cable| position + rotation * cable.attachment).collect();
        for (name, points) in [("anchors", &anchors), ("attachments", &ends)] {
            if dimensions(points) < 2 {
                return Err(DegenerateRig::Collinear { ends: name });
            }
        }
        let least = FLATNESS * self.platform_radius();
        let free = self.cables_at(home).free;
        if let Some(i) = free.iter().position(|length| length.is_nan() || *length <= least) {
            return Err(DegenerateRig::NoLength { cable: i + 1 });
        }
        if dimensions(&[anchors, ends].concat()) < 3 {
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
        Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 })
    }

    #[test]
    fn a_platform_above_all_its_anchors_makes_no_sense() {
        assert!(paper().can_be_at(&Pose::at(0.3, 0.0, 1.0)));
        for z in [0.0, -1.0, f64::NAN] {
            assert!(!paper().can_be_at(&Pose::at(0.3, 0.0, z)), "{z}");
        }
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
        let five = |rig: &mut Rig| rig.cables = PerCable::from_slice(&rig.cables[..5]).unwrap();
        assert_eq!(cause(five), DegenerateRig::TooFewCables { count: 5 });
        fn each(rig: &mut Rig, change: fn(&mut Cable)) {
            rig.cables.iter_mut().for_each(change);
        }
        let on_a_line = |rig: &mut Rig| each(rig, |c| (c.anchor.y, c.anchor.z) = (2.0 * c.anchor.x, 0.1));
        assert_eq!(cause(on_a_line), DegenerateRig::Collinear { ends: "anchors" });
        let rod = |rig: &mut Rig| each(rig, |c| (c.attachment.y, c.attachment.z) = (0.0, 0.0));
        assert_eq!(cause(rod), DegenerateRig::Collinear { ends: "attachments" });
        assert_eq!(cause(|rig| each(rig, |c| c.anchor.z = 1.0)), DegenerateRig::Coplanar);
        let none = |rig: &mut Rig| rig.cables[3].anchor = rig.cables[3].attachment + Vector3::z();
        assert_eq!(cause(none), DegenerateRig::NoLength { cable: 4 });
        // Anchor and attachment of every cable one above the other: nothing holds the platform sideways.
        let parallel = |rig: &mut Rig| each(rig, |c| c.anchor = c.attachment);
        assert!(matches!(cause(parallel), DegenerateRig::Singular { ratio } if ratio < 1e-12));
    }
}
