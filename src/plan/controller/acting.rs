//! What the controller gives: the tensions of the law, for when they act.

use super::{Controller, Mode, are_numbers};
use crate::control::{Estimator, Reference, Response, lyapunov, tensions};
use crate::plan::fault::{Check, Fault};
use crate::plan::interface::ControllerInputs;
use crate::plan::stop::Stop;
use crate::robot::{Coordinates, PerCable, Pose};

impl Controller {
    /// The law (4), or what stands for it when the controller may not or cannot act.
    pub(super) fn act(&mut self, inputs: &ControllerInputs, dt: f64) {
        if self.mode == Mode::Active {
            let state = self.when_it_acts();
            let reference = self.followed();
            match self.law(&state, &reference) {
                Some(tension) => self.pull(&tension, &state, &reference, inputs, dt),
                None => {
                    let fault = Fault::new(Check::Singular, 0.0, 0.0, &{ self.estimator.pose });
                    self.mode = self.fault(fault, self.time);
                }
            }
        }
        match self.mode {
            Mode::Active => {}
            Mode::Disabled => self.outputs.motor_tension = self.planner.rig().least_tensions(),
            Mode::Waiting(held) => self.outputs.motor_tension = held,
            Mode::Faulted(stop) => self.outputs.motor_tension = self.braking(&stop),
        }
        self.report(&inputs.goal_pose);
    }

    /// The tensions of a stop in the middle of the interval in which they act: of the course, if it was on one.
    fn braking(&self, stop: &Stop) -> PerCable<f64> {
        let parameters = &self.planner.parameters;
        let begin = self.time + parameters.command_delay;
        let middle = begin + 0.5 * self.hold[0];
        let rig = self.planner.rig();
        let tension = match &self.course {
            Some(course) => {
                let Reference { pose, rates, accelerations } =
                    Reference::held(|time| course.at(time), middle, begin, self.hold[0]);
                tensions(rig, &pose, &rates, &accelerations, self.planner.allowance())
            }
            None => self.planner.tensions_of(stop, middle),
        };
        self.limited_or_least(tension)
    }

    fn law(&self, (pose, rates): &(Pose, Coordinates), reference: &Reference) -> Option<PerCable<f64>> {
        let gains = self.planner.parameters.gains();
        let margin = self.planner.allowance();
        lyapunov::tension_command(self.planner.rig(), &gains, pose, rates, reference, margin)
            .filter(are_numbers)
    }

    /// The reference for which the command of this step is computed, with the mean of its accelerations over the interval in which it acts.
    fn followed(&self) -> Reference {
        let begin = self.time + self.foreseen_delay();
        let at = if self.is_compensated() { begin + 0.5 * self.hold[0] } else { begin };
        if self.course.is_none() {
            return self.reference(at);
        }
        Reference::held(|time| self.reference(time), at, begin, self.hold[0])
    }

    fn is_compensated(&self) -> bool {
        self.planner.parameters.hold_compensation
    }

    /// Pose and rates when the command of this step begins to act: with `holdCompensation` the estimate carried through the commands that are on
    /// their way, else the estimate.
    pub(super) fn when_it_begins_to_act(&self) -> (Pose, Coordinates) {
        let Estimator { pose, rates, .. } = self.estimator;
        if !self.is_compensated() {
            return (pose, rates);
        }
        let acts = self.time + self.foreseen_delay();
        self.commands.carry((&pose, &rates), &self.disturbing(), self.time, acts)
    }

    /// Pose and rates for which the command of this step is computed: with `holdCompensation` what the closed form makes of those when it begins
    /// to act in the middle of the interval in which it does.
    fn when_it_acts(&self) -> (Pose, Coordinates) {
        let (pose, rates) = self.when_it_begins_to_act();
        if !self.is_compensated() {
            return (pose, rates);
        }
        let begins = self.reference(self.time + self.foreseen_delay());
        let middle = Response::at(&self.planner.parameters.gains(), 0.5 * self.hold[0]);
        middle.carry((pose, rates), &begins, &self.followed())
    }

    fn pull(
        &mut self,
        tension: &PerCable<f64>,
        state: &(Pose, Coordinates),
        reference: &Reference,
        inputs: &ControllerInputs,
        dt: f64,
    ) {
        let rig = self.planner.rig();
        let desired = rig.clamped(tension);
        let command = if self.planner.parameters.force_loop {
            self.force_loop.command(&desired, &inputs.measured_tension, dt)
        } else {
            desired
        };
        self.outputs.motor_tension = rig.clamped(&command);
        let (gains, state) = (self.planner.parameters.gains(), (&state.0, &state.1));
        let imposed =
            lyapunov::imposed(rig, &gains, state, reference, [tension, &desired]) - self.disturbing();
        self.commands.send(self.time, self.time + self.foreseen_delay(), imposed);
    }

    /// How much later than its measurement a command is reckoned to act, s.
    pub(super) fn foreseen_delay(&self) -> f64 {
        if self.is_compensated() { self.planner.parameters.command_delay } else { 0.0 }
    }
}
