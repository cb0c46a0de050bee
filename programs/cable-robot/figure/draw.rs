//! A chart as SVG, drawn by plotters, and as PNG, painted from that by resvg with a font of its own.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use cable_robot_report::files::write_whole;
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    Circle, Color, Cross, DashedLineSeries, DrawingArea, IntoDrawingArea, IntoFont, LineSeries, PathElement,
    Polygon, RGBColor, SVGBackend, TextStyle, TriangleMarker,
};
use plotters::style::ShapeStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use resvg::{tiny_skia, usvg};

use super::chart::{BLACK, Chart, GREY, GRID, Look, Note, ON_DARK, PAPER, Panel, Series, Side};

/// Units of the SVG a pixel of the screen: plotters rounds to whole units.
const FINE: i32 = 8;
/// Pixels of the PNG a pixel of the screen.
const DENSITY: f32 = 1.5;
/// Sizes in pixels of the screen.
const TEXT: i32 = 15;
const EDGE: i32 = 8;
const LEFT: i32 = 62;
const BOTTOM: i32 = 42;
const TOP: i32 = 30;
const RIGHT: i32 = 34;
/// Width of a line; thin ones have 1.
const LINE: i32 = 3;
const DOT: i32 = 4;
const RING: i32 = 7;
const DASH: i32 = 8;
const GAP: i32 = 5;
/// Length of the piece of a line in the key.
const PIECE: i32 = 23;
/// How much of its colour a region is filled with.
const TINT: f64 = 0.12;
/// From line to line of the caption.
const CAPTION_LINE: i32 = 20;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// The chart as an SVG file.
pub fn svg(chart: &Chart) -> Result<String> {
    let mut text = String::new();
    draw(chart, &mut text).map_err(|error| anyhow!("cannot draw the figure: {error}"))?;
    // It is shown at the size of the screen, whatever the units inside.
    let [width, height] = chart.size;
    let inside = format!("width=\"{}\" height=\"{}\"", width * FINE as u32, height * FINE as u32);
    let shown = text.replacen(&inside, &format!("width=\"{width}\" height=\"{height}\""), 1);
    Ok(shown.replacen('>', &format!(">\n{}{}", title(chart), dark()), 1))
}

/// Writes the chart into a file, whole or not at all.
pub fn write(path: &Path, chart: &Chart) -> Result<()> {
    let svg = svg(chart)?;
    Ok(write_whole(path, |file| file.write_all(svg.as_bytes()))?)
}

/// For who hears the picture.
fn title(chart: &Chart) -> String {
    let escaped = |line: &String| line.replace('&', "&amp;").replace('<', "&lt;");
    chart.caption.first().map_or(String::new(), |line| format!("<title>{}</title>\n", escaped(line)))
}

/// Other colours where the screen is dark: a style sheet goes before the attributes that plotters writes.
fn dark() -> String {
    let hex = |RGBColor(r, g, b): RGBColor| format!("#{r:02X}{g:02X}{b:02X}");
    let rule = |[light, dark]: [RGBColor; 2]| {
        let (light, dark) = (hex(light), hex(dark));
        format!("[fill=\"{light}\"]{{fill:{dark}}}[stroke=\"{light}\"]{{stroke:{dark}}}\n")
    };
    let rules: String = ON_DARK.into_iter().map(rule).collect();
    format!("<style>@media (prefers-color-scheme: dark) {{\n{rules}}}</style>\n")
}

/// The same picture as a PNG file; nothing of the machine's fonts is used.
pub fn png(svg: &str) -> Result<Vec<u8>> {
    let mut options = usvg::Options::default();
    options.fontdb_mut().load_font_data(dejavu::sans::regular().to_vec());
    options.fontdb_mut().set_sans_serif_family("DejaVu Sans");
    let tree = usvg::Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size().scale_by(DENSITY).context("a picture without size")?;
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height()).context("a picture without size")?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(DENSITY, DENSITY), &mut pixels.as_mut());
    Ok(pixels.encode_png()?)
}

fn draw(chart: &Chart, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let [width, height] = chart.size.map(|side| side * FINE as u32);
    let root = SVGBackend::with_string(text, (width, height)).into_drawing_area();
    root.fill(&PAPER)?;
    let rows = chart.panels.len().div_ceil(chart.columns);
    let high = height as i32 - caption_height(chart) * FINE;
    let (panels, caption) = root.split_vertically(high);
    for (panel, area) in chart.panels.iter().zip(panels.split_evenly((rows, chart.columns))) {
        draw_panel(panel, &area, &root)?;
    }
    for (i, line) in chart.caption.iter().enumerate() {
        let at = (2 * EDGE * FINE, (i as i32 * CAPTION_LINE + EDGE) * FINE);
        caption.draw_text(line, &font(TEXT - 1, BLACK), at)?;
    }
    Ok(root.present()?)
}

