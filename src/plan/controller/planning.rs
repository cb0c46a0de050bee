//! What the controller decides at a tick of the planner: goal, gains and the next set point.

use serde::{Deserialize, Serialize};

use super::{Controller, Mode};
use crate::control::estimator::SETTLING;
use crate::plan::aim::WORK;
use crate::plan::interface::PlannerKind;
use crate::plan::planner::{Planner, Situation};
use crate::plan::prediction::{Motion, Prediction};
use crate::plan::tuning::{Pending, Tuning};
use crate::robot::memory::are_finite;
use crate::robot::{Coordinates, ParameterError, Pose};

/// A course that was not found is looked for again after this time, s.
const PATIENCE: f64 = 0.5;

/// What no course was found for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Refused {
    set_point: Pose,
    aim: Pose,
    /// When it is tried again, s.
    until: f64,
}

impl Refused {
    pub(super) fn is_sound(&self) -> bool {
        are_finite(&self.set_point.0) && are_finite(&self.aim.0) && self.until.is_finite()
    }

    fn is_still(&self, set_point: &Pose, aim: &Pose, time: f64) -> bool {
        (self.set_point, self.aim) == (*set_point, *aim) && time < self.until
    }
}

/// Of communication points, as a share of the planner's period.
pub(super) const ROUNDING: f64 = 1e-6;

impl Controller {
    /// What may change while it runs, as it was tuned last.
    pub fn tuning(&self) -> Tuning {
        self.wanted.unwrap_or_else(|| self.planner.parameters.tuning())
    }

    /// Changes gains, limits and tolerances: with the next step while no motion is planned, else at the first decision of the planner at which the motion under way
    /// is proved to go on with them ([`Pending`]). Until then it goes on as before.
    ///
    /// # Errors
    /// [`ParameterError`] for what makes no sense; then all stays as it was.
    pub fn tune(&mut self, tuning: &Tuning) -> Result<(), ParameterError> {
        self.planner.parameters.check_tuning(tuning)?;
        self.wanted = (*tuning != self.planner.parameters.tuning()).then_some(*tuning);
        self.outputs.pending = if self.wanted.is_some() { Pending::Undecided } else { Pending::No };
        Ok(())
    }

    /// Takes over what was tuned, if the planner with it `can_go_on`.
    pub(super) fn take_tuning(&mut self, can_go_on: impl FnOnce(&Planner, &Situation) -> bool) {
        let Some(tuning) = self.wanted else { return };
        let planner = self.planner.tuned(&tuning);
        let (pose, rates) = self.when_it_begins_to_act();
        let then = Situation { pose: &pose, rates: &rates, rest: planner.rest, ..self.situation() };
        if can_go_on(&planner, &then) {
            self.planner = planner;
            // Where it made for followed from the limits before.
            (self.wanted, self.search, self.aimed_for) = (None, None, None);
            self.outputs.pending = Pending::No;
        } else {
            self.outputs.pending = Pending::NotProved;
        }
    }

    /// When the planner decides next, s: at the first step that begins there or later. `None` while it plans nothing.
    pub fn next_decision(&self) -> Option<f64> {
        let next = self.planning_since() + self.ticks as f64 * self.planner.parameters.planner_period;
        (self.mode == Mode::Active).then_some(next)
    }

    /// Fig. 4: every T_s the next set point, if there is one; a new goal is taken up at the next of these ticks.
    pub(super) fn plan(&mut self, goal: &Pose) {
        if let Some(search) = &mut self.search {
            self.planner.advance(search, WORK);
        }
        let period = self.planner.parameters.planner_period;
        let elapsed = (self.time - self.planning_since()) / period;
        // A tick is not missed for the rounding of communication points.
        if elapsed < self.ticks as f64 - ROUNDING {
            return;
        }
        self.ticks = ((elapsed + ROUNDING).floor() as u64).saturating_add(1);
        self.take_tuning(Planner::can_go_on);
        let set_point = self.outputs.set_point;
        let goal = &self.take_goal(goal);
        // A new set point changes the motion only from where its first command acts.
        let (pose, rates) = self.when_it_begins_to_act();
        let then = Situation { pose: &pose, rates: &rates, ..self.situation() };
        let next = match self.planner.parameters.planner {
            PlannerKind::MinimumTime => self.set_out(&pose, &rates),
            PlannerKind::Bounded | PlannerKind::Exact => self.planner.next_set_point(&then, &self.aim),
        };
        let stuck = self.is_steady()
            && next.is_none()
            && set_point != self.aim
            && !self.planner.waits(&self.situation(), &self.aim);
        self.unreachable = stuck || self.aim != *goal || !self.planner.is_reachable(&set_point, goal);
        let instead = if stuck { set_point } else { self.aim };
        self.outputs.goal_distance =
            if self.unreachable { self.planner.distance(&instead, goal) } else { 0.0 };
        if let Some(next) = next {
            self.outputs.set_point = next;
            self.outputs.set_point_index = self.outputs.set_point_index.saturating_add(1);
            self.outputs.steady = false;
        }
        self.predict();
    }

