//! The three pictures: positions (Fig. 5), tensions (Fig. 6), the plane (Figs. 3 and 7).

use plotly::common::{Anchor, DashType, Fill, Line, LineShape, Marker, Mode, Orientation, Position};
use plotly::configuration::DisplayModeBar;
use plotly::layout::{Axis, HoverMode, Layout, Legend, Margin, RangeMode};
use plotly::{Configuration, Plot, Scatter};

use super::{Report, Run, Summary};

/// Okabe and Ito's colours, which the colour-blind tell apart, without yellow and black (lost on white, on dark).
const COLOURS: [&str; 6] = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9"];
/// Set points, borders: seen on white and on dark.
const GREY: &str = "#8a8f98";

/// At most about this many points are drawn of a line; the CSV file has them all.
const DRAWN: usize = 1_200;

/// x, y, z over time, each in an axis of its own, with its set point.
pub(super) fn positions(run: &Run) -> Plot {
    let mut plot = Plot::new();
    for (k, (name, axis)) in [("x", "y"), ("y", "y2"), ("z", "y3")].into_iter().enumerate() {
        let set_point =
            over_time(run, &run.set_point[k], "set point", GREY).show_legend(k == 0).legend_group("s");
        let set_point =
            set_point.line(Line::new().color(GREY).dash(DashType::Dash).shape(LineShape::Hv).width(1.5));
        plot.add_trace(set_point.y_axis(axis));
        plot.add_trace(over_time(run, &run.position[k], name, COLOURS[k]).y_axis(axis));
    }
    let axis = |k: usize, title: &str, domain: [f64; 2]| {
        Axis::new().title(title).domain(&domain).range(range(&run.position[k], &run.set_point[k]))
    };
    let layout = frame("time (s)", "y3")
        .y_axis(axis(0, "x (m)", [0.70, 1.0]))
        .y_axis2(axis(1, "y (m)", [0.35, 0.65]))
        .y_axis3(axis(2, "z (m)", [0.0, 0.30]));
    finish(plot, layout)
}

/// The six tensions over time, and below them the margin that the controller predicts.
pub(super) fn tensions(run: &Run) -> Plot {
    let mut plot = Plot::new();
    for (i, (tension, colour)) in run.tension.iter().zip(COLOURS).enumerate() {
        plot.add_trace(over_time(run, tension, &format!("u{}", i + 1), colour));
    }
    let margin = over_time(run, &run.tension_margin, "margin", GREY);
    plot.add_trace(margin.line(Line::new().color(GREY).shape(LineShape::Hv).width(2.0)).y_axis("y2"));
    let axis = |title: &str| Axis::new().title(title).range_mode(RangeMode::ToZero);
    let layout = frame("time (s)", "y2")
        .y_axis(axis("tension (N)").domain(&[0.34, 1.0]))
        .y_axis2(axis("margin (N)").domain(&[0.0, 0.28]));
    finish(plot, layout)
}

/// The plane: static workspace, reachable domains, path, set points.
pub(super) fn plane(report: &Report, summary: &Summary) -> Plot {
    let mut plot = Plot::new();
    let workspace = polygon(report.workspace, "static workspace");
    plot.add_trace(workspace.line(Line::new().color(GREY).dash(DashType::Dash)));
    for (i, domain) in report.domains.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let fill = polygon(domain, &format!("reachable from {i}")).fill(Fill::ToSelf);
        plot.add_trace(fill.fill_color(format!("{colour}22")).line(Line::new().color(colour).width(1.5)));
    }
    let rows = (0..report.run.times.len()).step_by(report.run.times.len().div_ceil(DRAWN).max(1));
    let [x, y] = [0, 1].map(|k| rows.clone().map(|row| rounded(report.run.position[k][row])).collect());
    plot.add_trace(
        Scatter::new(x, y).mode(Mode::Lines).name("path").line(Line::new().color(GREY).width(4.0)),
    );
    let points = &summary.set_points;
    let [x, y] = [0, 1].map(|k| points.iter().map(|point| rounded(point.position[k])).collect());
    let numbers = (0..points.len()).map(|i| i.to_string()).collect();
    // The last set points lie close together: every other number goes to the other side.
    let sides = [Position::TopLeft, Position::BottomRight].into_iter().cycle().take(points.len()).collect();
    let markers = Scatter::new(x, y).mode(Mode::MarkersText).name("set points").text_array(numbers);
    plot.add_trace(markers.text_position_array(sides).marker(Marker::new().color(COLOURS[4]).size(9)));
    let layout = frame("x (m)", "y").y_axis(Axis::new().title("y (m)").scale_anchor("x"));
    finish(plot, layout.hover_mode(HoverMode::Closest))
}

