//! What keeps the robot from the closed form, how far, and what that leaves of the certificate. Derived in `docs/certificate.md`.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};

use super::Cause;
use super::motion::Step;
use super::statics::{Pulling, least_sideways, stiffness};
use crate::reach::Curve;
use crate::robot::pose::{PITCH, ROLL};
use crate::robot::{Coordinates, Pose, Rig};

/// Makes an upper bound of a formula of positive terms that is computed with rounding.
pub const UPWARDS: f64 = 1.0 + 1e-9;
/// By how much a bound of the disturbing accelerations is tried larger than what the last one led to.
const GROWTH: f64 = 1.02;
/// Bounds tried.
const MOST_BOUNDS: usize = 200;

/// Bounds of what the controller does not know or cannot do; all zero is the closed form itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Relative error of the mass and of each moment of inertia, below 1.
    pub mass: f64,
    /// Distance of the centre of mass from where the rig says it is, m.
    pub centre_of_mass: f64,
    /// Force on the centre of mass, N.
    pub force: f64,
    /// Torque about it, N m.
    pub torque: f64,
    /// Difference of what a cable pulls from what was commanded, N: friction that no force loop makes up for.
    pub friction: f64,
    /// What the law keeps from the limits where it can, N: more than six cables must be shared by (D1) with this margin.
    pub law_margin: f64,
    /// Distance of anchors and attachments from where the rig says they are, m.
    pub accuracy: f64,
    /// Longest time for which a command is held, s.
    pub sample_period: f64,
    /// Age of the pose and velocity that a command is computed from, s.
    pub delay: f64,
}

/// How far coordinates (m, rad), rates (m/s, rad/s) and accelerations (m/s², rad/s²) that go into the law may be from the closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Of the coordinates.
    pub coordinates: Coordinates,
    /// Of their rates.
    pub rates: Coordinates,
    /// Of the accelerations.
    pub accelerations: Coordinates,
}

/// What the cables come to over all time: what the disturbances depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Greatest sum of the tensions, N.
    pub pull: f64,
    /// Shortest straight part of a cable, m.
    pub shortest: f64,
    /// Least distance of an attachment from the axis of its pulley, m; infinite without pulleys.
    pub sideways: f64,
    /// Bounds of [`stiffness`].
    pub stiffness: [[f64; 6]; 3],
}

impl Margins {
    /// Whether the closed form is meant: what the law keeps from the limits is no error.
    pub fn are_none(&self) -> bool {
        *self == Self { law_margin: self.law_margin, ..Self::default() }
    }
}

impl Extent {
    /// Of nothing yet.
    pub fn none() -> Self {
        let far = f64::INFINITY;
        Self { pull: 0.0, shortest: far, sideways: far, stiffness: [[0.0; 6]; 3] }
    }

    /// Takes in a span.
    pub fn include(&mut self, rig: &Rig, pulling: &Pulling) {
        let apart = pulling.apart * (pulling.tension.len() as f64).sqrt();
        let pull = pulling.tension.iter().map(|tension| tension.range()[1]).sum::<f64>() + apart;
        self.pull = self.pull.max(pull * UPWARDS);
        self.shortest =
            pulling.length.iter().fold(self.shortest, |least, length| least.min(length.range()[0]));
        self.sideways = self.sideways.min(least_sideways(rig, pulling));
        self.raise_stiffness(&stiffness(rig, pulling));
    }

    fn raise_stiffness(&mut self, other: &[[f64; 6]; 3]) {
        for (mine, other) in self.stiffness.as_flattened_mut().iter_mut().zip(other.as_flattened()) {
            *mine = mine.max(*other);
        }
    }

    /// A guess at what this becomes in a tube.
    pub fn enlarged(&self) -> Self {
        let largest = self.stiffness.as_flattened().iter().fold(0.0_f64, |most, k| most.max(*k));
        Self {
            pull: 1.1 * self.pull,
            shortest: 0.97 * self.shortest,
            sideways: 0.97 * self.sideways,
            stiffness: self.stiffness.map(|row| row.map(|k| 1.05 * k + 0.05 * largest)),
        }
    }

