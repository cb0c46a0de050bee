//! `MinimumTime`: courses of the paper's robot, level, along straight lines, and what they leave to the limits for what is not in the lines. Derived in
//! docs/minimum-time.md.

use super::course::{Course, Leg};
use super::line::Line;
use crate::control::tensions;
use crate::plan::exact::LEFT;
use crate::plan::planner::{Planner, Situation};
use crate::reach::Curve;
use crate::robot::{Coordinates, Pose, Shape, TensionLimits};

/// How level a goal must be, rad: rounding of rigs that stand turned.
const LEVEL: f64 = 1e-9;
/// Where holding the commands costs more than was left for it, a leg is planned again, with this many times as much.
const MORE: f64 = 1.05;
const PLANS: usize = 2;
/// Errors and disturbances are looked at where a leg begins and ends: in between they cost at most this many times as much.
const BETWEEN: f64 = 2.0;

impl Planner {
    /// Whether the planner's lines lead from one pose to the other: level ones of the paper's robot.
    pub(in crate::plan) fn is_level_move(&self, from: &Pose, goal: &Pose) -> bool {
        let Some(shape) = &self.shape else { return false };
        let tilt = |pose: &Pose| shape.to_paper(pose).minus(&Pose::default()).fixed_rows::<3>(3).amax();
        tilt(from) < self.rest.angle && tilt(goal) < LEVEL
    }

    /// The course to `goal` that begins at `begin` (s): from rest, or from the course `under_way` by way of a stop. `None` where none is proved, and before
    /// the robot rests.
    pub(in crate::plan) fn course(
        &self,
        now: &Situation,
        under_way: Option<&Course>,
        begin: f64,
        goal: &Pose,
    ) -> Option<Course> {
        if now.set_point == goal
            || !self.is_level_move(now.set_point, goal)
            || now.hold > self.parameters.longest_hold()
        {
            return None;
        }
        let shape = self.shape.as_ref()?;
        if let Some(stop) = under_way.and_then(|course| course.stop(begin)) {
            let from = stop.end_pose();
            let reference = under_way?.at(begin);
            let error = (now.pose.minus(&reference.pose), now.rates - reference.rates);
            let leg = self.leg(shape, now, &error, (&from, goal), begin + stop.timing.duration)?;
            return Some(Course::new(stop, Some(leg)));
        }
        if !now.is_steady() {
            return None;
        }
        let from = level(shape, now.set_point);
        let error = (now.pose.minus(&from), *now.rates);
        Some(Course::new(self.leg(shape, now, &error, (&from, goal), begin)?, None))
    }

    /// The fastest motion between two poses at rest that leaves what is needed to the limits.
    fn leg(
        &self,
        shape: &Shape,
        now: &Situation,
        error: &(Coordinates, Coordinates),
        (from, to): (&Pose, &Pose),
        begin: f64,
    ) -> Option<Leg> {
        let at_ends = |cost: &dyn Fn(&Pose) -> Option<f64>| Some(cost(from)?.max(cost(to)?));
        let of_error = BETWEEN * at_ends(&|pose| self.cost_of_error(pose, error))?;
        let disturbed = BETWEEN * at_ends(&|pose| self.cost_of_disturbance(pose))?;
        let unknown = self.unknown_on_the_way(from, to) + disturbed;
        // Where less is left at rest, no more is asked for.
        let most = (LEFT * self.known_margin_at(from)).max(0.0);
        let mut spare = self.allowance().max(of_error);
        for _ in 0..PLANS {
            let (line, timing, held) =
                self.along(shape, (from, to), (unknown + spare).min(most), now.hold)?;
            if of_error + held <= spare.min(most) {
                let direction = to.minus(from) / line.length();
                return Some(Leg { line, timing, begin, from: *from, direction, held });
            }
            spare = MORE * (of_error + held);
        }
        None
    }

