//! Panics end here: unwinding into C would abort the host, and its stderr is none of ours.
//!
//! What a panic prints comes from a hook, of which there is one in a process for all Rust code that shares a standard library: in an FMU that is this library alone,
//! elsewhere the program that it is linked into. So the hook that was there is asked as before for all panics but those within a call.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static IS_WITHIN_A_CALL: Cell<bool> = const { Cell::new(false) };
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What `body` returns, or the message of its panic, with the place in the source. Nothing is printed.
pub fn caught<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let other = take_hook();
        set_hook(Box::new(move |panic| match IS_WITHIN_A_CALL.get() {
            true => note(panic),
            false => other(panic),
        }));
    });
    let was_within = IS_WITHIN_A_CALL.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(body));
    IS_WITHIN_A_CALL.set(was_within);
    outcome.map_err(|_| MESSAGE.take())
}

fn note(panic: &PanicHookInfo) {
    let said = panic.payload_as_str().unwrap_or("unknown");
    let place = panic.location().map(|place| format!(" ({place})")).unwrap_or_default();
    MESSAGE.set(format!("{said}{place}"));
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A panic within a call went to the host's stderr, with a backtrace of 35 MB once.
    #[test]
    fn a_panic_within_a_call_is_a_message_and_prints_nothing() {
        static PRINTED: AtomicUsize = AtomicUsize::new(0);
        let printed = |panic: &PanicHookInfo| {
            let is_ours = panic.payload_as_str().is_some_and(|said| said.starts_with("on purpose"));
            PRINTED.fetch_add(usize::from(is_ours), Ordering::Relaxed);
        };
        // The hook of the host; ours comes before it with the first call.
        std::thread::spawn(move || {
            let other = take_hook();
            set_hook(Box::new(move |panic| {
                printed(panic);
                other(panic);
            }));
        })
        .join()
        .unwrap();
        assert_eq!(caught(|| 1), Ok(1));
        let message = caught(|| -> u32 { panic!("on purpose, {}", 2) }).unwrap_err();
        assert!(message.starts_with("on purpose, 2 (") && message.contains("panics.rs:"), "{message}");
        assert_eq!(PRINTED.load(Ordering::Relaxed), 0);
        assert!(catch_unwind(|| panic!("on purpose, outside")).is_err());
        assert_eq!(PRINTED.load(Ordering::Relaxed), 1);
    }
}
