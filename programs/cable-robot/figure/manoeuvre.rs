//! Figs. 5 and 6: the simulation of Section VI.

use anyhow::Result;
use cable_robot::control::{Response, tensions};
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::triangles::SIX;
use cable_robot::robot::{Coordinates, PerCable, Pose};

use super::Made;
use super::chart::{BLACK, COLOURS, Chart, Look, Panel, Series};
use super::run::{GOAL, Run, drawn, run};
use crate::command::simulate::source;

/// x and y of the set points printed in Eq. (18), m.
pub const PRINTED: [[f64; 2]; 3] = [[0.09, 0.085], [0.13, 0.128], [0.15, 0.15]];

/// The move on a perfect rig.
pub fn simulated() -> Result<Run> {
    run(&source::named("paper", &[])?)
}

/// x and y with their set points, and the levels of those that the paper prints.
pub fn figure_5() -> Result<Made> {
    let run = simulated()?;
    let panels = [("x", "x (m)", 0), ("y", "y (m)", 1)].map(|(title, label, k)| {
        let mut panel = Panel::over_time(title, label, run.duration, 0.18, 2);
        for printed in PRINTED {
            let level = vec![[0.0, printed[k]], [run.duration, printed[k]]];
            panel.series.push(Series::new("set points of Eq. (18)", Look::Thin, COLOURS[1], level));
        }
        panel.series[0].in_key = true;
        panel.series.push(Series::new("set point", Look::Dashed, BLACK, run.set_point(k)).in_key());
        panel.series.push(Series::new("position", Look::Line, COLOURS[0], run.coordinate(k)).in_key());
        panel
    });
    let differences = PRINTED.iter().zip(&run.set_points[1..]).map(|(printed, set_point)| {
        let [x, y] = [0, 1].map(|k| set_point.position[k] - printed[k]);
        format!("({x:+.4}, {y:+.4})")
    });
    let differences: Vec<_> = differences.collect();
    let mut findings = run.set_point_lines();
    findings.push(run.arrival_text());
    findings.push(format!("set points 1 to 3 differ from those of Eq. (18) by {} m", differences.join(", ")));
    Ok(Made {
        chart: Chart { size: [980, 600], columns: 1, panels: panels.into(), caption: vec![] },
        findings,
    })
}

/// The six tensions, and cable 5 alone with what the closed-form responses ask for.
pub fn figure_6() -> Result<Made> {
    let run = simulated()?;
    let predicted: Vec<_> = run.samples.iter().map(|sample| predicted(&run, sample.time)).collect();
    let mut all = Panel::over_time("all cables", "tension (N)", run.duration, 22.0, 0);
    for i in 0..SIX {
        let points = run.samples.iter().zip(&predicted).map(|(sample, u)| [sample.time, u[i]]).collect();
        all.push_cable(i, Look::Line, run.tension(i));
        all.series.push(Series::new(format!("u{} predicted", i + 1), Look::Dashed, BLACK, drawn(points)));
    }
    let mut fifth = Panel::over_time("cable 5 alone", "tension (N)", run.duration, 11.0, 0);
    let [simulated, dashed] = [2 * 4, 2 * 4 + 1].map(|row| all.series[row].points.clone());
    fifth.series.push(Series::new("simulated", Look::Line, COLOURS[4], simulated).in_key());
    fifth.series.push(Series::new("predicted", Look::Dashed, BLACK, dashed).in_key());

    let differences = run
        .samples
        .iter()
        .zip(&predicted)
        .flat_map(|(sample, u)| (0..SIX).map(|i| (sample.tension[i] - u[i]).abs()));
    let at_goal = run.last().tension.iter().map(|u| format!("{u:.3}")).collect::<Vec<_>>().join(", ");
    let findings = vec![
        run.smallest_text(),
        format!("at the goal u1 to u6 are {at_goal} N"),
        format!(
            "simulated and predicted tensions differ by at most {:.3} N",
            differences.fold(0.0, f64::max)
        ),
    ];
    Ok(Made {
        chart: Chart { size: [980, 660], columns: 1, panels: vec![all, fifth], caption: vec![] },
        findings,
    })
}

/// Tensions of Eq. (1) along the response (12) from rest at one set point to the next, N. A set point acts after the instant at which
/// it is given.
fn predicted(run: &Run, time: f64) -> PerCable<f64> {
    let rig = ControllerParameters::default().rig;
    let active = run.set_points.iter().rposition(|s| s.time < time).unwrap_or(0);
    let (from, to) = (&run.set_points[active.saturating_sub(1)], &run.set_points[active]);
    let response = Response::at(&ControllerParameters::default().gains(), time - to.time);
    let [x, y] = [0, 1].map(|k| response.motion(from.position[k], 0.0, to.position[k]));
    let rates = |k: usize| Coordinates::new(x[k], y[k], 0.0, 0.0, 0.0, 0.0);
    let pose = Pose::at(x[0], y[0], GOAL[2]);
    tensions(&rig, &pose, &rates(1), &rates(2), 0.0).unwrap_or(PerCable::filled(SIX, f64::NAN))
}
