//! The page: texts, tables, style, scripts and data in one file that fetches nothing.

use std::fmt::Display;

use quick_xml::escape::escape;
use serde::Serialize;

use super::TableError;
use super::data::{Data, MANY, kept};
use super::digest::Digest;
use super::events::{Event, Kind};
use super::facts::{facts, first_of, limits};
use super::history::{Arrival, History};
use super::workspace::sections;
use cable_robot::plan::{PlannerKind, Status};

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// The bar at the bottom.
const TIME: &str = include_str!("page/time.html");
/// What pages of one run and of two share.
const SCRIPTS: [&str; 4] = [
    include_str!("page/scene.js"),
    include_str!("page/plane.js"),
    include_str!("page/charts.js"),
    include_str!("page/time.js"),
];
const SCRIPT: &str = include_str!("page/page.js");
const UPLOT: &str = include_str!("page/uplot/uPlot.iife.min.js");
const UPLOT_LICENCE: &str = include_str!("page/uplot/LICENSE");
const UPLOT_STYLE: &str = include_str!("page/uplot/uPlot.min.css");

/// The report of a run: one HTML file that stands alone. It draws some of the rows, extremes among them; the CSV file has all.
///
/// # Errors
/// [`TableError::Missing`]: a column that is needed is not there.
pub fn html(digest: &Digest) -> Result<String, TableError> {
    let history = History::of(digest)?;
    let info = &digest.folder.info;
    let mut data = Data::new(digest, &history);
    data.sections = sections(&history, &history.info.plant_parameters.rig);
    let turned = history.set_point.iter().any(|pose| pose.angles().amax() > 5e-5);
    let places = [
        ("title", escape(&info.title).into_owned()),
        ("verdict", verdict(&history, digest)),
        ("facts", table(&facts(digest, &history))),
        ("set_points", set_points(&history, turned)),
        ("more_set_points", more_set_points(&history)),
        ("angle_heads", angle_heads(turned).to_owned()),
        ("disturbed_key", disturbed_key([&history]).to_owned()),
        ("state_key", state_key([digest]).to_owned()),
        ("events", what_happened(&digest.events)),
        ("figure_5", of_the_paper("Fig. 5", &history)),
        ("figure_6", of_the_paper("Fig. 6", &history)),
        ("p_source", p_source(&history).to_owned()),
        ("predicted_by", predicted_by(&history).to_owned()),
        ("limits", limits(&info.controller_parameters.rig)),
        ("kept_key", kept_key([&history])),
        ("drawn", drawn(data.rows(), digest.rows)),
    ];
    Ok(page(TEMPLATE, SCRIPT, &data, &places))
}

/// A template filled with `places`, and with style, scripts and what they draw.
pub fn page(template: &str, script: &str, data: &impl Serialize, places: &[(&str, String)]) -> String {
    let shared = [
        ("time", TIME.to_owned()),
        ("uplot_css", UPLOT_STYLE.to_owned()),
        ("css", STYLE.to_owned()),
        ("data", script_safe(&serde_json::to_string(data).unwrap_or_default())),
        ("uplot_licence", UPLOT_LICENCE.to_owned()),
        ("uplot_js", UPLOT.to_owned()),
        ("js", SCRIPTS.concat() + script),
    ];
    filled(template, &[places, &shared].concat())
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

/// What the grey is, where there is any.
pub fn disturbed_key<const N: usize>(histories: [&History; N]) -> &'static str {
    if histories.iter().all(|history| history.disturbed_spans().is_empty()) {
        return "";
    }
    r#"<span><svg width="26" height="14" aria-hidden="true"><path class="disturbed-span" d="M1 1H25V13H1Z"/></svg>the platform is disturbed</span>"#
}

/// What the bands of states and faults are, where there are any.
pub fn state_key<const N: usize>(runs: [&Digest; N]) -> &'static str {
    if runs.iter().all(|run| run.events.is_empty() && run.unmeasured_spans.is_empty()) {
        return "";
    }
    r#"<span><svg width="26" height="14" aria-hidden="true"><path class="state-span" d="M1 1H25V13H1Z"/></svg>another state of the bridge</span>
    <span><svg width="26" height="14" aria-hidden="true"><path class="fault" d="M13 1V13"/></svg>a fault</span>
    <span><svg width="26" height="14" aria-hidden="true"><path class="unmeasured-span" d="M1 1H25V13H1Z"/></svg>the pose is not measured</span>"#
}

/// More events than these are counted only.
const MOST_EVENTS: usize = 200;

