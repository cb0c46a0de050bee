//! `cable-robot orbit`: a periodic motion that may leave the static workspace, and the proof of it.

mod outside;
mod picture;
mod show;

use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::orbit::{self, Figure, LOBES, OrbitError, Part, Proof, Refusal, SHARE, TURNS};
use cable_robot::reach::Slice;
use cable_robot::robot::{Coordinates, Pose, RigFile};
use cable_robot_report::files::probe;
use clap::{Args, ValueEnum, ValueHint};

use self::outside::Outside;
use crate::command::arguments::{finite, place, pose, seconds};
use crate::command::figure::draw;
use crate::command::rig::{RigArgument, require_below, require_rest};
use crate::command::{Outcome, print, print_json, workspace};

pub const EXAMPLE: &str = "\
Example: cable-robot orbit --radius 0.4 --rate 2.75 --start 2.5 --svg orbit.svg
         cable-robot orbit --through 0.325,0
         cable-robot orbit --shape hypotrochoid --radius 0.25
It begins and ends at rest in the centre. `cable-robot simulate orbit` runs such a scenario in a closed loop: docs/orbit.md.
Exit code 3: it is not proved; which cable forbids it, and what is proved instead.";

#[derive(Args)]
pub struct Orbit {
    #[command(flatten)]
    rig: RigArgument,
    /// What it draws
    #[arg(long, value_enum, default_value_t = Shape::Circle)]
    shape: Shape,
    /// Radius of the circle, half the line, or the hypotrochoid's large circle, m
    #[arg(long, value_parser = finite, allow_negative_numbers = true, required_unless_present = "through")]
    radius: Option<f64>,
    /// Of the end at which a line begins, from the x axis towards y, rad
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    direction: Option<f64>,
    /// Radius of a hypotrochoid's small circle, as a share of the large one's; without it 0.15
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    share: Option<f64>,
    /// Lobes of a hypotrochoid; without it 3
    #[arg(long)]
    lobes: Option<u32>,
    /// x,y: out to this place on a line and back, as quickly as is found, in place of a shape; m
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = place,
        allow_hyphen_values = true,
        conflicts_with_all = ["shape", "radius", "direction", "share", "lobes"]
    )]
    through: Option<[f64; 2]>,
    /// x,y,z[,roll,pitch,yaw] of the centre, m and rad; R = Rz(yaw) Ry(pitch) Rx(roll); without it the rig's
    /// home
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Option<Pose>,
    /// z of the centre, its x and y being those of the rig's home, m
    #[arg(long, value_parser = finite, allow_hyphen_values = true, conflicts_with = "from")]
    height: Option<f64>,
    /// Ω, rad/s; without it that of a pendulum as long as the anchors are above the centre
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Turns at full size; without it 3, through a place 0
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    turns: Option<f64>,
    /// How long it grows from the centre, s, and how long a stop takes; without it the shortest found that is
    /// proved
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    start: Option<f64>,
    /// For how long a command is held, s
    #[arg(long, value_parser = seconds, default_value = "0.001", allow_negative_numbers = true)]
    step: f64,
    /// Draws path, workspace and tensions into this file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    svg: Option<PathBuf>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Shape {
    /// About the centre
    Circle,
    /// To and fro, the centre in its middle
    Line,
    /// A circle and on it a smaller one that turns the other way round
    Hypotrochoid,
}

/// What came of it.
struct Answer {
    orbit: orbit::Orbit,
    /// Where its path is outside the static workspace.
    outside: Outside,
    found: Result<Proof, Refusal>,
    /// Of an orbit that is not proved: one that is.
    instead: Option<orbit::Orbit>,
}

impl Orbit {
    pub fn run(&self) -> Result<Outcome> {
        let (file, parameters) = self.rig.read_with_controller(None)?;
        let centre = self.centre(&file, &parameters)?;
        let asked = self.orbit(&parameters, centre)?;
        self.svg.as_deref().map_or(Ok(()), probe)?;
        let answer = self.answer(&parameters, &file, asked)?;
        if let Some(path) = &self.svg {
            draw::write(path, &picture::chart(&parameters.rig, &answer))?;
        }
        if self.json {
            print_json(&show::as_json(&answer, &parameters.rig))?;
        } else {
            print(&show::as_text(&answer, &parameters.rig))?;
        }
        Ok(if answer.found.is_ok() { Outcome::Done } else { Outcome::NotReachable })
    }

