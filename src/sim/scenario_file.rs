//! Scenarios written as TOML: what a file may say, and what is wrong with one that is refused (docs/scenarios.md).

mod fields;
mod orbit;

use std::f64::consts::TAU;

use nalgebra::Vector3;
use schemars::{Schema, schema_for};
use thiserror::Error;
use toml::Spanned;

use super::PlantParameters;
use super::scenario::{Disturbance, Goal, ROUNDING, Scenario, count_steps};
use crate::checked_toml::{Checked, Refused};
use crate::control::static_margin;
use crate::plan::through::MOST_WAY_POINTS;
use crate::plan::{ControllerParameters, PlannerKind, PoseSource};
use crate::robot::rig_file::without_null;
use crate::robot::{Coordinates, ParameterError, Pose, Rig, TensionLimits};

/// Step of a scenario that gives none, s.
pub const DEFAULT_STEP: f64 = 1e-3;

/// An orbit needs no planner; what is not known is heeded as with this one.
const FOR_ORBITS: PlannerKind = PlannerKind::Exact;

/// The text of a scenario, read but not yet joined with a rig.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    text: String,
    file: fields::File,
}

/// A scenario file that is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ScenarioFileError {
    /// No TOML, an unknown or missing field, or a value of the wrong kind.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A value that makes no sense.
    #[error(transparent)]
    Value(#[from] Refused),
}

/// JSON Schema of scenario files, for editors: everything that can be said of one field at a time.
pub fn schema() -> Schema {
    let mut schema = schema_for!(fields::File);
    without_null(&mut schema);
    schema
}

impl ScenarioFile {
    /// Reads the text of a scenario file.
    ///
    /// # Errors
    /// [`ScenarioFileError::Toml`]; values are looked at by [`scenario`](Self::scenario).
    pub fn parse(text: &str) -> Result<Self, ScenarioFileError> {
        Ok(Self { file: toml::from_str(text)?, text: text.to_owned() })
    }

    /// What it shows, in a line.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// Line and path of the rig file, the path relative to the scenario's; `None` for the paper's rig.
    pub fn rig(&self) -> Option<(usize, &str)> {
        self.file.rig.as_ref().map(|rig| (self.check().line(rig.span().start), rig.get_ref().as_str()))
    }

    /// Line of the start; `None` for the rig's home.
    pub fn start_line(&self) -> Option<usize> {
        start_of(&self.file.start).map(|offset| self.check().line(offset))
    }

    /// The scenario on the rig of this name and home, whose controller `base` is where the file says nothing else.
    ///
    /// # Errors
    /// [`ScenarioFileError::Value`]: the line, the field, its value and what is allowed.
    pub fn scenario(
        &self,
        rig: &str,
        home: Pose,
        base: ControllerParameters,
    ) -> Result<Scenario, ScenarioFileError> {
        let (duration, step) = self.times()?;
        let controller = self.controller(base);
        let plant = self.plant(&controller, self.start(&controller, home)?);
        let orbit = self.orbit(&controller.rig, &plant.initial_pose)?;
        controller.validate().map_err(|error| self.locate(&error))?;
        plant.validate().map_err(|error| self.locate(&error))?;
        controller.check_step(step).map_err(|error| self.locate(&error))?;
        Ok(Scenario {
            title: self.file.title.clone(),
            rig: rig.to_owned(),
            controller,
            plant,
            orbit,
            goals: self.goals(&controller, ((duration - step) / ROUNDING).round() * ROUNDING)?,
            disturbances: self.disturbances(duration)?,
            duration,
            step,
        })
    }

    fn controller(&self, base: ControllerParameters) -> ControllerParameters {
        let given = &self.file.controller;
        let pose_source = given.pose_source.map(|source| match source {
            fields::PoseSource::EncoderPose => PoseSource::EncoderPose,
            fields::PoseSource::CableLengths => PoseSource::CableLengths,
        });
        let mut rig = base.rig;
        for cable in rig.cables.iter_mut() {
            cable.limits.min = or(&given.min_tension, cable.limits.min);
            cable.limits.max = or(&given.max_tension, cable.limits.max);
        }
        ControllerParameters {
            rig,
            lambda: or(&given.lambda, base.lambda),
            eta: or(&given.eta, base.eta),
            planner_period: or(&given.planner_period, base.planner_period),
            bisection_steps: or(&given.bisection_steps, base.bisection_steps),
            planner: given.planner.unwrap_or(if self.file.orbit.is_some() {
                FOR_ORBITS
            } else {
                base.planner
            }),
            pose_source: pose_source.unwrap_or(base.pose_source),
            force_loop: given.force_loop.unwrap_or(base.force_loop),
            hold_compensation: given.hold_compensation.unwrap_or(base.hold_compensation),
            command_delay: or(&given.command_delay, base.command_delay),
            observer_bound: or(&given.observer_bound, base.observer_bound),
            mass_tolerance: or(&given.mass_tolerance, base.mass_tolerance),
            encoder_resolution: or(&given.encoder_resolution, base.encoder_resolution),
            disturbance_bound: or(&given.disturbance_bound, base.disturbance_bound),
            max_speed: or(&given.max_speed, base.max_speed),
            max_angular_rate: or(&given.max_angular_rate, base.max_angular_rate),
            max_cable_speed: or(&given.max_cable_speed, base.max_cable_speed),
            max_tension_rate: or(&given.max_tension_rate, base.max_tension_rate),
            lift: or(&given.lift, base.lift),
            ..base
        }
    }

