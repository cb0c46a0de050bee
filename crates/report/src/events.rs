//! What happened in a run beside its rows: states of a bridge, its faults, what became of goals. Only a run at a rig has such a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::RunFolderError;
use super::table::TableError;
use cable_robot_files::read_text;

/// The file, in the run folder.
pub const EVENTS_CSV: &str = "events.csv";
/// Its header.
pub const EVENT_COLUMNS: [&str; 3] = ["time", "kind", "text"];

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// When, s: of the run's rows.
    pub time: f64,
    /// What kind of thing.
    pub kind: Kind,
    /// In words.
    pub text: String,
}

/// What kind of thing happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The bridge went into a state.
    State,
    /// Something was found wrong.
    Fault,
    /// A goal was given, reached, given up or found unreachable.
    Goal,
    /// A goal was not taken.
    Refused,
}

impl Kind {
    /// As the file has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::State => "state",
            Self::Fault => "fault",
            Self::Goal => "goal",
            Self::Refused => "refused",
        }
    }
}

/// States in which the run is what it is there for.
const ORDINARY: [&str; 2] = ["Enabled", "Shadow"];

/// From when to when the bridge was in another state than the ordinary ones, s.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateSpan {
    state: String,
    from: f64,
    to: f64,
}

/// The events of a run folder; none if it has no such file.
///
/// # Errors
/// [`RunFolderError`]: it cannot be read, or a line is no event.
pub fn read(folder: &Path) -> Result<Vec<Event>, RunFolderError> {
    let path = folder.join(EVENTS_CSV);
    if !path.exists() {
        return Ok(vec![]);
    }
    let text = read_text(&path).map_err(|reason| RunFolderError::Read { path: path.clone(), reason })?;
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    let events: Result<Vec<Event>, TableError> = rows
        .enumerate()
        .map(|(k, row)| {
            let event: Event = row?;
            let no_time = || TableError::NotANumber {
                line: k as u64 + 2,
                column: 1,
                name: EVENT_COLUMNS[0].to_owned(),
                text: event.time.to_string(),
            };
            if event.time.is_finite() { Ok(event) } else { Err(no_time()) }
        })
        .collect();
    events.map_err(|reason| RunFolderError::Csv { path, reason })
}

/// The states that are not ordinary, until the next or the end of the run, s.
pub fn state_spans(events: &[Event], end: f64) -> Vec<StateSpan> {
    let states: Vec<_> = events.iter().filter(|event| event.kind == Kind::State).collect();
    let ends = states.iter().skip(1).map(|next| next.time).chain([end]);
    let spans = states.iter().zip(ends);
    spans
        .filter(|(event, to)| !ORDINARY.contains(&event.text.as_str()) && *to > event.time)
        .map(|(event, to)| StateSpan { state: event.text.clone(), from: event.time, to })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_event_is_refused_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read(folder.path()).unwrap(), []);
        let write = |rows: &str| {
            std::fs::write(folder.path().join(EVENTS_CSV), format!("time,kind,text\n{rows}")).unwrap();
        };
        write("0,state,Enabled\n1.5,fault,\"a, b\"\n");
        let events = read(folder.path()).unwrap();
        assert_eq!((events[1].kind, events[1].text.as_str()), (Kind::Fault, "a, b"));
        for rows in ["0,what,ever\n", "0,state\n", "soon,state,Safe\n", "NaN,state,Safe\n"] {
            write(rows);
            let error = read(folder.path()).unwrap_err().to_string();
            assert!(error.contains("events.csv") && error.contains("line"), "{error}");
        }
    }

    #[test]
    fn states_last_until_the_next_or_the_end() {
        let event = |time, text: &str| Event { time, kind: Kind::State, text: text.to_owned() };
        let events = [event(0.0, "Enabled"), event(2.0, "Stopping"), event(3.0, "Fault"), event(9.0, "Off")];
        let span = |state: &str, from, to| StateSpan { state: state.to_owned(), from, to };
        assert_eq!(state_spans(&events, 9.0), [span("Stopping", 2.0, 3.0), span("Fault", 3.0, 9.0)]);
    }
}
