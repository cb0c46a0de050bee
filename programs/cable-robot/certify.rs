//! `cable-robot certify`: a proof for one step of any rig, or where it fails.

use std::path::PathBuf;

use anyhow::Result;
use cable_robot::control::Gains;
use cable_robot::plan::extremes::{TensionAt, extremes_from};
use cable_robot::plan::{ControllerParameters, Planner};
use cable_robot::reach::certificate::{Cause, Margins, Step, Verdict, certify_with_margins};
use cable_robot::robot::{CableSet, Coordinates, LEAST_CABLES, Pose, Rig};
use cable_robot_report::files::probe;
use clap::{Args, ValueHint};
use schemars::JsonSchema;
use serde::Serialize;

use crate::command::arguments::{bound, pose, rates, share};
use crate::command::rig::RigArgument;
use crate::command::{Outcome, print, print_json, proof};

/// What a proof file of this version cannot say.
pub const EXAMPLE: &str = "\
Example: cable-robot certify --from 0,0,1 --to 0.1,0.05,0.9,0.05,0,0.1
         cable-robot certify --from 0,0,1 --to 0.1,0,1 --mass-error 0.005 --force 0.2 --sample-period 0.001
         cable-robot certify --rig rigs/eight.toml --from 0,0,2 --to 0.5,0.3,1.8,0,0.1,0.2
         cable-robot certify --from 0,0,1 --to 0.1,0,1 --force 0.2 --proof step.proof.json     (why it is so, to be checked: docs/proof.md)
Exit code 3: not proved. The certificate never says \"admissible\" of a step that is not.";

#[derive(Args)]
pub struct Certify {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] when the set point is given, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll)
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Pose,
    /// Rates of the six coordinates then, m/s and rad/s
    #[arg(long, value_parser = rates, allow_hyphen_values = true, default_value = "0,0,0,0,0,0")]
    rates: Coordinates,
    /// x,y,z[,roll,pitch,yaw] of the set point, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll)
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Pose,
    /// Relative error of mass and moments of inertia
    #[arg(long, default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    mass_error: f64,
    /// Error of the centre of mass, m
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    centre_of_mass_error: f64,
    /// Disturbing force, N
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    force: f64,
    /// Disturbing torque, N m
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    torque: f64,
    /// Friction that no force loop makes up for, N a cable
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    friction: f64,
    /// Distance of anchors and attachments from where the rig file says they are, m; the rig file's `accuracy` if left out
    #[arg(long, value_parser = bound, allow_negative_numbers = true)]
    accuracy: Option<f64>,
    /// Longest time for which a command is held, s
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    sample_period: f64,
    /// Age of the pose and velocity that a command is computed from, s
    #[arg(long, default_value_t = 0.0, value_parser = bound, allow_negative_numbers = true)]
    delay: f64,
    /// Writes what proves the verdict, for anyone to check
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    proof: Option<PathBuf>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

impl Certify {
    pub fn run(&self) -> Result<Outcome> {
        let file = self.rig.read()?;
        let gains = Gains { lambda: file.lambda, eta: file.eta };
        let step = Step { start: self.from, rates: self.rates, set_point: self.to, gains };
        let margins = self.margins(&file.rig);
        let is_of_six = file.rig.cables.len() == LEAST_CABLES;
        let decided = match &self.proof {
            None => certify_with_margins(&file.rig, &step, &margins)?,
            Some(path) => {
                probe(path)?;
                proof::write(path, &file.rig, &step, &margins)?
            }
        };
        let verdict = earliest(&file.rig, &step, decided);
        if self.json {
            print_json(&Answer::new(&verdict))?
        } else {
            self.show(&verdict, margins.are_none() && !is_of_six)?
        }
        Ok(if matches!(verdict, Verdict::Admissible { .. }) { Outcome::Done } else { Outcome::NotReachable })
    }

    fn margins(&self, rig: &Rig) -> Margins {
        Margins {
            mass: self.mass_error,
            centre_of_mass: self.centre_of_mass_error,
            force: self.force,
            torque: self.torque,
            friction: self.friction,
            law_margin: Planner::from(ControllerParameters::of(rig)).allowance(),
            accuracy: self.accuracy.unwrap_or(rig.accuracy),
            sample_period: self.sample_period,
            delay: self.delay,
        }
    }