    fn centre(&self, file: &RigFile, parameters: &ControllerParameters) -> Result<Pose> {
        let mut centre = self.from.unwrap_or(file.home);
        centre.0[2] = self.height.unwrap_or(centre.0[2]);
        let name = match (self.from, self.height) {
            (Some(_), _) => "--from".to_owned(),
            (None, Some(_)) => "--height".to_owned(),
            (None, None) => self.rig.name_of_home(),
        };
        require_below(&file.rig, &name, &centre)?;
        require_rest(parameters, &name, &centre)?;
        Ok(centre)
    }

    fn figure(&self, centre: &Pose) -> Result<Figure> {
        if let Some([x, y]) = self.through {
            let [dx, dy] = [x - centre.0[0], y - centre.0[1]];
            ensure!(dx != 0.0 || dy != 0.0, "--through {x},{y}: that is the centre, where it begins");
            return Ok(Figure::Line { radius: dx.hypot(dy), direction: dy.atan2(dx) });
        }
        let radius = self.radius.unwrap_or_default();
        let of_others = [
            ("--direction", self.direction.is_some() && self.shape != Shape::Line),
            ("--share", self.share.is_some() && self.shape != Shape::Hypotrochoid),
            ("--lobes", self.lobes.is_some() && self.shape != Shape::Hypotrochoid),
        ];
        if let Some((option, _)) = of_others.into_iter().find(|(_, is_given)| *is_given) {
            bail!("{option}: this shape has none: leave it out")
        }
        Ok(match self.shape {
            Shape::Circle => Figure::Circle { radius },
            Shape::Line => Figure::Line { radius, direction: self.direction.unwrap_or(0.0) },
            Shape::Hypotrochoid => {
                let (share, lobes) = (self.share.unwrap_or(SHARE), self.lobes.unwrap_or(LOBES));
                Figure::Hypotrochoid { radius, share, lobes }
            }
        })
    }

    /// As it is asked for; without a start with the longest that is tried.
    fn orbit(&self, parameters: &ControllerParameters, centre: Pose) -> Result<orbit::Orbit> {
        let rate = self.rate.unwrap_or(orbit::Orbit::natural_rate(&parameters.rig, &centre));
        let usual = if self.through.is_some() { 0.0 } else { TURNS };
        let (figure, turns) = (self.figure(&centre)?, self.turns.unwrap_or(usual));
        let mut orbit = orbit::Orbit { centre, figure, rate, turns, start: self.start.unwrap_or(1.0) };
        if self.start.is_none() {
            orbit.validate_but_start()?;
            orbit.start = orbit.longest_start();
        }
        orbit.validate()?;
        Ok(orbit)
    }

    fn answer(
        &self,
        parameters: &ControllerParameters,
        file: &RigFile,
        asked: orbit::Orbit,
    ) -> Result<Answer> {
        let orbit = self.completed(parameters, &asked).unwrap_or(asked);
        let found = match orbit.prove(parameters, &Coordinates::zeros(), self.step) {
            Ok(proof) => Ok(proof),
            Err(OrbitError::Refused(refusal)) => Err(refusal),
            Err(OrbitError::Parameter(error)) => return Err(error.into()),
        };
        let instead = found.as_ref().err().and_then(|refusal| self.instead(parameters, &orbit, refusal));
        let slice = Slice { rig: &file.rig, height: orbit.centre.0[2], angles: orbit.centre.angles() };
        let border = workspace::find(&slice, file, || ()).map_or(vec![], |found| found.corners);
        let outside = Outside::of(&parameters.rig, &orbit.trajectory(), border);
        Ok(Answer { orbit, outside, found, instead })
    }

    /// With what is not given: the shortest start, and on the way through a place the rate.
    fn completed(&self, parameters: &ControllerParameters, asked: &orbit::Orbit) -> Option<orbit::Orbit> {
        match (self.start, self.through, self.rate) {
            (Some(_), ..) => None,
            (None, Some(_), None) => asked.quickest(parameters, self.step),
            (None, ..) => asked.with_shortest_start(parameters, self.step),
        }
    }

    /// What is proved in place of an orbit that is not: with a longer start, where that may help, or smaller.
    fn instead(
        &self,
        parameters: &ControllerParameters,
        orbit: &orbit::Orbit,
        refusal: &Refusal,
    ) -> Option<orbit::Orbit> {
        let may_help = self.start.is_some() && refusal.part != Part::Full;
        let longer = may_help.then(|| orbit.with_shortest_start(parameters, self.step)).flatten();
        longer.or_else(|| orbit.with_largest_radius(parameters, self.step))
    }
}