    /// The fastest motion that keeps `spare` (N) from the limits, and what holding the commands for `hold` (s) costs on it.
    fn along(
        &self,
        shape: &Shape,
        (from, to): (&Pose, &Pose),
        spare: f64,
        hold: f64,
    ) -> Option<(Line, super::Timing, f64)> {
        let TensionLimits { min, max } = self.rig().common_limits();
        let limits = TensionLimits { min: min + spare, max: max - spare };
        let [start, end] = [from, to].map(|pose| shape.to_paper(pose).position());
        let line = Line::new(&shape.robot, limits, &start, &end);
        let timing = line.fastest(0.0, self.greatest_speed())?;
        let parameters = &self.parameters;
        let held = if parameters.hold_compensation {
            line.cost_of_holding(&timing, &parameters.gains(), hold * (hold + parameters.command_delay))
        } else {
            self.share_of_holding(hold) * line.change(&timing)
        };
        Some((line, timing, held))
    }

    /// On a level line, m/s: a cable's end moves as fast as the platform.
    fn greatest_speed(&self) -> f64 {
        let given = [self.parameters.max_speed, self.parameters.max_cable_speed];
        given.into_iter().filter(|limit| *limit > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// What an error of the pose and of the rates, which the law takes back, changes a tension by at most, N, about a pose at rest; to first order.
    ///
    /// Of cable i: (A e + B e'')_i with e = e₀ f + e₀' φ: a [`Curve`]. A is what a shift changes, B what an acceleration does.
    fn cost_of_error(&self, at: &Pose, (error, rates): &(Coordinates, Coordinates)) -> Option<f64> {
        /// s, so that a speed is a small way.
        const SHORT: f64 = 1e-3;
        let gains = self.parameters.gains();
        let (sum, omega2) = (gains.lambda + gains.eta, gains.omega_n_squared());
        let none = Coordinates::zeros();
        let at_rest = tensions(self.rig(), at, &none, &none, 0.0)?;
        let shifted = |by: Coordinates| tensions(self.rig(), &Pose(at.0 + by), &none, &none, 0.0);
        let accelerated = |by: &Coordinates| tensions(self.rig(), at, &none, by, 0.0);
        let (a_e, a_v) = (shifted(*error)?, shifted(rates * SHORT)?);
        let (b_e, b_v) = (accelerated(error)?, accelerated(rates)?);
        let cost = (0..at_rest.len()).map(|i| {
            let [a_e, a_v] = [a_e[i] - at_rest[i], (a_v[i] - at_rest[i]) / SHORT];
            let [b_e, b_v] = [b_e, b_v].map(|tension| tension[i] - at_rest[i]);
            // f'' = -ω² f + ω² S φ, φ'' = -S f + (S² - ω²) φ.
            let b = a_e - omega2 * b_e - sum * b_v;
            let c = a_v + omega2 * sum * b_e + (sum * sum - omega2) * b_v;
            let extremes = Curve { a: 0.0, b, c, d: 0.0 }.extremes(&gains);
            extremes.max.max(-extremes.min)
        });
        Some(cost.fold(0.0, f64::max))
    }

    /// What the estimated disturbance changes a tension by at most, N, at rest.
    fn cost_of_disturbance(&self, at: &Pose) -> Option<f64> {
        let none = Coordinates::zeros();
        if self.rig().disturbance == nalgebra::Vector6::zeros() {
            return Some(0.0);
        }
        let mut undisturbed = *self.rig();
        undisturbed.disturbance.fill(0.0);
        let [with, without] = [self.rig(), &undisturbed].map(|rig| tensions(rig, at, &none, &none, 0.0));
        let (with, without) = (with?, without?);
        Some((0..with.len()).map(|i| (with[i] - without[i]).abs()).fold(0.0, f64::max))
    }
}

/// The pose with zero orientation in the paper's frame.
fn level(shape: &Shape, pose: &Pose) -> Pose {
    let position = shape.to_paper(pose).position();
    shape.to_rig(&Pose::at(position.x, position.y, position.z))
}
