//! What a memory that was saved somewhere is checked for before it is taken up.

use super::planning::{ROUNDING, Refused};
use super::{Controller, Mode, UNSET_POSES};
use crate::control::DisturbanceObserver;
use crate::plan::aim::Search;
use crate::plan::interface::{ControllerOutputs, ControllerParameters};
use crate::plan::status::Status;
use crate::plan::stop::Stop;
use crate::plan::tuning::Pending;
use crate::robot::memory::{are_finite, are_of_each_cable, expect};
use crate::robot::{MemoryError, Pose};

impl Controller {
    /// Whether a run can have left this memory; its parameters are checked when it is read. Where nothing here tells that it cannot, what it commands keeps the limits all the same: each step sees to that.
    ///
    /// # Errors
    /// [`MemoryError`] for the first part that makes no sense.
    pub fn check(&self) -> Result<(), MemoryError> {
        let parameters = &self.planner.parameters;
        let (rig, cables) = (&parameters.rig, parameters.rig.cables.len());
        if let Some(wanted) = &self.wanted {
            expect(wanted.limits.len() == cables, "tuning", "limits of each cable")?;
            parameters.check_tuning(wanted)?;
        }
        let is_mode = match &self.mode {
            Mode::Disabled | Mode::Active => true,
            Mode::Waiting(held) => are_of_each_cable(held, cables),
            Mode::Faulted(stop) => Stop::is_sound(stop),
        };
        expect(is_mode, "mode", "finite numbers, one a cable")?;
        self.check_clock()?;
        let is_estimate = self.estimator.is_sound() && are_finite(&self.acceleration);
        expect(is_estimate, "estimate", "finite")?;
        let none = DisturbanceObserver { pole: 0.0, force: 0.0, torque: 0.0 };
        let observer = parameters.observer().unwrap_or(none);
        let are_found = [&rig.disturbance, &self.estimator.disturbance].map(|found| observer.can_find(found));
        expect(are_found == [true; 2], "disturbance", "within observerBound")?;
        expect(self.commands.is_sound(), "commands on their way", "no more than are remembered, finite")?;
        expect(self.force_loop.is_sound(rig), "force loop", "corrections within those of the rig")?;
        expect(self.has_sound_aims(), "aim", "finite poses, and a search with work left that it may have")?;
        let is_course = self.course.as_ref().is_none_or(|course| course.is_sound(cables));
        expect(is_course, "course", "finite numbers, a leg at least, with limits of each cable")?;
        self.check_outputs()
    }

    /// Whether it runs with these parameters, but for what was tuned and what it has found of the disturbance itself.
    pub fn is_of(&self, parameters: &ControllerParameters) -> bool {
        let own = &self.planner.parameters;
        let mut expected = parameters.tuned(&own.tuning());
        expected.rig.disturbance = own.rig.disturbance;
        parameters.rig.cables.len() == own.rig.cables.len() && *own == expected
    }

    /// When the command of the last step ends, s.
    pub fn holds_until(&self) -> f64 {
        self.time + self.hold[0]
    }

    fn check_clock(&self) -> Result<(), MemoryError> {
        expect(are_finite(&[self.time, self.started]), "times", "finite (s)")?;
        let are_spans = self.hold.iter().all(|hold| hold.is_finite() && *hold >= 0.0);
        expect(are_spans, "length of its last steps", "finite and 0 or greater (s)")?;
        // As the planner counts: one more than have passed.
        let passed = (self.time - self.planning_since()) / self.planner.parameters.planner_period;
        let has_counted = self.ticks == 0 || self.ticks as f64 - 1.0 <= passed.max(0.0) + ROUNDING;
        expect(has_counted, "count of the planner's decisions", "no more than have been due")?;
        expect(self.unset <= UNSET_POSES, "count of poses never set", "at most 5")
    }

    fn has_sound_aims(&self) -> bool {
        let is_pose = |pose: &Pose| are_finite(&pose.0);
        is_pose(&self.aim)
            && self.aimed_for.as_ref().is_none_or(is_pose)
            && self.search.as_ref().is_none_or(Search::is_sound)
            && self.refused.as_ref().is_none_or(Refused::is_sound)
            && self.way_points.iter().all(is_pose)
    }

