//! What an FMU has to say: status codes and log messages.
#![allow(unsafe_code)]

use std::collections::VecDeque;
use std::ffi::{CStr, c_char, c_void};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::limits::MOST_COMPLAINTS;

/// Status of a call; the codes of both versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Status {
    /// All is well.
    Ok,
    /// All is well, with a remark.
    Warning,
    /// Refused, the instance is as before.
    Discard,
    /// Failed; only reset, terminate and free are of use now.
    Error,
    /// All instances of the FMU are broken.
    Fatal,
    /// Not finished yet (FMI 2, asynchronous FMUs, which this importer does not serve).
    Pending,
    /// A number that the standard does not know.
    Unknown(u32),
}

impl From<u32> for Status {
    fn from(code: u32) -> Self {
        match code {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            3 => Self::Error,
            4 => Self::Fatal,
            5 => Self::Pending,
            _ => Self::Unknown(code),
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ok => "OK".fmt(f),
            Self::Unknown(code) => write!(f, "the unknown status {code}"),
            other => fmt::Debug::fmt(other, f),
        }
    }
}

/// One message of an FMU.
#[derive(Clone, Debug, PartialEq)]
pub struct LogMessage {
    /// Name of the instance.
    pub instance: String,
    /// How serious.
    pub status: Status,
    /// One of the categories that the FMU declares; empty if it gave none.
    pub category: String,
    /// The text.
    pub text: String,
}

/// Receives every message of an instance, on whichever thread the FMU speaks.
pub type LogCallback = Box<dyn FnMut(&LogMessage) + Send>;

/// Where an instance's messages go: to the caller, and into the error that they explain.
pub(super) struct LogSink {
    instance: String,
    callback: Mutex<LogCallback>,
    complaints: Mutex<VecDeque<String>>,
}

impl LogSink {
    pub(super) fn new(instance: &str, callback: LogCallback) -> Self {
        Self { instance: instance.to_owned(), callback: Mutex::new(callback), complaints: Mutex::default() }
    }

    /// What the FMU complained of since the last time: the newest of it.
    pub(super) fn take_complaints(&self) -> String {
        Vec::from(std::mem::take(&mut *lock(&self.complaints))).join("; ")
    }

    /// The pointer that the FMU hands back with each message.
    pub(super) fn environment(&self) -> *mut c_void {
        std::ptr::from_ref(self).cast_mut().cast()
    }

    pub(super) fn receive(&self, status: Status, category: String, text: String) {
        if status > Status::Warning {
            let mut complaints = lock(&self.complaints);
            if complaints.len() == MOST_COMPLAINTS {
                complaints.pop_front();
            }
            complaints.push_back(text.clone());
        }
        let message = LogMessage { instance: self.instance.clone(), status, category, text };
        (lock(&self.callback))(&message);
    }
}

/// A callback that panicked earlier does no harm to the next message.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// FMI 3's logger.
pub(super) unsafe extern "C" fn log_fmi3(
    environment: *mut c_void,
    status: u32,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as for this function: the FMU passes what FMI 3 says.
    unsafe { forward(environment, status, category, message, |text| text) };
}

/// FMI 2's logger, without the arguments that its `message` may ask for printf-style: Rust cannot read them.
/// `%%` becomes `%`, as printf would have it; other directives are left as they stand.
pub(super) unsafe extern "C" fn log_fmi2(
    environment: *mut c_void,
    _instance_name: *const c_char,
    status: u32,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as for this function: the FMU passes what FMI 2 says.
    unsafe { forward(environment, status, category, message, |text| text.replace("%%", "%")) };
}

/// # Safety
/// `environment` is null or from [`LogSink::environment`] of a live sink; the strings are null or C strings.
unsafe fn forward(
    environment: *mut c_void,
    status: u32,
    category: *const c_char,
    message: *const c_char,
    clean: fn(String) -> String,
) {
    // A panic of the caller's callback must not unwind into the FMU's C frames.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the sink lives, boxed and unmoved, until after the instance is freed; it is only shared.
        if let Some(sink) = unsafe { environment.cast::<LogSink>().as_ref() } {
            // SAFETY: the FMU passes null or a C string that lives during this call.
            let (category, text) = unsafe { (owned(category), owned(message)) };
            sink.receive(Status::from(status), category, clean(text));
        }
    }));
}

/// # Safety
/// `text` is null or a C string.
unsafe fn owned(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not null, hence a C string.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn fmi2_messages_lose_the_doubled_percent_and_null_strings_are_empty() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ear = Arc::clone(&heard);
        let sink = LogSink::new("p", Box::new(move |m| ear.lock().expect("no panic").push(m.clone())));
        // SAFETY: the sink lives, the message is a C string, null is allowed.
        unsafe {
            log_fmi2(sink.environment(), std::ptr::null(), 3, std::ptr::null(), c"5 %% of %s".as_ptr());
            log_fmi3(sink.environment(), 1, c"warn".as_ptr(), c"5 %% stays".as_ptr());
            log_fmi2(std::ptr::null_mut(), std::ptr::null(), 3, std::ptr::null(), std::ptr::null());
        }
        let said: Vec<_> =
            heard.lock().expect("no panic").iter().map(|m: &LogMessage| m.text.clone()).collect();
        assert_eq!(said, ["5 % of %s", "5 %% stays"]);
        assert_eq!(sink.take_complaints(), "5 % of %s", "the warning is no complaint");
        assert_eq!(sink.take_complaints(), "");
    }

    /// Calls that succeed may complain as well, and nobody asks why they failed.
    #[test]
    fn complaints_that_nobody_asks_for_do_not_pile_up() {
        let sink = LogSink::new("p", Box::new(|_| {}));
        for k in 0..3 * MOST_COMPLAINTS {
            sink.receive(Status::Error, String::new(), k.to_string());
        }
        let said = sink.take_complaints();
        assert_eq!(said.split("; ").count(), MOST_COMPLAINTS);
        assert!(said.ends_with(&format!("; {}", 3 * MOST_COMPLAINTS - 1)), "{said}");
    }

    #[test]
    fn a_panicking_callback_does_not_unwind_into_the_fmu() {
        let sink = LogSink::new("p", Box::new(|_| panic!("on purpose")));
        // SAFETY: the sink lives, the message is a C string.
        unsafe {
            log_fmi3(sink.environment(), 3, std::ptr::null(), c"one".as_ptr());
            log_fmi3(sink.environment(), 3, std::ptr::null(), c"two".as_ptr());
        }
        assert_eq!(sink.take_complaints(), "one; two");
    }
}
