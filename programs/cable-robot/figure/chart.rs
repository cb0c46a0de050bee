//! What a figure shows, as data: the picture and the CSV file are two forms of it.

use std::io::Write;
use std::ops::Range;

use anyhow::Result;
use plotters::style::RGBColor;

/// Okabe and Ito's colours, which the colour-blind tell apart, without yellow, which is lost on white.
pub const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
];
pub const BLACK: RGBColor = RGBColor(30, 30, 30);
pub const GREY: RGBColor = RGBColor(120, 120, 120);

/// Panels of equal size, row by row.
pub struct Chart {
    /// Width and height, in pixels of a screen.
    pub size: [u32; 2],
    /// Panels side by side.
    pub columns: usize,
    pub panels: Vec<Panel>,
}

/// One pair of axes and what is drawn in it, in this order.
pub struct Panel {
    pub title: &'static str,
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
    Dashed,
    Dots,
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
        Self { title, x, y, series: vec![], notes: vec![] }
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
                    csv.write_record([panel.title, &series.name, &short(*x), &short(*y)])?;
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
