//! What the controller takes in: the measured pose, and what it makes of one that makes no sense.

use super::{Controller, IN_MOTION, Mode};
use crate::control::estimator::SETTLING;
use crate::control::{Estimator, static_tensions};
use crate::plan::fault::{Check, Fault, check_pose, jump, pose_of_lengths};
use crate::plan::interface::{ControllerInputs, PoseSource};
use crate::plan::stop::Stop;
use crate::robot::{Coordinates, PerCable, Pose};

impl Controller {
    /// Takes in the measured pose and the operator's `enable`, and settles the mode.
    pub(super) fn sense(&mut self, inputs: &ControllerInputs, dt: f64) {
        let measured = self.measured_pose(inputs, dt);
        let jump = measured.ok().and_then(|pose| jump(&pose, &self.estimator, dt, self.planner.size));
        let was = self.mode;
        self.mode = match (inputs.enable, was, measured, jump) {
            (false, ..) => Mode::Disabled,
            (true, Mode::Faulted(stop), ..) => Mode::Faulted(stop),
            (true, Mode::Active, Ok(_), Some(fault)) | (true, Mode::Active, Err(fault), _) => {
                self.fault(fault, self.time - dt)
            }
            (true, _, Err(fault), _) if self.is_fresh || matches!(was, Mode::Waiting(_)) => {
                Mode::Waiting(self.hold_still(fault))
            }
            (true, _, Err(fault), _) => self.fault(fault, self.time - dt),
            (true, _, Ok(_), _) => Mode::Active,
        };
        match (measured, jump) {
            (Ok(pose), Some(_)) => self.estimator = Estimator::at_rest(pose),
            // The pose before was not measured.
            (Ok(pose), None) if matches!(was, Mode::Waiting(_)) => self.estimator = Estimator::at_rest(pose),
            (Ok(pose), None) => self.estimate(&pose, dt, was),
            (Err(_), _) => {}
        }
        if self.mode == Mode::Active && was != Mode::Active {
            self.start_here();
        }
        if self.mode == Mode::Active && self.has_started_in_motion() {
            self.outputs.set_point = self.planner.stop(&self.situation());
            // A course that was begun presumed rest.
            self.course = None;
            self.predict();
        }
        if matches!(self.mode, Mode::Active | Mode::Disabled) {
            self.outputs.fault = Fault::NONE;
        }
    }

    /// Takes in a measured pose. What disturbs is estimated only while it is known what the cables do.
    fn estimate(&mut self, measured: &Pose, dt: f64, was: Mode) {
        let is_known = was == Mode::Active && self.mode == Mode::Active;
        let observer = self.planner.parameters.observer().filter(|_| is_known);
        let observer = observer.as_ref().map(|observer| (self.planner.rig(), observer));
        let expected = self.estimator.rates + self.acceleration * dt;
        self.estimator.update(measured, &self.acceleration, dt, observer);
        if is_known && dt > 0.0 {
            let correction = (self.estimator.rates - expected) / dt;
            self.delay.update(&self.acceleration, &correction, dt, self.planner.rig().platform_radius());
        }
        self.planner.parameters.rig.disturbance = self.estimator.disturbance;
    }

    /// The pose measured, if it makes sense.
    fn measured_pose(&self, inputs: &ControllerInputs, dt: f64) -> Result<Pose, Fault> {
        let rig = self.planner.rig();
        match self.planner.parameters.pose_source {
            PoseSource::EncoderPose => self.encoder_pose(inputs),
            PoseSource::CableLengths => pose_of_lengths(rig, &inputs.cable_length, &self.estimator, dt)
                .and_then(|pose| check_pose(rig, pose)),
        }
    }

    pub(super) fn encoder_pose(&self, inputs: &ControllerInputs) -> Result<Pose, Fault> {
        let pose = inputs.encoder_pose;
        if self.unset > 0 && pose.0 == Coordinates::zeros() {
            return Err(Fault::new(Check::NotSet, 0.0, 0.0, &pose));
        }
        check_pose(self.planner.rig(), pose)
    }

    /// From now on the robot brakes from the last good state, known at `since` (s), and gravity is held where that ends.
    pub(super) fn fault(&mut self, fault: Fault, since: f64) -> Mode {
        self.outputs.fault = fault;
        // Where a command that is computed now begins to act, if it is on a course.
        let turn = self.time + self.planner.parameters.command_delay;
        let under_way = self.course.as_ref().filter(|course| since < course.end());
        self.course = under_way.map(|course| course.stopped(self.planner.rig(), turn));
        let Estimator { pose, rates, .. } = self.estimator;
        Mode::Faulted(Stop { pose, rates, since, at: self.planner.stop(&self.situation()) })
    }

    /// Takes note of a fault, and gives the tensions that hold gravity at the last good pose.
    fn hold_still(&mut self, fault: Fault) -> PerCable<f64> {
        self.outputs.fault = fault;
        let held = static_tensions(self.planner.rig(), &self.estimator.pose, self.planner.allowance());
        self.limited_or_least(held)
    }

    /// Whether it turns out that the robot did not rest at the start. The planner's first set point presumed that it did.
    fn has_started_in_motion(&self) -> bool {
        let (unexplained, rest) = (&self.estimator.unexplained, &self.planner.rest);
        self.time - self.started <= SETTLING
            && (unexplained.fixed_rows::<3>(0).norm() > IN_MOTION * rest.position
                || unexplained.fixed_rows::<3>(3).amax() > IN_MOTION * rest.angle)
    }
}
