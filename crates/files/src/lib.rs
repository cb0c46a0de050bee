//! Files that others wrote: read up to a limit, and refused with the number beyond it. A pipe that has a name is refused: nobody may ever write to it.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Bytes of a text: a rig, a scenario, a fieldbus file, `run.json`, what else entered a recorded bridge.
pub const LONGEST_TEXT: u64 = 1 << 26;
/// Bytes of a line of a file that is read line by line.
pub const LONGEST_LINE: usize = 1 << 20;

/// Opens a file that is read in parts, however long it is.
///
/// # Errors
/// What the system says, and for a pipe with a name.
pub fn open(path: &Path) -> io::Result<File> {
    refuse_pipe(path, &fs::metadata(path)?)?;
    File::open(path)
}

/// The bytes of a file, at most so many.
///
/// # Errors
/// What the system says, for a pipe with a name, and for more bytes: with how many there are, where that is known.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > most {
        return Err(io::Error::other(format!("it has {length} bytes; at most {most} are read")));
    }
    let mut bytes = vec![];
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other(format!("it has more than {most} bytes, the most that are read")));
    }
    Ok(bytes)
}

/// The text of a file, at most [`LONGEST_TEXT`] bytes.
///
/// # Errors
/// As of [`read`], and the line of the first byte that is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path, LONGEST_TEXT)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let (before, byte) = (&error.as_bytes()[..at], error.as_bytes()[at]);
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let said = format!("line {line}: byte {at} (0x{byte:02x}) is not UTF-8; the file must be UTF-8 text");
        io::Error::new(io::ErrorKind::InvalidData, said)
    })
}

/// What a shell puts below `/dev` (`/dev/stdin`, `/dev/fd/63`) has a writer.
#[cfg(unix)]
fn refuse_pipe(path: &Path, found: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::FileTypeExt;
    if found.file_type().is_fifo() && !path.starts_with("/dev") {
        return Err(io::Error::other("it is a pipe, to which nobody may ever write; a file is wanted"));
    }
    Ok(())
}

#[cfg(not(unix))]
fn refuse_pipe(_path: &Path, _found: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

/// Reads no line of more than [`LONGEST_LINE`] bytes.
pub struct Lines<R> {
    reader: R,
    /// Of the line so far.
    length: usize,
}

impl<R> Lines<R> {
    /// Of this reader, which stands at the beginning of a line.
    pub fn new(reader: R) -> Self {
        Self { reader, length: 0 }
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(bytes)?;
        let end = bytes[..count].iter().rposition(|byte| *byte == b'\n');
        self.length = end.map_or(self.length + count, |end| count - end - 1);
        if self.length > LONGEST_LINE {
            return Err(io::Error::other(format!(
                "a line has more than {LONGEST_LINE} bytes, the most that are read"
            )));
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(path: &Path) -> String {
        read_text(path).unwrap_err().to_string()
    }

    #[test]
    fn a_file_of_ten_gigabytes_of_nothing_is_refused_with_its_size() {
        let file = tempfile::NamedTempFile::new().unwrap();
        file.as_file().set_len(10_000_000_000).unwrap();
        assert_eq!(said(file.path()), "it has 10000000000 bytes; at most 67108864 are read");
        file.as_file().set_len(LONGEST_TEXT).unwrap();
        assert_eq!(read_text(file.path()).unwrap().len() as u64, LONGEST_TEXT);
    }

    #[cfg(unix)]
    #[test]
    fn a_text_without_end_is_refused_with_the_number_of_bytes() {
        assert_eq!(said(Path::new("/dev/zero")), "it has more than 67108864 bytes, the most that are read");
    }

    /// Until somebody writes, opening it waits.
    #[cfg(unix)]
    #[test]
    fn a_pipe_to_which_nobody_writes_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("rig.toml");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let refused = "it is a pipe, to which nobody may ever write; a file is wanted";
        assert_eq!(said(&pipe), refused);
        assert_eq!(open(&pipe).unwrap_err().to_string(), refused);
    }

    #[test]
    fn what_is_not_text_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, b"one\ntwo \xff").unwrap();
        assert!(said(&path).starts_with("line 2: byte 8 (0xff) is not UTF-8"), "{}", said(&path));
    }

    #[test]
    fn a_line_without_end_is_refused_with_the_number_of_bytes() {
        let mut endless = Lines::new(b"one\n".chain(io::repeat(0)));
        let said = io::copy(&mut endless, &mut io::sink()).unwrap_err().to_string();
        assert_eq!(said, "a line has more than 1048576 bytes, the most that are read");
    }
}