/// What the caption takes of a chart's height, in pixels of the screen.
pub fn caption_height(chart: &Chart) -> i32 {
    let lines = chart.caption.len() as i32;
    if lines == 0 { 0 } else { lines * CAPTION_LINE + 2 * EDGE }
}

fn draw_panel<'b>(panel: &Panel, area: &Area<'b>, root: &Area<'b>) -> Result<(), Box<dyn std::error::Error>> {
    let mut plane = ChartBuilder::on(area)
        .margin_top(TOP * FINE)
        .margin_left(EDGE * FINE)
        .margin_bottom(EDGE * FINE)
        .margin_right(RIGHT * FINE)
        .x_label_area_size(BOTTOM * FINE)
        .y_label_area_size(LEFT * FINE)
        .build_cartesian_2d(panel.x.range.clone(), panel.y.range.clone())?;
    plane
        .configure_mesh()
        .disable_axes()
        .light_line_style(PAPER.mix(0.0))
        .bold_line_style(pen(GRID, 1))
        .draw()?;
    for series in &panel.series {
        draw_series(&mut plane, series)?;
    }
    draw_axes(&mut plane, panel)?;
    for note in &panel.notes {
        draw_note(&plane, note, root)?;
    }
    draw_key(panel, area)
}

fn draw_axes(plane: &mut Plane, panel: &Panel) -> Result<(), Box<dyn std::error::Error>> {
    plane
        .configure_mesh()
        .disable_mesh()
        .axis_style(pen(GREY, 1))
        .set_all_tick_mark_size(4 * FINE)
        .label_style(font(TEXT - 1, BLACK))
        .axis_desc_style(font(TEXT, BLACK))
        .x_desc(panel.x.label)
        .y_desc(panel.y.label)
        .x_label_formatter(&|value| number(*value, panel.x.decimals))
        .y_label_formatter(&|value| number(*value, panel.y.decimals))
        .draw()?;
    Ok(())
}

fn draw_series(plane: &mut Plane, series: &Series) -> Result<(), Box<dyn std::error::Error>> {
    let points = series.points.iter().map(|[x, y]| (*x, *y));
    let colour = series.colour;
    match series.look {
        Look::Line => plane.draw_series(LineSeries::new(points, pen(colour, LINE)))?,
        Look::Thin => plane.draw_series(LineSeries::new(points, pen(colour, 1)))?,
        Look::Pieces => {
            let points: Vec<_> = points.collect();
            let piece = |piece: &[(f64, f64)]| PathElement::new(piece.to_vec(), pen(colour, 2));
            plane.draw_series(points.chunks_exact(2).map(piece))?
        }
        Look::Dashed => {
            plane.draw_series(DashedLineSeries::new(points, DASH * FINE, GAP * FINE, pen(colour, 1)))?
        }
        Look::Dots => plane.draw_series(points.map(|at| Circle::new(at, DOT * FINE, colour.filled())))?,
        Look::Rings => plane.draw_series(points.map(|at| Circle::new(at, RING * FINE, pen(colour, 2))))?,
        Look::Crosses => plane.draw_series(points.map(|at| Cross::new(at, RING * FINE, pen(colour, 2))))?,
        Look::Triangles => {
            plane.draw_series(points.map(|at| TriangleMarker::new(at, (DOT + 1) * FINE, colour.filled())))?
        }
        Look::Region => {
            let corners: Vec<_> = points.collect();
            let outline: Vec<_> = corners.iter().chain(corners.first()).copied().collect();
            plane.draw_series([Polygon::new(corners, colour.mix(TINT).filled())])?;
            plane.draw_series([PathElement::new(outline, pen(colour, 2))])?
        }
    };
    Ok(())
}

