//! `cable-robot figure`: the paper's figures, made again.

mod chart;
mod domains;
mod draw;
mod experiment;
mod manoeuvre;
mod response;
mod run;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};

use crate::arguments::create;
use crate::{Outcome, print};
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
        for which in Which::value_variants().iter().filter(|which| **which != Which::All) {
            if self.which == Which::All || self.which == *which {
                self.write(*which)?;
            }
        }
        Ok(Outcome::Done)
    }

    /// Each file is written whole beside its place, which is tried before the work begins, and then moved there.
    fn write(&self, which: Which) -> Result<()> {
        let value = which.to_possible_value().context("a figure without a number")?;
        let path = |ending: &str| self.output.join(format!("figure-{}.{ending}", value.get_name()));
        let part = path("part");
        create(&part)?;
        let made = make(which)?;
        let mut csv = vec![];
        made.chart.write_csv(&mut csv)?;
        let svg = draw::svg(&made.chart)?;
        let png = draw::png(&svg)?;
        for (ending, content) in [("csv", csv), ("png", png), ("svg", svg.into_bytes())] {
            let moved = fs::write(&part, content).and_then(|()| fs::rename(&part, path(ending)));
            moved.with_context(|| format!("cannot write {}", path(ending).display()))?;
        }
        let findings: String = made.findings.iter().map(|line| format!("  {line}\n")).collect();
        print(&format!("figure {}: {}\n{findings}", value.get_name(), path("svg").display()))
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
