//! The planner `Exact`: at every tick the farthest set point that is admissible from the state the robot is in, moving or not.
//!
//! The certificate proves each of them, from the state as it is measured. For a goal with zero orientation the exact domain tells it how far
//! to look (docs/exact.md).

use super::bisection::smallest_admissible;
use super::planner::{MOST_SPANS, Planner, STEEPEST, Situation};
use crate::reach::certificate::{Step, certify_within};
use crate::reach::{Curve, ExactDomain, Verdict};
use crate::robot::pose::PITCH;
use crate::robot::{Pose, TensionLimits};

/// Tension that is left unused beside the limits, as a part of the weight: 0.1 N with Table I.
const SPARE: f64 = 0.0017;
/// The same for what holding the tensions costs, and a master that hands them on a step late: as a part of what the tension of a cable
/// changes by on the way, for each unit of (λ₀ + η₀) times the step.
const SPARE_HELD: f64 = 0.5;

/// The same with `hold_compensation`, for each unit of (λ₀ + η₀)² times the step and the step and delay together.
const SPARE_COMPENSATED: f64 = 0.25;

/// Grids of (17) that are tried: with eight bisections the third is 17 million times finer than the way.
const GRIDS: usize = 3;

/// What a robot that rests with less than the allowance may keep of it, as a part of what is left.
pub(super) const LEFT: f64 = 0.9;

impl Planner {
    /// The tension that is left unused at rest in every cable beside the limits, N.
    pub fn allowance(&self) -> f64 {
        SPARE * self.rig().weight()
    }

    /// The active set point is admissible from every state on the way to it, so there is always one (docs/exact.md); `None` if it is
    /// that one.
    pub(super) fn exact(&self, now: &Situation, goal: &Pose) -> Option<Pose> {
        if now.set_point == goal || !self.rig().can_be_at(goal) || now.hold > self.parameters.longest_hold() {
            return None;
        }
        let goal = &self.within_speed(now, goal);
        if now.set_point == goal {
            return None;
        }
        // Where less is left at rest, no more is asked for.
        let wanted = self.allowance() + self.unknown_on_the_way(now.pose, now.set_point);
        let spare = wanted.min(LEFT * self.known_margin_at(now.set_point)).max(0.0);
        let within_reach = self.translation(now, goal, spare);
        let next = self.proved(now, &within_reach.unwrap_or(*goal), spare);
        next.filter(|next| next == goal || self.is_worth_it(now.set_point, next))
    }

    /// Of the paper's robot, how far on the way to the goal cables stay taut, if nothing turns: the certificate need not look farther.
    /// `None` if they do not even on the way to the active set point, and for other motions and rigs.
    fn translation(&self, now: &Situation, goal: &Pose, spare: f64) -> Option<Pose> {
        let shape = self.shape.filter(|shape| now.is_level(shape, goal))?;
        let limits = TensionLimits { min: self.rig().common_limits().min + spare, max: f64::INFINITY };
        let [pose, from, to] = [now.pose, now.set_point, goal].map(|pose| shape.to_paper(pose).position());
        let velocity = shape.velocity(now.rates);
        let domain = ExactDomain::new(&shape.robot, &self.parameters.gains(), limits, pose, velocity);
        let share = domain.farthest(&from, &to)?;
        if share == 1.0 {
            return Some(*goal);
        }
        let (from, to) = (now.set_point.position(), goal.position());
        let mut set_point = *goal;
        set_point.0.fixed_rows_mut::<3>(0).copy_from(&(from + (to - from) * share));
        Some(set_point)
    }

    /// (17) with the certificate: the farthest set point found on the straight way to `goal` in six coordinates. Where the first of the grid's points is too
    /// far, on the way to that one, and so on.
    ///
    /// None of them leaves less at rest than the allowance; where less is left now, none leaves less than that.
    fn proved(&self, now: &Situation, goal: &Pose, spare: f64) -> Option<Pose> {
        let mut spans = MOST_SPANS;
        let at_rest = self.allowance().min(self.margin_at(now.set_point));
        let mut is_proved =
            |next: &Pose| self.margin_at(next) >= at_rest && self.is_proved(now, next, spare, &mut spans);
        let (steps, mut goal) = (self.parameters.bisection_steps, *goal);
        for _ in 0..GRIDS {
            let way = Way { from: now.set_point, goal: &goal };
            let beta = smallest_admissible(steps, |beta| is_proved(&way.at(beta)));
            if beta < 1.0 {
                return Some(way.at(beta));
            }
            goal = way.at(1.0 - libm::scalbn(1.0, -steps));
        }
        None
    }

    /// Whether the certificate proves the step to `set_point` with `least` (N) to spare, and with what holding the commands may cost.
    /// Undecided is no, also for want of `spans`. The pitch must stay where the angles tell the orientation.
    pub(super) fn is_proved(&self, now: &Situation, set_point: &Pose, least: f64, spans: &mut usize) -> bool {
        let gains = self.parameters.gains();
        let error = now.pose.minus(set_point)[PITCH];
        let pitch = Curve { a: set_point.0[PITCH], b: error, c: now.rates[PITCH], d: 0.0 }.extremes(&gains);
        if pitch.min <= -STEEPEST || pitch.max >= STEEPEST {
            return false;
        }
        let step = Step { start: *now.pose, rates: *now.rates, set_point: *set_point, gains };
        let mut change = |spare: f64| match certify_within(self.rig(), &self.limits(spare), &step, spans) {
            Ok(Verdict::Admissible { change, .. }) => Some(change),
            _ => None,
        };
        let Some(seen) = change(least) else { return false };
        let held = self.share_of_holding(now.hold) * seen;
        held <= least || change(held).is_some()
    }
}

