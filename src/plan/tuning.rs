//! Parameters that may change while the controller runs: gains, limits and tolerances. They are taken together, at the first decision of the planner at
//! which the way to the active set point is proved with them.

use serde::{Deserialize, Serialize};

use super::exact::LEFT;
use super::interface::{ControllerParameters, PlannerKind};
use super::planner::{MOST_SPANS, Planner, Situation};
use crate::robot::{ParameterError, PerCable, TensionLimits};

/// What may change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// λ₀ of Eq. (2), 1/s.
    pub lambda: f64,
    /// η₀ of Eq. (4), 1/s.
    pub eta: f64,
    /// As in [`ControllerParameters`], m.
    pub position_tolerance: f64,
    /// As in [`ControllerParameters`], rad.
    pub angle_tolerance: f64,
    /// m/s.
    pub max_speed: f64,
    /// rad/s.
    pub max_angular_rate: f64,
    /// m/s.
    pub max_cable_speed: f64,
    /// N/s.
    pub max_tension_rate: f64,
    /// Of each cable, N.
    pub limits: PerCable<TensionLimits>,
}

/// Whether a [`Tuning`] that was asked for acts. The numbers are the FMU's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pending {
    /// It does.
    No = 0,
    /// It does from the planner's next decision on.
    Undecided = 1,
    /// Not yet: from the present state, the way to the active set point is not proved with it. Tried again at each decision.
    NotProved = 2,
}

impl Pending {
    /// All there are, in the order of their numbers.
    pub const ALL: [Self; 3] = [Self::No, Self::Undecided, Self::NotProved];
}

impl ControllerParameters {
    /// The same with what may change as in `tuning`, which must have a limit for each cable.
    #[must_use]
    pub fn tuned(&self, tuning: &Tuning) -> Self {
        let mut parameters = Self {
            lambda: tuning.lambda,
            eta: tuning.eta,
            position_tolerance: tuning.position_tolerance,
            angle_tolerance: tuning.angle_tolerance,
            max_speed: tuning.max_speed,
            max_angular_rate: tuning.max_angular_rate,
            max_cable_speed: tuning.max_cable_speed,
            max_tension_rate: tuning.max_tension_rate,
            ..*self
        };
        for (cable, limits) in parameters.rig.cables.iter_mut().zip(&tuning.limits) {
            cable.limits = *limits;
        }
        parameters
    }

    /// Whether it may be tuned so: allocates for an error only.
    pub(super) fn check_tuning(&self, tuning: &Tuning) -> Result<(), ParameterError> {
        let tuned = self.tuned(tuning);
        tuned.rig.validate_limits()?;
        tuned.check_settings()
    }

    /// What of these may change while the controller runs.
    pub fn tuning(&self) -> Tuning {
        Tuning {
            lambda: self.lambda,
            eta: self.eta,
            position_tolerance: self.position_tolerance,
            angle_tolerance: self.angle_tolerance,
            max_speed: self.max_speed,
            max_angular_rate: self.max_angular_rate,
            max_cable_speed: self.max_cable_speed,
            max_tension_rate: self.max_tension_rate,
            limits: self.rig.limits(),
        }
    }
}

impl Planner {
    /// The same with what may change as in `tuning`, which must have a limit for each cable. The rig keeps its shape.
    pub(super) fn tuned(&self, tuning: &Tuning) -> Self {
        let parameters = self.parameters.tuned(tuning);
        Self { rest: parameters.rest(), parameters, ..*self }
    }

    /// Whether the motion that goes on with these parameters is proved, as that to a new set point would be.
    pub(super) fn can_go_on(&self, now: &Situation) -> bool {
        let set_point = now.set_point;
        if self.parameters.planner == PlannerKind::MinimumTime && !now.is_steady() {
            // A course is made for the gains and limits with which it was begun.
            return false;
        }
        if self.parameters.planner == PlannerKind::Bounded {
            return self.is_proved(&Situation { hold: 0.0, ..*now }, set_point, 0.0, &mut { MOST_SPANS });
        }
        let spare = self.allowance().min(LEFT * self.known_margin_at(set_point)).max(0.0);
        now.hold <= self.parameters.longest_hold()
            && self.keeps_speeds(now, set_point)
            && self.is_proved(now, set_point, spare, &mut { MOST_SPANS })
    }
}
