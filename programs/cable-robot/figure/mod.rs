//! `cable-robot figure`: the paper's figures, made again.

pub mod chart;
mod domains;
pub mod draw;
mod experiment;
mod manoeuvre;
mod response;
mod run;

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cable_robot_report::files::{Part, probe};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use crate::command::{Outcome, print, print_json};
use chart::Chart;

pub const EXAMPLE: &str = "\
Example: cable-robot figure 7 --output figures
writes figures/figure-7.svg, figure-7.png and figure-7.csv (panel, series, x, y: every point that is drawn, in the units of the
axes) and says what the figure shows. docs/paper.md walks through them.";

#[derive(Args)]
pub struct Figure {
    /// Which of the paper's figures
    #[arg(value_enum)]
    which: Which,
    /// Folder to write into, made if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    output: PathBuf,
    /// Prints the files and what the figures show for machines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Which {
    /// Z_M over the damping ratio
    #[value(name = "2")]
    Two,
    /// Reachable domains from the points of Table I
    #[value(name = "3")]
    Three,
    /// Positions in the manoeuvre of Section VI
    #[value(name = "5")]
    Five,
    /// Tensions in it
    #[value(name = "6")]
    Six,
    /// The chain of reachable domains in it
    #[value(name = "7")]
    Seven,
    /// Positions on an imperfect rig
    #[value(name = "8")]
    Eight,
    /// Tensions on it
    #[value(name = "9")]
    Nine,
    /// Every one of them
    All,
}

/// A figure and what it shows, a line a fact.
struct Made {
    chart: Chart,
    findings: Vec<String>,
}

impl Figure {
    pub fn run(&self) -> Result<Outcome> {
        fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot make the folder {}", self.output.display()))?;
        let is_meant = |which: &&Which| match self.which {
            Which::All => **which != Which::All,
            one => **which == one,
        };
        let meant: Vec<_> = Which::value_variants().iter().filter(is_meant).collect();
        meant.iter().flat_map(|which| self.paths(**which)).try_for_each(|path| probe(&path))?;
        let mut written = vec![];
        for which in meant {
            written.push(self.write(*which)?);
        }
        if self.json {
            print_json(&json!({ "figures": written }))?;
        }
        Ok(Outcome::Done)
    }

    /// CSV, PNG and SVG of a figure.
    fn paths(&self, which: Which) -> [PathBuf; 3] {
        let name = which.number();
        ["csv", "png", "svg"].map(|ending| self.output.join(format!("figure-{name}.{ending}")))
    }

    /// Writes the files whole beside their places and moves them there.
    fn write(&self, which: Which) -> Result<Value> {
        let Made { chart, findings } = make(which)?;
        let mut csv = vec![];
        chart.write_csv(&mut csv)?;
        let svg = draw::svg(&chart)?;
        let png = draw::png(&svg)?;
        let paths = self.paths(which);
        let mut parts = vec![];
        for (path, content) in paths.iter().zip([csv, png, svg.into_bytes()]) {
            parts.push(Part::write(path, |file| file.write_all(&content))?);
        }
        parts.into_iter().try_for_each(Part::settle)?;
        let [csv, png, svg] = &paths;
        if !self.json {
            let lines: String = findings.iter().map(|line| format!("  {line}\n")).collect();
            print(&format!("figure {}: {}\n{lines}", which.number(), svg.display()))?;
        }
        Ok(json!({ "figure": which.number(), "svg": svg, "png": png, "csv": csv, "findings": findings }))
    }
}

impl Which {
    /// As the paper and the command line call it.
    fn number(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

fn make(which: Which) -> Result<Made> {
    Ok(match which {
        Which::Two => response::figure_2(),
        Which::Three => domains::figure_3(),
        Which::Five => manoeuvre::figure_5()?,
        Which::Six => manoeuvre::figure_6()?,
        Which::Seven => domains::figure_7(&manoeuvre::simulated()?),
        Which::Eight => experiment::figure_8()?,
        Which::Nine | Which::All => experiment::figure_9()?,
    })
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;

    /// Plotters would move a point beyond the axes to their edge without a word.
    #[test]
    fn every_point_lies_within_its_axes() {
        for which in Which::value_variants() {
            for panel in make(*which).expect("a figure").chart.panels {
                let holds = |range: &Range<f64>, v: &f64| (range.start - 1e-9..=range.end + 1e-9).contains(v);
                for series in &panel.series {
                    for [x, y] in &series.points {
                        let is_inside = holds(&panel.x.range, x) && holds(&panel.y.range, y);
                        assert!(is_inside, "({x}, {y}) of {} in {}", series.name, panel.title);
                    }
                }
            }
        }
    }
}
