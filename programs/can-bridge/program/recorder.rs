//! The recording, written in a thread of its own: nobody but it waits for the disk.

use std::io;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rtrb::{Consumer, RingBuffer};

use super::entry::{Entry, Teller};
use super::record::Recording;

/// Entries that wait for the disk: more than a second's at any rate that fits on a bus.
const QUEUE: usize = 1 << 14;
const PAUSE: Duration = Duration::from_millis(5);
const FLUSH_EVERY: Duration = Duration::from_secs(1);

/// The way to the recording's thread.
pub struct Recorder {
    teller: Teller,
    thread: JoinHandle<io::Result<()>>,
}

impl Recorder {
    /// Starts it.
    pub fn start(recording: Recording) -> Result<Self> {
        let (producer, consumer) = RingBuffer::new(QUEUE);
        let run = move || run(recording, consumer);
        let thread = thread::Builder::new().name("recorder".to_owned()).spawn(run);
        Ok(Self { teller: Teller::new(producer), thread: thread.context("no thread for the recording")? })
    }

    /// Hands an entry over, if there is room.
    pub fn take(&mut self, entry: &Entry) {
        self.teller.tell(*entry);
    }

    /// How many entries found none.
    pub fn lost(&self) -> u64 {
        self.teller.lost()
    }

    /// Whether it ended before it was asked to: it could not write.
    pub fn has_failed(&self) -> bool {
        self.thread.is_finished()
    }

    /// Waits until everything is written.
    pub fn finish(self) -> io::Result<()> {
        drop(self.teller);
        self.thread.join().unwrap_or_else(|_| Err(io::Error::other("the recording's thread failed")))
    }
}

fn run(mut recording: Recording, mut queue: Consumer<Entry>) -> io::Result<()> {
    let mut flushed = Instant::now();
    loop {
        // Looked at first: what was pushed before the other end went is still taken.
        let is_last = queue.is_abandoned();
        while let Ok(entry) = queue.pop() {
            recording.take(&entry)?;
        }
        if flushed.elapsed() >= FLUSH_EVERY || is_last {
            flushed = Instant::now();
            recording.flush()?;
        }
        if is_last {
            return Ok(());
        }
        thread::sleep(PAUSE);
    }
}
