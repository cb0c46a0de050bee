//! `cable-robot reach`: the domain (15) of a step from rest.

use std::fmt::Write;

use anyhow::{Result, ensure};
use cable_robot::plan::PlannerKind;
use cable_robot::plan::nearest::{Facet, domain_facets};
use cable_robot::reach::{BoundedDomain, polygon};
use cable_robot::robot::{Pose, Shape};
use clap::Args;
use nalgebra::Vector2;
use serde_json::json;

use crate::command::arguments::pose;
use crate::command::rig::{RigArgument, require_rest};
use crate::command::{Outcome, metres, print, print_json};

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
        let (_, parameters) = self.rig.read_with_controller(Some(PlannerKind::Bounded))?;
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
        let domain = BoundedDomain::new(robot, &parameters.gains(), from, z);
        let mut vertices = polygon(&domain.half_planes(), 2.0 * robot.a);
        // Where three half-planes meet in one point, clipping leaves it twice.
        vertices.dedup_by(|a, b| (*a - *b).norm() < 1e-12);
        let tried = self.to.map(|to| attempt(&domain, &from, &to.position().xy()));
        if self.json {
            print_json(&as_json(&self.from, &vertices, tried.as_ref()))?;
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
    if let Some(Tried { to, admissible, farthest, forbidden_by }) = tried {
        let verdict = match forbidden_by {
            None if *admissible => "is admissible".to_owned(),
            None => "is not admissible".to_owned(),
            Some(cable) => format!("is not admissible: cable {cable} forbids it"),
        };
        let _ = writeln!(text, "({}, {}) {verdict}", to.x, to.y);
        if *to != from.position().xy() {
            let end = [farthest.x, farthest.y].map(|c| metres(c).trim().to_owned()).join(", ");
            let _ = writeln!(text, "the domain ends in that direction at ({end})");
        }
    }
    text
}

fn as_json(from: &Pose, vertices: &[Vector2<f64>], tried: Option<&Tried>) -> serde_json::Value {
    let point = |p: &Vector2<f64>| [p.x, p.y];
    json!({
        "from": from.0.as_slice(),
        "vertices": vertices.iter().map(point).collect::<Vec<_>>(),
        "to": tried.map(|tried| json!({
            "point": point(&tried.to),
            "admissible": tried.admissible,
            "farthest": point(&tried.farthest),
            "forbiddenBy": tried.forbidden_by,
        })),
    })
}
