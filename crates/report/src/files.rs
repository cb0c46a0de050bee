//! Files: tried before the work, written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::RunFolderError;

/// As Linux follows.
const MOST_LINKS: usize = 40;

/// A file that is whole but not yet in its place; dropped, it is removed.
pub struct Part {
    /// As the user calls it.
    path: PathBuf,
    /// Where it goes; a link leads there.
    place: PathBuf,
    /// `None` for what is no file, a device or a pipe, which was written to.
    file: Option<NamedTempFile>,
}

impl Part {
    /// Writes a file beside its place, under a name of its own.
    ///
    /// # Errors
    /// [`RunFolderError::Write`]; nothing is left then.
    pub fn write(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
    ) -> Result<Self, RunFolderError> {
        let written = || -> io::Result<Self> {
            let place = place(path)?;
            let file = if becomes_file(&place) {
                let file = beside(&place)?;
                write_to(file.as_file(), write)?;
                file.as_file().sync_all()?;
                Some(file)
            } else {
                write_to(&File::create(&place)?, write)?;
                None
            };
            Ok(Self { path: path.to_owned(), place, file })
        };
        written().map_err(|reason| unwritten(path, reason))
    }

    /// Moves it to its place.
    ///
    /// # Errors
    /// [`RunFolderError::Write`]; the file that stood there is then untouched.
    pub fn settle(self) -> Result<(), RunFolderError> {
        let Self { path, place, file } = self;
        let Some(file) = file else { return Ok(()) };
        file.persist(place).map(drop).map_err(|refused| unwritten(&path, refused.error))
    }
}

/// Writes a file beside its place and moves it there when it is whole. A link leads to the place; what is no file (a device, a pipe) is
/// written to.
///
/// # Errors
/// [`RunFolderError::Write`]; the file that stood at `path` is then untouched.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), RunFolderError> {
    Part::write(path, write)?.settle()
}

/// An empty file in the place of what stood there, to be written as its content comes. Links and what is no file are treated as
/// [`write_whole`] treats them.
///
/// # Errors
/// [`RunFolderError::Write`]; the file that stood at `path` is then untouched.
pub fn begin(path: &Path) -> Result<File, RunFolderError> {
    let begun = || -> io::Result<File> {
        let place = place(path)?;
        if becomes_file(&place) { Ok(beside(&place)?.persist(&place)?) } else { File::create(&place) }
    };
    begun().map_err(|reason| unwritten(path, reason))
}

/// Sees whether [`write_whole`] can put a file there: to be called before the work. What stands there is not touched.
///
/// # Errors
/// [`RunFolderError::Write`].
pub fn probe(path: &Path) -> Result<(), RunFolderError> {
    let tried = place(path).and_then(|place| match fs::metadata(&place) {
        Ok(there) if there.is_dir() => Err(io::Error::other("it is a folder, a file is wanted")),
        // A pipe that is opened and closed again would have ended for its reader.
        Ok(there) if !there.is_file() => Ok(()),
        _ => tempfile::tempfile_in(folder_of(&place)).map(drop),
    });
    tried.map_err(|reason| unwritten(path, reason))
}

/// Where a file goes: links lead there, as far as they can be trusted.
fn place(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&place) {
            Ok(link) if link.is_symlink() => {
                trust(&place, &link)?;
                place = folder_of(&place).join(fs::read_link(&place)?);
            }
            _ => return Ok(place),
        }
    }
    Err(io::Error::other(format!("more than {MOST_LINKS} links one after another")))
}

/// Refuses a link that somebody else may have planted.
#[cfg(unix)]
fn trust(link: &Path, found: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let folder = fs::metadata(folder_of(link))?;
    let own = rustix::process::geteuid().as_raw();
    if may_follow(found.uid(), folder.uid(), folder.mode(), own) {
        return Ok(());
    }
    let said = format!("{} is a link of somebody else, in a folder where anybody can write", link.display());
    Err(io::Error::new(io::ErrorKind::PermissionDenied, said))
}

