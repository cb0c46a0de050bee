//! What a measured pose is checked for, and what a fault says.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::control::Estimator;
use crate::robot::pose::{LARGEST_PITCH, PITCH};
use crate::robot::{Coordinates, PerCable, Pose, Rig, forward_kinematics};

/// A pose measured farther than this from where the robot should be by now, plus what it can travel meanwhile, is a sensor fault.
/// m, rad, m/s, rad/s; lengths and speeds for the paper's rig, more for a larger one. The first two are the range in which forward
/// kinematics is proved.
const JUMP_POSITION: f64 = 0.05;
const JUMP_ANGLE: f64 = 5.0 * std::f64::consts::PI / 180.0;
const TOP_SPEED: f64 = 2.0;
const TOP_ANGULAR_RATE: f64 = 4.0;

/// Which check a measurement failed. The numbers are the FMU's enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Check {
    /// None failed.
    None = 1,
    /// The first poses were zero in all six coordinates, as a master with unit delays passes them on before it knows one.
    NotSet = 2,
    /// Every anchor lies below its attachment: no cable pulls against gravity.
    AboveAnchors = 3,
    /// The pitch is too near a quarter turn, where the angles do not tell the orientation.
    Pitch = 4,
    /// Too far from where the robot should be by now.
    PositionJump = 5,
    /// Turned too far from how the robot should be by now.
    AngleJump = 6,
    /// The cable lengths belong to no pose near the last one.
    CableLengths = 7,
    /// No tensions give the wrench that the law wants: the wrench matrix is singular.
    Singular = 8,
}

impl Check {
    /// All there are, in the order of their numbers.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::NotSet,
        Self::AboveAnchors,
        Self::Pitch,
        Self::PositionJump,
        Self::AngleJump,
        Self::CableLengths,
        Self::Singular,
    ];
}

/// A check that a measurement failed, with what was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// Which.
    pub check: Check,
    /// What was found: m or rad, 0 where there is no single number.
    pub value: f64,
    /// What it is compared with, in the same unit.
    pub limit: f64,
    /// Number of the cable whose length is farthest off, from 1; 0 if it is no matter of cables.
    pub cable: usize,
    /// The pose that was measured, or expected where none was.
    pub pose: Pose,
}

impl Fault {
    /// No check failed.
    pub const NONE: Self = Self {
        check: Check::None,
        value: 0.0,
        limit: 0.0,
        cable: 0,
        pose: Pose(Coordinates::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    };

    pub(super) fn new(check: Check, value: f64, limit: f64, pose: &Pose) -> Self {
        Self { check, value, limit, cable: 0, pose: *pose }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { value, limit, cable, .. } = self;
        let [x, y, z, roll, pitch, yaw]: [f64; 6] = self.pose.0.into();
        match self.check {
            Check::None => return write!(f, "no check failed"),
            Check::NotSet => write!(f, "encoderPose is zero in all six coordinates, as if never set"),
            Check::AboveAnchors => write!(
                f,
                "no cable pulls against gravity: the highest anchor is {value:.4} m above its attachment, more than {limit} is needed"
            ),
            Check::Pitch => {
                write!(f, "encoderPose.pitch is {value:.4} rad off level, less than {limit} is needed")
            }
            Check::PositionJump => {
                write!(
                    f,
                    "encoderPose is {value:.4} m from where the robot should be by now, at most {limit:.4} is plausible"
                )
            }
            Check::AngleJump => {
                write!(
                    f,
                    "encoderPose is turned by {value:.4} rad from how the robot should be by now, at most {limit:.4} is plausible"
                )
            }
            Check::CableLengths => write!(
                f,
                "cableLength[{cable}] is {value:.4} m where {limit:.4} is expected: these lengths belong to no pose near the last one"
            ),
            Check::Singular => write!(f, "the wrench matrix is singular: no tensions give the wrench wanted"),
        }?;
        write!(f, "; pose ({x:.4}, {y:.4}, {z:.4}, {roll:.4}, {pitch:.4}, {yaw:.4}), check {:?}", self.check)
    }
}

/// A pose at which cables can pull the platform up, not turned on edge.
pub(super) fn check_pose(rig: &Rig, pose: Pose) -> Result<Pose, Fault> {
    let height = rig.highest_anchor(&pose);
    let pitch = pose.0[PITCH].abs();
    if !rig.can_be_at(&pose) {
        Err(Fault::new(Check::AboveAnchors, height, 0.0, &pose))
    } else if pitch >= LARGEST_PITCH {
        Err(Fault::new(Check::Pitch, pitch, LARGEST_PITCH, &pose))
    } else {
        Ok(pose)
    }
}

/// The pose with the cable lengths (m) measured `dt` s after the last estimate.
pub(super) fn pose_of_lengths(
    rig: &Rig,
    length: &PerCable<f64>,
    estimator: &Estimator,
    dt: f64,
) -> Result<Pose, Fault> {
    let expected = estimator.expected(dt);
    forward_kinematics(rig, length, &expected).map(|found| found.pose).map_err(|_| {
        let there = rig.cables_at(&expected).length;
        let off = |i: &usize| (length[*i] - there[*i]).abs();
        let farthest = (0..there.len()).max_by(|i, k| off(i).total_cmp(&off(k))).unwrap_or(0);
        let cable = farthest + 1;
        Fault { cable, ..Fault::new(Check::CableLengths, length[farthest], there[farthest], &expected) }
    })
}

/// Why a pose is too far from where the robot should be `dt` s after the last estimate, if it is; `size` is the rig's in units of the paper's.
pub(super) fn jump(pose: &Pose, estimator: &Estimator, dt: f64, size: f64) -> Option<Fault> {
    let off = pose.minus(&estimator.expected(dt));
    let (distance, turn) = (off.fixed_rows::<3>(0).norm(), off.fixed_rows::<3>(3).norm());
    let (farthest, widest) = ((JUMP_POSITION + TOP_SPEED * dt) * size, JUMP_ANGLE + TOP_ANGULAR_RATE * dt);
    if distance > farthest {
        Some(Fault::new(Check::PositionJump, distance, farthest, pose))
    } else if turn > widest {
        Some(Fault::new(Check::AngleJump, turn, widest, pose))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checks_are_numbered_from_one_in_their_order() {
        for (k, check) in Check::ALL.into_iter().enumerate() {
            assert_eq!(check as usize, k + 1);
        }
    }

    #[test]
    fn a_fault_says_which_check_and_which_value() {
        let rig = crate::plan::ControllerParameters::default().rig;
        let said = |pose: Pose| check_pose(&rig, pose).unwrap_err().to_string();
        let above = said(Pose::at(0.0, 0.0, -0.25));
        assert!(
            above.contains("highest anchor is -0.2500 m") && above.contains("check AboveAnchors"),
            "{above}"
        );
        let turned = said(Pose(Coordinates::new(0.0, 0.0, 1.0, 0.0, -1.5, 0.0)));
        assert!(
            turned.contains("encoderPose.pitch is 1.5000 rad") && turned.contains("less than 1.4"),
            "{turned}"
        );
        let here = Estimator::at_rest(Pose::default());
        let far = jump(&Pose::at(0.3, 0.0, 1.0), &here, 0.01, 1.0).unwrap().to_string();
        assert!(far.contains("0.3000 m from where") && far.contains("at most 0.0700"), "{far}");
        let mut length = rig.cables_at(&Pose::default()).length;
        length[2] = 0.01;
        let short = pose_of_lengths(&rig, &length, &here, 0.0).unwrap_err().to_string();
        assert!(short.contains("cableLength[3] is 0.0100 m"), "{short}");
    }
}