    fn plant(&self, controller: &ControllerParameters, initial_pose: Pose) -> PlantParameters {
        let given = &self.file.imperfections;
        let ideal = PlantParameters { rig: controller.rig, initial_pose, ..PlantParameters::default() };
        PlantParameters {
            friction: or(&given.friction, ideal.friction),
            motor_lag: or(&given.motor_lag, ideal.motor_lag),
            encoder_resolution: or(&given.encoder_resolution, ideal.encoder_resolution),
            load_cell_noise: or(&given.load_cell_noise, ideal.load_cell_noise),
            noise_seed: given.noise_seed.unwrap_or(ideal.noise_seed),
            ..ideal
        }
    }

    fn times(&self) -> Result<(f64, f64), Refused> {
        let duration = self.check().positive(&self.file.duration, "duration", "s")?;
        let step = self.file.step.as_ref();
        let step = step.map_or(Ok(DEFAULT_STEP), |step| self.check().positive(step, "step", "s"))?;
        match count_steps(duration, step) {
            Ok(_) => Ok((duration, step)),
            Err(right) => {
                Err(self.check().refuse(self.file.duration.span().start, "duration", duration, right))
            }
        }
    }

    fn start(&self, controller: &ControllerParameters, home: Pose) -> Result<Pose, Refused> {
        let Some(given) = &self.file.start else { return Ok(home) };
        let pose = self.pose(&controller.rig, given, "start")?;
        let rests = static_margin(&controller.rig.with_limits(TensionLimits::default()), &pose) > 0.0;
        let allowed =
            "it lies outside the static workspace: a cable is slack there, so there is no rest to start from";
        self.check().require(rests, given, "start", format!("{:?}", given.get_ref()), allowed)?;
        Ok(pose)
    }

    /// A goal that comes after the beginning of the last step is never given.
    fn goals(&self, controller: &ControllerParameters, last: f64) -> Result<Vec<Goal>, Refused> {
        let rig = &controller.rig;
        let mut goals: Vec<Goal> = vec![];
        for (i, table) in self.file.goals.iter().enumerate() {
            let field = |name: &str| format!("goals[{}].{name}", i + 1);
            let time = *table.time.get_ref();
            let ok = (0.0..=last + ROUNDING).contains(&time);
            let allowed = format!("must be 0 or greater and at most {last} s, when the last step begins");
            self.check().require(ok, &table.time, &field("time"), time, &allowed)?;
            let before = goals.last().map_or(f64::NEG_INFINITY, |goal| goal.time);
            let allowed = format!("must come after the goal before it, {before} s");
            self.check().require(time > before, &table.time, &field("time"), time, &allowed)?;
            let mut through = vec![];
            for (k, pose) in table.through.iter().enumerate() {
                let taken = if controller.planner == PlannerKind::MinimumTime { MOST_WAY_POINTS } else { 0 };
                let allowed = format!(
                    "at most {MOST_WAY_POINTS} way points are taken, and with planner = \"minimum-time\" alone"
                );
                let field = format!("{}[{}]", field("through"), k + 1);
                self.check().require(k < taken, pose, &field, format!("{:?}", pose.get_ref()), &allowed)?;
                through.push(self.pose(rig, pose, &field)?);
            }
            goals.push(Goal { time, pose: self.pose(rig, &table.pose, &field("pose"))?, through });
        }
        Ok(goals)
    }

    fn disturbances(&self, duration: f64) -> Result<Vec<Disturbance>, Refused> {
        let mut disturbances = vec![];
        for (i, table) in self.file.disturbances.iter().enumerate() {
            let field = |name: &str| format!("disturbances[{}].{name}", i + 1);
            let from = *table.from.get_ref();
            let ok = from.is_finite() && from >= 0.0;
            self.check().require(
                ok,
                &table.from,
                &field("from"),
                from,
                "must be finite and 0 or greater (s)",
            )?;
            let allowed = format!("the run ends at duration = {duration} (s): must be less");
            self.check().require(from < duration, &table.from, &field("from"), from, &allowed)?;
            let until = or(&table.until, f64::INFINITY);
            if let Some(given) = &table.until {
                let allowed =
                    format!("must be greater than from = {from} (s); without it the disturbance lasts");
                self.check().require(until > from, given, &field("until"), until, &allowed)?;
            }
            let given = table.force.is_some() || table.torque.is_some();
            let allowed = "a disturbance needs force = [x, y, z] (N), torque = [x, y, z] (N m), or both";
            self.check().require(given, &table.from, &field("force"), "nothing", allowed)?;
            let force = self.vector(table.force.as_ref(), &field("force"))?;
            let torque = self.vector(table.torque.as_ref(), &field("torque"))?;
            disturbances.push(Disturbance { from, until, force, torque });
        }
        Ok(disturbances)
    }

