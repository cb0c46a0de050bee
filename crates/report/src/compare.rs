//! Two runs of one rig in one page: what came of each, side by side and over one another.

use quick_xml::escape::escape;
use thiserror::Error;

use super::data::Data;
use super::digest::Digest;
use super::facts::{facts, slack_in_words};
use super::history::History;
use super::page::{disturbed_key, kept_key, page, state_key};
use super::{Summary, TableError};
use cable_robot::plan::Status;
use cable_robot::robot::Rig;

const TEMPLATE: &str = include_str!("page/compare.html");
const SCRIPT: &str = include_str!("page/compare.js");

/// Two runs that cannot be compared.
#[derive(Debug, Error)]
pub enum CompareError {
    /// Their tensions would say nothing of one another.
    #[error(
        "the runs are of different rigs: {difference}; runs are compared that have the cables, the mass, the inertia and the gravity of \
         one rig"
    )]
    Rigs {
        /// The first difference: what, and its value in either run.
        difference: String,
    },
    /// A column that is needed is not there.
    #[error("run.csv: {0}")]
    Csv(#[from] TableError),
}

/// What a run says of one thing, and whether that is bad.
type Said = (String, bool);

/// Both runs in one HTML file that stands alone, as [`html`](super::html) makes it of one.
///
/// # Errors
/// [`CompareError`].
pub fn compare(runs: [&Digest; 2]) -> Result<String, CompareError> {
    let [a, b] = runs.map(|run| &run.folder.info.plant_parameters.rig);
    if let Some(difference) = difference(a, b) {
        return Err(CompareError::Rigs { difference });
    }
    let histories = [History::of(runs[0])?, History::of(runs[1])?];
    let data = [0, 1].map(|k| Data::new(runs[k], &histories[k]));
    let [a, b] = [0, 1].map(|k| facts(runs[k], &histories[k]));
    let (differences, same) = differences(&a, &b);
    let [title_a, title_b] = runs.map(|run| escape(&run.folder.info.title).into_owned());
    let places = [
        ("title_a", title_a),
        ("title_b", title_b),
        ("results", results(&histories, runs)),
        ("differences", differences),
        ("disturbed_key", disturbed_key(histories.each_ref()).to_owned()),
        ("state_key", state_key(runs).to_owned()),
        ("kept_key", kept_key(histories.each_ref())),
        ("same", escape(same.join(", ")).into_owned()),
        ("drawn", drawn(&data, runs)),
    ];
    Ok(page(TEMPLATE, SCRIPT, &data, &places))
}

/// The first thing that two rigs do not share; limits of tension and what is known of errors may differ.
fn difference(a: &Rig, b: &Rig) -> Option<String> {
    let [cables_a, cables_b] = [a, b].map(|rig| rig.cables.len());
    if cables_a != cables_b {
        return Some(format!("A has {cables_a} cables, B {cables_b}"));
    }
    if a.mass != b.mass {
        return Some(format!("mass = {} kg in A, {} kg in B", a.mass, b.mass));
    }
    if a.gravity != b.gravity {
        return Some(format!(
            "gravity = {:?} m/s² in A, {:?} in B",
            a.gravity.as_slice(),
            b.gravity.as_slice()
        ));
    }
    if a.inertia != b.inertia {
        return Some(format!(
            "inertia = {:?} kg m² in A, {:?} in B",
            a.inertia.as_slice(),
            b.inertia.as_slice()
        ));
    }
    a.cables.iter().zip(&b.cables).enumerate().find_map(|(i, (a, b))| {
        let ends = [("anchor", a.anchor, b.anchor), ("attachment", a.attachment, b.attachment)];
        let moved = ends.into_iter().find(|(_, a, b)| a != b).map(|(end, a, b)| {
            format!("cable {}: {end} = {:?} m in A, {:?} in B", i + 1, a.as_slice(), b.as_slice())
        });
        moved.or_else(|| (a.pulley != b.pulley).then(|| format!("cable {}: the pulleys differ", i + 1)))
    })
}

/// What people compare first.
const RESULTS: [&str; 6] = [
    "At the goal",
    "Smallest tension",
    "Greatest tension",
    "Slack cables",
    "Set points",
    "Status at the end",
];

/// Rows of [`RESULTS`].
fn results(histories: &[History; 2], runs: [&Digest; 2]) -> String {
    let [a, b] = [0, 1].map(|k| came_of(&histories[k], &runs[k].summary));
    RESULTS.iter().zip(a.iter().zip(&b)).map(|(name, both)| row(name, both.0, both.1)).collect()
}

