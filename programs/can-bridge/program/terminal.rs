//! What a person reads on stderr: lines, and below them the status. Nobody waits for it to be written: the platform is to be held also
//! when a terminal is gone, or stopped.

use std::fmt::Display;
use std::io::Write;
use std::sync::OnceLock;

use anyhow::Result;
use cable_robot_programs::plain::plain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::outlet::Outlet;

enum Text {
    Line(String),
    Status(String),
    Typed(Option<String>),
    NoStatus,
}

static OUTLET: OnceLock<Outlet<Text>> = OnceLock::new();

/// Starts the thread that writes. To be called before the calling thread gets a priority, which it would inherit.
pub fn start() -> Result<()> {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.set_style(ProgressStyle::with_template("{wide_msg}")?);
    let (mut status, mut typed) = (String::new(), None);
    let write = move |text| {
        match text {
            Text::Line(line) => {
                bar.suspend(|| print(&line));
                return Ok(());
            }
            Text::NoStatus => {
                bar.finish_and_clear();
                return Ok(());
            }
            Text::Status(line) => status = line,
            Text::Typed(line) => typed = line,
        }
        let shown = typed.as_ref().map_or(status.clone(), |typed| format!("{typed} | {status}"));
        bar.set_message(plain(&shown).into_owned());
        bar.tick();
        Ok(())
    };
    let _ = OUTLET.set(Outlet::new("terminal", write)?);
    Ok(())
}

/// A line.
pub fn say(text: impl Display) {
    match OUTLET.get() {
        Some(outlet) => outlet.push(Text::Line(text.to_string())),
        None => print(&text.to_string()),
    }
}

/// What the last line of a terminal shows from now on.
pub fn show(status: String) {
    if let Some(outlet) = OUTLET.get() {
        outlet.push(Text::Status(status));
    }
}

/// What the operator is typing, before the status.
pub fn show_typed(typed: Option<String>) {
    if let Some(outlet) = OUTLET.get() {
        outlet.push(Text::Typed(typed));
    }
}

/// No status any more.
pub fn show_nothing() {
    if let Some(outlet) = OUTLET.get() {
        outlet.push(Text::NoStatus);
    }
}

/// Waits for what is still to be read, but not for somebody who does not read.
pub fn finish() {
    OUTLET.get().map(Outlet::finish);
}

fn print(line: &str) {
    // Nobody is left to tell if it fails.
    let _ = writeln!(std::io::stderr(), "{}", plain(line));
}
