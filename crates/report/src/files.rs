//! Files: read as text, tried before the work, written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::RunFolderError;

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
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let is_file = fs::metadata(&place).map_or(true, |place| place.is_file());
        let written = if is_file {
            write_beside(&place, write).map(Some)
        } else {
            File::create(&place).and_then(|file| write_to(&file, write)).map(|()| None)
        };
        match written {
            Ok(file) => Ok(Self { path: path.to_owned(), place, file }),
            Err(reason) => Err(unwritten(path, reason)),
        }
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

/// Sees whether [`write_whole`] can put a file there: to be called before the work. What stands there is not touched.
///
/// # Errors
/// [`RunFolderError::Write`].
pub fn probe(path: &Path) -> Result<(), RunFolderError> {
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let tried = match fs::metadata(&place) {
        Ok(there) if there.is_dir() => Err(io::Error::other("it is a folder, a file is wanted")),
        // A pipe that is opened and closed again would have ended for its reader.
        Ok(there) if !there.is_file() => Ok(()),
        _ => tempfile::tempfile_in(folder_of(&place)).map(drop),
    };
    tried.map_err(|reason| unwritten(path, reason))
}

/// The text of a file.
///
/// # Errors
/// What the system says, or the line of the first byte that is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(fs::read(path)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let (before, byte) = (&error.as_bytes()[..at], error.as_bytes()[at]);
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let said = format!("line {line}: byte {at} (0x{byte:02x}) is not UTF-8; the file must be UTF-8 text");
        io::Error::new(io::ErrorKind::InvalidData, said)
    })
}

fn write_beside(
    place: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<NamedTempFile> {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".{name}.");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask, as any file
    let file = builder.tempfile_in(folder_of(place))?;
    write_to(file.as_file(), write)?;
    file.as_file().sync_all()?;
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

fn unwritten(path: &Path, reason: io::Error) -> RunFolderError {
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

    #[test]
    fn what_is_not_text_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, b"one\ntwo \xff").unwrap();
        let said = read_text(&path).unwrap_err().to_string();
        assert!(said.starts_with("line 2: byte 8 (0xff) is not UTF-8"), "{said}");
    }
}