/// The panel of the events, where there are any.
fn what_happened(events: &[Event]) -> String {
    if events.is_empty() {
        return String::new();
    }
    let row = |event: &Event| {
        let class = if event.kind == Kind::Fault { " class=\"bad\"" } else { "" };
        format!(
            "<tr{class}><td>{:.3}</td><td>{}</td><td>{}</td></tr>\n",
            event.time,
            event.kind.name(),
            escape(&event.text)
        )
    };
    let rows: String = events.iter().take(MOST_EVENTS).map(row).collect();
    let more = if events.len() > MOST_EVENTS {
        format!(
            "<p class=\"help\">The first {MOST_EVENTS} of {} are listed; events.csv has all.</p>",
            events.len()
        )
    } else {
        String::new()
    };
    format!(
        r#"<section class="card" id="events" aria-labelledby="events-title">
  <h2 id="events-title">What happened</h2>
  <div class="scroll tall" tabindex="0" role="region" aria-label="What happened"><table>
  <thead><tr><th scope="col">at (s)</th><th scope="col">kind</th><th scope="col">what</th></tr></thead>
  <tbody>{rows}</tbody>
  </table></div>{more}
</section>"#
    )
}

/// What gives the tensions that were predicted.
fn predicted_by(history: &History) -> &'static str {
    match history.info.controller_parameters.planner {
        PlannerKind::Bounded | PlannerKind::Exact => "closed form",
        PlannerKind::MinimumTime => "of the motion planned",
    }
}

/// What the dotted limits are, where there are any.
pub fn kept_key<const N: usize>(histories: [&History; N]) -> String {
    let mut distances = histories.map(|history| kept(&history.info.controller_parameters)).to_vec();
    distances.retain(|&distance| distance > 0.0);
    distances.dedup();
    if distances.is_empty() {
        return String::new();
    }
    let distances: Vec<_> = distances.iter().map(|distance| format!("{distance:.3} N")).collect();
    format!(
        r#"<span><svg width="26" height="10" aria-hidden="true"><path class="kept" d="M1 5H25"/></svg>the plan keeps {} from them, or more</span>"#,
        distances.join(" and ")
    )
}

/// A name in the paper, where the run is of the paper's rig and planner.
fn of_the_paper(name: &str, history: &History) -> String {
    let planner = history.info.controller_parameters.planner;
    let is_so = history.paper.is_some() && planner == PlannerKind::Bounded;
    if is_so { format!(" <small>{name}</small>") } else { String::new() }
}

/// What came of the run, in a few words each; what is bad is marked.
fn verdict(history: &History, digest: &Digest) -> String {
    let summary = &digest.summary;
    let item = |bad: bool, name: &str, value: &dyn Display| {
        let class = if bad { " class=\"bad\"" } else { "" };
        format!("<li{class}>{name} <b>{}</b></li>\n", escape(value.to_string()))
    };
    let mut list = String::new();
    if let Some(fault) = digest.events.iter().find(|event| event.kind == Kind::Fault) {
        list += &item(true, &format!("fault at {:.3} s", fault.time), &fault.text);
    }
    let goals = history.goals();
    let count = |is: fn(&Arrival) -> bool| goals.iter().filter(|(_, arrival)| is(arrival)).count();
    let reached = count(|arrival| matches!(arrival, Arrival::After(_)));
    let replaced = count(|arrival| matches!(arrival, Arrival::Replaced(_)));
    list += &match goals.as_slice() {
        [] => item(false, "goal", &"the start, held"),
        [(_, Arrival::After(time))] => item(false, "at the goal after", &format!("{time:.3} s")),
        [_] => item(true, "goal", &"not reached"),
        many => {
            let also =
                if replaced == 0 { String::new() } else { format!(", {replaced} replaced on the way") };
            let text = format!("{reached} of {}{also}", many.len());
            item(reached + replaced < many.len(), "goals reached", &text)
        }
    };
    let refused = digest.events.iter().filter(|event| event.kind == Kind::Refused).count();
    if refused > 0 {
        list += &item(true, "goals refused", &refused);
    }
    if let Some(smallest) = summary.smallest_tension {
        list += &item(smallest.value <= 0.0, "smallest tension", &smallest);
    }
    let slack: Vec<_> = summary.slack.iter().map(|slack| slack.cable.to_string()).collect();
    list += &match slack.as_slice() {
        [] => item(false, "slack cables", &"none"),
        slack => item(true, "slack cables", &slack.join(", ")),
    };
    let steps = history.set_point_rows().len() - 1;
    list += &item(false, "set points", &steps);
    if let Some(status) = history.last_status() {
        let is_bad = status == Status::GoalUnreachable || status.lacks_pose();
        // What comes after the fault may have no rows.
        let is_faulted = digest.events.iter().any(|event| event.kind == Kind::Fault);
        let name = if is_faulted { "last status measured" } else { "status at the end" };
        list += &item(is_bad, name, &status.in_words());
    }
    list
}

