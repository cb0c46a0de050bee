//! What a library leaves as it was in the program that calls it.

pub mod floating_point;
pub mod panics;

/// What `body` returns, computed in the default floating-point environment; or the message of its panic, of which nothing is printed.
pub fn guarded<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    floating_point::in_default_environment(|| panics::caught(body))
}
