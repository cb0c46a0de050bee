//! `cable-robot reach`: the domain (15) of a step from rest.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use cable_robot::plan::PlannerKind;
use cable_robot::plan::nearest::{Facet, domain_facets};
use cable_robot::reach::{BoundedDomain, polygon};
use cable_robot::robot::{Pose, RigFile, Shape};
use cable_robot_report::files::probe;
use clap::{Args, ValueHint};
use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::Serialize;

use crate::command::arguments::pose;
use crate::command::figure::chart::{BLACK, COLOURS, Chart, GREY, Look, Series};
use crate::command::figure::draw;
use crate::command::plane::{self, View};
use crate::command::rig::{RigArgument, require_rest};
use crate::command::{Outcome, metres, print, print_json, workspace};

pub const EXAMPLE: &str = "\
Example: cable-robot reach --from 0,0,1 --to 0.15,0.15,1
Exit code 3: --to is not in the domain. It may still be reached by several steps: see `cable-robot plan`.";

#[derive(Args)]
pub struct Reach {
    #[command(flatten)]
    rig: RigArgument,
    /// x,y,z of the rest before the step, m
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    from: Pose,
    /// A set point to be tried, m
    #[arg(long, value_parser = pose, allow_hyphen_values = true)]
    to: Option<Pose>,
    /// Also draws the domain into this file, in the static workspace
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    svg: Option<PathBuf>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What becomes of a set point tried.
struct Tried {
    to: Vector2<f64>,
    admissible: bool,
    /// Farthest admissible point towards it, the border itself.
    farthest: Vector2<f64>,
    /// The cable whose facet ends the ray, from 1; `None` if it goes on beyond `to`.
    forbidden_by: Option<usize>,
}

impl Reach {
    pub fn run(&self) -> Result<Outcome> {
        let (file, parameters) = self.rig.read_with_controller(Some(PlannerKind::Bounded))?;
        let shape = Shape::of(&parameters.rig)?;
        ensure!(
            shape.is_in_place(),
            "the domain (15) is shown for a rig that stands and is numbered as the paper's only"
        );
        let robot = &shape.robot;
        let (from, z) = (self.from.position().xy(), self.from.0[2]);
        for (name, pose) in [("--from", Some(&self.from)), ("--to", self.to.as_ref())] {
            let level = pose.is_none_or(|pose| pose.angles().norm() == 0.0 && pose.0[2] == z);
            ensure!(level, "{name}: the domain (15) is of steps at one height and with zero orientation");
        }
        require_rest(&parameters, "--from", &self.from)?;
        self.svg.as_deref().map_or(Ok(()), probe)?;
        let domain = BoundedDomain::new(robot, &parameters.gains(), from, z);
        let mut vertices = polygon(&domain.half_planes(), 2.0 * robot.a);
        // Where three half-planes meet in one point, clipping leaves it twice.
        vertices.dedup_by(|a, b| (*a - *b).norm() < 1e-12);
        let tried = self.to.map(|to| attempt(&domain, &from, &to.position().xy()));
        if let Some(path) = &self.svg {
            draw::write(path, &picture(&file, &self.from, &vertices, tried.as_ref()))?;
        }
        if self.json {
            print_json(&Answer::new(&self.from, &vertices, tried.as_ref()))?;
        } else {
            print(&as_text(&self.from, &vertices, tried.as_ref()))?;
        }
        let refused = tried.is_some_and(|tried| !tried.admissible);
        Ok(if refused { Outcome::NotReachable } else { Outcome::Done })
    }
}

fn attempt(domain: &BoundedDomain, from: &Vector2<f64>, to: &Vector2<f64>) -> Tried {
    let direction = to - from;
    let facets = domain_facets(domain);
    let ray = |facet: &Facet| facet.half_plane.ray(from, &direction);
    let first = facets.iter().min_by(|a, b| ray(a).total_cmp(&ray(b)));
    let length = domain.ray(&direction);
    let admissible = domain.contains(to);
    Tried {
        to: *to,
        admissible,
        farthest: if length.is_finite() { from + direction * length } else { *from },
        forbidden_by: first.filter(|_| !admissible).map(|facet| facet.cable),
    }
}

fn as_text(from: &Pose, vertices: &[Vector2<f64>], tried: Option<&Tried>) -> String {
    let mut text = format!(
        "domain (15) of a step from rest at ({}, {}, {}): inside\n     x (m)     y (m)\n",
        from.0[0], from.0[1], from.0[2]
    );
    for vertex in vertices {
        let _ = writeln!(text, " {} {}", metres(vertex.x), metres(vertex.y));
    }
    text + &tried.map_or(String::new(), |tried| verdict(from, tried))
}

/// What becomes of the set point tried.
fn verdict(from: &Pose, Tried { to, admissible, farthest, forbidden_by }: &Tried) -> String {
    let verdict = match forbidden_by {
        None if *admissible => "is admissible".to_owned(),
        None => "is not admissible".to_owned(),
        Some(cable) => format!("is not admissible: cable {cable} forbids it"),
    };
    let mut text = format!("({}, {}) {verdict}\n", to.x, to.y);
    if *to != from.position().xy() {
        let end = [farthest.x, farthest.y].map(|c| metres(c).trim().to_owned()).join(", ");
        let _ = writeln!(text, "the domain ends in that direction at ({end})");
    }
    text
}

/// The domain in the static workspace and the base, and from near.
fn picture(file: &RigFile, from: &Pose, vertices: &[Vector2<f64>], tried: Option<&Tried>) -> Chart {
    let domain: Vec<[f64; 2]> = vertices.iter().map(|vertex| [vertex.x, vertex.y]).collect();
    let (rest, border) = ([from.0[0], from.0[1]], workspace::border(file, from));
    let points = tried.map_or(vec![], |tried| [tried.to, tried.farthest].map(Into::into).to_vec());
    let near: Vec<[f64; 2]> = domain.iter().copied().chain([rest]).chain(points.iter().copied()).collect();
    let anchors = plane::anchors(&file.rig, View::LEVEL).into_iter().map(|(at, _)| at);
    let all: Vec<_> = near.iter().copied().chain(border.iter().copied()).chain(anchors).collect();
    let titles = [(plane::side_seen(&file.rig).to_owned(), all), ("from near".to_owned(), near)];
    let mut panels = titles.map(|(title, shown)| {
        let mut panel = View::LEVEL.panel(title, shown.into_iter());
        panel.series.push(Series::new("static workspace", Look::Region, GREY, border.clone()));
        panel.series.push(Series::new("domain (15)", Look::Region, COLOURS[0], domain.clone()));
        plane::clip(&mut panel);
        panel
    });
    for panel in &mut panels {
        panel.series.push(Series::new("rest", Look::Dots, BLACK, vec![rest]));
        if let [to, farthest] = points[..] {
            panel.series.push(Series::new("tried", Look::Crosses, COLOURS[4], vec![to]));
            panel.series.push(Series::new("farthest that way", Look::Rings, COLOURS[0], vec![farthest]));
        }
    }
    // The key of one panel has no room for all.
    plane::name_in_key(&mut panels[0], &["static workspace", "domain (15)"]);
    plane::name_in_key(&mut panels[1], &["rest", "tried", "farthest that way"]);
    plane::draw_base(&mut panels[0], &file.rig, View::LEVEL);
    let first = format!("{}; {}", file.name, plane::frame(&file.rig));
    let said = format!("domain (15) of a step from rest at ({}, {}, {})", from.0[0], from.0[1], from.0[2]);
    let verdict = tried.map_or(String::new(), |tried| verdict(from, tried));
    let text: Vec<_> = [first, said].into_iter().chain(verdict.lines().map(str::to_owned)).collect();
    plane::chart(panels.into(), 2, &text)
}

/// The domain (15) of a step from rest: the set points at the same height that slacken no cable.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Answer {
    /// Where the platform rests: x, y, z (m), roll, pitch, yaw (rad), base frame.
    from: [f64; 6],
    /// x, y of the domain's corners in order, m.
    vertices: Vec<[f64; 2]>,
    /// What becomes of the set point `--to`; null if none was given.
    to: Option<AnswerTo>,
}

/// What becomes of a set point.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(deny_unknown_fields)]
pub struct AnswerTo {
    /// The set point: x, y, m.
    point: [f64; 2],
    /// Whether it lies in the domain.
    admissible: bool,
    /// Where the domain ends in its direction: x, y, m.
    farthest: [f64; 2],
    /// The cable that forbids it, from 1; null if none does.
    forbidden_by: Option<usize>,
}

impl Answer {
    fn new(from: &Pose, vertices: &[Vector2<f64>], tried: Option<&Tried>) -> Self {
        let point = |p: &Vector2<f64>| [p.x, p.y];
        Self {
            from: from.0.into(),
            vertices: vertices.iter().map(point).collect(),
            to: tried.map(|tried| AnswerTo {
                point: point(&tried.to),
                admissible: tried.admissible,
                farthest: point(&tried.farthest),
                forbidden_by: tried.forbidden_by,
            }),
        }
    }
}
