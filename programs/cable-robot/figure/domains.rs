//! Figs. 3 and 7: the static workspace and chains of reachable domains in it.

use std::ops::Range;

use cable_robot::control::Response;
use cable_robot::plan::ControllerParameters;
use cable_robot::reach::{BoundedDomain, HalfPlane, polygon, static_workspace};
use cable_robot::robot::RobotParameters;
use nalgebra::Vector2;

use super::Made;
use super::chart::{Axis, BLACK, COLOURS, Chart, GREY, Look, Note, Panel, Series, Side};
use super::manoeuvre::PRINTED;
use super::run::{GOAL, Run};

/// O1 to O5 of Table I, m.
const TABLE_I: [[f64; 2]; 5] = [[0.0, 0.0], [0.08, 0.08], [0.12, 0.11], [0.14, 0.15], [0.15, 0.17]];
const Z: f64 = GOAL[2];

/// The domains from the points of Table I.
pub fn figure_3() -> Made {
    let mut panels = planes(&TABLE_I);
    for panel in &mut panels {
        panel.series.push(Series::new("points of Table I", Look::Dots, BLACK, TABLE_I.to_vec()));
    }
    finish(&mut panels[1], numbered("O", 1, &TABLE_I));
    let mut findings: Vec<_> = TABLE_I.windows(2).enumerate().map(|(i, pair)| inside(i, pair)).collect();
    findings.push(areas(&TABLE_I));
    Made { chart: chart(panels), findings }
}

/// The domains from the set points of the simulation, and its path.
pub fn figure_7(run: &Run) -> Made {
    let set_points: Vec<_> = run.set_points.iter().map(|s| [s.position[0], s.position[1]]).collect();
    let from = &set_points[..set_points.len() - 1];
    let path: Vec<_> =
        run.samples.iter().step_by(25).map(|sample| [sample.pose.0[0], sample.pose.0[1]]).collect();
    let mut panels = planes(from);
    for panel in &mut panels {
        panel.series.push(Series::new("path", Look::Line, BLACK, path.clone()));
        panel.series.push(Series::new("set points", Look::Dots, BLACK, set_points.clone()));
    }
    finish(&mut panels[1], numbered("x", 0, &set_points));
    let facets = static_workspace(&RobotParameters::default());
    let distance =
        |p: &[f64; 2]| facets.iter().map(|f| f.slack(&Vector2::from(*p))).fold(f64::INFINITY, f64::min);
    let shares = |points: &[[f64; 2]]| {
        points.windows(2).map(|pair| format!("{:.4}", share(pair))).collect::<Vec<_>>().join(", ")
    };
    let printed = [&[[0.0, 0.0]], &PRINTED[..]].concat();
    let findings = vec![
        format!("the steps end at {} of the way to the borders of their domains", shares(&set_points)),
        format!("those of Eq. (18) would end at {} of the way", shares(&printed)),
        format!(
            "p comes as close as {:.4} m to the border of the static workspace; the goal lies {:.4} m from it",
            set_points.windows(2).flat_map(moving_point).map(|p| distance(&p)).fold(f64::INFINITY, f64::min),
            distance(&[GOAL[0], GOAL[1]])
        ),
        areas(from),
    ];
    Made { chart: chart(panels), findings }
}

/// Both panels with their domains; their plotting areas are square.
fn chart(panels: [Panel; 2]) -> Chart {
    Chart { size: [1000, 476], columns: 2, panels: panels.into(), caption: vec![] }
}

