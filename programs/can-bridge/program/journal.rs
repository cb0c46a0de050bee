//! The journal: takes what the loop tells out of the queue, says it, shows it and writes it down, in a thread of its own. It waits for
//! nothing but the disk of the recording.

use std::io;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cable_robot_fieldbus::bridge::{Cause, Event};
use cable_robot_fieldbus::{Config, Nanoseconds};
use rtrb::{Consumer, RingBuffer};
use serde_json::json;

use super::entry::{Entry, Teller};
use super::record::Recording;
use super::status::{Status, Stream};
use super::survey::{self, Survey};
use super::terminal::{say, show, show_nothing};

/// Entries that wait: more than a second's at any rate that fits on a bus.
const QUEUE: usize = 1 << 14;
const PAUSE: Duration = Duration::from_millis(5);
const SHOW_EVERY: Duration = Duration::from_millis(100);
const FLUSH_EVERY: Duration = Duration::from_secs(1);

/// The journal's thread.
pub struct Journal {
    thread: JoinHandle<bool>,
}

impl Journal {
    /// Starts it; it ends when the [`Teller`] is dropped.
    pub fn start(
        recording: Option<Recording>,
        stream: Option<Stream>,
        config: &Config,
        survey: Option<Arc<Survey>>,
    ) -> Result<(Teller, Self)> {
        let (producer, consumer) = RingBuffer::new(QUEUE);
        let writer = Writer { status: Status::new(config)?, recording, stream, survey, is_whole: true };
        let thread = thread::Builder::new()
            .name("journal".to_owned())
            .spawn(move || writer.run(consumer))
            .context("no thread for the journal")?;
        Ok((Teller::new(producer), Self { thread }))
    }

    /// Waits for its end. Whether everything was written.
    pub fn join(self) -> bool {
        self.thread.join().unwrap_or(false)
    }
}

struct Writer {
    status: Status,
    recording: Option<Recording>,
    stream: Option<Stream>,
    survey: Option<Arc<Survey>>,
    is_whole: bool,
}

impl Writer {
    fn run(mut self, mut queue: Consumer<Entry>) -> bool {
        let (mut shown, mut flushed) = (Instant::now(), Instant::now());
        loop {
            // Looked at first: what was pushed before the other end went is still taken.
            let is_last = queue.is_abandoned();
            while let Ok(entry) = queue.pop() {
                self.take(&entry);
            }
            if shown.elapsed() >= SHOW_EVERY || is_last {
                shown = Instant::now();
                self.show();
            }
            if flushed.elapsed() >= FLUSH_EVERY || is_last {
                flushed = Instant::now();
                self.record(Recording::flush);
            }
            if is_last {
                break;
            }
            thread::sleep(PAUSE);
        }
        show_nothing();
        say(self.status.summary());
        let lost = self.stream.map_or(0, |stream| stream.finish());
        if lost > 0 {
            say(format_args!(
                "can-bridge: the status stream lacks {lost} lines: nobody read them, or they could not be written"
            ));
        }
        self.is_whole && lost == 0
    }

    fn take(&mut self, entry: &Entry) {
        self.status.take(entry);
        self.record(|recording| recording.take(entry));
        if let Some((time, text)) = message(entry) {
            self.say(time, &text);
        }
        if let (Entry::Event(time, event), Some(survey)) = (entry, &self.survey)
            && let Some(text) = survey.follow(event)
        {
            self.say(*time, &text);
        }
        if let Entry::Lost(count) = entry {
            self.is_whole = false;
            self.say(0, &format!("the queue was full: {count} entries are missing in the recording"));
        }
    }

    /// Writes to the recording; if that fails once, there is none any more. The robot goes on.
    fn record(&mut self, write: impl FnOnce(&mut Recording) -> io::Result<()>) {
        let Some(recording) = &mut self.recording else { return };
        if let Err(reason) = write(recording) {
            (self.recording, self.is_whole) = (None, false);
            self.say(0, &format!("THE RECORDING STOPS, control goes on: {reason}"));
        }
    }

    fn say(&mut self, time: Nanoseconds, text: &str) {
        let seconds = time as f64 * 1e-9;
        let line = if time > 0 { format!("[{seconds:9.3}] {text}") } else { format!("can-bridge: {text}") };
        say(line);
        self.stream(json!({ "time": seconds, "message": text }));
    }

    fn show(&self) {
        show(self.status.line());
        self.stream(self.status.json());
    }

    fn stream(&self, value: serde_json::Value) {
        self.stream.iter().for_each(|stream| stream.write(&value));
    }
}

/// What is to be said of an entry.
fn message(entry: &Entry) -> Option<(Nanoseconds, String)> {
    match entry {
        Entry::Event(time, event) => Some((*time, event_text(event))),
        Entry::Refused(time, refusal) => Some((*time, format!("refused: {refusal}"))),
        Entry::Note(time, text) => Some((*time, (*text).to_owned())),
        Entry::Received(_) | Entry::Input(_) | Entry::Sent(_) | Entry::Cycle(_) | Entry::Lost(_) => None,
    }
}

fn event_text(event: &Event) -> String {
    match event {
        Event::Entered(state) => format!("{state}"),
        Event::Stopped(Cause::Released) => "the operator let go: to the safe output".to_owned(),
        Event::Stopped(Cause::EnableExpired) => "enable was not given again: to the safe output".to_owned(),
        Event::Stopped(Cause::Shutdown) => "the program ends: to the safe output".to_owned(),
        Event::Stopped(Cause::Lower | Cause::Landed) => {
            "the operator wants the platform down: to the safe output".to_owned()
        }
        Event::Stopped(Cause::Reset) => "everything is to be set up anew: to the safe output".to_owned(),
        Event::Stopped(Cause::Fault(fault)) => format!("to the safe output, since {fault}"),
        Event::LetGo(Cause::Landed) => "the platform stands: the motors are off".to_owned(),
        Event::LetGo(Cause::EnableExpired) => "home was not given again: the motors are off".to_owned(),
        Event::LetGo(_) => "the operator let go: the motors are off".to_owned(),
        Event::Pulled { cable, tension, came_in } => survey::pulled_text(*cable, *tension, came_in),
        Event::Placed(pose, _) => format!("measured at {}", survey::at(pose)),
        Event::Weighed { mass, rise, tilt } => format!(
            "the load cells carry {mass:.3} kg, {:.1} mm above the stand, turned by {tilt:.4} rad",
            1e3 * rise
        ),
        Event::NotLifted => {
            "the platform did not leave its stand at one and a half times its weight: is it heavier than the rig file says, or held?"
                .to_owned()
        }
        Event::Zeroed(reading) => survey::zeroed_text(reading),
        Event::WatchdogProved => {
            "every drive stopped by itself when the bridge was silent; all are set up anew".to_owned()
        }
        Event::Fault(fault) => format!("FAULT: {fault}"),
        Event::Emergency(emergency) => format!("emergency message: {emergency}"),
        Event::Lost(count) => format!("{count} more emergency messages came at once"),
    }
}
