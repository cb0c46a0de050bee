//! What a person looks at, and what a program reads, while a session runs.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::Path;

use anyhow::Result;
use cable_robot::plan::ControllerParameters;
use cable_robot::robot::{PerCable, TensionLimits};
use cable_robot_fieldbus::bridge::CycleReport;
use cable_robot_fieldbus::bus_load::worst_case_bits;
use cable_robot_fieldbus::{Config, Nanoseconds};
use cable_robot_report::files::begin;
use hdrhistogram::Histogram;

use super::entry::{Cycle, Entry};
use super::fate::Goals;
use super::outlet::Outlet;
use super::status_line::{Line, SessionStatus, Times};
use super::terminal::say;

/// Largest time that is told apart, and to how many digits.
const LONGEST: Nanoseconds = 60_000_000_000;
const DIGITS: u8 = 2;
/// The bus load is that of the last second.
const WINDOW: Nanoseconds = 1_000_000_000;

/// Everything that is shown, kept up to date.
pub struct Status {
    limits: PerCable<TensionLimits>,
    bit_rate: Vec<f64>,
    lateness: Histogram<u64>,
    latency: Histogram<u64>,
    report: Option<CycleReport>,
    goals: Goals,
    cycles: u64,
    missed: u64,
    lost: u64,
    frames: u64,
    /// Time, bus and worst-case bits of the frames of the last second.
    recent: VecDeque<(Nanoseconds, usize, u32)>,
}

impl Status {
    /// Nothing has happened yet.
    pub fn new(config: &Config, controller: ControllerParameters) -> Result<Self> {
        let histogram = || Histogram::new_with_bounds(1, LONGEST, DIGITS);
        Ok(Self {
            limits: config.rig.limits(),
            bit_rate: config.buses.iter().map(|bus| bus.bit_rate).collect(),
            lateness: histogram()?,
            latency: histogram()?,
            report: None,
            goals: Goals::new(controller),
            cycles: 0,
            missed: 0,
            lost: 0,
            frames: 0,
            recent: VecDeque::new(),
        })
    }

    /// Takes in what happened. What is to be said of a goal then.
    pub fn take(&mut self, entry: &Entry) -> Option<String> {
        self.count(entry);
        self.goals.take(entry)
    }

    /// Since the program's start, of the last cycle.
    pub fn now(&self) -> Nanoseconds {
        self.report.map_or(0, |report| report.time)
    }

    fn count(&mut self, entry: &Entry) {
        match entry {
            Entry::Received(frame) | Entry::Sent(frame) => {
                self.frames += 1;
                let bits = worst_case_bits(frame.frame.length());
                self.recent.push_back((frame.time, frame.bus, bits));
                while self.recent.front().is_some_and(|(time, ..)| time + WINDOW < frame.time) {
                    self.recent.pop_front();
                }
            }
            Entry::Cycle(Cycle { report, lateness, latency, missed }) => {
                self.cycles += 1;
                self.missed += missed;
                self.lateness.saturating_record(*lateness);
                latency.iter().for_each(|latency| self.latency.saturating_record(*latency));
                self.report = Some(*report);
            }
            Entry::Lost(count) => self.lost += count,
            Entry::Input(..) | Entry::Event(..) | Entry::Refused(..) | Entry::Note(..) => {}
        }
    }

    /// Share of each bus that the frames of the last second took, stuffed at worst.
    fn loads(&self) -> Vec<f64> {
        let bits = |bus: usize| {
            let of_bus = self.recent.iter().filter(|frame| frame.1 == bus);
            of_bus.map(|frame| u64::from(frame.2)).sum::<u64>() as f64
        };
        let share = |(bus, rate): (usize, &f64)| bits(bus) * 1e9 / WINDOW as f64 / rate;
        self.bit_rate.iter().enumerate().map(share).collect()
    }

    /// How far each cable is from its nearer limit, N.
    fn margins(&self, report: &CycleReport) -> PerCable<f64> {
        PerCable::from_fn(self.limits.len(), |i| self.limits[i].margin(report.measured[i]))
    }