    /// Three or six numbers, where a cable can pull against gravity.
    fn pose(&self, rig: &Rig, given: &Spanned<Vec<f64>>, field: &str) -> Result<Pose, Refused> {
        let numbers = given.get_ref();
        let ok = matches!(numbers.len(), 3 | 6) && numbers.iter().all(|number| number.is_finite());
        let allowed = "a pose is three finite numbers x, y, z (m), or six with roll, pitch, yaw (rad)";
        self.check().require(ok, given, field, format!("{numbers:?}"), allowed)?;
        for (k, angle) in numbers.iter().enumerate().skip(3) {
            let allowed = "angles are in radians, at most a turn (6.2832) each way";
            self.check().require(
                angle.abs() <= TAU,
                given,
                &format!("{field}[{}]", k + 1),
                angle,
                allowed,
            )?;
        }
        let mut pose = Coordinates::zeros();
        pose.as_mut_slice()[..numbers.len()].copy_from_slice(numbers);
        let pose = Pose(pose);
        let allowed = match rig.gravity.z >= 0.0 {
            true => "z points down: below the anchors z is greater than theirs (m)",
            false => "z points up: below the anchors z is less than theirs (m)",
        };
        self.check().require(rig.can_be_at(&pose), given, &format!("{field}[3]"), numbers[2], allowed)?;
        Ok(pose)
    }

    fn vector(&self, given: Option<&Spanned<[f64; 3]>>, field: &str) -> Result<Vector3<f64>, Refused> {
        given.map_or(Ok(Vector3::zeros()), |given| self.check().vector(given, field, ""))
    }

    fn check(&self) -> Checked<'_> {
        Checked { text: &self.text }
    }

    /// What the domain refuses, with the place in the file. A parameter that only the rig gives is refused for another that
    /// the file gives: the least tension, above the rig's greatest.
    fn locate(&self, error: &ParameterError) -> Refused {
        let (controller, rig) = (&self.file.controller, &self.file.imperfections);
        let least = start_of(&controller.min_tension);
        let name = error.name.split_once('[').map_or(&*error.name, |(name, _)| name);
        let (field, offset) = match name {
            "step" => ("step", start_of(&self.file.step)),
            "lambda" => ("controller.lambda", start_of(&controller.lambda)),
            "eta" => ("controller.eta", start_of(&controller.eta)),
            "plannerPeriod" => ("controller.planner_period", start_of(&controller.planner_period)),
            "commandDelay" => ("controller.command_delay", start_of(&controller.command_delay)),
            "observerBound" => ("controller.observer_bound", start_of(&controller.observer_bound)),
            "massTolerance" => ("controller.mass_tolerance", start_of(&controller.mass_tolerance)),
            "disturbanceBound" => ("controller.disturbance_bound", start_of(&controller.disturbance_bound)),
            "maxSpeed" => ("controller.max_speed", start_of(&controller.max_speed)),
            "maxAngularRate" => ("controller.max_angular_rate", start_of(&controller.max_angular_rate)),
            "maxCableSpeed" => ("controller.max_cable_speed", start_of(&controller.max_cable_speed)),
            "maxTensionRate" => ("controller.max_tension_rate", start_of(&controller.max_tension_rate)),
            "lift" => ("controller.lift", start_of(&controller.lift)),
            "bisectionSteps" => ("controller.bisection_steps", start_of(&controller.bisection_steps)),
            "minTension" => ("controller.min_tension", least),
            "maxTension" => ("controller.max_tension", start_of(&controller.max_tension).or(least)),
            "friction" => ("imperfections.friction", start_of(&rig.friction)),
            "motorLag" => ("imperfections.motor_lag", start_of(&rig.motor_lag)),
            // Both have one: the controller's is refused first.
            "encoderResolution" if or(&controller.encoder_resolution, 0.0) == error.value => {
                ("controller.encoder_resolution", start_of(&controller.encoder_resolution))
            }
            "encoderResolution" => ("imperfections.encoder_resolution", start_of(&rig.encoder_resolution)),
            "loadCellNoise" => ("imperfections.load_cell_noise", start_of(&rig.load_cell_noise)),
            other => (other, None),
        };
        self.check().refuse(offset.unwrap_or(0), field, error.value, error.allowed.as_ref())
    }
}

fn or<T: Copy>(given: &Option<Spanned<T>>, otherwise: T) -> T {
    given.as_ref().map_or(otherwise, |given| *given.get_ref())
}

fn start_of<T>(given: &Option<Spanned<T>>) -> Option<usize> {
    given.as_ref().map(|given| given.span().start)
}

#[cfg(test)]
mod tests;
