//! Eq. (1) over a span of time: the wrench matrix, the wrench and, proved, the tensions between them.
//!
//! All in the platform's frame, where attachments and inertia are constant.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::motion::Motion;
use super::taylor::{ORDER, Taylor, combination};
use crate::robot::triangles::SIX;
use crate::robot::{Cable, PerCable, Pulley, Rig};

type Vector = [Taylor; 3];

/// Six cables over a span of time.
pub struct Cables {
    /// Tensions, N.
    pub tension: [Taylor; SIX],
    /// Tensions over lengths.
    pub solved: Solved,
    length: [Taylor; SIX],
    along: [Vector; SIX],
    placed: Placed,
}

/// Where the platform is over a span of time.
struct Placed {
    orientation: Orientation,
    /// In the platform's frame, m.
    position: Vector,
}

/// Cables that pull, over a span of time.
pub struct Pulling<'a> {
    /// Tensions, N,
    pub tension: &'a [Taylor],
    /// and what they were found with.
    pub solved: &'a Solved,
    /// How far from these they may be, all together, N.
    pub apart: f64,
    /// Lengths of the straight parts, m.
    pub length: &'a [Taylor],
    /// Along them, from the attachment, m, in the platform's frame.
    along: PerCable<Vector>,
    placed: &'a Placed,
}

impl Cables {
    /// As they pull.
    pub fn pulling(&self) -> Pulling<'_> {
        let Self { tension, solved, length, along, placed } = self;
        Pulling { tension, solved, apart: 0.0, length, along: PerCable::from_fn(SIX, |i| along[i]), placed }
    }
}

/// The cables over the span of `motion`; `None` where the wrench matrix is singular or too near to it to tell.
///
/// The columns of the matrix are taken `length` times too long, which makes them linear in R and the position: what is solved for is
/// tension over length.
pub fn cables(rig: &Rig, motion: &Motion) -> Option<Cables> {
    let placed = Placed::new(motion);
    let mut length = [Taylor::ZERO; SIX];
    let mut along = [[Taylor::ZERO; 3]; SIX];
    let mut matrix = [[Taylor::ZERO; SIX]; 6];
    for i in 0..SIX {
        let column = column(&rig.cables[i], &placed)?;
        along[i] = [column[0], column[1], column[2]];
        length[i] = norm(&along[i])?;
        for k in 0..6 {
            matrix[k][i] = column[k];
        }
    }
    let solved = solve(&matrix, &required_wrench(rig, motion, &placed.orientation))?;
    let tension = std::array::from_fn(|i| solved.unknowns[i] * length[i]);
    Some(Cables { tension, solved, length, along, placed })
}

/// W u = w of any number of cables over a span of time.
pub struct System {
    /// Columns of the wrench matrix, each `length` times too long.
    pub columns: PerCable<[Taylor; 6]>,
    /// Lengths of their straight parts, m.
    pub length: PerCable<Taylor>,
    /// What the cables must give.
    pub wrench: [Taylor; 6],
    placed: Placed,
}

impl System {
    /// The system over the span of `motion`; `None` where a cable may have no length.
    pub fn new(rig: &Rig, motion: &Motion) -> Option<Self> {
        let placed = Placed::new(motion);
        let count = rig.cables.len();
        let mut columns = PerCable::filled(count, [Taylor::ZERO; 6]);
        let mut length = PerCable::filled(count, Taylor::ZERO);
        for i in 0..count {
            columns[i] = column(&rig.cables[i], &placed)?;
            length[i] = norm(&[columns[i][0], columns[i][1], columns[i][2]])?;
        }
        Some(Self { columns, length, wrench: required_wrench(rig, motion, &placed.orientation), placed })
    }

    /// The cables as they pull with tensions that are no farther `apart` from these, N.
    pub fn pulling<'a>(&'a self, tension: &'a [Taylor], solved: &'a Solved, apart: f64) -> Pulling<'a> {
        let along = self.columns.map(|column| [column[0], column[1], column[2]]);
        Pulling { tension, solved, apart, length: &self.length, along, placed: &self.placed }
    }
}

impl Placed {
    fn new(motion: &Motion) -> Self {
        let orientation = Orientation::new(motion);
        let position = orientation.to_platform(&[0, 1, 2].map(|k| motion.coordinates[k]));
        Self { orientation, position }
    }

    /// From an attachment to the anchor.
    fn to_anchor(&self, cable: &Cable) -> Vector {
        let anchor = self.orientation.turned_to_platform(&cable.anchor);
        std::array::from_fn(|k| anchor[k] - self.position[k] + Taylor::constant(-cable.attachment[k]))
    }
}

