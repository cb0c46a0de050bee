//! What a person looks at: one HTML file of a run, which opens offline by double click.

mod closed_loop;
mod plots;
mod run;

pub use closed_loop::ClosedLoop;
pub use run::{Run, SetPoint, SmallestTension, Summary};

use plotly::Plot;
use quick_xml::escape::escape;

/// Everything that the report shows.
pub struct Report<'a> {
    /// What was run, in a line.
    pub title: &'a str,
    /// What was run and with what, as names and values; the results are added to it.
    pub settings: &'a [(String, String)],
    /// The run itself.
    pub run: &'a Run,
    /// Vertices of the static workspace in the plane, m.
    pub workspace: &'a [[f64; 2]],
    /// Vertices of the reachable domain at the start and at each set point, m.
    pub domains: &'a [Vec<[f64; 2]>],
}

impl Report<'_> {
    /// The whole file: text, data, style and the plotting script.
    pub fn html(&self) -> String {
        let summary = self.run.summary();
        let script = Plot::offline_js_sources();
        // The first of the two scripts is plotly.js; the second typesets formulae, of which there are none.
        let plotly_js = script.split_inclusive("</script>").next().unwrap_or_default();
        TEMPLATE
            .replace("{{title}}", &escape(self.title))
            .replace("{{facts}}", &table(&self.facts(&summary)))
            .replace("{{set_points}}", &set_points(&summary.set_points))
            .replace("{{positions}}", &plots::positions(self.run).to_inline_html(Some("positions")))
            .replace("{{tensions}}", &plots::tensions(self.run).to_inline_html(Some("tensions")))
            .replace("{{plane}}", &plots::plane(self, &summary).to_inline_html(Some("plane")))
            .replace("{{plotly_js}}", plotly_js)
    }

    fn facts(&self, summary: &Summary) -> Vec<(String, String)> {
        let smallest = summary.smallest_tension.map_or("none recorded".to_owned(), |s| s.to_string());
        let arrival = summary.time_to_goal.map_or("not reached".to_owned(), |t| format!("{t:.3} s"));
        let slack =
            summary.slack.map_or("none".to_owned(), |(cable, t)| format!("cable {cable}, first at {t:.3} s"));
        let results = [("Smallest tension", smallest), ("Time to goal", arrival), ("Slack cables", slack)];
        let results = results.into_iter().map(|(name, value)| (name.to_owned(), value));
        self.settings.iter().cloned().chain(results).collect()
    }
}

const TEMPLATE: &str = include_str!("template.html");

/// Rows of name and value.
fn table(rows: &[(String, String)]) -> String {
    rows.iter()
        .map(|(name, value)| format!("<tr><th>{}</th><td>{}</td></tr>\n", escape(name), escape(value)))
        .collect()
}

/// Rows of number, time and position.
fn set_points(points: &[SetPoint]) -> String {
    let row = |(i, p): (usize, &SetPoint)| {
        let [x, y, z] = p.position.map(|v| format!("{v:.4}"));
        format!("<tr><td>{i}</td><td>{:.3}</td><td>{x}</td><td>{y}</td><td>{z}</td></tr>\n", p.time)
    };
    points.iter().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coordinates move, cable 5 comes close to nothing, set point 1 comes at 0.5 s.
    pub(super) fn run(samples: usize) -> Run {
        let times: Vec<f64> = (0..samples).map(|k| k as f64 / 1000.0).collect();
        let along = |f: fn(f64) -> f64| times.iter().map(|t| f(*t)).collect::<Vec<_>>();
        Run {
            position: [along(|t| 0.01 * t), along(|t| 0.02 * t), along(|_| 1.0)],
            set_point: [along(|t| if t < 0.5 { 0.0 } else { 0.2 }), along(|_| 0.0), along(|_| 1.0)],
            set_point_index: along(|t| if t < 0.5 { 0.0 } else { 1.0 }),
            tension: std::array::from_fn(|i| {
                along(if i == 4 { |t| 1.0 + (t - 0.7) * (t - 0.7) } else { |t| 10.0 + t.sin() })
            }),
            slack: std::array::from_fn(|_| vec![0.0; samples]),
            tension_margin: along(|_| 1.0),
            at_goal: along(|t| f64::from(u8::from(t > 0.9))),
            times,
        }
    }

    fn html(run: &Run) -> String {
        let square = vec![[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]];
        let settings = [("Step".to_owned(), "1 ms <held>".to_owned())];
        Report {
            title: "A & B",
            settings: &settings,
            run,
            workspace: &square,
            domains: std::slice::from_ref(&square),
        }
        .html()
    }

    #[test]
    fn the_file_stands_alone_and_stays_small() {
        let html = html(&run(20_000));
        assert!(html.len() < 6_000_000, "{} bytes", html.len());
        assert_eq!(html.matches("plotly.js v").count(), 1, "the script once");
        assert!(!html.contains("<script src") && !html.contains("<link"), "nothing is fetched");
        let (head, rest) = html.split_once("<script").expect("the script");
        let (_, tail) = rest.split_once("</script>").expect("its end");
        assert!(!head.contains("{{") && !tail.contains("{{"), "every place is filled");
    }

    #[test]
    fn text_is_escaped_and_results_are_there() {
        let html = html(&run(1_000));
        let head = &html[..html.find("<script").expect("a script")];
        assert!(head.contains("<h1>A &amp; B</h1>") && head.contains("1 ms &lt;held&gt;"));
        assert!(head.contains("<td>1.000 N in cable 5 at 0.700 s</td>"), "{head}");
        assert!(
            head.contains("<tr><td>1</td><td>0.500</td><td>0.2000</td><td>0.0000</td><td>1.0000</td></tr>")
        );
    }
}
