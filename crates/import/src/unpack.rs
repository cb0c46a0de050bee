//! An archive's files, put into a temporary folder: nothing outside it, and not more than fits.

use std::fs::{self, File};
use std::io::{self, Read, Seek};
use std::path::Path;

use zip::ZipArchive;
use zip::read::ZipFile;

use super::folder::Folder;
use super::limits::{MOST_ENTRIES, MOST_UNPACKED};

/// Unpacks into a new temporary folder; the reason if that fails.
pub(super) fn unpack(archive: impl Read + Seek) -> Result<Folder, String> {
    let mut archive = ZipArchive::new(archive).map_err(|e| e.to_string())?;
    let folder = Folder::new().map_err(|e| e.to_string())?;
    extract(&mut archive, folder.path(), MOST_UNPACKED)?;
    // An FMU may come without, and is told the path all the same.
    fs::create_dir_all(folder.path().join("resources")).map_err(|e| e.to_string())?;
    Ok(folder)
}

/// Puts everything into `folder`, at most `most` bytes: those that come count, whatever the archive says of them.
fn extract<R: Read + Seek>(archive: &mut ZipArchive<R>, folder: &Path, most: u64) -> Result<(), String> {
    let count = archive.len();
    if count > MOST_ENTRIES {
        return Err(format!("{count} files are in it; at most {MOST_ENTRIES} are unpacked"));
    }
    let mut rest = most;
    for index in 0..count {
        let mut entry = archive.by_index(index).map_err(|e| e.to_string())?;
        let name = entry.name().map_err(|e| e.to_string())?.into_owned();
        let written = write(&mut entry, folder, rest).map_err(|reason| format!("{name}: {reason}"))?;
        rest = rest.checked_sub(written).ok_or_else(|| {
            format!("{name}: unpacked it has more than {most} bytes, the most that are unpacked")
        })?;
    }
    Ok(())
}

/// Writes one file, or makes one folder; how many bytes came, which may be one more than `rest`.
fn write<R: Read>(entry: &mut ZipFile<R>, folder: &Path, rest: u64) -> io::Result<u64> {
    let inside = entry.enclosed_name().ok_or_else(|| io::Error::other("it lies outside the archive"))?;
    let path = folder.join(inside);
    if entry.is_dir() {
        return fs::create_dir_all(path).map(|()| 0);
    }
    if entry.is_symlink() {
        return Err(io::Error::other("it is a link; an FMU has files and folders"));
    }
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    let mut file = File::create(&path)?;
    let written = io::copy(&mut entry.take(rest + 1), &mut file)?;
    #[cfg(unix)]
    if let Some(mode) = entry.unix_mode() {
        use std::os::unix::fs::PermissionsExt;
        // Tools among the resources are to be run.
        file.set_permissions(fs::Permissions::from_mode(mode & 0o700 | 0o600))?;
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    /// An archive in memory.
    fn archive(fill: impl FnOnce(&mut ZipWriter<Cursor<Vec<u8>>>)) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(vec![]));
        fill(&mut zip);
        zip.finish().unwrap().into_inner()
    }

    fn extracted(bytes: Vec<u8>, most: u64) -> (tempfile::TempDir, Result<(), String>) {
        let folder = tempfile::tempdir().unwrap();
        let done = extract(&mut ZipArchive::new(Cursor::new(bytes)).unwrap(), folder.path(), most);
        (folder, done)
    }

    fn two_files() -> Vec<u8> {
        archive(|zip| {
            for name in ["a/one", "two"] {
                zip.start_file(name, SimpleFileOptions::default()).unwrap();
                zip.write_all(&[0; 1000]).unwrap();
            }
        })
    }

    #[test]
    fn an_archive_that_unpacks_to_more_than_the_limit_is_refused_with_the_number() {
        assert_eq!(extracted(two_files(), 2000).1, Ok(()));
        let (folder, refused) = extracted(two_files(), 1999);
        let said = refused.unwrap_err();
        assert_eq!(said, "two: unpacked it has more than 1999 bytes, the most that are unpacked");
        assert!(fs::metadata(folder.path().join("two")).unwrap().len() <= 1000);
    }

    #[test]
    fn an_archive_of_more_files_than_the_limit_is_refused_before_any_is_written() {
        let many = archive(|zip| {
            for k in 0..=MOST_ENTRIES {
                zip.start_file(k.to_string(), SimpleFileOptions::default()).unwrap();
            }
        });
        let (folder, refused) = extracted(many, 2000);
        assert_eq!(refused.unwrap_err(), "100001 files are in it; at most 100000 are unpacked");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// The size that stands in the archive is one byte for each file.
    #[test]
    fn an_archive_that_lies_about_its_size_fills_no_disk() {
        let mut bytes = two_files();
        let size = 1000_u32.to_le_bytes();
        let places: Vec<_> = (0..bytes.len() - 4).filter(|at| bytes[*at..at + 4] == size).collect();
        assert!(places.len() >= 4, "in the local headers and in the directory");
        for at in places {
            bytes[at..at + 4].copy_from_slice(&1_u32.to_le_bytes());
        }
        let (folder, done) = extracted(bytes, 500);
        let length = |name: &str| fs::metadata(folder.path().join(name)).map_or(0, |file| file.len());
        assert!(done.is_err() && length("a/one") + length("two") <= 501, "{done:?}");
    }

    #[test]
    fn links_and_names_that_lead_outside_are_refused() {
        let link =
            archive(|zip| zip.add_symlink("link", "/etc/passwd", SimpleFileOptions::default()).unwrap());
        let (folder, refused) = extracted(link, 2000);
        assert!(refused.unwrap_err().starts_with("link: it is a link"));
        assert!(!folder.path().join("link").is_symlink());
        let outside = archive(|zip| {
            zip.start_file("../outside", SimpleFileOptions::default()).unwrap();
            zip.write_all(b"x").unwrap();
        });
        let (folder, refused) = extracted(outside, 2000);
        assert_eq!(refused.unwrap_err(), "../outside: it lies outside the archive");
        assert!(!folder.path().parent().unwrap().join("outside").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_tool_among_the_resources_stays_executable_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let tool = archive(|zip| {
            zip.start_file("tool", SimpleFileOptions::default().unix_permissions(0o755)).unwrap();
        });
        let (folder, done) = extracted(tool, 2000);
        assert_eq!(done, Ok(()));
        assert_eq!(fs::metadata(folder.path().join("tool")).unwrap().permissions().mode() & 0o777, 0o700);
    }
}