/// From the attachment along the straight part of the cable, and the torque of a pull along it, both in the platform's frame: a column of the
/// wrench matrix, `length` times too long. `None` where an attachment may be inside a pulley.
fn column(cable: &Cable, Placed { orientation, position }: &Placed) -> Option<[Taylor; 6]> {
    let attachment = &cable.attachment;
    let anchor = orientation.turned_to_platform(&cable.anchor);
    let from_centre: Vector = std::array::from_fn(|k| anchor[k] - position[k]);
    let along: Vector = std::array::from_fn(|k| from_centre[k] + Taylor::constant(-attachment[k]));
    let (along, torque) = match &cable.pulley {
        None => (along, arm_cross(attachment, &from_centre)),
        Some(pulley) => {
            let along = over_pulley(pulley.radius, &orientation.turned_to_platform(&pulley.axis), &along)?;
            (along, arm_cross(attachment, &along))
        }
    };
    Some([along[0], along[1], along[2], torque[0], torque[1], torque[2]])
}

/// From the attachment to where the cable leaves the wheel, r (1 + cos θ) e + r sin θ axis from the anchor, with θ and e of
/// [`Pulley::run`]: so written, what is not known of the attachment comes in once as it is, and else times r.
fn over_pulley(radius: f64, axis: &Vector, to_anchor: &Vector) -> Option<Vector> {
    let height = -dot(to_anchor, axis);
    let sideways: Vector = std::array::from_fn(|k| -to_anchor[k] - axis[k] * height);
    let distance = norm(&sideways)?;
    let (p, q) = (distance + Taylor::constant(-radius), height);
    let square = p * p + q * q;
    let free =
        (square + Taylor::constant(-radius * radius).widened(f64::EPSILON * radius * radius)).sqrt()?;
    let of_radius = square.inverse() * radius;
    let cos = (p * radius - q * free) * of_radius;
    let sin = (q * radius + p * free) * of_radius;
    let outwards = (Taylor::constant(radius) + cos) * distance.inverse();
    Some(std::array::from_fn(|k| to_anchor[k] + sideways[k] * outwards + axis[k] * sin))
}

/// Bounds of how much the torque of the cables about the platform's axes changes when it moves while the tensions are held:
/// N m a metre along x, y, z of the base, N m a radian about the platform's axes.
///
/// In the platform's frame a turn of the platform turns all that is fixed in the base the other way round, the cables' directions too; besides, the
/// attachments move as in a shift.
pub fn stiffness(rig: &Rig, pulling: &Pulling) -> [[f64; 6]; 3] {
    let mut torque = [[Taylor::ZERO; 3]; 6];
    // Of a newton in each cable, squared and added up.
    let mut of_one = [[0.0; 3]; 6];
    for (i, cable) in rig.cables.iter().enumerate() {
        let (along, attachment) = (&pulling.along[i], &cable.attachment);
        let inverse_length = pulling.length[i].inverse();
        let swivel = cable.pulley.as_ref().map(|pulley| Swivel::new(pulley, cable, pulling, i));
        for j in 0..6 {
            let (turned, moved) = if j < 3 {
                ([Taylor::ZERO; 3], pulling.placed.orientation.rotation[j].map(|r| -r))
            } else {
                let axis = Vector3::ith(j - 3, 1.0);
                (arm_cross(&-axis, along), attachment.cross(&axis).map(Taylor::constant).into())
            };
            let swung = swing(along, &pulling.length[i], swivel.as_ref(), &moved);
            let change: Vector = std::array::from_fn(|k| (turned[k] + swung[k]) * inverse_length);
            let by_cable = arm_cross(attachment, &change);
            let sizes = by_cable.map(|part| part.size());
            torque[j] = std::array::from_fn(|k| torque[j][k] + by_cable[k] * pulling.tension[i]);
            of_one[j] = std::array::from_fn(|k| of_one[j][k] + sizes[k] * sizes[k]);
        }
    }
    let bound = |size: f64| if size.is_nan() { f64::INFINITY } else { size };
    let size = |j: usize, k: usize| torque[j][k].size() + pulling.apart * of_one[j][k].sqrt() * ROUND_UP;
    std::array::from_fn(|k| std::array::from_fn(|j| bound(size(j, k))))
}

/// By how much a cable that runs along v, of length l, changes its direction when its end moves by v', times l: v' - v (v·v')/l², across the cable;
/// and over a pulley less than that out of the plane of the wheel.
fn swing(along: &Vector, length: &Taylor, swivel: Option<&Swivel>, moved: &Vector) -> Vector {
    let inverse = length.inverse();
    let share = dot(along, moved) * (inverse * inverse);
    let across = std::array::from_fn(|k| moved[k] - along[k] * share);
    swivel.map_or(across, |swivel| {
        let less = dot(&swivel.normal, moved) * swivel.less;
        std::array::from_fn(|k| across[k] - swivel.normal[k] * less)
    })
}

