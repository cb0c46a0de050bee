//! The journal: takes what the loop tells out of the queue, says it, shows it and hands it to the recording, in a thread of its own. It
//! waits for nothing.

use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cable_robot_fieldbus::Nanoseconds;
use cable_robot_fieldbus::bridge::{Cause, Event};
use rtrb::{Consumer, RingBuffer};

use super::entry::{Entry, Teller};
use super::prompt;
use super::record::Recording;
use super::recorder::Recorder;
use super::status::{Status, Stream};
use super::status_line::{Line, Message};
use super::survey::{self, Survey};
use super::terminal::{say, show, show_nothing};

/// Entries that wait: more than a second's at any rate that fits on a bus.
const QUEUE: usize = 1 << 14;
const PAUSE: Duration = Duration::from_millis(5);
const SHOW_EVERY: Duration = Duration::from_millis(100);

/// The journal's thread.
pub struct Journal {
    thread: JoinHandle<bool>,
}

impl Journal {
    /// Starts it; it ends when the [`Teller`] is dropped.
    pub fn start(
        recording: Option<Recording>,
        stream: Option<Stream>,
        status: Status,
        has_keys: bool,
        survey: Option<Arc<Survey>>,
    ) -> Result<(Teller, Self)> {
        let (producer, consumer) = RingBuffer::new(QUEUE);
        let recorder = recording.map(Recorder::start).transpose()?;
        let writer = Writer { status, has_keys, recorder, stream, survey, is_whole: true };
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
    /// Whether the operator has keys, or gives lines.
    has_keys: bool,
    recorder: Option<Recorder>,
    stream: Option<Stream>,
    survey: Option<Arc<Survey>>,
    is_whole: bool,
}

impl Writer {
    fn run(mut self, mut queue: Consumer<Entry>) -> bool {
        let mut shown = Instant::now();
        loop {
            // Looked at first: what was pushed before the other end went is still taken.
            let is_last = queue.is_abandoned();
            while let Ok(entry) = queue.pop() {
                self.take(&entry);
            }
            if shown.elapsed() >= SHOW_EVERY || is_last {
                shown = Instant::now();
                self.watch_recorder();
                self.show();
            }
            if is_last {
                break;
            }
            thread::sleep(PAUSE);
        }
        if let Some(recorder) = self.recorder.take() {
            self.end(recorder);
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
        let of_goal = self.status.take(entry);
        self.recorder.iter_mut().for_each(|recorder| recorder.take(entry));
        if let Some((time, text)) = self.message(entry) {
            self.say(time, &text);
        }
        if let Some(text) = of_goal {
            self.say(self.status.now(), &text);
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

    /// If it fails once, there is none any more; a disk that is too slow is said once. The robot goes on.
    fn watch_recorder(&mut self) {
        if let Some(failed) = self.recorder.take_if(|recorder| recorder.has_failed()) {
            self.end(failed);
        }
        if self.is_whole && self.recorder.as_ref().is_some_and(|recorder| recorder.lost() > 0) {
            self.is_whole = false;
            self.say(0, "the disk is too slow: entries are missing in the recording from here on");
        }
    }

    fn end(&mut self, recorder: Recorder) {
        self.is_whole &= recorder.lost() == 0;
        if let Err(reason) = recorder.finish() {
            self.is_whole = false;
            self.say(0, &format!("THE RECORDING STOPS, control goes on: {reason}"));
        }
    }

    fn say(&mut self, time: Nanoseconds, text: &str) {
        let seconds = time as f64 * 1e-9;
        let line = if time > 0 { format!("[{seconds:9.3}] {text}") } else { format!("can-bridge: {text}") };
        say(line);
        self.stream(Line::Message(Message { time: seconds, message: text.to_owned() }));
    }

    /// What is to be said of an entry.
    fn message(&self, entry: &Entry) -> Option<(Nanoseconds, String)> {
        match entry {
            Entry::Event(time, Event::Entered(state)) => {
                // In a survey that says what comes next.
                let next = self.survey.is_none().then(|| prompt::next(*state, self.has_keys));
                Some((*time, next.map_or(state.to_string(), |next| format!("{state}: {next}"))))
            }
            Entry::Event(time, event) => Some((*time, event_text(event))),
            Entry::Refused(time, refusal) => Some((*time, format!("refused: {refusal}"))),
            Entry::Note(time, text) => Some((*time, (*text).to_owned())),
            Entry::Received(_) | Entry::Input(..) | Entry::Sent(_) | Entry::Cycle(_) | Entry::Lost(_) => None,
        }
    }

    fn show(&self) {
        show(self.status.line());
        if let Some(session) = self.status.session() {
            self.stream(Line::Session(Box::new(session)));
        }
    }

    fn stream(&self, line: Line) {
        self.stream.iter().for_each(|stream| stream.write(&line));
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
        Event::Stopped(cause @ (Cause::Taut | Cause::TooFast | Cause::WrongWay)) => {
            format!("to the safe output: {cause}")
        }
        Event::Stopped(Cause::Fault(fault)) => format!("to the safe output, since {fault}"),
        Event::LetGo(Cause::Landed) => "the platform stands: the motors are off".to_owned(),
        Event::LetGo(cause @ (Cause::EnableExpired | Cause::Taut | Cause::TooFast | Cause::WrongWay)) => {
            format!("{cause}: the motors are off")
        }
        Event::LetGo(_) => "the operator let go: the motors are off".to_owned(),
        Event::Pulled { cable, tension, came_in } => survey::pulled_text(*cable, *tension, came_in),
        Event::Jogged { cable, came_in, measured } => format!(
            "cable {} {} by {:.1} mm; its load cell says {measured:.2} N",
            cable + 1,
            if *came_in < 0.0 { "went out" } else { "came in" },
            1e3 * came_in.abs()
        ),
        Event::Placed(pose, _) => format!("measured at {}", survey::at(pose)),
        Event::Weighed { mass, rise, tilt, .. } => format!(
            "the load cells carry {mass:.3} kg, {:.1} mm above the stand, turned by {tilt:.4} rad",
            1e3 * rise
        ),
        Event::NotLifted => {
            "the platform did not leave its stand at one and a half times its weight: is it heavier than the rig file says, or held?"
                .to_owned()
        }
        Event::Zeroed(reading) => survey::zeroed_text(reading),
        Event::WatchdogTried(found) => {
            let drive = |(cable, found)| format!("\n  drive of cable {cable}: {found}");
            (1..).zip(found).map(drive).fold("the bridge was silent; then".to_owned(), |all, one| all + &one)
        }
        Event::WatchdogProved => {
            "every drive stopped by itself when the bridge was silent; all are set up anew".to_owned()
        }
        Event::Fault(fault) => format!("FAULT: {fault}"),
        Event::Emergency(emergency) => format!("emergency message: {emergency}"),
        Event::Lost(count) => format!("{count} more emergency messages came at once"),
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, File};
    use std::io::Read;
    use std::process::Command;

    use cable_robot_fieldbus::Frame;
    use cable_robot_fieldbus::bridge::Fault;

    use super::*;
    use crate::program::Purpose;
    use crate::program::controller::BridgeController;
    use crate::program::entry::OnBus;
    use crate::program::tests::files;

    /// A pipe that nobody reads stands for the disk. The status was that of seconds before, and a fault was not said.
    #[test]
    fn a_disk_that_stands_still_delays_no_fault() {
        let folder = tempfile::tempdir().unwrap();
        let (run, told) = (folder.path().join("run"), folder.path().join("status"));
        fs::create_dir(&run).unwrap();
        let frames = run.join("frames.log");
        assert!(Command::new("mkfifo").arg(&frames).status().unwrap().success());
        // Opened both ways: who writes does not wait for a reader, only for room.
        let mut disk = File::options().read(true).write(true).open(&frames).unwrap();

        let files = files();
        let controller = BridgeController::open(&files.config, None).unwrap();
        let recording = Recording::create(&run, &files, &controller, Purpose::Run(None)).unwrap();
        let status = Status::new(&files.config, controller.parameters()).unwrap();
        let stream = Stream::create(&told).unwrap();
        let (mut teller, journal) =
            Journal::start(Some(recording), Some(stream), status, false, None).unwrap();
        let received = OnBus { bus: 0, time: 1_000, frame: Frame::data(0x181, [0; 8]) };
        (0..10_000).for_each(|_| teller.tell(Entry::Received(received)));
        // Long enough that it is written.
        thread::sleep(Duration::from_millis(1_500));
        teller.tell(Entry::Event(1_000, Event::Fault(Fault::NoPose)));
        let begun = Instant::now();
        while !fs::read_to_string(&told).unwrap().contains("FAULT: the cable lengths belong to no pose") {
            assert!(begun.elapsed() < Duration::from_secs(5), "nothing is said");
            thread::sleep(Duration::from_millis(10));
        }
        thread::spawn(move || _ = disk.read_to_end(&mut vec![]));
        drop(teller);
        assert!(journal.join(), "all was written in the end");
    }
}