    /// Whether nothing is larger than assumed.
    pub fn is_within(&self, assumed: &Self) -> bool {
        let stiffness = self.stiffness.as_flattened().iter().zip(assumed.stiffness.as_flattened());
        self.pull <= assumed.pull
            && self.shortest >= assumed.shortest
            && self.sideways >= assumed.sideways
            && stiffness.into_iter().all(|(k, most)| k <= most)
    }
}

impl Tube {
    /// The closed form itself.
    pub fn empty() -> Self {
        let none = Coordinates::zeros();
        Self { coordinates: none, rates: none, accelerations: none }
    }
}

/// Greatest value of φ.
fn largest_phi(step: &Step) -> f64 {
    step.gains.largest_phi() * UPWARDS
}

/// Least and greatest value of x - x_d of a coordinate, in closed form, with room for rounding.
fn errors(step: &Step, k: usize) -> [f64; 2] {
    let (error, rate) = (step.start.minus(&step.set_point)[k], step.rates[k]);
    let extremes = Curve { a: 0.0, b: error, c: rate, d: 0.0 }.extremes(&step.gains);
    let rounding = (UPWARDS - 1.0) * (error.abs() + rate.abs() * largest_phi(step));
    [extremes.min - rounding, extremes.max + rounding]
}

/// Why the angles cannot tell the law where the platform is turned to, if anywhere in the tube they cannot.
pub fn lost_angles(step: &Step, tube: &Tube) -> Option<Cause> {
    let largest =
        |k: usize| errors(step, k).map(f64::abs).into_iter().fold(0.0, f64::max) + tube.coordinates[k];
    if (3..6).any(|k| largest(k) > PI - 1e-6) {
        return Some(Cause::HalfTurn);
    }
    (largest_angle(step, tube, PITCH) > FRAC_PI_2 - 1e-6).then_some(Cause::GimbalLock)
}

/// Largest absolute value that an angle takes in the tube, rad.
fn largest_angle(step: &Step, tube: &Tube, k: usize) -> f64 {
    let goal = step.set_point.minus(&Pose(Coordinates::zeros()))[k];
    let [least, greatest] = errors(step, k);
    (goal + least).abs().max((goal + greatest).abs()) + tube.coordinates[k]
}

/// A bound of the accelerations that the model does not know, and with it the coordinates, rates and accelerations that reach the law, while the cables are within
/// `extent`; `None` where no bound is found.
///
/// For a bound D of the accelerations that the model does not know, the motion stays in a tube about the closed form, and in this tube
/// those accelerations are below G(D). A D with G(D) < D is what is looked for.
pub fn tube(rig: &Rig, step: &Step, margins: &Margins, extent: &Extent) -> Option<(Coordinates, Tube)> {
    let mut bound = Coordinates::zeros();
    for _ in 0..MOST_BOUNDS {
        let around = Around::new(rig, step, margins, &bound);
        let disturbance = around.disturbance(extent)?;
        if disturbance.iter().zip(&bound).all(|(found, tried)| found < tried || *found == 0.0) {
            return Some((bound, around.sensed()));
        }
        bound = disturbance * GROWTH;
    }
    None
}

/// Bounds of the motion, all of absolute values, while the unknown accelerations are within a bound.
struct Around<'a> {
    rig: &'a Rig,
    step: &'a Step,
    margins: &'a Margins,
    /// Distance from the closed form.
    tube: Tube,
    /// Rates of the coordinates.
    rates: Coordinates,
    /// Accelerations that the law would command at the true state, and those that happen.
    commanded: Coordinates,
    actual: Coordinates,
    /// Age of the state that the tensions were computed from, s.
    age: f64,
}

