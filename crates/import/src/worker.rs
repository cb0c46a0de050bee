//! How the process is started in which a foreign FMU runs.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Longest time that a call may take unless the caller says otherwise.
const LIMIT: Duration = Duration::from_secs(60);

/// A program in whose process an FMU runs: `cable-robot fmu-worker`, or any other that does nothing but [`serve`](super::serve).
#[derive(Clone)]
pub struct Worker {
    pub(super) program: PathBuf,
    pub(super) arguments: Vec<OsString>,
    pub(super) limit: Duration,
    pub(super) stop: Arc<dyn Fn() -> bool + Send + Sync>,
    pub(super) show: Show,
}

/// Who shows what an FMU prints.
pub(super) type Show = Arc<dyn Fn(&str) + Send + Sync>;

impl Worker {
    /// This program, with these arguments. A call may take a minute; what the FMU prints goes to stderr as it is.
    pub fn new(program: impl Into<PathBuf>, arguments: &[&str]) -> Self {
        let arguments = arguments.iter().map(OsString::from).collect();
        Self {
            program: program.into(),
            arguments,
            limit: LIMIT,
            stop: Arc::new(|| false),
            // Nothing depends on whether it is read.
            show: Arc::new(|text| drop(io::stderr().write_all(text.as_bytes()))),
        }
    }

    /// Longest time that a call may take, loading and freeing included; the process is killed then.
    #[must_use]
    pub fn with_limit(self, limit: Duration) -> Self {
        Self { limit, ..self }
    }

    /// Hands what the FMU prints, to stdout or stderr, to `show`, a line or a part of a long one at a time, from a thread of its own.
    #[must_use]
    pub fn with_prints(self, show: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { show: Arc::new(show), ..self }
    }

    /// Gives a call up that has lasted a tenth of a second once `stop` is true: the process is killed then.
    #[must_use]
    pub fn until(self, stop: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self { stop: Arc::new(stop), ..self }
    }
}