#[cfg(not(unix))]
fn trust(_link: &Path, _found: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

/// The rule of Linux's `protected_symlinks`, which reading a link goes around: in a folder where anybody can write, those of the user and of the
/// folder's owner.
#[cfg(unix)]
fn may_follow(link: u32, folder: u32, mode: u32, own: u32) -> bool {
    mode & 0o002 == 0 || link == own || link == folder
}

/// Whether a file is to stand there, in place of one or of nothing.
fn becomes_file(place: &Path) -> bool {
    fs::metadata(place).map_or(true, |place| place.is_file())
}

/// A new file beside its place: whoever may read what stands there may read it.
fn beside(place: &Path) -> io::Result<NamedTempFile> {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".{name}.");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    let there = fs::metadata(place).ok();
    #[cfg(unix)]
    if there.is_none() {
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask, as any file
    }
    let file = builder.tempfile_in(folder_of(place))?;
    if let Some(there) = there {
        file.as_file().set_permissions(there.permissions())?;
    }
    Ok(file)
}

fn write_to(file: &File, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let mut file = BufWriter::new(file);
    write(&mut file)?;
    file.into_inner()?;
    Ok(())
}

fn folder_of(place: &Path) -> &Path {
    place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

pub(super) fn unwritten(path: &Path, reason: io::Error) -> RunFolderError {
    RunFolderError::Write { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_file_that_cannot_be_finished_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "old").unwrap();
        let half = write_whole(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(half.unwrap_err().to_string().ends_with("file: the disk is full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn two_that_write_one_file_at_once_do_not_meet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let part = |text: &str| Part::write(&path, |file| file.write_all(text.as_bytes())).unwrap();
        let (first, second) = (part("first"), part("second"));
        first.settle().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        second.settle().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_what_is_written() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let [whole, plain] = ["whole", "plain"].map(|name| folder.path().join(name));
        write_whole(&whole, |file| file.write_all(b"text")).unwrap();
        fs::write(&plain, "text").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&whole), mode(&plain));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_only_its_owner_may_read_stays_so() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.html");
        let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        for wanted in [0o600, 0o640, 0o444] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(wanted)).unwrap();
            write_whole(&path, |file| file.write_all(b"new")).unwrap();
            assert_eq!((mode(), fs::read_to_string(&path).unwrap().as_str()), (wanted, "new"));
            drop(begin(&path).unwrap());
            assert_eq!(mode(), wanted);
            fs::remove_file(&path).unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_planted_where_anybody_can_write_is_not_followed() {
        use std::os::unix::fs::{PermissionsExt, lchown, symlink};
        let (own, other, owner) = (1000, 1001, 0);
        assert!(!may_follow(other, owner, 0o1777, own));
        assert!(may_follow(own, owner, 0o1777, own) && may_follow(owner, owner, 0o1777, own));
        assert!(may_follow(other, owner, 0o755, own));

        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o1777)).unwrap();
        let [victim, link] = ["victim", "report.html"].map(|name| folder.path().join(name));
        fs::write(&victim, "old").unwrap();
        symlink(&victim, &link).unwrap();
        // Only root can give a link away; for others the rule above has to do.
        if lchown(&link, Some(other), None).is_ok() {
            let refused = [
                write_whole(&link, |file| file.write_all(b"new")).unwrap_err(),
                begin(&link).unwrap_err(),
                probe(&link).unwrap_err(),
            ];
            for said in refused.map(|error| error.to_string()) {
                assert!(
                    said.ends_with("a link of somebody else, in a folder where anybody can write"),
                    "{said}"
                );
            }
            assert_eq!(fs::read_to_string(&victim).unwrap(), "old");
        }
    }

    #[test]
    fn a_device_is_not_replaced_by_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let [device, link] = ["device", "link"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("/dev/full", &device).unwrap();
        let full = write_whole(&device, |file| file.write_all(b"text")).unwrap_err().to_string();
        assert!(full.contains("device: No space left"), "{full}");
        assert!(device.is_symlink() && !fs::metadata(&device).unwrap().is_file());
        let file = folder.path().join("file");
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, |file| file.write_all(b"new")).unwrap();
        assert!(link.is_symlink() && fs::read_to_string(&file).unwrap() == "new");
    }
}