impl<'a> Around<'a> {
    fn new(rig: &'a Rig, step: &'a Step, margins: &'a Margins, bound: &Coordinates) -> Self {
        let (sum, product) = (step.gains.lambda + step.gains.eta, step.gains.omega_n_squared());
        let (phi, error, speed) =
            (largest_phi(step), step.start.minus(&step.set_point).abs(), step.rates.abs());
        // ∫φ = 1/(λη), ∫|φ'| = 2 max φ, ∫|φ''| = 1 + 2 Z_M.
        let tube = Tube {
            coordinates: bound * (UPWARDS / product),
            rates: bound * (2.0 * phi * UPWARDS),
            accelerations: bound * ((1.0 + 2.0 * step.gains.z_m()) * UPWARDS),
        };
        let commanded = (error * product + speed * sum) * UPWARDS + tube.accelerations;
        Self {
            rig,
            step,
            margins,
            tube,
            rates: (error * (product * phi) + speed) * UPWARDS + tube.rates,
            commanded,
            actual: (commanded + bound) * UPWARDS,
            age: margins.sample_period + margins.delay,
        }
    }

    /// How far the law's accelerations at the state that reaches it are from those at the true one.
    fn late(&self) -> Coordinates {
        let (sum, product) =
            (self.step.gains.lambda + self.step.gains.eta, self.step.gains.omega_n_squared());
        (self.rates * product + self.actual * sum) * (self.age * UPWARDS)
    }

    /// The tube of what reaches the law.
    fn sensed(&self) -> Tube {
        Tube {
            coordinates: (self.tube.coordinates + self.rates * self.age) * UPWARDS,
            rates: (self.tube.rates + self.actual * self.age) * UPWARDS,
            accelerations: (self.tube.accelerations + self.late()) * UPWARDS,
        }
    }

    /// Angular accelerations that the model does not know, x of them but for the error of each component of the inertia, where it knows of others up to `commanded`:
    /// y = x + δ M (y + commanded) with M = |I⁻¹| |I|. `None` where that error may be all of the inertia.
    fn answer_of_inertia(&self, x: &Vector3<f64>, commanded: f64) -> Option<Vector3<f64>> {
        let inertia = &self.rig.inertia;
        let errors = inertia.try_inverse()?.abs() * inertia.abs() * self.margins.mass;
        if errors.row_iter().any(|row| row.sum() >= MOST_OF_INERTIA) {
            return None;
        }
        (Matrix3::identity() - errors)
            .try_inverse()
            .map(|known| known * (x + errors * Vector3::repeat(commanded)))
    }

