//! Punctuality: the highest priority, memory that stays, and waiting until a time.

use cable_robot_fieldbus::Nanoseconds;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{ClockId, Timespec, clock_nanosleep_absolute};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Of 99: above what a kernel gives its interrupt threads (50).
const PRIORITY: u8 = 80;
const ADVICE: &str = "cycles may come late. Allow it with rtprio and memlock for the user in /etc/security/limits.d; --no-realtime \
                      leaves it as it is";

/// Gives the calling thread a real-time priority and locks the memory. What the system refuses is said, and is no error.
pub fn prepare() -> Vec<String> {
    let mut warnings = vec![];
    if let Err(reason) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        warnings.push(format!("the memory cannot be locked ({reason}): {ADVICE}"));
    }
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority =
        ThreadPriorityValue::try_from(PRIORITY).map_or(ThreadPriority::Max, ThreadPriority::Crossplatform);
    if let Err(reason) = set_thread_priority_and_policy(thread_native_id(), priority, fifo) {
        warnings.push(format!("no real-time priority ({reason}): {ADVICE}"));
    }
    warnings
}

/// A panic is said in a line: a backtrace takes longer than the drives wait for the next cycle.
pub fn say_panics_briefly() {
    std::panic::set_hook(Box::new(|panic| super::terminal::say(format_args!("can-bridge: {panic}"))));
}

/// Sleeps until a time on the clock of `transport::now`; returns at once if it has passed.
pub fn sleep_until(time: Nanoseconds) {
    let request = Timespec { tv_sec: (time / 1_000_000_000) as i64, tv_nsec: (time % 1_000_000_000) as i64 };
    // Nothing but a signal ends it early.
    while clock_nanosleep_absolute(ClockId::Monotonic, &request)
        .is_err_and(|error| error == rustix::io::Errno::INTR)
    {}
}