/// The plane of a wheel that swivels: with the attachment moved by δ along its normal n, n long as the attachment is far from the axis, e, it turns
/// by δ/e, and the cable's direction with it by sin θ δ/e, where its straight part l has sin θ l = e - r (1 + cos θ).
struct Swivel {
    normal: Vector,
    /// (1 - l sin θ/e)/e² = r (1 + cos θ)/e³.
    less: Taylor,
}

impl Swivel {
    fn new(pulley: &Pulley, cable: &Cable, pulling: &Pulling, i: usize) -> Self {
        let axis = pulling.placed.orientation.turned_to_platform(&pulley.axis);
        let normal = cross(&axis, &pulling.placed.to_anchor(cable));
        let cos = dot(&axis, &pulling.along[i]) * pulling.length[i].inverse();
        let square = dot(&normal, &normal);
        let distance = square.sqrt().map_or(Taylor::ball(0.0, f64::INFINITY), |distance| distance.inverse());
        let less = (Taylor::constant(1.0) + cos) * distance * square.inverse() * pulley.radius;
        Self { normal, less }
    }
}

/// A lower bound of how far the attachments are from the axes of their pulleys, m; infinite without pulleys.
pub fn least_sideways(rig: &Rig, pulling: &Pulling) -> f64 {
    let sideways = |cable: &Cable| {
        let pulley = cable.pulley.as_ref()?;
        let axis = pulling.placed.orientation.turned_to_platform(&pulley.axis);
        let normal = cross(&axis, &pulling.placed.to_anchor(cable));
        Some(norm(&normal).map_or(0.0, |distance| distance.range()[0]))
    };
    rig.cables.iter().filter_map(sideways).fold(f64::INFINITY, f64::min)
}

/// Sines and cosines of the angles and R = Rz(yaw) Ry(pitch) Rx(roll).
struct Orientation {
    roll: (Taylor, Taylor),
    pitch: (Taylor, Taylor),
    /// Rows of R.
    rotation: [Vector; 3],
}

impl Orientation {
    fn new(motion: &Motion) -> Self {
        let [roll, pitch, yaw] = [3, 4, 5].map(|k| motion.coordinates[k].sin_cos());
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll, pitch, yaw);
        let (sp_sr, sp_cr) = (sp * sr, sp * cr);
        let rotation = [
            [cy * cp, cy * sp_sr - sy * cr, cy * sp_cr + sy * sr],
            [sy * cp, sy * sp_sr + cy * cr, sy * sp_cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ];
        Self { roll, pitch, rotation }
    }

    /// Rᵀ v.
    fn to_platform(&self, v: &Vector) -> Vector {
        let r = &self.rotation;
        std::array::from_fn(|k| r[0][k] * v[0] + r[1][k] * v[1] + r[2][k] * v[2])
    }

    /// Rᵀ v of a vector that does not move.
    fn turned_to_platform(&self, v: &Vector3<f64>) -> Vector {
        let r = &self.rotation;
        std::array::from_fn(|k| combination([v.x, v.y, v.z], [&r[0][k], &r[1][k], &r[2][k]]))
    }

    /// Angular velocity and acceleration in the platform's frame.
    fn spin(&self, motion: &Motion) -> (Vector, Vector) {
        let ((sr, cr), (sp, cp)) = (self.roll, self.pitch);
        let [roll, pitch, yaw] = [3, 4, 5].map(|k| motion.rates[k]);
        let [dd_roll, dd_pitch, dd_yaw] = [3, 4, 5].map(|k| motion.accelerations[k]);
        let (level, d_level) = (yaw * cp, dd_yaw * cp - yaw * pitch * sp); // yaw' cos(pitch) and its derivative
        let omega = [roll - yaw * sp, pitch * cr + level * sr, level * cr - pitch * sr];
        let alpha = [
            dd_roll - dd_yaw * sp - yaw * pitch * cp,
            dd_pitch * cr + d_level * sr + roll * omega[2],
            d_level * cr - dd_pitch * sr - roll * omega[1],
        ];
        (omega, alpha)
    }
}