    /// The accelerations of the coordinates that the model does not know; `None` beyond the range of the estimates.
    fn disturbance(&self, extent: &Extent) -> Option<Coordinates> {
        let Self { rig, margins, age, .. } = *self;
        // True cables may be shorter, and hold the platform farther out, than is believed.
        let radius = rig.platform_radius() + margins.accuracy;
        let wheels = Wheels::new(rig, extent, margins.accuracy)?;
        let shortest = wheels.shortest;
        let (speed, spin) = (linear(&self.rates), angular(&self.rates));
        let sensed = self.sensed();
        let [roll, pitch] = [ROLL, PITCH].map(|k| largest_angle(self.step, &sensed, k));
        if lost_angles(self.step, &sensed).is_some() {
            return None;
        }
        // What the cables' force and torque change by while a command is held and grows old, and what friction takes or adds.
        let friction = rig.cables.len() as f64 * margins.friction;
        // By how much cables run in other directions than is believed.
        let bent = 2.0 * margins.accuracy / shortest;
        let swing = (speed + spin * radius) / shortest;
        let force = extent.pull * (age * swing + bent) + friction;
        let [dx, dy, dz, d_roll, d_pitch, d_yaw]: [f64; 6] = self.rates.into();
        let twist = [dx, dy, dz, d_roll + pitch * d_yaw, d_pitch + roll * d_yaw, d_yaw + roll * d_pitch];
        // The stiffness is that of the rig as it is believed to be; the true one differs by this share of all its terms' sizes.
        let differs = 2.0 * margins.accuracy / rig.platform_radius() + 3.0 * bent + wheels.differ;
        let unknown = extent.pull * radius * (spin + swing) * differs;
        let turned =
            |k: usize| ((0..6).map(|j| extent.stiffness[k][j] * twist[j]).sum::<f64>() + unknown) * age;
        let misplaced = extent.pull * (radius * bent + margins.accuracy);
        let torque = Vector3::from_fn(|k, _| turned(k) + misplaced + radius * friction);

        let (late, known) = (self.late(), 1.0 / (1.0 - margins.mass));
        let alpha = angular(&self.actual) + spin * spin;
        let lifted = |k: usize| rig.gravity[k].abs() + rig.disturbance[k].abs() / rig.mass;
        let weight = self.commanded + Coordinates::from_fn(|k, _| if k < 3 { lifted(k) } else { 0.0 });
        let push = late + weight * margins.mass + Coordinates::repeat((force + margins.force) / rig.mass);
        let around = margins.centre_of_mass * (alpha + spin * spin);
        let position = push * known + Coordinates::repeat(around);

        let pull = rig.mass * (linear(&weight) + linear(&late)) + force;
        // Of the inertia tensor its norm, and what its inverse makes of a torque.
        let largest = rig.inertia.norm();
        let inverse = rig.inertia.try_inverse()?.abs();
        let gyroscopic = largest * spin * (2.0 * age * alpha + margins.mass * spin);
        // The disturbance that is known does not turn with the platform, of which the law has an old pose.
        let turned_away = age * spin * rig.disturbance.fixed_rows::<3>(3).norm();
        let outer = gyroscopic + margins.centre_of_mass * pull + margins.torque + turned_away;
        let kinematic = angular(&late) + age * spin * (3.0 * angular(&self.actual) + spin * spin);
        let answer = (inverse * torque.add_scalar(outer)).add_scalar(kinematic);
        let body = self.answer_of_inertia(&answer, angular(&self.commanded) + spin * spin)?;
        // From angular accelerations about the platform's axes to those of the angles.
        let across = roll * body.y + body.z;
        let angles = [body.x + libm::tan(pitch) * across, body.y + roll * body.z, across / libm::cos(pitch)];
        let [x, y, z] = [position.x, position.y, position.z];
        Some(Coordinates::new(x, y, z, angles[0], angles[1], angles[2]) * UPWARDS)
    }
}

/// What δ times the inertia's errors may come to at most, of 1.
const MOST_OF_INERTIA: f64 = 0.999;

/// What ends that are off do to cables over pulleys; docs/certificate.md, "Pulleys".
struct Wheels {
    /// Shortest straight part that there may be, m.
    shortest: f64,
    /// How much the change of direction with the pose differs from what is believed, as a share, besides 3 β.
    differ: f64,
}

impl Wheels {
    /// `None` where a cable may have no straight part, or an attachment come nearer to the axis of a pulley than its radius.
    fn new(rig: &Rig, extent: &Extent, accuracy: f64) -> Option<Self> {
        let radius = rig.cables.iter().filter_map(|cable| Some(cable.pulley?.radius)).fold(0.0, f64::max);
        // l² = d² - r², d from the attachment to the centre of the wheel.
        let nearest = libm::hypot(extent.shortest, radius) - 2.0 * accuracy;
        let shortest = (nearest * nearest - radius * radius).sqrt();
        let sideways = extent.sideways - 2.0 * accuracy;
        if nearest <= radius || shortest.is_nan() || sideways < radius {
            return None;
        }
        let bent = 2.0 * accuracy / shortest;
        let differ =
            if radius > 0.0 { bent * (1.0 + nearest / shortest) + 12.0 * accuracy / sideways } else { 0.0 };
        Some(Self { shortest, differ })
    }
}

