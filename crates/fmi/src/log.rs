//! What an instance tells its environment.

use std::ffi::CStr;

use super::error::{FmiError, Status};

/// The log categories of the XML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Why a call failed.
    Error,
    /// Why a call was not carried out, although the run may go on.
    Discard,
    /// What is allowed and yet worth a word.
    Warning,
    /// What happens in the run.
    Events,
}

/// Every category, in the order of the XML.
pub const CATEGORIES: [Category; 4] =
    [Category::Error, Category::Discard, Category::Warning, Category::Events];

impl Category {
    /// Name in the XML: one of the standard's own.
    pub fn name(self) -> &'static CStr {
        match self {
            Category::Error => c"logStatusError",
            Category::Discard => c"logStatusDiscard",
            Category::Warning => c"logStatusWarning",
            Category::Events => c"logEvents",
        }
    }

    /// One sentence for the XML.
    pub fn description(self) -> &'static str {
        match self {
            Category::Error => "Why a call failed; always sent, also with logging off",
            Category::Discard => "Why a call was not carried out although the run may go on; always sent",
            Category::Warning => "What is allowed and yet worth a word",
            Category::Events => "Initialisation, changes of discrete outputs such as status, termination",
        }
    }
}

/// How a message reaches the environment: status, category, text. The C callback is behind it.
pub type Sink = Box<dyn Fn(Status, &CStr, &str)>;

/// Sends messages. A call that does not return OK always says why, since a bare status helps nobody; all else is sent if
/// its category is enabled.
pub struct Log {
    sink: Sink,
    enabled: [bool; CATEGORIES.len()],
}

impl Log {
    /// All categories enabled, or none.
    pub fn new(sink: Sink, on: bool) -> Self {
        Self { sink, enabled: [on; CATEGORIES.len()] }
    }

    /// Whether the category is enabled.
    pub fn is_enabled(&self, category: Category) -> bool {
        self.enabled[category as usize]
    }

    /// Sends a message: always if it explains a status, else if its category is enabled.
    pub fn send(&self, status: Status, category: Category, message: &str) {
        if status != Status::Ok || self.is_enabled(category) {
            (self.sink)(status, category.name(), message);
        }
    }

    /// Enables or disables the categories named, or all of them if none is.
    ///
    /// # Errors
    /// [`FmiError::UnknownCategory`] for the first name that is none; the others are obeyed.
    pub fn enable(&mut self, on: bool, names: &[String]) -> Result<(), FmiError> {
        if names.is_empty() {
            self.enabled = [on; CATEGORIES.len()];
        }
        let mut outcome = Ok(());
        for name in names {
            match CATEGORIES.into_iter().find(|category| category.name().to_bytes() == name.as_bytes()) {
                Some(category) => self.enabled[category as usize] = on,
                None if outcome.is_ok() => outcome = Err(unknown(name)),
                None => {}
            }
        }
        outcome
    }
}

fn unknown(name: &str) -> FmiError {
    let known: Vec<_> = CATEGORIES.iter().map(|category| category.name().to_string_lossy()).collect();
    FmiError::UnknownCategory { name: name.to_owned(), known: known.join(", ") }
}