impl Planner {
    /// What holding the commands costs, as a part of what the tension of a cable changes by on the way.
    pub(super) fn share_of_holding(&self, hold: f64) -> f64 {
        let parameters = &self.parameters;
        let sum = parameters.lambda + parameters.eta;
        if parameters.hold_compensation {
            SPARE_COMPENSATED * sum * sum * hold * (hold + parameters.command_delay)
        } else {
            SPARE_HELD * sum * hold
        }
    }
}

/// The straight way in six coordinates; angles turn the short way round.
pub(super) struct Way<'a> {
    pub from: &'a Pose,
    pub goal: &'a Pose,
}

impl Way<'_> {
    /// x_f + β (x_prev - x_f), Eq. (17).
    pub fn at(&self, beta: f64) -> Pose {
        Pose(self.goal.0 + self.from.minus(self.goal) * beta)
    }
}

#[cfg(test)]
mod tests {
    use super::super::interface::{ControllerParameters, PlannerKind};
    use super::*;
    use crate::robot::Coordinates;

    fn planner() -> Planner {
        Planner::from(ControllerParameters { planner: PlannerKind::Exact, ..Default::default() })
    }

    fn yaw(angle: f64) -> Pose {
        Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, 0.0, angle))
    }

    fn next(pose: &Pose, rates: &Coordinates, set_point: &Pose, goal: &Pose) -> Option<Pose> {
        let planner = planner();
        planner.next_set_point(&Situation { pose, rates, set_point, hold: 1e-3, rest: planner.rest }, goal)
    }

    #[test]
    fn the_papers_move_a_rise_and_a_turn_take_one_step_each() {
        let (start, at_rest) = (Pose::default(), Coordinates::zeros());
        for goal in [Pose::at(0.15, 0.15, 1.0), Pose::at(-0.1, 0.05, 0.8), yaw(0.9)] {
            assert_eq!(next(&start, &at_rest, &start, &goal), Some(goal));
        }
    }

    #[test]
    fn a_turn_too_far_for_one_step_goes_as_far_as_is_proved() {
        let (start, at_rest) = (Pose::default(), Coordinates::zeros());
        // At rest cables go slack at π/3.
        let first = next(&start, &at_rest, &start, &yaw(1.2)).unwrap();
        assert!(first.0[5] > 1.0 && first.0[5] < std::f64::consts::FRAC_PI_3, "{first:?}");
        assert_eq!(
            first.0[5] / 1.2 * 256.0,
            (first.0[5] / 1.2 * 256.0).round(),
            "not on the grid of Eq. (17)"
        );
    }

    /// 3 m down at gains of 30, a step of more than 11 mm asks for more than gravity gives: that is less than the 256th part of the way, and the goal was
    /// called unreachable.
    #[test]
    fn a_way_that_is_long_for_its_gains_is_gone_in_steps_finer_than_the_grid() {
        let parameters = ControllerParameters {
            planner: PlannerKind::Exact,
            lambda: 30.0,
            eta: 30.0,
            ..Default::default()
        };
        let (start, goal) = (Pose::default(), Pose(Coordinates::new(0.0, 0.0, 4.0, 0.0, 0.0, 0.1)));
        let next = Planner::from(parameters).next_from_rest(&start, &goal).unwrap();
        let step = next.0[2] - 1.0;
        assert!(step > 0.008 && step < 3.0 / 256.0, "{step}");
    }

    #[test]
    fn a_turn_can_be_taken_back_on_the_way() {
        let (pose, rates) = (yaw(0.3), Coordinates::new(0.1, 0.0, 0.05, 0.0, 0.0, 0.8));
        assert_eq!(next(&pose, &rates, &yaw(0.9), &Pose::default()), Some(Pose::default()));
    }

    #[test]
    fn the_active_set_point_turns_back_though_the_robot_is_still_level() {
        let goal = Pose::at(0.05, 0.0, 1.0);
        assert_eq!(next(&Pose::default(), &Coordinates::zeros(), &yaw(0.5), &goal), Some(goal));
    }

    #[test]
    fn where_the_robot_cannot_rest_is_unreachable_and_aimed_at_from_inside() {
        let (planner, start) = (planner(), Pose::default());
        assert!(planner.is_reachable(&start, &yaw(1.0)));
        for goal in [yaw(1.1), yaw(std::f64::consts::FRAC_PI_2), Pose::at(0.0, 0.0, -1.0)] {
            assert!(!planner.is_reachable(&start, &goal), "{goal:?}");
        }
        // Tensions vanish at π/3; here 0.2 N are left.
        let aim = planner.aim(&start, &yaw(1.1));
        let kept = 2.0 * planner.allowance();
        assert!(planner.rests_at(&aim, kept) && !planner.rests_at(&yaw(aim.0[5] + 1e-9), kept), "{aim:?}");
    }
}
