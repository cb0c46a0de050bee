//! What Ctrl-C does to a simulation.

use std::io;
use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use anyhow::{Context, Result};

/// How often the user pressed Ctrl-C, or the program was asked to end. Once: the simulation stops, and what was recorded is written.
/// Twice: the program ends at once; files that are being written are given up and removed. A third time waits for nothing.
#[derive(Clone, Default)]
pub struct Interruption {
    asked: Arc<AtomicUsize>,
    writing: Arc<AtomicBool>,
}

impl Interruption {
    /// Listens from now on.
    pub fn listen() -> Result<Self> {
        let interruption = Self::default();
        let heard = interruption.clone();
        ctrlc::set_handler(move || {
            let before = heard.asked.fetch_add(1, Ordering::Relaxed);
            if before >= 2 || before == 1 && !heard.writing.load(Ordering::Relaxed) {
                exit(crate::INTERRUPTED.into());
            }
        })
        .context("cannot listen to Ctrl-C")?;
        Ok(interruption)
    }

    /// Whether the simulation is to stop.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed) > 0
    }

    /// Whether files are not to be finished.
    pub fn gives_up(&self) -> bool {
        self.asked.load(Ordering::Relaxed) > 1
    }

    /// From now on files are written, and [`go_on`](Self::go_on) is asked often.
    pub fn begin_writing(&self) {
        self.writing.store(true, Ordering::Relaxed);
    }

    /// An error if files are not to be finished.
    pub fn go_on(&self) -> io::Result<()> {
        if self.gives_up() { Err(io::Error::other("interrupted")) } else { Ok(()) }
    }
}