/// Left side of Eq. (1), force and torque in the platform's frame.
fn required_wrench(rig: &Rig, motion: &Motion, orientation: &Orientation) -> [Taylor; 6] {
    let lift: Vector = std::array::from_fn(|k| motion.accelerations[k] + Taylor::constant(-rig.gravity[k]));
    let force = orientation.to_platform(&lift);
    let (omega, alpha) = orientation.spin(motion);
    let times_inertia = |v: &Vector| -> Vector {
        std::array::from_fn(|k| combination(std::array::from_fn(|j| rig.inertia[(k, j)]), v.each_ref()))
    };
    let (momentum, change) = (times_inertia(&omega), times_inertia(&alpha));
    let torque: Vector = std::array::from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        change[k] + omega[next] * momentum[last] - omega[last] * momentum[next]
    });
    let [fx, fy, fz] = force.map(|component| component * rig.mass);
    let inertial = [fx, fy, fz, torque[0], torque[1], torque[2]];
    if rig.disturbance == Vector6::zeros() {
        return inertial;
    }
    let [force, torque] = [0, 3].map(|k| rig.disturbance.fixed_rows::<3>(k).into_owned());
    let given = [force, torque].map(|v| orientation.turned_to_platform(&v));
    std::array::from_fn(|k| inertial[k] - given[k / 3][k % 3])
}

fn arm_cross(arm: &Vector3<f64>, v: &Vector) -> Vector {
    [
        combination([arm.y, -arm.z], [&v[2], &v[1]]),
        combination([arm.z, -arm.x], [&v[0], &v[2]]),
        combination([arm.x, -arm.y], [&v[1], &v[0]]),
    ]
}

fn dot(a: &Vector, b: &Vector) -> Taylor {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        a[next] * b[last] - a[last] * b[next]
    })
}

fn norm(v: &Vector) -> Option<Taylor> {
    dot(v, v).sqrt()
}

/// Six unknowns over a span, and what they were found with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// C.
    pub inverse: Matrix6<f64>,
    /// u.
    pub unknowns: [Taylor; 6],
}

/// All u with W u = w for some W of `matrix` and w of `wrench`.
///
/// With C near the inverse of W in the middle, A = C W is near 1 and A u = b = C w. A polynomial û that solves this to the order kept
/// leaves r = b - A û, and u - û = r + (1 - A)(u - û). Where ρ = ‖1 - A‖∞ < 1, A is regular and |u - û| ≤ ‖r‖∞/(1 - ρ); once more
/// through the same equation gives each component its own bound.
pub fn solve(matrix: &[[Taylor; SIX]; 6], wrench: &[Taylor; 6]) -> Option<Solved> {
    let inverse = Matrix6::from_fn(|row, column| matrix[row][column].coefficients[0]).try_inverse()?;
    let row = |k: usize| std::array::from_fn(|j| inverse[(k, j)]);
    let a: [[Taylor; 6]; 6] = std::array::from_fn(|k| {
        std::array::from_fn(|i| combination::<6>(row(k), std::array::from_fn(|j| &matrix[j][i])))
    });
    let b: [Taylor; 6] =
        std::array::from_fn(|k| combination::<6>(row(k), std::array::from_fn(|j| &wrench[j])));
    let near = series(&a, &b);
    let distance: [f64; 6] = std::array::from_fn(|k| {
        let one = Taylor::constant(1.0);
        (0..6).map(|i| if i == k { (one - a[k][i]).size() } else { a[k][i].size() }).sum::<f64>() * ROUND_UP
    });
    let residual: [f64; 6] =
        std::array::from_fn(|k| (0..6).fold(b[k], |left, i| left - a[k][i] * near[i]).size());
    let rho = greatest(&distance);
    if rho.is_nan() || rho >= 1.0 - 1e-9 {
        return None;
    }
    let apart = greatest(&residual) / (1.0 - rho) * ROUND_UP;
    let unknowns = std::array::from_fn(|k| near[k].widened((residual[k] + distance[k] * apart) * ROUND_UP));
    Some(Solved { inverse, unknowns })
}

/// What makes a bound got from a few rounded operations an upper bound again; 1 - ρ loses up to 1e-7 where ρ is near 1.
const ROUND_UP: f64 = 1.0 + 1e-6;

/// NaN if there is one.
fn greatest(values: &[f64; 6]) -> f64 {
    if values.iter().any(|value| value.is_nan()) {
        f64::NAN
    } else {
        values.iter().copied().fold(0.0, f64::max)
    }
}

