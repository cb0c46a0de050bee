//! Events of co-simulation: the clock of the planner, and steps that end where it ticks.

use super::Instance;
use crate::lifecycle::State;
use crate::models::controller::PLANNER_TICK;
use crate::models::{Model, Running, Use, Variant};

/// Rounding of communication points, in communication steps.
const ROUNDING: f64 = 1e-6;

impl Instance {
    /// Event Mode -> Step Mode.
    pub fn enter_steps(&mut self) {
        self.now.state = State::StepMode;
    }

    /// Whether something has happened that the importer should enter Event Mode for.
    pub fn needs_event_mode(&self) -> bool {
        match &self.node {
            Some(node) => node.sends(),
            None => self.usage == Use::CoSimulationWithEvents && self.is_due(),
        }
    }

    /// The clock ticks where the planner will decide in the step that begins here.
    pub(super) fn set_clock(&mut self) {
        if self.has_clock() {
            let ticks = f64::from(self.is_due());
            self.now.values.put(PLANNER_TICK.first, ticks);
        }
    }

    /// Events are done: the clock ticks no more.
    pub(super) fn stop_clock(&mut self) {
        if self.has_clock() {
            self.now.values.put(PLANNER_TICK.first, 0.0);
        }
    }

    /// The length of a step from `point` that may end where the planner decides.
    pub(super) fn shortened(&self, point: f64, h: f64) -> f64 {
        let next = self.next_decision().filter(|_| self.returns_early);
        next.map(|next| next - point)
            .filter(|&until| until > ROUNDING * h && until < h * (1.0 - ROUNDING))
            .unwrap_or(h)
    }

    fn has_clock(&self) -> bool {
        self.interface.variant() == Variant::Full && self.model() == Model::Controller
    }

    fn is_due(&self) -> bool {
        // As the controller compares.
        self.next_decision().is_some_and(|next| next - self.time() <= self.rounding())
    }

    fn next_decision(&self) -> Option<f64> {
        self.now.running.as_ref().and_then(Running::next_decision)
    }

    /// s.
    fn rounding(&self) -> f64 {
        match &self.now.running {
            Some(Running::Controller(controller)) => ROUNDING * controller.parameters().planner_period,
            _ => 0.0,
        }
    }
}
