//! Figs. 8 and 9: the experiment of Section VII, on a plant with the imperfections of a rig.

use anyhow::Result;
use cable_robot::robot::triangles::SIX;

use super::Made;
use super::chart::{BLACK, COLOURS, Chart, Look, Panel, Series};
use super::manoeuvre::simulated;
use super::run::{Run, run};
use crate::command::simulate::source;

/// The bundled scenario, whose force loop is closed, and the same with it open.
fn measured() -> Result<[Run; 2]> {
    let closed = source::named("experiment", &[])?;
    let mut open = closed.clone();
    open.controller.force_loop = false;
    Ok([run(&closed)?, run(&open)?])
}

/// x and y, with the loop closed on the left and open on the right.
pub fn figure_8() -> Result<Made> {
    let (runs, simulated) = (measured()?, simulated()?);
    let titles = [["x, loop closed", "x, loop open"], ["y, loop closed", "y, loop open"]];
    let mut panels = vec![];
    for (k, label) in ["x (m)", "y (m)"].into_iter().enumerate() {
        for (title, run) in titles[k].into_iter().zip(&runs) {
            let mut panel = Panel::over_time(title, label, run.duration, 0.18, 2);
            panel
                .series
                .push(Series::new("Fig. 5", Look::Thin, COLOURS[1], simulated.coordinate(k)).in_key());
            panel.series.push(Series::new("set point", Look::Dashed, BLACK, run.set_point(k)).in_key());
            panel.series.push(Series::new("position", Look::Line, COLOURS[0], run.coordinate(k)).in_key());
            panels.push(panel);
        }
    }
    let [closed, open] = &runs;
    let mut findings = closed.set_point_lines();
    findings.push(closed.arrival_text());
    findings.push(format!("{}, {} from Fig. 5 at most", rest_text(closed), apart_text(closed, &simulated)));
    findings.push(format!("loop open: {} set point(s), {}", open.set_points.len() - 1, open.arrival_text()));
    findings.push(format!("loop open: {}", rest_text(open)));
    Ok(Made { chart: Chart { size: [1080, 620], columns: 2, panels, caption: vec![] }, findings })
}

/// Where the robot is at the end, seen from its set point.
fn rest_text(run: &Run) -> String {
    let set_point = run.set_points[run.set_points.len() - 1].position;
    let pose = run.last().pose;
    let off: f64 = (0..3).map(|k| (pose.0[k] - set_point[k]).powi(2)).sum();
    let turned = pose.angles().amax();
    format!("at the end {:.2} mm and {:.1} mrad from the set point", off.sqrt() * 1e3, turned * 1e3)
}

/// The greatest distance from another run at the same time.
fn apart_text(run: &Run, other: &Run) -> String {
    let distances =
        run.samples.iter().zip(&other.samples).map(|(a, b)| (a.pose.position() - b.pose.position()).norm());
    format!("{:.1} mm", distances.fold(0.0, f64::max) * 1e3)
}

/// The tensions as the load cells see them.
pub fn figure_9() -> Result<Made> {
    let (runs, simulated) = (measured()?, simulated()?);
    let mut panels = vec![];
    for (title, run) in ["force loop closed", "force loop open"].into_iter().zip(&runs) {
        let mut panel = Panel::over_time(title, "tension (N)", run.duration, 22.0, 0);
        for i in 0..SIX {
            panel.push_cable(i, Look::Thin, run.tension(i));
        }
        panel.series.push(Series::new("u5 of Fig. 6", Look::Dashed, BLACK, simulated.tension(4)).in_key());
        panels.push(panel);
    }
    let [closed, open] = &runs;
    let findings = vec![
        format!("loop closed: {}", closed.smallest_text()),
        format!("loop open: {}", open.smallest_text()),
    ];
    Ok(Made { chart: Chart { size: [980, 660], columns: 1, panels, caption: vec![] }, findings })
}