    fn check_outputs(&self) -> Result<(), MemoryError> {
        let ControllerOutputs { motor_tension, reference, .. } = &self.outputs;
        let limits = self.planner.rig().limits();
        let keeps = motor_tension.len() == limits.len()
            && motor_tension.iter().zip(&limits).all(|(u, limits)| limits.margin(*u) >= 0.0);
        expect(keeps, "commanded tensions", "one a cable, from minTension to maxTension (N)")?;
        let vectors = [
            &self.outputs.set_point.0,
            &reference.pose.0,
            &reference.rates,
            &reference.accelerations,
            &self.outputs.estimated_pose.0,
            &self.outputs.estimated_velocity,
            &self.outputs.disturbance,
        ];
        expect(vectors.into_iter().all(are_finite), "outputs", "finite")?;
        let is_pending = self.outputs.pending != Pending::No;
        expect(is_pending == self.wanted.is_some(), "parametersPending", "0 if nothing was tuned")?;
        expect(self.outputs.set_point_index >= 0, "setPointIndex", "0 or greater")?;
        let is_status = match (&self.mode, self.outputs.status) {
            (Mode::Disabled, status) => status == Status::Disabled,
            (Mode::Waiting(_), status) => status == Status::WaitingForPose,
            (Mode::Faulted(_), status) => status == Status::SensorFault,
            (Mode::Active, Status::Disabled | Status::Unknown(_)) => false,
            (Mode::Active, status) => !status.lacks_pose(),
        };
        expect(is_status, "status", "as its mode is")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::ControllerInputs;
    use crate::plan::PlannerKind;
    use crate::robot::{PerCable, RigFile};

    fn inputs() -> ControllerInputs {
        let rest = PerCable::filled(6, 10.0);
        ControllerInputs {
            encoder_pose: Pose::default(),
            cable_length: RigFile::default().rig.cables_at(&Pose::default()).length,
            measured_tension: rest,
            goal_pose: Pose::at(0.15, 0.15, 1.0),
            enable: true,
        }
    }

    /// On its way, after so many steps of 1 ms; the robot is where it is led.
    fn under_way(planner: PlannerKind, steps: u32) -> Controller {
        let parameters = ControllerParameters { planner, ..ControllerParameters::default() };
        let mut inputs = inputs();
        let mut controller = Controller::new(parameters, 0.0, &inputs).unwrap();
        for k in 0..steps {
            controller.step(f64::from(k) * 1e-3, 1e-3, &inputs);
            inputs.encoder_pose = controller.outputs().reference.pose;
        }
        controller
    }

    #[test]
    fn every_memory_of_a_run_is_taken_up() {
        for planner in PlannerKind::ALL {
            for steps in [0, 1, 20, 60, 130, 400] {
                assert_eq!(under_way(planner, steps).check(), Ok(()), "{planner:?}, {steps} steps");
            }
        }
    }

    /// Each was accepted.
    #[test]
    fn a_memory_that_no_run_leaves_is_refused_and_says_what_is_wrong() {
        let refused = |part: &str, change: fn(&mut Controller)| {
            let mut controller = under_way(PlannerKind::MinimumTime, 130);
            assert!(controller.course.is_some());
            change(&mut controller);
            let said = controller.check().unwrap_err().to_string();
            assert!(said.starts_with(&format!("wrong {part}: right is ")), "{said}");
        };
        refused("commanded tensions", |c| c.outputs.motor_tension[0] = -0.71);
        refused("commanded tensions", |c| c.outputs.motor_tension[5] = f64::NAN);
        refused("mode", |c| c.mode = Mode::Waiting(PerCable::filled(5, 10.0)));
        refused("status", |c| c.mode = Mode::Waiting(PerCable::filled(6, 10.0)));
        refused("length of its last steps", |c| c.hold[0] = -1.0);
        refused("times", |c| c.started = f64::NAN);
        refused("count of the planner's decisions", |c| c.ticks = 1 << 40);
        refused("count of poses never set", |c| c.unset = 6);
        refused("estimate", |c| c.estimator.rates[2] = f64::INFINITY);
        refused("disturbance", |c| c.estimator.disturbance[0] = 100.0);
        refused("aim", |c| c.aim.0[0] = f64::NAN);
        refused("tuning", |c| {
            c.wanted = Some(c.planner.parameters.tuning());
            c.wanted.as_mut().unwrap().limits = PerCable::filled(5, Default::default());
        });
        refused("parametersPending", |c| c.wanted = Some(c.planner.parameters.tuning()));
        refused("setPointIndex", |c| c.outputs.set_point_index = -1);
    }
}
