//! How far a piece of work is.

use std::fs::File;
use std::io::{self, Read};
use std::sync::Once;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work that lasts longer shows how far it is.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar on stderr, on a terminal only, once the work has lasted a second; it is gone when this is.
pub struct Progress {
    bar: ProgressBar,
    begun: Instant,
    shown: Once,
}

impl Progress {
    /// `what` is done in so many steps.
    pub fn new(what: &'static str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(what);
        Self { bar, begun: Instant::now(), shown: Once::new() }
    }

    /// So many more steps are done.
    pub fn done(&self, steps: u64) {
        if self.begun.elapsed() > PATIENCE {
            self.shown.call_once(|| self.bar.set_draw_target(ProgressDrawTarget::stderr()));
        }
        self.bar.inc(steps);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A file that shows how much of it is read.
pub struct WatchedFile {
    file: File,
    progress: Progress,
}

impl WatchedFile {
    /// Read from where it stands.
    pub fn new(file: File) -> Self {
        let length = file.metadata().map_or(0, |file| file.len());
        Self { file, progress: Progress::new("reading", length) }
    }
}

impl Read for WatchedFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(bytes)?;
        self.progress.done(count as u64);
        Ok(count)
    }
}