fn draw_note(plane: &Plane, note: &Note, root: &Area) -> Result<(), Box<dyn std::error::Error>> {
    let (x, y) = plane.backend_coord(&(note.at[0], note.at[1]));
    let gap = 6 * FINE;
    let (at, anchor) = match note.side {
        Side::Right => ((x + gap, y), Pos::new(HPos::Left, VPos::Center)),
        Side::Above => ((x, y - gap), Pos::new(HPos::Center, VPos::Bottom)),
        Side::Below => ((x, y + gap), Pos::new(HPos::Center, VPos::Top)),
    };
    root.draw_text(&note.text, &font(TEXT - 1, note.colour).pos(anchor), at)?;
    Ok(())
}

/// The panel's title, and up to the right end the series that are to be named, each behind a piece of it.
fn draw_key(panel: &Panel, area: &Area) -> Result<(), Box<dyn std::error::Error>> {
    let y = TOP * FINE / 2;
    let left = Pos::new(HPos::Left, VPos::Center);
    area.draw_text(&panel.title, &font(TEXT, BLACK).pos(left), ((EDGE + LEFT) * FINE, y))?;
    let mut x = area.dim_in_pixel().0 as i32 - RIGHT * FINE;
    for series in panel.series.iter().rev().filter(|series| series.in_key) {
        x -= width(&series.name);
        area.draw_text(&series.name, &font(TEXT - 1, BLACK).pos(left), (x, y))?;
        x -= (PIECE + DOT) * FINE;
        draw_piece(series, area, (x, y))?;
        x -= 4 * DOT * FINE;
    }
    Ok(())
}

/// What a series looks like, with its left end at `(x, y)`.
fn draw_piece(series: &Series, area: &Area, (x, y): (i32, i32)) -> Result<(), Box<dyn std::error::Error>> {
    let colour = series.colour;
    let line = |from: i32, length: i32, width: i32| {
        PathElement::new(vec![(x + from * FINE, y), (x + (from + length) * FINE, y)], pen(colour, width))
    };
    match series.look {
        Look::Line => area.draw(&line(0, PIECE, LINE))?,
        Look::Thin | Look::Pieces => area.draw(&line(0, PIECE, 1))?,
        Look::Dashed => {
            for dash in 0..2 {
                area.draw(&line(dash * (DASH + GAP), DASH, 1))?;
            }
        }
        Look::Dots => area.draw(&Circle::new((x + PIECE * FINE / 2, y), DOT * FINE, colour.filled()))?,
        Look::Rings => area.draw(&Circle::new((x + PIECE * FINE / 2, y), RING * FINE, pen(colour, 2)))?,
        Look::Crosses => area.draw(&Cross::new((x + PIECE * FINE / 2, y), RING * FINE, pen(colour, 2)))?,
        Look::Triangles => {
            area.draw(&TriangleMarker::new((x + PIECE * FINE / 2, y), (DOT + 1) * FINE, colour.filled()))?
        }
        Look::Region => {
            let (right, low, high) = (x + PIECE * FINE, y + 6 * FINE, y - 6 * FINE);
            let outline = vec![(x, low), (right, low), (right, high), (x, high), (x, low)];
            area.draw(&Polygon::new(outline.clone(), colour.mix(TINT).filled()))?;
            area.draw(&PathElement::new(outline, pen(colour, 2)))?;
        }
    }
    Ok(())
}

/// About the width of a text of the key in DejaVu Sans.
fn width(text: &str) -> i32 {
    text.chars().count() as i32 * (TEXT - 1) * FINE / 2
}

fn font<'a>(size: i32, colour: RGBColor) -> TextStyle<'a> {
    ("sans-serif", size * FINE).into_font().color(&colour)
}

fn pen(colour: RGBColor, width: i32) -> ShapeStyle {
    colour.stroke_width((width * FINE * 3 / 4) as u32)
}

/// Never -0.
fn number(value: f64, decimals: usize) -> String {
    let unit = 10f64.powi(decimals as i32);
    format!("{:.decimals$}", (value * unit).round() / unit + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only the font that comes with the program is there to paint with.
    #[test]
    fn every_character_of_the_figures_is_painted() {
        let (blank, unknown) = (painted(""), painted("\u{e123}"));
        for character in "Z_M ωₙ² ẍ₀ ξ = (m) −0.5".chars().filter(|c| !c.is_whitespace()) {
            let made = painted(&character.to_string());
            assert!(made != blank && made != unknown, "{character}");
        }
    }

    fn painted(text: &str) -> Vec<u8> {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"40\">\
             <text x=\"10\" y=\"30\" font-family=\"sans-serif\" font-size=\"20\">{text}</text></svg>"
        );
        png(&svg).expect("a picture")
    }
}
