//! FMUs as files: what is in one, written always with the same bytes.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::describe::{Version, shipped_files};
use super::models::Interface;

/// Files by their paths in the archive.
pub type Files = BTreeMap<String, Vec<u8>>;

/// Everything in an FMU: the libraries by their paths under `binaries/`, and the names and texts of its resources.
pub fn contents(
    interface: &Interface,
    version: Version,
    libraries: &Files,
    resources: &[(&str, &str)],
) -> Files {
    let mut files: Files = shipped_files(interface, version).into_iter().collect();
    files.extend(libraries.clone());
    let resource = |&(name, text): &(&str, &str)| (format!("resources/{name}"), text.as_bytes().to_vec());
    files.extend(resources.iter().map(resource));
    files
}

/// Writes the archive: the same files give the same bytes, whenever and wherever.
///
/// # Errors
/// What the file system says.
pub fn write(path: &Path, files: &Files) -> io::Result<()> {
    fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644);
    // Packed beside and renamed, so that nobody loads half a file.
    let unfinished = path.with_extension("unfinished");
    // What a killed program left, or somebody else planted, is not written into.
    let _ = fs::remove_file(&unfinished);
    let mut archive = ZipWriter::new(File::create_new(&unfinished)?);
    for (name, bytes) in files {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?;
    fs::rename(unfinished, path)
}

/// The libraries of a packed FMU, and its modelDescription.xml.
///
/// # Errors
/// What the file system says, and if the file is no FMU.
pub fn libraries(path: &Path) -> io::Result<(Files, String)> {
    let mut archive = ZipArchive::new(File::open(path)?)?;
    let (mut libraries, mut description) = (Files::new(), String::new());
    for k in 0..archive.len() {
        let mut entry = archive.by_index(k)?;
        let name = entry.name()?.into_owned();
        if name == "modelDescription.xml" {
            entry.read_to_string(&mut description)?;
        } else if name.starts_with("binaries/") && entry.is_file() {
            let mut bytes = vec![];
            entry.read_to_end(&mut bytes)?;
            libraries.insert(name, bytes);
        }
    }
    Ok((libraries, description))
}
