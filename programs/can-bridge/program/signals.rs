//! SIGINT, SIGTERM and SIGHUP: the first one asks for the end, a deliberate second one cuts the torque off.

use std::ffi::c_int;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// A signal that follows the first so soon is an echo of it: a dying shell and the kernel both send SIGHUP, `timeout` signals the
/// program and its group.
const ECHO: Duration = Duration::from_millis(500);

/// How often the end was asked for, 0 to 2, kept up to date by a thread of its own.
pub fn listen() -> Result<Arc<AtomicU32>> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).context("cannot listen to signals")?;
    let count = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&count);
    let listen = move || {
        let mut requests = Requests::default();
        for signal in signals.forever() {
            counted.store(requests.take(signal, Instant::now()), Ordering::Relaxed);
        }
    };
    thread::Builder::new().name("signals".to_owned()).spawn(listen).context("no thread for signals")?;
    Ok(count)
}

#[derive(Default)]
struct Requests {
    first: Option<Instant>,
    has_second: bool,
}

impl Requests {
    /// How often the end has been asked for, with this signal.
    fn take(&mut self, signal: c_int, now: Instant) -> u32 {
        match self.first {
            None => self.first = Some(now),
            // Nobody hangs up to have the torque cut off.
            Some(first) => self.has_second |= signal != SIGHUP && now.duration_since(first) >= ECHO,
        }
        1 + u32::from(self.has_second)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn echoes_and_hang_ups_are_no_second_signal_but_a_later_one_is() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut requests = Requests::default();
        assert_eq!(requests.take(SIGHUP, at(0)), 1);
        assert_eq!(requests.take(SIGHUP, at(3)), 1);
        assert_eq!(requests.take(SIGTERM, at(499)), 1);
        assert_eq!(requests.take(SIGHUP, at(5000)), 1);
        assert_eq!(requests.take(SIGINT, at(6000)), 2);
        assert_eq!(requests.take(SIGHUP, at(7000)), 2);
    }
}
