//! Pictures of a workspace: in characters for a terminal, as SVG for a page. Both with x to the right, y up.

use std::fmt::Write;

use cable_robot::reach::Slice;
use cable_robot::reach::static_region::Grid;
use nalgebra::Vector2;

use crate::command::contours::{levels, line};
use crate::command::figure::chart::{BLACK, COLOURS, Chart, GREY, Look, Note, Panel, Series, Side};
use crate::command::plane::{self, View};
use crate::command::workspace::Found;
use crate::command::{metres, number};

/// Shades by quarters of the greatest margin.
const SHADES: [char; 4] = ['░', '▒', '▓', '█'];
/// Panels side by side.
const COLUMNS: usize = 3;

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

/// A panel a slice, all to one scale: border, lines of equal margin, the deepest point, anchors.
pub fn chart(rig_name: &str, slices: &[(Slice, Option<Found>)]) -> Chart {
    let rig = slices[0].0.rig;
    let greatest =
        slices.iter().flat_map(|(_, found)| found).map(|found| found.deepest.1).fold(0.0, f64::max);
    let levels = levels(greatest);
    let corners = slices.iter().flat_map(|(_, found)| found).flat_map(|found| &found.corners);
    let anchors = plane::anchors(rig, View::LEVEL).into_iter().map(|(at, _)| at);
    let shown: Vec<[f64; 2]> = corners.map(|corner| [corner.x, corner.y]).chain(anchors).collect();
    let panels = slices.iter().map(|(slice, found)| panel(slice, found.as_ref(), &shown, &levels));
    let panels: Vec<_> = panels.collect();
    let columns = if panels.len() == 4 { 2 } else { panels.len().min(COLUMNS) };
    let said =
        "static workspace; lines: the least distance of a tension to a limit, N; dot: where it is greatest";
    let weight = format!("the platform weighs {:.1} N", rig.weight());
    plane::chart(panels, columns, &[format!("{rig_name}; {}", plane::frame(rig)), said.to_owned(), weight])
}

fn panel(slice: &Slice, found: Option<&Found>, shown: &[[f64; 2]], levels: &[f64]) -> Panel {
    let title = plane::level_of(&slice.pose(&Vector2::zeros()));
    let mut panel = View::LEVEL.panel(title, shown.iter().copied());
    let [x, y] = [&panel.x.range, &panel.y.range].map(|range| range.start.midpoint(range.end));
    match found {
        Some(found) => draw(&mut panel, found, levels),
        None => panel.notes.push(Note::new([x, y], Side::Above, BLACK, "empty")),
    }
    plane::draw_base(&mut panel, slice.rig, View::LEVEL);
    panel
}

fn draw(panel: &mut Panel, found: &Found, levels: &[f64]) {
    let border = found.corners.iter().map(|corner| [corner.x, corner.y]).collect();
    panel.series.push(Series::new("static workspace", Look::Region, GREY, border));
    let (deepest, margin) = ([found.deepest.0.x, found.deepest.0.y], found.deepest.1);
    let mut named = vec![(deepest, format!("{margin:.2} N"))];
    for level in levels.iter().rev() {
        let line = line(&found.grid, *level);
        let highest = line.iter().copied().reduce(|a, b| if b[1] > a[1] { b } else { a });
        named.extend(highest.map(|at| (at, number(*level))));
        panel.series.push(Series::new(number(*level), Look::Pieces, COLOURS[0], line));
    }
    panel.series.push(Series::new("deepest", Look::Dots, COLOURS[0], vec![deepest]));
    plane::name_points(panel, COLOURS[0], named.into_iter());
}
