//! The page: texts, tables, style, scripts and data in one file that fetches nothing.

use std::fmt::Display;

use quick_xml::escape::escape;

use super::data::Data;
use super::history::History;
use super::run_folder::Model;
use super::{RunFolder, Summary, TableError};
use crate::plan::{PlannerKind, PoseSource};
use crate::robot::{CABLES, Pose};

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPTS: [&str; 4] = [
    include_str!("page/scene.js"),
    include_str!("page/plane.js"),
    include_str!("page/charts.js"),
    include_str!("page/page.js"),
];
const UPLOT: &str = include_str!("page/uplot/uPlot.iife.min.js");
const UPLOT_LICENCE: &str = include_str!("page/uplot/LICENSE");
const UPLOT_STYLE: &str = include_str!("page/uplot/uPlot.min.css");

/// The report of a run: one HTML file that stands alone. It draws some of the rows, extremes among them; the CSV file has all.
///
/// # Errors
/// [`TableError::Missing`]: a column that is needed is not there.
pub fn html(folder: &RunFolder) -> Result<String, TableError> {
    let history = History::new(folder)?;
    let summary = history.run.summary();
    let data = Data::new(&history);
    let turned = history.set_point.iter().any(|pose| pose.angles().amax() > 5e-5);
    let places = [
        ("title", escape(&folder.info.title).into_owned()),
        ("verdict", verdict(&history, &summary)),
        ("facts", table(&facts(&history, &summary))),
        ("set_points", set_points(&history, turned)),
        ("angle_heads", angle_heads(turned).to_owned()),
        ("domain_key", domain_key(&history).to_owned()),
        ("p_source", p_source(&history).to_owned()),
        ("limits", limits(&history)),
        ("drawn", drawn(data.rows(), history.len())),
        ("uplot_css", UPLOT_STYLE.to_owned()),
        ("css", STYLE.to_owned()),
        ("data", script_safe(&serde_json::to_string(&data).unwrap_or_default())),
        ("uplot_licence", UPLOT_LICENCE.to_owned()),
        ("uplot_js", UPLOT.to_owned()),
        ("js", SCRIPTS.concat()),
    ];
    Ok(filled(TEMPLATE, &places))
}

/// The template with each `{{name}}` replaced; what is put in is not looked at again.
fn filled(template: &str, places: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut page = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").unwrap_or((part, ""));
        if let Some((_, text)) = places.iter().find(|(place, _)| *place == name) {
            page += text;
        }
        page += rest;
    }
    page
}

/// JSON in which no `</script>` can end the element that it lies in.
fn script_safe(json: &str) -> String {
    json.replace('<', "\\u003c")
}

/// What came of the run, in a few words each; what is bad is marked.
fn verdict(history: &History, summary: &Summary) -> String {
    let item = |bad: bool, name: &str, value: &dyn Display| {
        let class = if bad { " class=\"bad\"" } else { "" };
        format!("<li{class}>{name} <b>{}</b></li>\n", escape(value.to_string()))
    };
    let mut list = String::new();
    let goals = history.goals();
    let reached = goals.iter().filter(|(_, time)| time.is_some()).count();
    list += &match goals.as_slice() {
        [(_, Some(time))] => item(false, "at the goal after", &format!("{time:.3} s")),
        [(_, None)] => item(true, "goal", &"not reached"),
        many => item(reached < many.len(), "goals reached", &format!("{reached} of {}", many.len())),
    };
    if let Some(smallest) = summary.smallest_tension {
        list += &item(smallest.value <= 0.0, "smallest tension", &smallest);
    }
    list += &match summary.slack {
        Some((cable, time)) => item(true, "slack", &format!("cable {cable}, first at {time:.3} s")),
        None => item(false, "slack cables", &"none"),
    };
    let steps = history.set_point_rows().len() - 1;
    list + &item(false, "set points", &steps)
}

