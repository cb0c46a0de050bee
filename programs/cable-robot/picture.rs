//! Pictures of a workspace: in characters for a terminal, as SVG for a page. Both as seen from below: x to the right, y up.

use std::fmt::Write;

use cable_robot::reach::Slice;
use cable_robot::reach::static_region::Grid;
use nalgebra::Vector2;

use crate::command::workspace::Found;
use crate::command::{metres, number};

/// Shades by quarters of the greatest margin.
const SHADES: [char; 4] = ['░', '▒', '▓', '█'];
/// Side of the SVG picture and its white edge, in its own units.
const SIDE: f64 = 640.0;
const EDGE: f64 = 60.0;

/// A character for each column and every second row of the grid: characters are twice as high as wide.
pub fn characters(grid: &Grid, greatest: f64) -> String {
    let shade = |margin: &f64| {
        let quarter = (4.0 * margin / greatest).clamp(0.0, 3.0) as usize;
        if *margin >= 0.0 { SHADES[quarter] } else { '·' }
    };
    let mut text = String::new();
    for (y, row) in grid.y.iter().zip(&grid.margin).rev().step_by(2) {
        let _ = writeln!(text, "{} {}", metres(*y), row.iter().map(shade).collect::<String>());
    }
    let (first, last) = (grid.x.first().unwrap_or(&0.0), grid.x.last().unwrap_or(&0.0));
    let width = grid.x.len();
    let _ = writeln!(text, "    y (m) {first:<8.3}{:^middle$}{last:>8.3}", "x (m)", middle = width - 16);
    let _ = writeln!(text, "margin by quarters of the greatest, from the border inwards: ░ ▒ ▓ █");
    text
}

/// Anchors, workspace and its deepest point.
pub fn svg(rig_name: &str, slice: &Slice, found: Option<&Found>) -> String {
    let (low, high) = slice.extent();
    let scale = (SIDE - 2.0 * EDGE) / (high - low).max();
    let middle = (low + high) * 0.5;
    let at =
        |p: &Vector2<f64>| (SIDE / 2.0 + (p.x - middle.x) * scale, SIDE / 2.0 - (p.y - middle.y) * scale);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIDE} {SIDE}\" font-family=\"sans-serif\" font-size=\"14\">\n\
         <rect width=\"{SIDE}\" height=\"{SIDE}\" fill=\"white\"/>\n"
    );
    let _ = writeln!(
        text,
        "<title>Static workspace of {}, z = {} m</title>",
        escaped(rig_name),
        number(slice.height)
    );
    let (zero_x, zero_y) = at(&Vector2::zeros());
    let _ = writeln!(
        text,
        "<path d=\"M0 {zero_y:.2}H{SIDE}M{zero_x:.2} 0V{SIDE}\" stroke=\"#ccc\"/>\n\
         <text x=\"{:.0}\" y=\"{:.2}\">x</text><text x=\"{:.2}\" y=\"48\">y</text>",
        SIDE - 18.0,
        zero_y - 6.0,
        zero_x + 6.0
    );
    if let Some(found) = found {
        let corner = |p: &Vector2<f64>| format!("{:.2},{:.2}", at(p).0, at(p).1);
        let border: Vec<_> = found.corners.iter().map(corner).collect();
        let _ = writeln!(
            text,
            "<polygon points=\"{}\" fill=\"#9ecae1\" stroke=\"#08519c\" stroke-width=\"1.5\"/>",
            border.join(" ")
        );
        let ((x, y), margin) = (at(&found.deepest.0), found.deepest.1);
        let _ = writeln!(
            text,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"3\" fill=\"#08519c\"/>\n\
             <text x=\"{:.2}\" y=\"{:.2}\">{margin:.2} N</text>",
            x + 6.0,
            y + 16.0
        );
    }
    for (anchor, cables) in anchors(slice) {
        let (x, y) = at(&anchor);
        let _ = writeln!(
            text,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"5\" fill=\"#a63603\"/>\n\
             <text x=\"{:.2}\" y=\"{:.2}\" fill=\"#a63603\">{cables}</text>",
            x + 8.0,
            y - 8.0
        );
    }
    // A bar of the power of ten that fits into a third of the picture.
    let metres = 10f64.powf(((high - low).max() / 3.0).log10().floor());
    let _ = writeln!(
        text,
        "<path d=\"M20 {bottom}h{:.2}\" stroke=\"black\" stroke-width=\"2\"/><text x=\"20\" y=\"{}\">{metres} m</text>\n\
         <text x=\"20\" y=\"24\">{}, z = {} m, seen from below</text>\n</svg>",
        metres * scale,
        SIDE - 30.0,
        escaped(rig_name),
        number(slice.height),
        bottom = SIDE - 22.0
    );
    text
}

/// Places of anchors with the numbers of the cables that start there.
fn anchors(slice: &Slice) -> Vec<(Vector2<f64>, String)> {
    let mut places: Vec<(Vector2<f64>, String)> = vec![];
    for (i, anchor) in slice.rig.cables.iter().map(|cable| cable.anchor).enumerate() {
        match places.iter_mut().find(|(place, _)| (place - anchor.xy()).norm() < 1e-3) {
            Some((_, cables)) => *cables += &format!(", {}", i + 1),
            None => places.push((anchor.xy(), format!("{}", i + 1))),
        }
    }
    places
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
