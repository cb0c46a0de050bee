//! What a report needs of a run: some of its rows, and what all of them come to. However long the run, it is read in parts.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::events::{self, Event};
use super::history::History;
use super::run_folder::{Model, RUN_CSV};
use super::table::CsvRows;
use super::thinning::{extremes, group, is_even};
use super::{RunFolder, RunFolderError, Summary, Table, TableError};

/// A run, thinned.
pub struct Digest {
    /// Rows that are drawn, in which a set point or a goal is new or reached, and the rows before these.
    pub folder: RunFolder,
    /// How many rows the run has.
    pub rows: usize,
    /// What all of them come to.
    pub summary: Summary,
    /// Of the rows in `folder` those that are drawn anyhow: at equal distances, and extremes.
    pub(super) drawn: Vec<usize>,
    /// From when to when a cable was slack, s; what is nearer together than a thousandth of the run is one.
    pub(super) slack_spans: Vec<[f64; 2]>,
    /// From when to when the platform was disturbed, s.
    pub(super) disturbed_spans: Vec<[f64; 2]>,
    /// Greatest disturbing force and torque, N and N m.
    pub(super) disturbance: [f64; 2],
    /// From when to when a rig's platform was not measured, s: there are no rows.
    pub(super) unmeasured_spans: Vec<[f64; 2]>,
    /// What happened beside the rows.
    pub(super) events: Vec<Event>,
}

/// At a rig a row that is so many steps after the one before shows that there was nothing to record between them.
const GAP: f64 = 2.5;

/// How many rows there are, and for how long, s.
struct Extent {
    rows: usize,
    duration: f64,
}

impl Digest {
    /// Of a run that is in memory.
    ///
    /// # Errors
    /// [`TableError::Missing`]: a column that is needed is not there.
    pub fn of(run: &RunFolder) -> Result<Self, TableError> {
        let times = run.table.column("time")?;
        let ends = times.first().zip(times.last());
        let extent = Extent { rows: times.len(), duration: ends.map_or(0.0, |(first, last)| last - first) };
        let empty = RunFolder { info: run.info.clone(), table: run.table.empty() };
        let mut rows = 0..times.len();
        Self::new(empty, &extent, |part| {
            let next = rows.next();
            next.iter().for_each(|row| part.push_of(&run.table, *row));
            Ok(next.is_some())
        })
    }

    /// Of a run folder, which is read twice, `run.csv` through readers of its own.
    ///
    /// # Errors
    /// As of [`RunFolder::read`], and for a column that is needed and not there.
    pub fn read<R: Read>(folder: &Path, reader: impl Fn(File) -> R) -> Result<Self, RunFolderError> {
        let csv = |reason| RunFolderError::Csv { path: folder.join(RUN_CSV), reason };
        let (info, file) = RunFolder::open(folder)?;
        let extent = Extent::of(reader(file)).map_err(csv)?;
        let (_, file) = RunFolder::open(folder)?;
        let digest = || {
            let mut rows = CsvRows::begin(reader(file))?;
            Self::new(RunFolder { info, table: rows.empty() }, &extent, |part| rows.next(part))
        };
        Ok(Self { events: events::read(folder)?, ..digest().map_err(csv)? })
    }

    /// Begins with `empty`; `next` adds the next row of the run to a table, or tells that there is none.
    fn new(
        empty: RunFolder,
        extent: &Extent,
        mut next: impl FnMut(&mut Table) -> Result<bool, TableError>,
    ) -> Result<Self, TableError> {
        let mut part = empty.clone();
        let mut digest = Self {
            folder: empty,
            rows: 0,
            summary: Summary::default(),
            drawn: vec![],
            slack_spans: vec![],
            disturbed_spans: vec![],
            disturbance: [0.0; 2],
            unmeasured_spans: vec![],
            events: vec![],
        };
        let mut kept = 0;
        loop {
            let known = part.table.rows();
            while part.table.rows() - known < group(extent.rows) && next(&mut part.table)? {}
            if part.table.rows() == known {
                return Ok(digest);
            }
            let history = History::new(&part)?;
            digest.add(&history, known, extent);
            kept = digest.keep(&history, known, kept, extent);
            part.table.keep_last();
        }
    }

