//! What pictures of a rig's planes have in common: equal scales, the base with its cables, points with their names.

use std::ops::Range;

use cable_robot::robot::{Pose, Rig};
use nalgebra::{Vector2, Vector3};
use plotters::style::RGBColor;

use crate::command::figure::chart::{Axis, Chart, GREY, Look, Note, Panel, Series, Side};
use crate::command::figure::draw::caption_height;
use crate::command::number;

/// Sides of a panel whose plotting area is a square, in pixels of a screen.
const PANEL: [u32; 2] = [500, 476];
/// How near points may come, as a part of the panel, before only the first of them is named.
const NEAR: f64 = 0.05;
/// Characters that have room below a panel.
const LINE: usize = 80;

/// Two coordinates of the base frame: the one to the right, and the one upwards, or downwards if z points down.
#[derive(Clone, Copy, PartialEq)]
pub struct View {
    pub axes: [usize; 2],
    is_down: bool,
}

impl View {
    /// x to the right and y up: seen against z.
    pub const LEVEL: Self = Self { axes: [0, 1], is_down: false };

    /// The axis k to the right, and z as gravity has it.
    pub fn upright(k: usize, rig: &Rig) -> Self {
        Self { axes: [k, 2], is_down: rig.gravity.z > 0.0 }
    }

    pub fn of(self, point: &Vector3<f64>) -> [f64; 2] {
        self.axes.map(|k| point[k])
    }

    /// A panel about these points, a square.
    pub fn panel(self, title: impl Into<String>, shown: impl Iterator<Item = [f64; 2]> + Clone) -> Panel {
        let label = |k: usize| ["x (m)", "y (m)", "z (m)"][k];
        let [x, y] = square(shown);
        let size = x.end - x.start;
        let decimals = (-(size / 10.0).log10().floor()).clamp(0.0, 6.0) as usize;
        let y = if self.is_down { y.end..y.start } else { y };
        let [x, y] = [(0, x), (1, y)].map(|(k, range)| Axis::new(label(self.axes[k]), range, decimals));
        Panel { title: title.into(), x, y, series: vec![], notes: vec![] }
    }
}

/// From where x to the right and y up are seen.
pub fn side_seen(rig: &Rig) -> &'static str {
    if rig.gravity.z > 0.0 { "from below" } else { "from above" }
}

/// What the axes are.
pub fn frame(rig: &Rig) -> String {
    let way = if rig.gravity.z > 0.0 { "down" } else { "up" };
    format!("base frame, z points {way}, seen {}; equal scales", side_seen(rig))
}

/// Ranges of equal size about all points, for a square picture.
pub fn square(points: impl Iterator<Item = [f64; 2]> + Clone) -> [Range<f64>; 2] {
    let points = points.map(Vector2::from);
    let corner =
        |pick: fn(f64, f64) -> f64| points.clone().reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default();
    let (low, high) = (corner(f64::min), corner(f64::max));
    let (middle, half) = ((low + high) * 0.5, 0.55 * (high - low).max());
    let half = if half > 0.0 { half } else { 1.0 };
    [middle.x - half..middle.x + half, middle.y - half..middle.y + half]
}

/// Panels side by side, with text below that says what they show.
pub fn chart(panels: Vec<Panel>, columns: usize, text: &[String]) -> Chart {
    let rows = panels.len().div_ceil(columns);
    let [width, height] = [PANEL[0] * columns as u32, PANEL[1] * rows as u32];
    let caption = text.iter().flat_map(|line| wrapped(line, LINE * columns)).collect();
    let mut chart = Chart { size: [width, height], columns, panels, caption };
    chart.size[1] += caption_height(&chart) as u32;
    chart
}

/// Lines of at most so many characters, if no word is longer.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Where the anchors are, with the numbers of the cables that start there.
pub fn anchors(rig: &Rig, view: View) -> Vec<([f64; 2], String)> {
    let mut places: Vec<([f64; 2], String)> = vec![];
    for (i, cable) in rig.cables.iter().enumerate() {
        let at = view.of(&cable.anchor);
        match places.iter_mut().find(|(place, _)| gap(place, &at) < 1e-3 * rig.radius()) {
            Some((_, cables)) => *cables += &format!(", {}", i + 1),
            None => places.push((at, format!("{}", i + 1))),
        }
    }
    places
}

/// Draws the anchors, named after their cables.
pub fn draw_base(panel: &mut Panel, rig: &Rig, view: View) {
    let anchors = anchors(rig, view);
    let middle = panel.y.range.start.midpoint(panel.y.range.end);
    for (at, cables) in &anchors {
        let text = format!("{} {cables}", if cables.contains(',') { "cables" } else { "cable" });
        // Away from what the cables carry.
        let is_above = (at[1] >= middle) == (panel.y.range.end > panel.y.range.start);
        let side = if is_above { Side::Above } else { Side::Below };
        panel.notes.push(Note::new(*at, side, GREY, text));
    }
    let points = anchors.into_iter().map(|(at, _)| at).collect();
    panel.series.push(Series::new("base", Look::Triangles, GREY, points));
}

