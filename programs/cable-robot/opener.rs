//! Shows a file with the program that the platform has for it.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

/// The platform's own.
const OPENER: &str = if cfg!(windows) {
    "explorer"
} else if cfg!(target_os = "macos") {
    "open"
} else {
    "xdg-open"
};
/// What has not failed by then shows the file: where there is no desktop, `xdg-open` lasts as long as the browser.
const PATIENCE: Duration = Duration::from_secs(2);
const PAUSE: Duration = Duration::from_millis(20);

/// Opens `path`; the browser may outlive this program.
///
/// # Errors
/// There is no opener, or it failed: both say what to do instead.
pub fn open(path: &Path) -> Result<()> {
    let instead = format!("open {} in a browser yourself", path.display());
    let mut command = Command::new(OPENER);
    command.arg(path).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(reason) if reason.kind() == ErrorKind::NotFound => {
            bail!("--open: there is no {OPENER} here (on Linux it is in the package xdg-utils); {instead}")
        }
        Err(reason) => bail!("--open: {OPENER}: {reason}; {instead}"),
    };
    let begun = Instant::now();
    let mut ended: Option<ExitStatus> = None;
    while ended.is_none() && begun.elapsed() < PATIENCE {
        sleep(PAUSE);
        ended = child.try_wait()?;
    }
    match ended {
        // Explorer fails always.
        Some(status) if !status.success() && !cfg!(windows) => bail!("--open: {OPENER}: {status}; {instead}"),
        _ => Ok(()),
    }
}