    /// Adds what a part of the run comes to; its first row is known from the part before, unless `known` is 0.
    fn add(&mut self, part: &History, known: usize, extent: &Extent) {
        self.summary.add(&part.run, known);
        let times = &part.run.times;
        let slack = (known..part.len()).filter(|row| part.is_slack(*row)).map(|row| [times[row]; 2]);
        join(&mut self.slack_spans, slack, |gap| gap <= extent.duration / 1e3);
        if part.info.plant == Model::Rig {
            let gaps = times.windows(2).filter(|ends| ends[1] - ends[0] > GAP * part.info.step);
            self.unmeasured_spans.extend(gaps.map(|ends| [ends[0], ends[1]]));
        }
        join(&mut self.disturbed_spans, part.disturbed_spans().iter().copied(), |gap| gap <= 0.0);
        for (greatest, here) in self.disturbance.iter_mut().zip(part.disturbance) {
            *greatest = greatest.max(here);
        }
    }

    /// When the run ends, s: with its last row, or what happened after it.
    pub(super) fn end(&self, history: &History) -> f64 {
        let last_row = history.run.times.last().copied();
        last_row.into_iter().chain(self.events.iter().map(|event| event.time)).fold(f64::MIN, f64::max)
    }

    /// Keeps rows of a part; up to `kept` rows of the run are settled. How many are then.
    fn keep(&mut self, part: &History, known: usize, mut kept: usize, extent: &Extent) -> usize {
        let before = self.rows - known;
        self.rows += part.len() - known;
        let run = &part.run;
        let coordinates: [Vec<f64>; 6] =
            std::array::from_fn(|k| part.pose.iter().map(|pose| pose.0[k]).collect());
        let curves = coordinates.iter().chain(&run.tension).chain(&run.slack).chain([&run.tension_margin]);
        let curves: Vec<&[f64]> = curves.map(Vec::as_slice).collect();
        let mut drawn = extremes(&curves, known..part.len());
        drawn.extend((known..part.len()).filter(|row| is_even(before + row, extent.rows)));
        let arrival = |row: &usize| *row > 0 && run.at_goal[*row] != run.at_goal[row - 1];
        let mut news = [part.set_point_rows(), part.goal_rows()].concat();
        news.extend((known..part.len()).filter(arrival));
        news.retain(|row| *row >= known);
        let mut rows = [drawn.clone(), news.clone()].concat();
        rows.extend(news.iter().map(|row| row.saturating_sub(1)));
        rows.sort_unstable();
        rows.dedup();
        drawn.sort_unstable();
        for row in rows {
            if before + row >= kept {
                if drawn.binary_search(&row).is_ok() {
                    self.drawn.push(self.folder.table.rows());
                }
                self.folder.table.push_of(part.table, row);
                kept = before + row + 1;
            }
        }
        kept
    }
}

impl Extent {
    fn of(reader: impl Read) -> Result<Self, TableError> {
        let mut csv = CsvRows::begin(reader)?;
        let (mut rows, mut first, mut last) = (0, None, csv.empty());
        while csv.next(&mut last)? {
            last.keep_last();
            let time = last.column("time")?[0];
            first = first.or(Some(time));
            rows += 1;
        }
        Ok(Self { rows, duration: last.column("time")?[0] - first.unwrap_or_default() })
    }
}