/// Names these series above the panel.
pub fn name_in_key(panel: &mut Panel, names: &[&str]) {
    let is_meant = |series: &&mut Series| names.contains(&series.name.as_str());
    panel.series.iter_mut().filter(is_meant).for_each(|series| series.in_key = true);
}

/// Names points, the first ones above all: no name where one is near already.
pub fn name_points(panel: &mut Panel, colour: RGBColor, points: impl Iterator<Item = ([f64; 2], String)>) {
    let near = NEAR * (panel.x.range.end - panel.x.range.start);
    let mut named: Vec<[f64; 2]> = vec![];
    for (at, name) in points {
        if named.iter().all(|other| gap(other, &at) > near) {
            panel.notes.push(Note::new(at, Side::Right, colour, name));
            named.push(at);
        }
    }
}

/// "z = 1 m", and the angles if there are any.
pub fn level_of(pose: &Pose) -> String {
    let [roll, pitch, yaw] = pose.angles().into();
    let height = format!("z = {} m", number(pose.0[2]));
    if pose.angles().amax() == 0.0 {
        return height;
    }
    format!("{height}, roll, pitch, yaw = {}, {}, {} rad", number(roll), number(pitch), number(yaw))
}

/// Leaves of the regions what lies within the axes.
pub fn clip(panel: &mut Panel) {
    let [x, y] = [panel.x.range.clone(), panel.y.range.clone()];
    // Coordinate, sign, and the greatest that the coordinate with that sign may be.
    let sides = [(0, 1.0, x.end), (0, -1.0, -x.start), (1, 1.0, y.end), (1, -1.0, -y.start)];
    for series in panel.series.iter_mut().filter(|series| series.look == Look::Region) {
        for (k, sign, most) in sides {
            series.points = beside(&series.points, |point| most - sign * point[k]);
        }
    }
}

/// The part of a polygon where `room` is not negative, after Sutherland and Hodgman.
fn beside(polygon: &[[f64; 2]], room: impl Fn(&[f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut part = vec![];
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let [of_a, of_b] = [room(a), room(b)];
        if of_a >= 0.0 {
            part.push(*a);
        }
        if (of_a >= 0.0) != (of_b >= 0.0) {
            let share = of_a / (of_a - of_b);
            part.push([0, 1].map(|k| a[k] + (b[k] - a[k]) * share));
        }
    }
    part
}

fn gap([x, y]: &[f64; 2], [u, v]: &[f64; 2]) -> f64 {
    (x - u).hypot(y - v)
}

#[cfg(test)]
mod tests {
    use cable_robot::robot::RigFile;

    use super::*;
    use crate::command::figure::chart::BLACK;

    /// A picture of a rig whose z points up said that it is seen from below.
    #[test]
    fn the_side_seen_is_that_of_right_handed_axes() {
        let down = RigFile::default();
        let text = include_str!("../../rigs/eight.toml").replacen("name =", "frame = \"z-up\"\nname =", 1);
        let up = RigFile::parse(&text.replace(", 0.0]\nattachment", ", 4.0]\nattachment"));
        assert_eq!(side_seen(&down.rig), "from below");
        assert_eq!(side_seen(&up.unwrap().rig), "from above");
        let panel = View::upright(0, &down.rig).panel("", [[0.0, 0.0], [1.0, 2.0]].into_iter());
        assert!(panel.y.range.start > panel.y.range.end, "z points down");
    }

    #[test]
    fn of_a_region_only_what_lies_within_the_axes_is_drawn() {
        let mut panel = View::LEVEL.panel("", [[0.0, 0.0], [1.0, 1.0]].into_iter());
        let corners = vec![[0.5, 0.5], [9.0, 0.5], [0.5, 9.0]];
        panel.series.push(Series::new("triangle", Look::Region, BLACK, corners));
        clip(&mut panel);
        let (low, high) = (panel.x.range.start, panel.x.range.end);
        assert!((low + 0.05).abs() < 1e-12 && (high - 1.05).abs() < 1e-12);
        let mut found = panel.series[0].points.clone();
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let expected = [[0.5, 0.5], [0.5, high], [high, 0.5], [high, high]];
        let far = |(a, b): (&[f64; 2], &[f64; 2])| gap(a, b);
        assert!(
            found.len() == 4 && found.iter().zip(&expected).map(far).fold(0.0, f64::max) < 1e-12,
            "{found:?}"
        );
    }
}