/// What was run and with what, and what came of it.
fn facts(history: &History, summary: &Summary) -> Vec<(&'static str, String)> {
    let info = history.info;
    let (controller, plant) = (&info.controller_parameters, &info.plant_parameters);
    let (robot, gains) = (&plant.robot, controller.gains());
    let planner = match controller.planner {
        PlannerKind::Bounded => "reachable domain (15)",
        PlannerKind::Exact => "exact domain",
    };
    let source = match controller.pose_source {
        PoseSource::EncoderPose => "the encoders' pose",
        PoseSource::CableLengths => "the cable lengths",
    };
    let ends = |column: &[f64]| (column[0], column[column.len() - 1]);
    let (start, end) = ends(&history.run.times);
    let mut facts = vec![
        ("Controller", model(&info.controller)),
        ("Plant", model(&info.plant)),
        ("Rig", info.rig.clone()),
        (
            "Robot",
            format!(
                "a = {} m, b = {} m, m = {} kg, I = ({}, {}, {}) kg m², g = {} m/s²",
                robot.a, robot.b, robot.m, robot.i1, robot.i2, robot.i3, robot.g
            ),
        ),
        (
            "Law (4)",
            format!(
                "λ = {} 1/s, η = {} 1/s: ω = {:.3} 1/s, ξ = {:.3}; reads {source}; load-cell force loop {}",
                gains.lambda,
                gains.eta,
                gains.omega_n(),
                gains.xi(),
                if controller.force_loop { "closed" } else { "open" }
            ),
        ),
        (
            "Planner",
            format!("{planner}, T_s = {} s, N = {}", controller.planner_period, controller.bisection_steps),
        ),
        ("Tension limits", format!("{} to {} N", controller.min_tension, controller.max_tension)),
        (
            "Imperfections",
            format!(
                "friction {} N, motor lag {} s, encoder resolution {} m, load-cell noise {} N (seed {})",
                plant.friction,
                plant.motor_lag,
                plant.encoder_resolution,
                plant.load_cell_noise,
                plant.noise_seed
            ),
        ),
        (
            "Disturbance",
            match history.disturbance {
                [0.0, 0.0] => "none".to_owned(),
                [force, torque] => format!("up to {force:.3} N and {torque:.3} N m"),
            },
        ),
        ("Time", format!("{start} to {end} s in steps of {} s, {} rows", info.step, history.len())),
        ("Written by", format!("cable-robot {}", info.program_version)),
    ];
    if let Some(scenario) = &info.scenario {
        facts.insert(0, ("Scenario", scenario.clone()));
    }
    let smallest = summary.smallest_tension.map_or("none recorded".to_owned(), |s| s.to_string());
    let last = history.len() - 1;
    let missed = history.pose[last].minus(&history.goal[last]);
    facts.extend(history.goals().iter().map(|goal| ("Goal", arrival(history, goal))));
    facts.extend([
        ("Smallest tension", smallest),
        ("Slack cables", slack(history)),
        ("From the goal at the end", format!("{:.4} m", missed.fixed_rows::<3>(0).norm())),
    ]);
    facts
}

fn model(model: &Model) -> String {
    match model {
        Model::Library => "the library's own".to_owned(),
        Model::Rig => "a rig with drives and load cells".to_owned(),
        Model::Fmu { path, name, fmi_version } => {
            format!("{name}, FMI {fmi_version}, {}", path.display())
        }
    }
}

/// When a goal was given and how long the robot took.
fn arrival(history: &History, (row, reached): &(usize, Option<f64>)) -> String {
    let given = history.run.times[*row];
    let after = reached.map_or("not reached".to_owned(), |time| format!("reached after {time:.3} s"));
    format!("{} given at {given:.3} s: {after}", pose(&history.goal[*row]))
}

/// Position in m, and angles in rad if there are any.
fn pose(pose: &Pose) -> String {
    let [p, angles] = [pose.position(), pose.angles()].map(|v| format!("({}, {}, {})", v.x, v.y, v.z));
    if pose.angles().amax() == 0.0 { format!("{p} m") } else { format!("{p} m, turned {angles} rad") }
}

