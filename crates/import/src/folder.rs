//! The temporary folder into which an FMU is unpacked.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::time::Duration;

use tempfile::TempDir;

const PREFIX: &str = "fmu-";
/// Locked for as long as the folder is in use: the system lets go of it however a process ends.
const LOCK: &str = ".lock";
/// A folder that is younger may not be locked yet.
const YOUNG: Duration = Duration::from_secs(60);

/// Goes when it is dropped. One of a process that was killed goes when the next FMU is opened.
pub(crate) struct Folder {
    folder: TempDir,
    _lock: File,
}

impl Folder {
    /// A new one in the system's folder for temporary files.
    pub fn new() -> io::Result<Self> {
        let parent = std::env::temp_dir().canonicalize()?;
        remove_abandoned(&parent);
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let folder = builder.tempdir_in(parent)?;
        let lock = File::create(folder.path().join(LOCK))?;
        lock.lock()?;
        Ok(Self { folder, _lock: lock })
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes the folders that nobody holds. What cannot be removed, or belongs to somebody else, stays.
fn remove_abandoned(parent: &Path) {
    let folders = fs::read_dir(parent).into_iter().flatten().flatten();
    for folder in folders.filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX)) {
        if is_abandoned(&folder.path().join(LOCK)) {
            let _ = fs::remove_dir_all(folder.path());
        }
    }
}

fn is_abandoned(lock: &Path) -> bool {
    let Ok(lock) = File::options().read(true).write(true).open(lock) else { return false };
    let age = lock.metadata().and_then(|found| found.modified()).ok().and_then(|time| time.elapsed().ok());
    age.is_some_and(|age| age > YOUNG) && lock.try_lock().is_ok()
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    /// A folder as it was left an hour ago, and its lock.
    fn left() -> (std::path::PathBuf, File) {
        let Folder { folder, _lock: lock } = Folder::new().unwrap();
        lock.set_modified(SystemTime::now() - Duration::from_secs(3600)).unwrap();
        (folder.keep(), lock)
    }

    #[cfg(unix)]
    #[test]
    fn nobody_else_may_look_into_it_or_put_something_there() {
        use std::os::unix::fs::PermissionsExt;
        let folder = Folder::new().unwrap();
        assert_eq!(fs::metadata(folder.path()).unwrap().permissions().mode() & 0o777, 0o700);
    }

    /// Each process that was killed left the unpacked FMU behind.
    #[test]
    fn what_a_killed_process_left_goes_and_what_is_in_use_stays() {
        let (abandoned, lock) = left();
        drop(lock);
        let (used, lock) = left();
        let fresh = Folder::new().unwrap();
        assert!(!abandoned.exists() && used.exists() && fresh.path().exists());
        drop(lock);
        fs::remove_dir_all(used).unwrap();
        let path = fresh.path().to_owned();
        drop(fresh);
        assert!(!path.exists());
    }
}