    /// When the planner's clock started, s: that of `MinimumTime` when it is known how the robot moved at the start, for its motions leave no room for that.
    pub(super) fn planning_since(&self) -> f64 {
        let is_fast = self.planner.parameters.planner == PlannerKind::MinimumTime;
        if is_fast { self.started + SETTLING } else { self.started }
    }

    /// Begins the course to where the planner makes for, from where the robot will be when its first command acts.
    fn set_out(&mut self, pose: &Pose, rates: &Coordinates) -> Option<Pose> {
        let (set_point, aim) = (self.outputs.set_point, self.aim);
        if !self.is_under_way() {
            let at_once = |next: &&Pose| !self.planner.is_worth_it(&set_point, next);
            let passed = self.way_points.iter().take_while(at_once).count();
            self.way_points.drain(..passed);
        }
        let is_direct = self.way_points.is_empty();
        if (is_direct && set_point == aim)
            || self.refused.is_some_and(|refused| refused.is_still(&set_point, &aim, self.time))
        {
            return None;
        }
        let then = Situation { pose, rates, ..self.situation() };
        let begin = self.time + self.foreseen_delay();
        if is_direct && !self.is_under_way() && !self.planner.is_worth_it(&set_point, &aim) {
            self.course = None;
            return Some(aim);
        }
        let found = self.planner.course(&then, self.course.as_ref(), begin, (&self.way_points, &aim));
        let is_asked =
            !self.course.as_ref().is_some_and(|course| begin < course.end() && course.is_for(&aim));
        let until = self.time + PATIENCE;
        self.refused = (found.is_none() && is_asked).then_some(Refused { set_point, aim, until });
        let (course, end) = found?;
        if end == aim {
            self.way_points.clear();
        }
        self.course = Some(course);
        Some(end)
    }

    /// The goal, or the one before if it differs by so little that no step is worth it. The search for where the planner makes for takes a
    /// few steps, in which the robot goes on as before.
    fn take_goal(&mut self, goal: &Pose) -> Pose {
        let known = self.search.map(|search| search.goal).or(self.aimed_for);
        let goal = known.filter(|known| !self.planner.is_worth_it(known, goal)).unwrap_or(*goal);
        if known != Some(goal) {
            let mut search = self.planner.search(&self.outputs.set_point, &goal);
            self.planner.advance(&mut search, WORK);
            self.search = Some(search);
        }
        match self.search {
            Some(search) if search.has_ended() => {
                (self.aim, self.aimed_for, self.search) = (search.at, Some(goal), None);
                goal
            }
            // Until it has ended, the goal before stands.
            Some(_) => self.aimed_for.unwrap_or(self.aim),
            None => goal,
        }
    }

    pub(super) fn predict(&mut self) {
        let (pose, rates) = self.when_it_begins_to_act();
        let begins = self.time + self.foreseen_delay();
        let hold = self.situation().hold;
        self.prediction = match &self.course {
            Some(course) if begins < course.end() => Prediction::of_course(
                self.planner.rig(),
                course,
                &self.planner.parameters.gains(),
                (&pose, &rates),
                begins,
                self.planner.allowance(),
            ),
            _ => prediction(&self.planner, (&pose, &rates), &self.outputs.set_point, begins, hold),
        };
    }
}

pub(super) fn prediction(
    planner: &Planner,
    state: (&Pose, &Coordinates),
    set_point: &Pose,
    time: f64,
    hold: f64,
) -> Prediction {
    let motion = Motion { pose: state.0, rates: state.1, set_point, gains: planner.parameters.gains() };
    Prediction::new(planner.rig(), &motion, time, planner.allowance(), planner.share_of_holding(hold))
}
