//! What a figure shows, as data: the picture and the CSV file are two forms of it.

use std::io::Write;
use std::ops::Range;

use anyhow::Result;
use plotters::style::RGBColor;

/// Okabe and Ito's colours, which the colour-blind tell apart, without yellow; orange and sky blue are darker than theirs, with a contrast of 3:1 on white.
pub const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(184, 122, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(56, 150, 210),
];
pub const BLACK: RGBColor = RGBColor(30, 30, 30);
pub const GREY: RGBColor = RGBColor(120, 120, 120);
/// The lines behind everything, which say nothing of their own.
pub const GRID: RGBColor = RGBColor(225, 225, 225);
/// What is drawn on.
pub const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Each colour on a light screen, and in its place on a dark one.
pub const ON_DARK: [[RGBColor; 2]; 10] = [
    [COLOURS[0], RGBColor(80, 170, 235)],
    [COLOURS[1], RGBColor(230, 159, 0)],
    [COLOURS[2], RGBColor(0, 190, 140)],
    [COLOURS[3], RGBColor(222, 140, 186)],
    [COLOURS[4], RGBColor(240, 120, 40)],
    [COLOURS[5], RGBColor(130, 205, 250)],
    [BLACK, RGBColor(230, 230, 230)],
    [GREY, RGBColor(150, 150, 150)],
    [GRID, RGBColor(52, 56, 62)],
    [PAPER, RGBColor(22, 24, 29)],
];

/// Panels of equal size, row by row.
pub struct Chart {
    /// Width and height, in pixels of a screen.
    pub size: [u32; 2],
    /// Panels side by side.
    pub columns: usize,
    pub panels: Vec<Panel>,
    /// Lines below the panels; the first says what the picture is.
    pub caption: Vec<String>,
}

/// One pair of axes and what is drawn in it, in this order.
pub struct Panel {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub notes: Vec<Note>,
}

/// An axis. Points must lie within its range: the picture has no place for others.
pub struct Axis {
    /// With the unit.
    pub label: &'static str,
    pub range: Range<f64>,
    /// Decimals of the numbers along it.
    pub decimals: usize,
}

/// Points and how they look.
pub struct Series {
    pub name: String,
    pub points: Vec<[f64; 2]>,
    pub colour: RGBColor,
    pub look: Look,
    /// Whether the key above the panel names it; if not, a note should.
    pub in_key: bool,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Look {
    Line,
    Thin,
    /// Each point with an odd place joined to the next.
    Pieces,
    Dashed,
    Dots,
    Rings,
    Crosses,
    Triangles,
    /// A closed outline, lightly filled.
    Region,
}

/// Text beside a point.
pub struct Note {
    pub at: [f64; 2],
    pub text: String,
    pub colour: RGBColor,
    pub side: Side,
}

#[derive(Clone, Copy)]
pub enum Side {
    Right,
    Above,
    Below,
}

impl Panel {
    /// Empty axes over `duration` seconds, the upright one from 0 to `greatest`.
    pub fn over_time(
        title: &'static str,
        label: &'static str,
        duration: f64,
        greatest: f64,
        decimals: usize,
    ) -> Self {
        let (x, y) = (Axis::new("time (s)", 0.0..duration, 0), Axis::new(label, 0.0..greatest, decimals));
        Self { title: title.to_owned(), x, y, series: vec![], notes: vec![] }
    }

    /// The tension of cable `i`, from 0, in its colour and named at its end.
    pub fn push_cable(&mut self, i: usize, look: Look, points: Vec<[f64; 2]>) {
        let name = format!("u{}", i + 1);
        if let Some(end) = points.last() {
            self.notes.push(Note::new(*end, Side::Right, COLOURS[i], name.as_str()));
        }
        self.series.push(Series::new(name, look, COLOURS[i], points));
    }
}

impl Axis {
    pub fn new(label: &'static str, range: Range<f64>, decimals: usize) -> Self {
        Self { label, range, decimals }
    }
}

impl Series {
    pub fn new(name: impl Into<String>, look: Look, colour: RGBColor, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, colour, look, in_key: false }
    }

    pub fn in_key(mut self) -> Self {
        self.in_key = true;
        self
    }
}

impl Note {
    pub fn new(at: [f64; 2], side: Side, colour: RGBColor, text: impl Into<String>) -> Self {
        Self { at, text: text.into(), colour, side }
    }
}

impl Chart {
    /// Every point of every series: its panel's title, its series, x and y in the units of the axes.
    pub fn write_csv(&self, to: impl Write) -> Result<()> {
        let mut csv = csv::Writer::from_writer(to);
        csv.write_record(["panel", "series", "x", "y"])?;
        for panel in &self.panels {
            for series in &panel.series {
                for [x, y] in &series.points {
                    csv.write_record([&panel.title, &series.name, &short(*x), &short(*y)])?;
                }
            }
        }
        Ok(csv.flush()?)
    }
}

/// To a hundred-thousandth, never -0.
fn short(value: f64) -> String {
    format!("{}", (value * 1e5).round() / 1e5 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// WCAG 2.2, 1.4.11.
    const LEAST_CONTRAST: f64 = 3.0;

    fn luminance(RGBColor(r, g, b): RGBColor) -> f64 {
        let linear = |part: u8| match f64::from(part) / 255.0 {
            part if part <= 0.04045 => part / 12.92,
            part => ((part + 0.055) / 1.055).powf(2.4),
        };
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    fn contrast(a: RGBColor, b: RGBColor) -> f64 {
        let [a, b] = [luminance(a), luminance(b)];
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// Orange and sky blue had 2.2:1.
    #[test]
    fn lines_stand_out_from_light_and_from_dark() {
        assert!((contrast(RGBColor(0, 0, 0), PAPER) - 21.0).abs() < 1e-9);
        let dark = ON_DARK[9][1];
        for [light, on_dark] in ON_DARK.into_iter().filter(|[light, _]| *light != GRID && *light != PAPER) {
            let found = [contrast(light, PAPER), contrast(on_dark, dark)];
            assert!(found.iter().all(|contrast| *contrast >= LEAST_CONTRAST), "{light:?}: {found:?}");
        }
        assert!(COLOURS.iter().all(|colour| ON_DARK.iter().any(|[light, _]| light == colour)));
    }
}
