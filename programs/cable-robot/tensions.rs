//! `cable-robot tensions`: length and tension of each cable at a pose, at rest or in motion.

use std::fmt::Write;

use anyhow::{Result, bail};
use cable_robot::control::distribution::{Solutions, share, widest_margin};
use cable_robot::robot::dynamics::required_wrench;
use cable_robot::robot::{Cable, Coordinates, LEAST_CABLES, PerCable, Pose, Rig};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;

use crate::command::arguments::{accelerations, pose, rates};
use crate::command::rig::RigArgument;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot tensions --pose 0.15,0.15,1
         cable-robot tensions --rig rigs/eight.toml --pose 0.5,0.3,1.8,0,0.1,0.2 --acceleration 1,0,0,0,0,0
The orientation is R = Rz(yaw) Ry(pitch) Rx(roll), angles in rad.
Exit code 3: no tensions within the limits give what the pose and the motion ask for.";

#[derive(Args)]
pub struct Tensions {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z[,roll,pitch,yaw] of the centre of mass, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll); without it the rig's home
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    pose: Option<Pose>,
    /// Rates of the six coordinates, m/s and rad/s
    #[arg(long, value_parser = rates, allow_hyphen_values = true, default_value = "0,0,0,0,0,0")]
    rates: Coordinates,
    /// Accelerations of the six coordinates, m/s² and rad/s²
    #[arg(long, value_parser = accelerations, allow_hyphen_values = true, default_value = "0,0,0,0,0,0")]
    acceleration: Coordinates,
    /// How more than six cables share the load
    #[arg(long, value_enum, default_value_t = Sharing::Law)]
    distribution: Sharing,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Sharing {
    /// As the control law does: near a reference, within the limits wherever that can be
    Law,
    /// As far from the limits as can be
    Widest,
}

/// What the cables do.
struct Found {
    length: PerCable<f64>,
    /// N.
    tension: PerCable<f64>,
    /// Least distance of a tension to its limit, N: less than 0 if one is broken.
    margin: f64,
    /// The greatest that any distribution has.
    widest: f64,
}

impl Tensions {
    pub fn run(&self) -> Result<Outcome> {
        let file = self.rig.read()?;
        let pose = self.pose.unwrap_or(file.home);
        let Some(found) = self.find(&file.rig, &pose) else {
            bail!("the wrench matrix is singular there: there is a force or torque that no tensions give")
        };
        if self.json {
            print_json(&Answer::new(&file.name, &file.rig, &pose, &found))?;
        } else {
            print(&self.as_text(&file.rig, &found))?;
        }
        Ok(if found.margin >= 0.0 { Outcome::Done } else { Outcome::NotReachable })
    }

    fn find(&self, rig: &Rig, pose: &Pose) -> Option<Found> {
        let cables = rig.cables_at(pose);
        let columns = cables.wrench_matrix();
        let wrench = required_wrench(rig, pose, &self.rates, &self.acceleration);
        let widest = widest_margin(rig, &columns, &wrench);
        let tension = match self.distribution {
            Sharing::Widest if rig.cables.len() > LEAST_CABLES && widest.is_finite() => {
                // The limits as far inside as can be, but for rounding.
                let limits = rig.limits().map(|limits| limits.shrunk(widest - 1e-9 * (1.0 + widest.abs())));
                Solutions::new(&columns, &wrench, rig.platform_radius())?.tensions_within(&limits, rig)
            }
            _ => share(rig, &columns, &wrench, 0.0)?,
        };
        let margins = tension.iter().zip(&rig.cables).map(|(u, cable)| cable.limits.margin(*u));
        let margin = margins.fold(f64::INFINITY, f64::min);
        Some(Found { length: cables.length, tension, margin, widest })
    }

    fn as_text(&self, rig: &Rig, found: &Found) -> String {
        let mut text = String::from("cable  length (m)  tension (N)     least  greatest\n");
        for (i, cable) in rig.cables.iter().enumerate() {
            let greatest = match cable.limits.max {
                max if max.is_finite() => format!("{max:.1}"),
                _ => "none".to_owned(),
            };
            let _ = writeln!(
                text,
                "{:>5}  {:>10.4}  {:>11.3}  {:>8.1}  {greatest:>8}",
                i + 1,
                found.length[i],
                found.tension[i],
                cable.limits.min
            );
        }
        let _ = match (rig.cables.len() > LEAST_CABLES, found.margin >= 0.0) {
            (false, true) => {
                writeln!(text, "margin: {:.3} N; six cables have one distribution", found.margin)
            }
            (true, true) => writeln!(
                text,
                "margin: {:.3} N with the distribution `{}`; the widest is {:.3} N",
                found.margin,
                self.distribution
                    .to_possible_value()
                    .map_or(String::new(), |name| name.get_name().to_owned()),
                found.widest
            ),
            (_, false) => writeln!(
                text,
                "no tensions within the limits: each would have to be wider by {:.3} N",
                -found.widest
            ),
        };
        text
    }
}

/// Lengths and tensions of the cables at a pose.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct Answer {
    /// The rig's name.
    rig: String,
    /// Of the centre of mass: x, y, z (m), roll, pitch, yaw (rad), base frame; R = Rz(yaw) Ry(pitch) Rx(roll).
    pose: [f64; 6],
    /// One a cable, in their order.
    cables: Vec<AnswerCable>,
    /// The least distance of a tension to its limit, N; below 0 if one is broken.
    margin: f64,
    /// The greatest that it is with any distribution, N; null if there is no greatest.
    widest_margin: Option<f64>,
    /// Whether every tension is within its limits.
    feasible: bool,
}

/// A cable.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AnswerCable {
    /// Its number, from 1.
    cable: usize,
    /// m.
    length: f64,
    /// N.
    tension: f64,
    /// Its least tension, N.
    min: f64,
    /// Its greatest tension, N; null for no limit.
    max: Option<f64>,
}

impl Answer {
    fn new(name: &str, rig: &Rig, pose: &Pose, found: &Found) -> Self {
        let limit = |max: f64| max.is_finite().then_some(max);
        let cable = |(i, cable): (usize, &Cable)| AnswerCable {
            cable: i + 1,
            length: found.length[i],
            tension: found.tension[i],
            min: cable.limits.min,
            max: limit(cable.limits.max),
        };
        Self {
            rig: name.to_owned(),
            pose: pose.0.into(),
            cables: rig.cables.iter().enumerate().map(cable).collect(),
            margin: found.margin,
            widest_margin: limit(found.widest),
            feasible: found.margin >= 0.0,
        }
    }
}
