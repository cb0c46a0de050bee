//! What Ctrl-C does to a simulation.

use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};

/// How often the user pressed Ctrl-C, or the program was asked to end. Once: the simulation stops, also where an FMU does not return. Twice: the
/// program ends at once. Every row so far is written in any case.
#[derive(Clone, Default)]
pub struct Interruption {
    asked: Arc<AtomicUsize>,
}

impl Interruption {
    /// Listens from now on.
    pub fn listen() -> Result<Self> {
        let interruption = Self::default();
        let heard = interruption.clone();
        ctrlc::set_handler(move || {
            if heard.asked.fetch_add(1, Ordering::Relaxed) > 0 {
                exit(crate::command::INTERRUPTED.into());
            }
        })
        .context("cannot listen to Ctrl-C")?;
        Ok(interruption)
    }

    /// Whether the simulation is to stop.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed) > 0
    }
}