/// The whole workspace, with the key to the domains, and its part with x and y greater than 0.
fn planes(from: &[[f64; 2]]) -> [Panel; 2] {
    [("whole", -0.28..0.28), ("part", -0.01..0.26)].map(|(title, range)| {
        let robot = RobotParameters::default();
        let hexagon = corners(&static_workspace(&robot), &range);
        let mut series = vec![Series::new("static workspace", Look::Region, GREY, hexagon)];
        for (i, (from, colour)) in from.iter().zip(COLOURS).enumerate() {
            let border = corners(&domain(from).half_planes(), &range);
            let mut domain = Series::new(format!("RD{}", i + 1), Look::Region, colour, border);
            domain.in_key = title == "whole";
            series.push(domain);
        }
        let (x, y) = (Axis::new("x (m)", range.clone(), 2), Axis::new("y (m)", range, 2));
        Panel { title: title.to_owned(), x, y, series, notes: vec![] }
    })
}

/// Names what is drawn last, points, in the key and one by one.
fn finish(panel: &mut Panel, notes: Vec<Note>) {
    panel.notes = notes;
    for series in panel.series.iter_mut().filter(|series| series.look != Look::Region) {
        series.in_key = true;
    }
}

fn domain(from: &[f64; 2]) -> BoundedDomain {
    let parameters = ControllerParameters::default();
    BoundedDomain::new(&RobotParameters::default(), &parameters.gains(), Vector2::from(*from), Z)
}

/// The corners of a convex set, or of the part of it in a window with x and y in this range.
fn corners(half_planes: &[HalfPlane], window: &Range<f64>) -> Vec<[f64; 2]> {
    let side = |x: f64, y: f64, bound: f64| HalfPlane { normal: Vector2::new(x, y), bound };
    let (low, high) = (-window.start, window.end);
    let sides = [side(1.0, 0.0, high), side(0.0, 1.0, high), side(-1.0, 0.0, low), side(0.0, -1.0, low)];
    polygon(&[half_planes, &sides].concat(), 1.0).into_iter().map(Into::into).collect()
}

/// A number below each point but the last, where it would meet the one before.
fn numbered(name: &str, first: usize, points: &[[f64; 2]]) -> Vec<Note> {
    let note = |(i, at): (usize, &[f64; 2])| {
        let side = if i + 1 == points.len() { Side::Above } else { Side::Below };
        Note::new(*at, side, BLACK, format!("{name}{}", i + first))
    };
    points.iter().enumerate().map(note).collect()
}

/// Whether a point of Table I may be given as set point at the one before.
fn inside(i: usize, pair: &[[f64; 2]]) -> String {
    let (from, to) = (i + 1, i + 2);
    let verdict = if domain(&pair[0]).contains(&Vector2::from(pair[1])) { "lies in" } else { "lies outside" };
    format!("O{to} {verdict} RD{from}, at {:.3} of the way to its border", share(pair))
}

/// How far a step goes, 1 being the border of the domain.
fn share(pair: &[[f64; 2]]) -> f64 {
    1.0 / domain(&pair[0]).ray(&(Vector2::from(pair[1]) - Vector2::from(pair[0])))
}

fn areas(from: &[[f64; 2]]) -> String {
    let area_of = |half_planes: &[HalfPlane]| area(&corners(half_planes, &(-1.0..1.0)));
    let whole = area_of(&static_workspace(&RobotParameters::default()));
    let share = |from| format!("{:.1} %", 100.0 * area_of(&domain(from).half_planes()) / whole);
    let shares: Vec<_> = from.iter().map(share).collect();
    format!("areas of the domains, as shares of the static workspace: {}", shares.join(", "))
}

/// Gauss's formula.
fn area(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let twice: f64 = corners.iter().zip(next).map(|([x, y], [x1, y1])| x * y1 - x1 * y).sum();
    twice.abs() / 2.0
}

/// p = P + P'' z/g on the way from rest at one set point to the next.
fn moving_point(pair: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> {
    let parameters = ControllerParameters::default();
    let [from, to] = [pair[0], pair[1]].map(Vector2::from);
    (0..=150).map(move |k| {
        let [f, _, dd] = Response::at(&parameters.gains(), 0.02 * f64::from(k)).step_error();
        (to + (from - to) * (f + dd * Z / RobotParameters::default().g)).into()
    })
}