/// In the order of [`RESULTS`].
fn came_of(history: &History, summary: &Summary) -> [Said; 6] {
    let reached = summary.time_to_goal.map(|time| format!("after {time:.3} s"));
    let smallest = summary.smallest_tension;
    let greatest = history.run.tension.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let status = history.last_status();
    let is_bad = |status: Status| status == Status::GoalUnreachable || status.lacks_pose();
    [
        (reached.clone().unwrap_or_else(|| "not reached".to_owned()), reached.is_none()),
        (
            smallest.map_or_else(String::new, |smallest| smallest.to_string()),
            smallest.is_some_and(|smallest| smallest.value <= 0.0),
        ),
        (format!("{greatest:.3} N"), false),
        (slack_in_words(&summary.slack), !summary.slack.is_empty()),
        ((history.set_point_rows().len() - 1).to_string(), false),
        (status.map_or("unknown".into(), Status::in_words).into_owned(), status.is_some_and(is_bad)),
    ]
}

fn row(name: &str, a: &Said, b: &Said) -> String {
    let cell = |(said, is_bad): &Said| {
        let class = if *is_bad { " class=\"bad\"" } else { "" };
        format!("<td{class}>{}</td>", escape(said))
    };
    format!("<tr><th scope=\"row\">{}</th>{}{}</tr>\n", escape(name), cell(a), cell(b))
}

/// Rows of the facts that differ, the lines of one name together, and the names of the others.
fn differences<'a>(a: &[(&'a str, String)], b: &[(&'a str, String)]) -> (String, Vec<&'a str>) {
    let mut names: Vec<&str> = vec![];
    for (name, _) in a.iter().chain(b) {
        if !names.contains(name) && !RESULTS.contains(name) {
            names.push(name);
        }
    }
    let said = |facts: &[(&str, String)], name: &str| {
        let lines: Vec<_> = facts.iter().filter(|(n, _)| *n == name).map(|(_, said)| said.as_str()).collect();
        (lines.join("; "), false)
    };
    let (same, differ): (Vec<_>, Vec<_>) = names.into_iter().partition(|name| said(a, name) == said(b, name));
    (differ.into_iter().map(|name| row(name, &said(a, name), &said(b, name))).collect(), same)
}

fn drawn([a, b]: &[Data; 2], runs: [&Digest; 2]) -> String {
    let [of_a, of_b] = runs.map(|run| run.rows);
    format!("Drawn are of A {} of {of_a} rows, of B {} of {of_b} rows.", a.rows(), b.rows())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::run;
    use cable_robot::plan::PlannerKind;
    use cable_robot::robot::PerCable;

    #[test]
    fn two_planners_stand_side_by_side_in_one_page_that_stands_alone() {
        let [a, b] = [PlannerKind::Bounded, PlannerKind::MinimumTime].map(|planner| run(planner, 2.0, 0.0));
        let digests = [&a, &b].map(|run| Digest::of(run).unwrap());
        let page = compare(digests.each_ref()).unwrap();
        assert!(!page.contains("{{") && page.matches("</script>").count() == 3);
        let (fast, smallest) = {
            let summary = b.run().unwrap().summary();
            (summary.time_to_goal.unwrap(), summary.smallest_tension.unwrap())
        };
        assert!(page.contains(&format!("<td class=\"bad\">not reached</td><td>after {fast:.3} s</td>")));
        assert!(page.contains(&format!("<td>{smallest}</td></tr>")));
        assert!(page.contains("<th scope=\"row\">Planner</th><td>Bounded"));
        assert!(page.contains("The same in both: Controller, Plant, Rig, Robot, Law,"));
        assert!(!page.contains("<th scope=\"row\">Rig</th>"), "what is the same is not listed");
        assert!(page.contains("the plan keeps 0.100 N from them, or more"), "of B; A keeps nothing");
        assert!(!page.contains("class=\"disturbed-span\""), "nothing was, and the key says nothing of it");
    }

    #[test]
    fn other_rigs_are_refused_with_what_differs() {
        let a = run(PlannerKind::Bounded, 0.01, 0.0);
        let said = |change: fn(&mut Rig)| {
            let mut b = a.clone();
            change(&mut b.info.plant_parameters.rig);
            let digests = [&a, &b].map(|run| Digest::of(run).unwrap());
            compare(digests.each_ref()).map_err(|error| error.to_string())
        };
        let differ = |change, what: &str| {
            let said = said(change).unwrap_err();
            assert!(said.starts_with(&format!("the runs are of different rigs: {what}; ")), "{said}");
        };
        differ(|rig| rig.mass = 5.0, "mass = 6 kg in A, 5 kg in B");
        differ(|rig| rig.cables = PerCable::from_slice(&rig.cables[..5]).unwrap(), "A has 6 cables, B 5");
        differ(
            |rig| rig.cables[2].attachment = [0.0, 0.5, 0.25].into(),
            &format!(
                "cable 3: attachment = {:?} m in A, [0.0, 0.5, 0.25] in B",
                a.info.plant_parameters.rig.cables[2].attachment.as_slice()
            ),
        );
        assert!(said(|rig| rig.cables[2].limits.max = 7.0).is_ok(), "limits are what one may compare");
    }
}
