//! The clock that deadlines and arrivals are told on, and waiting on it.

use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::time::{ClockId, clock_gettime};

use crate::Nanoseconds;

/// The time on CLOCK_MONOTONIC, ns: never set, so a step of the wall clock does no harm.
pub fn now() -> Nanoseconds {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

/// Waits until there is something to read, be it an error, or until the deadline; whether there is.
pub(super) fn wait_until_readable(link: impl AsFd, deadline: Nanoseconds) -> Result<bool, Errno> {
    loop {
        let left = Duration::from_nanos(deadline.saturating_sub(now()));
        let timeout = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: left.subsec_nanos().into() };
        match poll(&mut [PollFd::new(&link, PollFlags::IN)], Some(&timeout)) {
            Err(Errno::INTR) => {}
            result => return result.map(|ready| ready > 0),
        }
    }
}
