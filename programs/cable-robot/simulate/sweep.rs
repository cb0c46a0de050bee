//! `simulate --sweep`: a scenario run for every combination of some values.

use std::fmt::Write;

use anyhow::{Context, Result};
use rayon::prelude::*;

use super::answer::{Answer, AnswerCase};
use super::interruption::Interruption;
use super::record::{Record, Sink};
use super::settings::{Setting, combinations};
use super::source;
use super::{End, Simulate};
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

/// What one combination came to: its settings and the summary of the run.
struct Case {
    settings: Vec<Setting>,
    summary: Answer,
    is_slack: bool,
}

/// Runs them all, on all cores.
pub fn run(simulate: &Simulate, name: &str) -> Result<Outcome> {
    let interruption = Interruption::listen()?;
    let cases = combinations(&simulate.sweep);
    let progress = Progress::new("simulating", cases.len() as u64);
    let run = |settings: Vec<Setting>| {
        let found = case(simulate, name, settings, &interruption);
        progress.done(1);
        found
    };
    let found: Result<Vec<Option<Case>>> = cases.into_par_iter().map(run).collect();
    drop(progress);
    let Some(cases) = found?.into_iter().collect::<Option<Vec<_>>>() else {
        return Ok(Outcome::Interrupted);
    };
    let is_slack = cases.iter().any(|case| case.is_slack);
    if simulate.json {
        print_json(&cases.into_iter().map(Case::answer).collect::<Vec<_>>())?;
    } else {
        print(&table(&cases))?;
    }
    Ok(if is_slack { Outcome::Slack } else { Outcome::Done })
}

/// `None` if it was interrupted.
fn case(
    simulate: &Simulate,
    name: &str,
    settings: Vec<Setting>,
    interruption: &Interruption,
) -> Result<Option<Case>> {
    let all: Vec<_> = simulate.set.iter().chain(&settings).cloned().collect();
    let named = || {
        let all = settings.iter().map(|setting| format!("{}={}", setting.name, setting.value));
        format!("--sweep, {}", all.collect::<Vec<_>>().join(", "))
    };
    let scenario = source::named(name, &all).with_context(named)?;
    let models = simulate.models(&scenario, interruption)?;
    let info = simulate.info(&scenario, &models);
    let mut record = Record::new(&scenario, info, &[], Sink::Nowhere, 1);
    if let End::Interrupted =
        simulate.simulate(&scenario, models, &mut record, interruption).with_context(named)?
    {
        return Ok(None);
    }
    record.summary.finish()?;
    Ok(Some(Case { summary: record.summary.answer(), is_slack: record.summary.is_slack(), settings }))
}

impl Case {
    fn answer(self) -> AnswerCase {
        let set = self.settings.into_iter().map(|setting| (setting.name, setting.value)).collect();
        AnswerCase { set, summary: self.summary }
    }

    /// When the last goal was reached, s after it was given.
    fn reached(&self) -> Option<f64> {
        let goal = self.summary.goals.last()?;
        Some(goal.reached? - goal.time)
    }
}

/// A row a case.
fn table(cases: &[Case]) -> String {
    let names: Vec<_> =
        cases.iter().take(1).flat_map(|case| &case.settings).map(|setting| &setting.name).collect();
    let widths: Vec<_> = names.iter().map(|name| name.len().max(8)).collect();
    let mut text = String::new();
    for (name, width) in names.iter().zip(&widths) {
        let _ = write!(text, "{name:>width$}  ");
    }
    text += "last goal after (s)  smallest tension (N)  slack  status\n";
    for case in cases {
        for (setting, width) in case.settings.iter().zip(&widths) {
            let value = setting.value.as_str().map_or_else(|| setting.value.to_string(), str::to_owned);
            let _ = write!(text, "{value:>width$}  ");
        }
        let reached = case.reached().map_or("-".to_owned(), |time| format!("{time:.3}"));
        let smallest =
            case.summary.smallest_tension.as_ref().map_or("-".to_owned(), |u| format!("{:.3}", u.tension));
        let (slack, status) =
            (if case.is_slack { "yes" } else { "no" }, case.summary.status.as_deref().unwrap_or("-"));
        let _ = writeln!(text, "{reached:>19}  {smallest:>20}  {slack:>5}  {status}");
    }
    text
}