/// Each slack cable with its first time and for how long.
fn slack(history: &History) -> String {
    let times = &history.run.times;
    let of = |i: usize| {
        let column = &history.run.slack[i];
        let first = column.iter().position(|value| *value != 0.0)?;
        let total: f64 =
            (1..times.len()).filter(|k| column[*k] != 0.0).map(|k| times[k] - times[k - 1]).sum();
        Some(format!("cable {} from {:.3} s, {total:.3} s in all", i + 1, times[first]))
    };
    let cables: Vec<_> = (0..CABLES).filter_map(of).collect();
    if cables.is_empty() { "none".to_owned() } else { cables.join("; ") }
}

fn domain_key(history: &History) -> &'static str {
    match history.info.controller_parameters.planner {
        PlannerKind::Bounded => "domain (15) that the active set point was chosen from",
        PlannerKind::Exact => "exact domain that the active set point was chosen from",
    }
}

fn p_source(history: &History) -> &'static str {
    if history.estimate.is_some() {
        "Its acceleration is the one that the law (5) demands of the recorded estimate."
    } else {
        "The controller tells no estimate, so it is found from the measured tensions."
    }
}

fn limits(history: &History) -> String {
    let controller = &history.info.controller_parameters;
    format!("{} and {} N", controller.min_tension, controller.max_tension)
}

fn drawn(drawn: usize, rows: usize) -> String {
    if drawn == rows {
        format!("All {rows} rows of run.csv are drawn.")
    } else {
        format!("{drawn} of the {rows} rows of run.csv are drawn, with the extremes of every curve.")
    }
}

/// Rows of name and value.
fn table(rows: &[(&str, String)]) -> String {
    rows.iter()
        .map(|(name, value)| {
            format!("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(*name), escape(value))
        })
        .collect()
}

fn angle_heads(turned: bool) -> &'static str {
    if turned {
        "<th scope=\"col\">roll (rad)</th><th scope=\"col\">pitch (rad)</th><th scope=\"col\">yaw (rad)</th>"
    } else {
        ""
    }
}

/// Rows of number, time and pose; angles if there are any.
fn set_points(history: &History, turned: bool) -> String {
    let row = |(i, row): (usize, &usize)| {
        let pose = &history.set_point[*row].0;
        let cells = pose.iter().take(if turned { 6 } else { 3 });
        let cells: String =
            cells.map(|value| format!("<td>{:.4}</td>", (value * 1e4).round() / 1e4 + 0.0)).collect();
        format!("<tr><td>{i}</td><td>{:.3}</td>{cells}</tr>\n", history.run.times[*row])
    };
    history.set_point_rows().iter().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::run;

    #[test]
    fn twenty_noisy_seconds_stay_small_and_stand_alone() {
        let page = html(&run(PlannerKind::Exact, 20.0, 0.5)).unwrap();
        assert!(page.len() < 6_000_000, "{} bytes", page.len());
        for fetched in ["src=", "@import", "url(", "<link rel=\"stylesheet"] {
            assert!(!page.contains(fetched), "{fetched}");
        }
        assert_eq!(page.matches("</script>").count(), 3, "no text ends a script");
        assert!(!page.contains("{{"), "every place is filled");
        assert!(page.contains("Copyright (c) 2022 Leon Sorokin"), "uPlot's licence goes with it");
    }

    #[test]
    fn text_is_escaped_and_results_are_there() {
        let page = html(&run(PlannerKind::Bounded, 8.0, 0.0)).unwrap();
        assert!(page.contains("<h1>A &amp; B &lt;/script&gt;</h1>"));
        assert!(page.contains("<li class=\"bad\">goals reached <b>1 of 2</b></li>"));
        assert!(page.contains("(0.1, 0.1, 1) m given at 0.000 s: reached after "));
        assert!(page.contains("(-0.1, 0.05, 1) m given at 6.001 s: not reached"));
        assert!(
            page.contains("<tr><td>1</td><td>0.001</td><td>0.0855</td><td>0.0855</td><td>1.0000</td></tr>")
        );
    }

    #[test]
    fn what_is_put_in_is_not_looked_at_again() {
        let places = [("a", "{{b}}".to_owned()), ("b", "no".to_owned())];
        assert_eq!(filled("<{{a}}>{{b}}", &places), "<{{b}}>no");
        assert_eq!(script_safe(r#"{"a":"</script>"}"#), r#"{"a":"\u003c/script>"}"#);
    }
}
