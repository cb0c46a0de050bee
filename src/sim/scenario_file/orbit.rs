//! The table `[orbit]` of a scenario.

use toml::Spanned;

use super::fields::{self, Shape};
use super::{ScenarioFile, or, start_of};
use crate::checked_toml::Refused;
use crate::plan::orbit::{Figure, LOBES, Orbit, SHARE, TURNS};
use crate::robot::{ParameterError, Pose, Rig};

impl ScenarioFile {
    /// The orbit about `centre`, if one is given.
    pub(super) fn orbit(&self, rig: &Rig, centre: &Pose) -> Result<Option<Orbit>, Refused> {
        let Some(given) = &self.file.orbit else { return Ok(None) };
        self.has_only_an_orbit(given)?;
        let given = given.get_ref();
        let radius = *given.radius.get_ref();
        let figure = match given.shape {
            Shape::Circle => Figure::Circle { radius },
            Shape::Line => Figure::Line { radius, direction: or(&given.direction, 0.0) },
            Shape::Hypotrochoid => {
                let (share, lobes) = (or(&given.share, SHARE), or(&given.lobes, LOBES));
                Figure::Hypotrochoid { radius, share, lobes }
            }
        };
        let rate = or(&given.rate, Orbit::natural_rate(rig, centre));
        let orbit = Orbit {
            centre: *centre,
            figure,
            rate,
            turns: or(&given.turns, TURNS),
            start: *given.start.get_ref(),
        };
        orbit.validate().map_err(|error| self.locate_in_orbit(given, &error))?;
        Ok(Some(orbit))
    }

    /// What an orbit would not heed is refused.
    fn has_only_an_orbit(&self, orbit: &Spanned<fields::Orbit>) -> Result<(), Refused> {
        let (controller, given) = (&self.file.controller, orbit.get_ref());
        let table = orbit.span().start;
        let is_other = |shape: Shape, at: Option<usize>| at.filter(|_| given.shape != shape);
        let of_shapes = [
            ("orbit.direction", is_other(Shape::Line, start_of(&given.direction))),
            ("orbit.share", is_other(Shape::Hypotrochoid, start_of(&given.share))),
            ("orbit.lobes", is_other(Shape::Hypotrochoid, start_of(&given.lobes))),
        ];
        let of_planners = [
            ("goals", self.file.goals.first().map(|goal| goal.time.span().start)),
            ("controller.planner", controller.planner.map(|_| table)),
            ("controller.planner_period", start_of(&controller.planner_period)),
            ("controller.bisection_steps", start_of(&controller.bisection_steps)),
            ("controller.hold_compensation", controller.hold_compensation.map(|_| table)),
            ("controller.observer_bound", start_of(&controller.observer_bound)),
            ("controller.max_speed", start_of(&controller.max_speed)),
            ("controller.max_angular_rate", start_of(&controller.max_angular_rate)),
            ("controller.max_cable_speed", start_of(&controller.max_cable_speed)),
            ("controller.max_tension_rate", start_of(&controller.max_tension_rate)),
        ];
        let found = |fields: &[(&'static str, Option<usize>)]| {
            fields.iter().find_map(|(field, at)| at.map(|at| (*field, at)))
        };
        if let Some((field, at)) = found(&of_shapes) {
            return Err(self.check().refuse(at, field, "given", "this shape has none: leave it out"));
        }
        match found(&of_planners) {
            Some((field, at)) => {
                let allowed = "an orbit heeds none: leave it out, or the table [orbit]";
                Err(self.check().refuse(at, field, "given", allowed))
            }
            None => Ok(()),
        }
    }

    fn locate_in_orbit(&self, given: &fields::Orbit, error: &ParameterError) -> Refused {
        let at = match &*error.name {
            "rate" => start_of(&given.rate),
            "turns" => start_of(&given.turns),
            "start" => Some(given.start.span().start),
            "direction" => start_of(&given.direction),
            "share" => start_of(&given.share),
            "lobes" => start_of(&given.lobes),
            _ => Some(given.radius.span().start),
        };
        let field = format!("orbit.{}", error.name);
        self.check().refuse(at.unwrap_or(0), &field, error.value, error.allowed.as_ref())
    }
}