/// Adds spans of time to others; where the gap to the one before is `small`, that becomes longer.
fn join(spans: &mut Vec<[f64; 2]>, more: impl Iterator<Item = [f64; 2]>, small: impl Fn(f64) -> bool) {
    for span in more {
        match spans.last_mut() {
            Some(last) if small(span[0] - last[1]) => last[1] = span[1],
            _ => spans.push(span),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html;
    use crate::tests::run;
    use cable_robot::plan::PlannerKind;

    /// The page of a run in a file is that of the run in memory, in parts of every length.
    #[test]
    fn a_run_that_is_read_in_parts_has_the_page_of_the_whole() {
        let run = run(PlannerKind::Bounded, 2.0, 0.5);
        let folder = tempfile::tempdir().unwrap();
        run.write(folder.path()).unwrap();
        let digest = Digest::read(folder.path(), |file| file).unwrap();
        let in_memory = Digest::of(&run).unwrap();
        assert_eq!((digest.rows, &digest.summary), (2_001, &run.run().unwrap().summary()));
        assert_eq!(html(&digest).unwrap(), html(&in_memory).unwrap());
    }

    /// What a digest says of all rows is what a history of all rows says.
    #[test]
    fn what_is_kept_tells_what_all_rows_tell() {
        let mut run = run(PlannerKind::Exact, 3.0, 0.5);
        change(&mut run, "plant.disturbanceForce.x", |row| if (500..900).contains(&row) { 2.0 } else { 0.0 });
        change(&mut run, "plant.slack[2]", |row| f64::from(u8::from(row % 700 > 600 || row == 1_234)));
        let (whole, digest) = (History::new(&run).unwrap(), Digest::of(&run).unwrap());
        let kept = History::of(&digest).unwrap();
        assert!(kept.len() < whole.len());
        let given = |history: &History, rows: Vec<usize>| -> Vec<f64> {
            rows.iter().map(|row| history.run.times[*row]).collect()
        };
        assert_eq!(given(&kept, kept.set_point_rows()), given(&whole, whole.set_point_rows()));
        assert_eq!(given(&kept, kept.goal_rows()), given(&whole, whole.goal_rows()));
        let arrivals = |history: &History| history.goals().iter().map(|goal| goal.1).collect::<Vec<_>>();
        assert_eq!(arrivals(&kept), arrivals(&whole));
        assert_eq!(kept.disturbed_spans(), whole.disturbed_spans());
        assert_eq!((kept.disturbance, kept.last_status()), (whole.disturbance, whole.last_status()));
        assert_eq!(digest.summary, whole.run.summary());
        let spans = [[0.601, 0.699], [1.234; 2], [1.301, 1.399], [2.001, 2.099], [2.701, 2.799]];
        let near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9;
        assert!(digest.slack_spans.iter().zip(&spans).all(|(a, b)| near(a, b)), "{:?}", digest.slack_spans);
        assert_eq!(digest.slack_spans.len(), spans.len());
    }

    /// Another value in each row of a column.
    fn change(run: &mut RunFolder, column: &str, value: impl Fn(usize) -> f64) {
        let table = &run.table;
        let place = table.names().iter().position(|name| name == column).unwrap();
        let mut changed = table.empty();
        for row in 0..table.rows() {
            let mut numbers: Vec<_> =
                table.names().iter().map(|name| table.column(name).unwrap()[row]).collect();
            numbers[place] = value(row);
            changed.push(numbers[0], &numbers[1..]);
        }
        run.table = changed;
    }

    /// What happened to the platform then, nobody recorded: a line across would say that it went straight.
    #[test]
    fn a_rig_that_was_not_measured_for_a_while_is_said_to_be_so() {
        let mut run = run(PlannerKind::Bounded, 2.0, 0.0);
        let table = run.table.empty();
        let whole = std::mem::replace(&mut run.table, table);
        (0..whole.rows())
            .filter(|row| !(700..900).contains(row))
            .for_each(|row| run.table.push_of(&whole, row));
        assert!(Digest::of(&run).unwrap().unmeasured_spans.is_empty(), "a simulated plant always is");
        run.info.plant = Model::Rig;
        let [[from, to]] = Digest::of(&run).unwrap().unmeasured_spans[..] else { panic!("one gap") };
        assert!((from - 0.699).abs() + (to - 0.9).abs() < 1e-9, "{from} to {to}");
    }
}