/// A line over time, thinned to what a screen can show.
fn over_time(run: &Run, values: &[f64], name: &str, colour: &'static str) -> Box<Scatter<f64, f64>> {
    let (times, values) = thinned(&run.times, values, DRAWN);
    Scatter::new(times, values).mode(Mode::Lines).name(name).line(Line::new().color(colour).width(2.0))
}

/// From the least to the greatest of both, at least 2 cm wide: what changes by less is at rest.
fn range(a: &[f64], b: &[f64]) -> Vec<f64> {
    let all = || a.iter().chain(b).copied().filter(|value| value.is_finite());
    let (least, greatest) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let half = (0.55 * (greatest - least)).max(0.01);
    let middle = 0.5 * (least + greatest);
    vec![middle - half, middle + half]
}

/// A closed outline.
fn polygon(vertices: &[[f64; 2]], name: &str) -> Box<Scatter<f64, f64>> {
    let closed = || vertices.iter().chain(vertices.first());
    let [x, y] = [0, 1].map(|k| closed().map(|vertex| rounded(vertex[k])).collect());
    Scatter::new(x, y).mode(Mode::Lines).name(name)
}

/// What the three layouts share. Colours of text and grid are the page's, see the template.
/// The axis of x stands below the axis `lowest` of y.
fn frame(x_title: &str, lowest: &str) -> Layout {
    Layout::new()
        .auto_size(true)
        .margin(Margin::new().left(64).right(12).top(8).bottom(48))
        .paper_background_color("rgba(0,0,0,0)")
        .plot_background_color("rgba(0,0,0,0)")
        .hover_mode(HoverMode::XUnified)
        .legend(Legend::new().orientation(Orientation::Horizontal).x(0.0).y(1.02).y_anchor(Anchor::Bottom))
        .x_axis(Axis::new().title(x_title).anchor(lowest))
}

fn finish(mut plot: Plot, layout: Layout) -> Plot {
    plot.set_layout(layout);
    // Dragging zooms and a double click goes back; the bar of buttons would hide the legend of a phone.
    plot.set_configuration(Configuration::new().responsive(true).display_mode_bar(DisplayModeBar::False));
    plot
}

/// Keeps the extremes: of each of `limit / 2` groups the smallest and the greatest sample, in the order of time.
fn thinned(times: &[f64], values: &[f64], limit: usize) -> (Vec<f64>, Vec<f64>) {
    if values.len() <= limit {
        return values.iter().zip(times).map(|(value, time)| (rounded(*time), rounded(*value))).unzip();
    }
    let group = values.len().div_ceil(limit / 2);
    let rows = (0..values.len()).step_by(group).flat_map(|start| {
        let rows = || start..values.len().min(start + group);
        let least = rows().min_by(|a, b| values[*a].total_cmp(&values[*b]));
        let greatest = rows().max_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut pair = [least.unwrap_or(start), greatest.unwrap_or(start)];
        pair.sort_unstable();
        pair
    });
    rows.map(|row| (rounded(times[row]), rounded(values[row]))).unzip()
}

/// To a millionth, which no screen shows and which keeps the file short.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes_and_the_order() {
        let times: Vec<f64> = (0..10_001).map(f64::from).collect();
        let mut values: Vec<f64> = times.iter().map(|t| (t / 1000.0).sin()).collect();
        (values[777], values[778]) = (-9.0, 9.0);
        let (t, v) = thinned(&times, &values, 100);
        assert!(v.len() <= 102, "{}", v.len());
        assert!(t.is_sorted(), "{t:?}");
        assert!(t.contains(&777.0) && v.contains(&-9.0) && t.contains(&778.0) && v.contains(&9.0));
    }

    #[test]
    fn short_lines_are_kept_whole() {
        assert_eq!(thinned(&[0.0, 1.0], &[2.0, 3.0], 100), (vec![0.0, 1.0], vec![2.0, 3.0]));
    }
}