fn p_source(history: &History) -> &'static str {
    if history.estimate.is_some() {
        "Its acceleration is the one that the law demands of the recorded estimate."
    } else {
        "The controller tells no estimate, so it is found from the measured tensions."
    }
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

fn more_set_points(history: &History) -> String {
    let count = history.set_point_rows().len();
    if count > MANY { first_of(MANY, count, "set points") } else { String::new() }
}

/// Rows of number, time and pose of the first [`MANY`]; angles if there are any.
fn set_points(history: &History, turned: bool) -> String {
    let row = |(i, row): (usize, &usize)| {
        let pose = &history.set_point[*row].0;
        let cells = pose.iter().take(if turned { 6 } else { 3 });
        let cells: String =
            cells.map(|value| format!("<td>{:.4}</td>", (value * 1e4).round() / 1e4 + 0.0)).collect();
        format!("<tr><td>{i}</td><td>{:.3}</td>{cells}</tr>\n", history.run.times[*row])
    };
    history.set_point_rows().iter().take(MANY).enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::run;
    use crate::{RunFolder, Table};
    use cable_robot::sim::Scenario;

    fn page_of(run: &RunFolder) -> String {
        html(&Digest::of(run).unwrap()).unwrap()
    }

    #[test]
    fn twenty_noisy_seconds_stay_small_and_stand_alone() {
        let page = page_of(&run(PlannerKind::Exact, 20.0, 0.5));
        assert!(page.len() < 6_000_000, "{} bytes", page.len());
        for fetched in ["src=", "@import", "url(", "<link rel=\"stylesheet"] {
            assert!(!page.contains(fetched), "{fetched}");
        }
        assert_eq!(page.matches("</script>").count(), 3, "no text ends a script");
        assert!(!page.contains("{{"), "every place is filled");
        assert!(page.contains("Copyright (c) 2022 Leon Sorokin"), "uPlot's licence goes with it");
    }

    /// The table with each value changed by its column's name, its row and itself.
    fn changed(table: &Table, change: impl Fn(&str, usize, f64) -> f64) -> Table {
        let mut changed = Table::new(table.names()[1..].iter().cloned());
        let columns: Vec<_> = table.names().iter().map(|name| (name, table.column(name).unwrap())).collect();
        for row in 0..table.rows() {
            let values: Vec<f64> =
                columns[1..].iter().map(|(name, column)| change(name, row, column[row])).collect();
            changed.push(columns[0].1[row], &values);
        }
        changed
    }

    #[test]
    fn a_set_point_and_a_goal_at_each_step_of_twenty_noisy_seconds_stay_small() {
        let mut folder = run(PlannerKind::Bounded, 20.0, 0.5);
        folder.table = changed(&folder.table, |name, row, value| match name {
            "controller.setPointIndex" => row as f64,
            "controller.setPoint.x" | "controller.goalPose.x" => 0.1 * (row as f64 / 3e3).sin(),
            _ => value,
        });
        let page = page_of(&folder);
        assert!(page.len() < 6_000_000, "{} bytes", page.len());
        assert!(page.contains("set points <b>20000</b>"));
        assert!(page.matches("<tr>").count() < 300, "{} rows of tables", page.matches("<tr>").count());
        assert!(page.contains("The first 100 of 20001 set points"));
        assert!(page.contains("The first 10 of 20001 goals"));
    }

    #[test]
    fn without_a_goal_none_was_reached_and_the_last_status_is_said() {
        let mut folder = crate::tests::record(&Scenario {
            title: "thrown".to_owned(),
            rig: String::new(),
            controller: Default::default(),
            plant: Default::default(),
            orbit: None,
            goals: vec![],
            disturbances: vec![],
            duration: 0.1,
            step: 0.01,
        });
        let page = page_of(&folder);
        assert!(page.contains("<li>goal <b>the start, held</b></li>"));
        assert!(page.contains("<li>status at the end <b>at the goal</b></li>"));
        assert!(!page.contains("at the goal after") && !page.contains(" given at "));
        assert!(page.contains("From the start at the end"));

        folder.table = changed(&folder.table, |name, row, value| match name {
            "controller.status" if row > 3 => f64::from(Status::SensorFault.number()),
            _ => value,
        });
        assert!(page_of(&folder).contains("<li class=\"bad\">status at the end <b>sensor fault</b></li>"));
    }

    #[test]
    fn text_is_escaped_and_results_are_there() {
        let page = page_of(&run(PlannerKind::Bounded, 8.0, 0.0));
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