/// Of x, y, z together.
fn linear(q: &Coordinates) -> f64 {
    q.fixed_rows::<3>(0).norm()
}

/// Of roll, pitch and yaw together: each turns the platform about an axis of its own.
fn angular(q: &Coordinates) -> f64 {
    q.fixed_rows::<3>(3).sum()
}

#[cfg(test)]
mod tests {
    use super::super::proof::{Proof, prove};
    use super::*;
    use crate::control::{Gains, Response};
    use crate::robot::{Pulley, RobotParameters, TensionLimits};
    use rand::{RngExt, SeedableRng};

    fn step(lambda: f64, eta: f64) -> Step {
        let gains = Gains { lambda, eta };
        Step {
            start: Pose::default(),
            rates: Coordinates::zeros(),
            set_point: Pose::at(0.05, 0.0, 1.0),
            gains,
        }
    }

    /// ∫|φ|, ∫|φ'| and ∫|φ''| by the midpoint rule: what the worst disturbance of size 1 does to x, x' and the command.
    #[test]
    fn the_tube_is_what_the_worst_disturbance_does() {
        let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
        for (lambda, eta) in [(3.0, 3.0), (2.0, 5.0), (8.0, 1.0)] {
            let step = step(lambda, eta);
            let h = 1e-3;
            let mut worst = [0.0; 3];
            for k in 0..20_000 {
                let phi = Response::at(&step.gains, (f64::from(k) + 0.5) * h).motion(0.0, 1.0, 0.0);
                for d in 0..3 {
                    worst[d] += phi[d].abs() * h;
                }
            }
            let one = Coordinates::repeat(1.0);
            let tube = Around::new(&rig, &step, &Margins::default(), &one).tube;
            for (bound, worst) in [tube.coordinates, tube.rates, tube.accelerations].iter().zip(worst) {
                assert!((bound[0] - worst).abs() < 1e-4 * worst, "{} is not {worst}", bound[0]);
            }
        }
    }

    #[test]
    fn a_force_alone_moves_the_robot_by_force_over_stiffness() {
        let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
        let margins = Margins { force: 0.6, ..Margins::default() };
        let extent = Extent { pull: 70.0, shortest: 0.9, sideways: f64::INFINITY, stiffness: [[20.0; 6]; 3] };
        let (_, tube) = tube(&rig, &step(3.0, 3.0), &margins, &extent).unwrap();
        let expected = 0.6 / 6.0 / 9.0;
        assert!(tube.coordinates[2] >= expected && tube.coordinates[2] < 1.05 * expected, "{tube:?}");
        assert_eq!(tube.coordinates[4], 0.0);
    }

    #[test]
    fn what_a_proof_says_of_the_disturbance_is_more_than_comes_about() {
        let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
        for margins in [
            Margins { force: 0.1, ..Margins::default() },
            Margins { mass: 0.005, friction: 1e-3, ..Margins::default() },
            Margins { accuracy: 1e-6, sample_period: 2e-4, delay: 2e-4, ..Margins::default() },
        ] {
            let step = step(3.0, 4.0);
            let (_, proof) = prove(&rig, &step, &margins).unwrap();
            let Some(Proof::Admissible { tube: Some(proved), .. }) = proof else { panic!("{margins:?}") };
            let around = Around::new(&rig, &step, &margins, &proved.disturbance);
            let comes_about = around.disturbance(&proved.extent).unwrap();
            for (found, said) in comes_about.iter().zip(&proved.disturbance) {
                assert!(found < said || (*found == 0.0 && *said == 0.0), "{found} {said}");
            }
        }
    }