    /// For a terminal.
    pub fn line(&self) -> String {
        let Some(report) = &self.report else { return "waiting for the first cycle".to_owned() };
        let Times { p50, p99, max } = times(&self.lateness);
        let loads: Vec<_> = self.loads().iter().map(|load| format!("{:.0} %", 100.0 * load)).collect();
        let margins: Vec<_> = self.margins(report).iter().map(|margin| tenths(*margin)).collect();
        // What is behind them may be cut off.
        let fault = report.fault.map_or(String::new(), |fault| format!(": {fault}"));
        let goal = self.goals.text().map_or(String::new(), |goal| format!(" | {goal}"));
        format!(
            "{}{fault}{goal} | late {p50:.0}/{p99:.0}/{max:.0} µs, {} missed | bus {} | margins {} N",
            report.state,
            self.missed,
            loads.join(" "),
            margins.join(" "),
        )
    }

    /// For machines; nothing before the first cycle.
    pub fn session(&self) -> Option<SessionStatus> {
        let report = self.report.as_ref()?;
        Some(SessionStatus {
            time: report.time as f64 * 1e-9,
            state: report.state.to_string(),
            fault: report.fault.map(|fault| fault.to_string()),
            pose: report.measured_pose.map(|pose| pose.0.into()),
            goal: self.goals.status(),
            length: report.length.to_vec(),
            measured: report.measured.to_vec(),
            tension: report.tension.to_vec(),
            margin: self.margins(report).to_vec(),
            predicted_margin: report.controller.map(|answer| answer.tension_margin),
            controller: report.controller.map(|answer| answer.status.to_string()),
            cycles: self.cycles,
            missed_cycles: self.missed,
            lost_entries: self.lost,
            lateness_microseconds: times(&self.lateness),
            latency_microseconds: times(&self.latency),
            frames: self.frames,
            bus_load: self.loads(),
        })
    }

    /// At the end.
    pub fn summary(&self) -> String {
        let Times { p50, p99, max } = times(&self.lateness);
        let latency = times(&self.latency);
        format!(
            "{} cycles, {} missed; {} frames; late by {p50:.0} µs (p50), {p99:.0} µs (p99), {max:.0} µs (max); from encoder to \
             torque {:.0} µs (p50), {:.0} µs (p99), {:.0} µs (max)",
            self.cycles, self.missed, self.frames, latency.p50, latency.p99, latency.max
        )
    }
}

/// To a tenth, never -0.
fn tenths(value: f64) -> String {
    format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0)
}

/// In µs.
fn times(histogram: &Histogram<u64>) -> Times {
    let [p50, p99, max] =
        [histogram.value_at_quantile(0.5), histogram.value_at_quantile(0.99), histogram.max()]
            .map(|time| time as f64 / 1e3);
    Times { p50, p99, max }
}

/// Where the status for machines goes, a JSON object a line, each at once. Lines that nobody reads are dropped and counted.
pub struct Stream {
    outlet: Outlet<String>,
}

impl Stream {
    /// Into this file; `-` is stdout.
    pub fn create(path: &Path) -> Result<Self> {
        let mut file: Box<dyn Write + Send> =
            if path == Path::new("-") { Box::new(io::stdout()) } else { Box::new(begin(path)?) };
        let write = move |line: String| {
            let written = file.write_all(line.as_bytes()).and_then(|()| file.flush());
            written.inspect_err(|reason| say(format_args!("can-bridge: the status stream ends: {reason}")))
        };
        Ok(Self { outlet: Outlet::new("status", write)? })
    }

    /// A line.
    pub fn write(&self, line: &Line) {
        // Numbers and words always are JSON.
        self.outlet.push(serde_json::to_string(line).unwrap_or_default() + "\n");
    }

    /// Waits for its readers, but not for long. How many lines were not written.
    pub fn finish(&self) -> u64 {
        self.outlet.finish()
    }
}
