//! Whether the platform is where it is meant to be: not far from what the law follows, and within its box.

use super::{Bridge, Fault, Mode};
use crate::Nanoseconds;
use cable_robot::robot::Pose;

/// The law's poles are at λ₀ at least as far as it is critically damped: after so many of its time constants next to nothing is left of a distance.
const TIME_CONSTANTS: f64 = 10.0;

/// A set point on its way: which, since when, and how far it was then, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Course {
    set_point: i32,
    since: Nanoseconds,
    distance: f64,
}

impl Bridge {
    /// After the controller was asked: the distance from what it follows, which may not grow, and is to be gone in time.
    pub(super) fn watch_course(&mut self) {
        let is_driven = matches!(self.mode, Mode::Enabled { since, .. } if self.share(since, self.config.safe.ramp) == 1.0);
        let Some(answer) = self.answer.filter(|_| is_driven) else {
            self.course = None;
            return;
        };
        let distance = (self.pose.position() - answer.reference.pose.position()).norm();
        let begun = Course { set_point: answer.set_point_index, since: self.time, distance };
        let course = self.course.filter(|course| course.set_point == begun.set_point).unwrap_or(begun);
        self.course = Some(course);
        let time = TIME_CONSTANTS / self.config.controller.lambda;
        let is_new = self.time.saturating_sub(course.since) as f64 * 1e-9 < time;
        let most = self.config.limits.following + if is_new { course.distance } else { 0.0 };
        if distance > most {
            self.raise(Fault::OffCourse { distance, most });
        }
    }

    /// The axis (0 to 2) along which a pose is outside of the box, and where it is there.
    pub(super) fn outside(&self, pose: &Pose) -> Option<(usize, f64)> {
        let at = pose.position();
        let is_out = |axis: &usize| {
            let [least, greatest] = self.config.limits.space[*axis];
            !(least..=greatest).contains(&at[*axis])
        };
        (0..3).find(is_out).map(|axis| (axis, at[axis]))
    }

    pub(super) fn watch_box(&mut self) {
        if let Some((axis, at)) = self.outside(&self.pose) {
            self.raise(Fault::OutOfBox { axis: b"xyz"[axis].into(), at });
        }
    }
}
