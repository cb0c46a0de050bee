//! `cable-robot certify`: a proof for one step of any rig of six cables, or where it fails.

use anyhow::Result;
use cable_robot::control::Gains;
use cable_robot::reach::certificate::{Margins, Step, Verdict, certify_with_margins};
use cable_robot::robot::{Coordinates, Pose};
use clap::Args;
use serde_json::json;

use crate::arguments::{pose, rates};
use crate::rig::RigArgument;
use crate::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot certify --from 0,0,1 --to 0.1,0.05,0.9,0.05,0,0.1
         cable-robot certify --from 0,0,1 --to 0.1,0,1 --mass-error 0.005 --force 0.2 --sample-period 0.001
Exit code 3: not proved. The certificate never says \"admissible\" of a step that is not.";

#[derive(Args)]
pub struct Certify {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] when the set point is given, m and rad
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Pose,
    /// Rates of the six coordinates then, m/s and rad/s
    #[arg(long, value_parser = rates, allow_hyphen_values = true, default_value = "0,0,0,0,0,0")]
    rates: Coordinates,
    /// x,y,z[,roll,pitch,yaw] of the set point, m and rad
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Pose,
    /// Relative error of mass and moments of inertia
    #[arg(long, default_value_t = 0.0)]
    mass_error: f64,
    /// Error of the centre of mass, m
    #[arg(long, default_value_t = 0.0)]
    centre_of_mass_error: f64,
    /// Disturbing force, N
    #[arg(long, default_value_t = 0.0)]
    force: f64,
    /// Disturbing torque, N m
    #[arg(long, default_value_t = 0.0)]
    torque: f64,
    /// Friction that no force loop makes up for, N a cable
    #[arg(long, default_value_t = 0.0)]
    friction: f64,
    /// Longest time for which a command is held, s
    #[arg(long, default_value_t = 0.0)]
    sample_period: f64,
    /// Age of the pose and velocity that a command is computed from, s
    #[arg(long, default_value_t = 0.0)]
    delay: f64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

impl Certify {
    pub fn run(&self) -> Result<Outcome> {
        let file = self.rig.read()?;
        let gains = Gains { lambda: file.lambda, eta: file.eta };
        let step = Step { start: self.from, rates: self.rates, set_point: self.to, gains };
        let verdict = certify_with_margins(&file.rig, &step, &self.margins())?;
        if self.json {
            self.show_json(&verdict)?
        } else {
            self.show(&verdict)?
        }
        Ok(if matches!(verdict, Verdict::Admissible { .. }) { Outcome::Done } else { Outcome::NotReachable })
    }

    fn margins(&self) -> Margins {
        Margins {
            mass: self.mass_error,
            centre_of_mass: self.centre_of_mass_error,
            force: self.force,
            torque: self.torque,
            friction: self.friction,
            sample_period: self.sample_period,
            delay: self.delay,
        }
    }

    fn show(&self, verdict: &Verdict) -> Result<()> {
        print(&match verdict {
            Verdict::Admissible { least, greatest } => {
                format!("admissible: every tension stays between {least:.3} and {greatest:.3} N")
            }
            Verdict::NotAdmissible { cable, time, tension } => {
                format!("not admissible: cable {cable} has {tension:.3} N after {time:.3} s")
            }
            Verdict::Undecided { time, resolution, cause } => {
                format!("undecided: {cause:?} about {time:.3} s after the step (span of {resolution:.1e} s)")
            }
        })
    }

    fn show_json(&self, verdict: &Verdict) -> Result<()> {
        print_json(&match verdict {
            Verdict::Admissible { least, greatest } => {
                json!({"verdict": "admissible", "least": least, "greatest": greatest})
            }
            Verdict::NotAdmissible { cable, time, tension } => {
                json!({"verdict": "not admissible", "cable": cable, "time": time, "tension": tension})
            }
            Verdict::Undecided { time, resolution, cause } => {
                json!({"verdict": "undecided", "time": time, "resolution": resolution, "cause": format!("{cause:?}")})
            }
        })
    }
}