    fn show(&self, verdict: &Verdict, is_any_distribution: bool) -> Result<()> {
        print(&match verdict {
            Verdict::Admissible { least, greatest, .. } if is_any_distribution => {
                format!("admissible: at all times there are tensions between {least:.3} and {greatest:.3} N")
            }
            Verdict::Admissible { least, greatest, .. } => {
                format!("admissible: every tension stays between {least:.3} and {greatest:.3} N")
            }
            Verdict::NotAdmissible { cable, time, tension } => {
                format!("not admissible: cable {cable} has {tension:.3} N after {time:.3} s")
            }
            Verdict::NoDistribution { time, shortfall, at_least, at_greatest } => {
                let held = [("least", at_least), ("greatest", at_greatest)];
                let held: Vec<_> = held.into_iter().filter(|(_, cables)| !cables.is_empty()).collect();
                let held: Vec<_> = held.iter().map(|(limit, cables)| at_limit(limit, **cables)).collect();
                format!(
                    "not admissible: after {time:.3} s no tensions keep the limits, at best they break them by {shortfall:.3} N; {} forbid it",
                    held.join(" and ")
                )
            }
            Verdict::Undecided { time, resolution, cause } => {
                let place = match *resolution {
                    0.0 => format!("at {time:.3} s after the step"),
                    f64::INFINITY => format!("from {time:.3} s after the step on"),
                    span => format!("about {time:.3} s after the step, in spans of {span:.1e} s"),
                };
                format!("undecided: {} ({place})", in_words(*cause))
            }
        })
    }
}

/// What is proved of a step.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "verdict", rename_all_fields = "camelCase")]
#[schemars(deny_unknown_fields)]
pub enum Answer {
    /// No tension leaves its limits; of more than six cables: there are such tensions at all times.
    #[serde(rename = "admissible")]
    Admissible {
        /// Lower bound of all tensions for all time, N.
        least: f64,
        /// Upper bound, N.
        greatest: f64,
    },
    /// A tension breaks a limit.
    #[serde(rename = "not admissible")]
    NotAdmissible {
        /// The cable, from 1.
        cable: usize,
        /// After the set point was given, s.
        time: f64,
        /// N.
        tension: f64,
    },
    /// More than six cables: at an instant no tensions keep the limits.
    #[serde(rename = "not admissible")]
    NoDistribution {
        /// After the set point was given, s.
        time: f64,
        /// By how much they break them at best, N; null if it is beyond all numbers.
        shortfall: Option<f64>,
        /// Cables whose least tension forbids it, from 1.
        at_least: Vec<usize>,
        /// Cables whose greatest tension forbids it, from 1.
        at_greatest: Vec<usize>,
    },
    /// Neither is proved.
    #[serde(rename = "undecided")]
    Undecided {
        /// After the set point was given, s: where it is not known.
        time: f64,
        /// Length of the spans looked at there, s; null for all time from there on.
        resolution: Option<f64>,
        /// Why.
        #[schemars(extend("enum" = ["Singular", "TooClose", "Effort", "HalfTurn", "GimbalLock"]))]
        cause: String,
    },
}

impl Answer {
    fn new(verdict: &Verdict) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        match *verdict {
            Verdict::Admissible { least, greatest, .. } => Self::Admissible { least, greatest },
            Verdict::NotAdmissible { cable, time, tension } => Self::NotAdmissible { cable, time, tension },
            Verdict::NoDistribution { time, shortfall, at_least, at_greatest } => Self::NoDistribution {
                time,
                shortfall: finite(shortfall),
                at_least: at_least.numbers().collect(),
                at_greatest: at_greatest.numbers().collect(),
            },
            Verdict::Undecided { time, resolution, cause } => {
                Self::Undecided { time, resolution: finite(resolution), cause: format!("{cause:?}") }
            }
        }
    }
}

/// A proof that a limit is broken may be of a late instant. If it is broken before, the first instant seen of that.
pub fn earliest(rig: &Rig, step: &Step, verdict: Verdict) -> Verdict {
    let Verdict::NotAdmissible { time, .. } = verdict else { return verdict };
    let seen = extremes_from(rig, &step.gains, (&step.start, &step.rates), &step.set_point);
    match seen.and_then(|seen| seen.first_outside).filter(|first| first.time < time) {
        Some(TensionAt { cable, tension, time, .. }) => Verdict::NotAdmissible { cable, time, tension },
        None => verdict,
    }
}

/// Whose limits they are: "cables 2, 5 at their least".
fn at_limit(limit: &str, cables: CableSet) -> String {
    let numbers: Vec<_> = cables.numbers().map(|number| number.to_string()).collect();
    match &numbers[..] {
        [cable] => format!("cable {cable} at its {limit}"),
        _ => format!("cables {} at their {limit}", numbers.join(", ")),
    }
}

fn in_words(cause: Cause) -> &'static str {
    match cause {
        Cause::Singular => {
            "the wrench matrix is singular, or nearly so; there is a force or torque that no tensions give"
        }
        Cause::TooClose => "a tension comes nearer to its limit than rounding or the margins allow to tell",
        Cause::Effort => "the work that is allowed did not suffice",
        Cause::HalfTurn => {
            "an angle may get half a turn from its set point, where the law turns back the other way round"
        }
        Cause::GimbalLock => {
            "the pitch may get a quarter turn from level, where the angles do not tell the orientation and the law cannot follow"
        }
    }
}