/// The polynomials that solve A u = b power by power, taking A's constant part for 1.
fn series(a: &[[Taylor; 6]; 6], b: &[Taylor; 6]) -> [Taylor; 6] {
    let mut u = [Taylor::ZERO; 6];
    for order in 0..ORDER {
        for k in 0..6 {
            let mut term = b[k].coefficients[order];
            for i in 0..6 {
                for j in 1..=order {
                    term -= a[k][i].coefficients[j] * u[i].coefficients[order - j];
                }
            }
            u[k].coefficients[order] = term;
        }
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Gains, tensions};
    use crate::reach::certificate::margins::Tube;
    use crate::reach::certificate::motion::{Span, Step};
    use crate::robot::{Coordinates, Pose, Pulley, RobotParameters, TensionLimits};
    use nalgebra::Rotation3;

    const STEP: Step = Step {
        start: Pose(Coordinates::new(0.05, -0.1, 1.1, 0.1, -0.2, 0.3)),
        rates: Coordinates::new(0.1, 0.2, -0.1, 0.4, -0.3, 0.5),
        set_point: Pose(Coordinates::new(0.0, 0.1, 0.9, -0.1, 0.1, -0.2)),
        gains: Gains { lambda: 2.0, eta: 4.0 },
    };

    fn paper() -> Rig {
        Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 })
    }

    /// With pulleys, products of inertia and gravity that is not along z.
    fn odd() -> Rig {
        let mut rig = paper();
        rig.gravity = Vector3::new(0.5, -0.3, 9.7);
        (rig.inertia[(0, 1)], rig.inertia[(1, 0)]) = (0.005, 0.005);
        let pulley = Pulley { radius: 0.05, axis: Vector3::new(0.0, 0.6, -0.8) };
        rig.cables.iter_mut().step_by(2).for_each(|cable| cable.pulley = Some(pulley));
        rig
    }

    /// In the middle of a span.
    fn middle(numbers: &[Taylor; 6]) -> Coordinates {
        Coordinates::from_fn(|k, _| numbers[k].coefficients[0])
    }

    #[test]
    fn tensions_are_those_of_the_inverse_dynamics() {
        for (k, rig) in (0..100).map(|k| (k / 2, if k % 2 == 0 { paper() } else { odd() })) {
            let time = 0.05 * f64::from(k);
            let motion = STEP.motion(Span::Between(time, time), &Tube::empty());
            let found = cables(&rig, &motion).unwrap();
            let at = |of| middle(of);
            let [q, dq, ddq] = [at(&motion.coordinates), at(&motion.rates), at(&motion.accelerations)];
            let expected = tensions(&rig, &Pose(q), &dq, &ddq, 0.0).unwrap();
            for i in 0..SIX {
                let [low, high] = found.tension[i].range();
                assert!(
                    high - low < 1e-9 && (expected[i] - low).abs() < 1e-9,
                    "{} is not {}",
                    low,
                    expected[i]
                );
            }
        }
    }

    #[test]
    fn a_span_encloses_its_instants_with_an_error_of_high_order() {
        let rig = odd();
        let over =
            |width: f64| cables(&rig, &STEP.motion(Span::Between(0.2, 0.2 + width), &Tube::empty())).unwrap();
        let span = over(0.1);
        for k in 0..=20 {
            let at = 0.2 + 0.005 * f64::from(k);
            let instant = cables(&rig, &STEP.motion(Span::Between(at, at), &Tube::empty())).unwrap();
            for i in 0..SIX {
                let ([low, high], [l, h]) = (span.tension[i].range(), instant.tension[i].range());
                assert!(low <= l && h <= high);
            }
        }
        assert!(span.tension[0].error < 1e-2 && over(0.05).tension[0].error < span.tension[0].error / 40.0);
    }

    #[test]
    fn stiffness_is_the_change_of_the_torque_also_over_pulleys() {
        for rig in [paper(), odd()] {
            let motion = STEP.motion(Span::Between(0.3, 0.3), &Tube::empty());
            let found = cables(&rig, &motion).unwrap();
            let tension = found.tension.map(|u| u.coefficients[0]);
            let pose = Pose(middle(&motion.coordinates));
            let torque = |moved: &Vector3<f64>, turn: &Vector3<f64>| {
                let rotation = pose.rotation() * Rotation3::from_scaled_axis(*turn);
                rotation.inverse() * rig.cables(&(pose.position() + moved), &rotation).wrench(&tension).1
            };
            let bounds = stiffness(&rig, &found.pulling());
            for j in 0..6 {
                let step = |h: f64| {
                    let axis = Vector3::ith(j % 3, h);
                    if j < 3 { torque(&axis, &Vector3::zeros()) } else { torque(&Vector3::zeros(), &axis) }
                };
                let change = (step(1e-5) - step(-1e-5)) / 2e-5;
                for k in 0..3 {
                    let (bound, size) = (bounds[k][j], change[k].abs());
                    assert!((bound - size).abs() < 1e-6, "{k} {j}: {bound} {size}");
                }
            }
        }
    }
}
