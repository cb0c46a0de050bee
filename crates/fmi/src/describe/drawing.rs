//! The frame, drawn: base, platform, cables with their numbers, axes. The points are those of the geometry itself.

use std::fmt::Write;

use nalgebra::Vector3;

use cable_robot::robot::RigFile;

/// A parallel view from the front and a little above: x to the right, z down, y towards the reader.
fn project(point: &Vector3<f64>) -> (f64, f64) {
    (300.0 + 340.0 * (point.x - 0.35 * point.y), 110.0 + 340.0 * (point.z + 0.3 * point.y))
}

/// An SVG of the robot with Table I's dimensions, one metre below its base.
pub fn robot() -> String {
    let cables = RigFile::default().rig.cables;
    let below = |point: &Vector3<f64>| point + Vector3::z();
    let mut svg = String::from(
        "<svg viewBox=\"90 40 400 470\" role=\"img\" aria-label=\"Base triangle above, platform triangle below, six cables \
         between them, the z axis points down\">\n",
    );
    svg += &triangle("base", [0, 2, 4].map(|i| cables[i].anchor));
    svg += &triangle("platform", [1, 3, 5].map(|i| below(&cables[i].attachment)));
    for i in 0..cables.len() {
        let (from, to) = (cables[i].anchor, below(&cables[i].attachment));
        let (middle, n) = (from.lerp(&to, 0.4), i + 1);
        svg += &line("cable", &from, &to);
        svg += &label(&middle, (-4.0, 4.0), "number", &n.to_string());
    }
    let origin = Vector3::zeros();
    let axes = [
        ("x", Vector3::x() * 0.3, (8.0, 4.0)),
        ("y", Vector3::y() * 0.4, (-16.0, 12.0)),
        ("z", Vector3::z() * 0.45, (8.0, 4.0)),
    ];
    for (name, tip, offset) in axes {
        svg += &line("axis", &origin, &tip);
        svg += &label(&tip, offset, "text", name);
    }
    svg += &label(&cables[4].anchor, (60.0, -28.0), "text", "base, side 2a");
    svg += &label(&below(&cables[3].attachment), (-40.0, 28.0), "text", "platform, side 2b");
    svg + "</svg>"
}

fn triangle(class: &str, corners: [Vector3<f64>; 3]) -> String {
    let mut points = String::new();
    for corner in &corners {
        let (x, y) = project(corner);
        let _ = write!(points, "{x:.1},{y:.1} ");
    }
    format!("<polygon class=\"{class}\" points=\"{}\"/>\n", points.trim_end())
}

fn line(class: &str, from: &Vector3<f64>, to: &Vector3<f64>) -> String {
    let ((x1, y1), (x2, y2)) = (project(from), project(to));
    format!("<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>\n")
}

fn label(at: &Vector3<f64>, (right, down): (f64, f64), class: &str, text: &str) -> String {
    let (x, y) = project(at);
    format!("<text class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\">{text}</text>\n", x + right, y + down)
}