    /// Of products of inertia each error counts, and the torque that answers the others'.
    #[test]
    fn a_skew_inertia_that_is_off_disturbs_no_more_than_is_said() {
        let mut rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
        rig.inertia = Matrix3::new(0.125, 0.1, 0.0, 0.1, 0.125, 0.0, 0.0, 0.0, 0.25);
        let margins = Margins { mass: 0.02, torque: 1e-3, ..Margins::default() };
        let step =
            Step { set_point: Pose(Coordinates::new(0.05, 0.0, 1.0, 0.05, -0.05, 0.05)), ..step(3.0, 3.0) };
        let extent = Extent { pull: 70.0, shortest: 0.9, sideways: f64::INFINITY, stiffness: [[20.0; 6]; 3] };
        let around = Around::new(&rig, &step, &margins, &Coordinates::repeat(1e-3));
        let said = around.disturbance(&extent).unwrap().fixed_rows::<3>(3).into_owned();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        let mut most = 0.0f64;
        for _ in 0..2000 {
            let mut sign = || if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let meant = Vector3::from_fn(|k, _| sign() * around.commanded[3 + k]);
            let torque = Vector3::from_fn(|_, _| sign()).normalize() * margins.torque;
            let mut truth = rig.inertia;
            for (k, j) in [(0, 0), (1, 1), (2, 2), (0, 1)] {
                let off = rig.inertia[(k, j)] * (1.0 + sign() * margins.mass);
                (truth[(k, j)], truth[(j, k)]) = (off, off);
            }
            let happens = truth.try_inverse().unwrap() * (rig.inertia * meant + torque);
            let off = (happens - meant).abs().component_div(&said).max();
            assert!(off <= 1.0, "{off} of what is said");
            most = most.max(off);
        }
        assert!(most > 0.2, "{most}");
    }

    #[test]
    fn what_the_loop_cannot_stand_has_no_tube() {
        let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
        let margins = Margins { delay: 0.2, ..Margins::default() };
        let extent = Extent { pull: 70.0, shortest: 0.9, sideways: f64::INFINITY, stiffness: [[20.0; 6]; 3] };
        assert_eq!(tube(&rig, &step(3.0, 3.0), &margins, &extent), None);
    }

    /// Cables over wheels whose ends are both off: what [`Wheels`] says of their straight parts, directions and how these change with the pose.
    #[test]
    fn ends_that_are_off_change_a_cable_over_a_pulley_no_more_than_is_said() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
        let (accuracy, axis) = (1e-3, Vector3::z());
        let (mut tried, mut most) = (0, [0.0_f64; 2]);
        while tried < 20_000 {
            let radius = rng.random_range(0.01..0.2);
            let pulley = Pulley { radius, axis };
            let at = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
            let run = pulley.run(&at);
            let mut rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
            rig.cables[0].pulley = Some(pulley);
            let sideways = at.xy().norm();
            let extent = Extent { pull: 1.0, shortest: run.free, sideways, stiffness: [[0.0; 6]; 3] };
            let Some(wheels) = Wheels::new(&rig, &extent, accuracy).filter(|_| run.free > 0.02) else {
                continue;
            };
            tried += 1;
            let mut off = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64)).normalize() * accuracy;
            let moved = at + off() + off();
            let other = pulley.run(&moved);
            let bent = 2.0 * accuracy / wheels.shortest;
            assert!(other.free >= wheels.shortest && (other.direction - run.direction).norm() <= bent);
            let slopes = [at, moved].map(|at| {
                Matrix3::from_columns(&[0, 1, 2].map(|k| {
                    let direction = |h: f64| pulley.run(&(at + Vector3::ith(k, h))).direction;
                    (direction(1e-6) - direction(-1e-6)) / 2e-6
                }))
            });
            let differ = (slopes[0] - slopes[1]).singular_values().max() * wheels.shortest;
            let said = 3.0 * bent + wheels.differ;
            assert!(differ <= said + 1e-6, "{differ}, not {said}");
            assert!(slopes[1].singular_values().max() * wheels.shortest <= 1.0 + 1e-6);
            most = [most[0].max((other.direction - run.direction).norm() / bent), most[1].max(differ / said)];
        }
        assert!(most[0] > 0.5 && most[1] > 0.1, "{most:?}");
    }
}
