//! An FMU on disk: unpacked, described, its binary found.
#![allow(unsafe_code)]

use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::error::Error;
use std::ffi::CString;
use std::fs::{self, File};
use std::io::{Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use super::fmi2::Slave2;
use super::fmi3::Slave3;
use super::folder::Folder;
use super::limits::{LONGEST_DESCRIPTION, MOST_PACKED};
use super::log::LogSink;
use super::slave::{Failure, Slave};
use super::unpack::unpack;
use super::{CosimError, FmiVersion, Instance, LogCallback, ModelDescription};
#[cfg(unix)]
use super::{Worker, remote::Remote, wire::Start};
use cable_robot_bindings::{fmi2::Fmi2Library, fmi3::Fmi3Library};

/// A co-simulation FMU, ready to be instantiated as often as wanted; it can be shared between threads.
#[derive(Clone)]
pub struct Fmu {
    /// Of the file.
    name: String,
    description: Arc<ModelDescription>,
    // Dropped before the folder it was loaded from.
    binary: Binary,
    folder: Arc<Folder>,
}

#[derive(Clone)]
enum Binary {
    Here(Library),
    /// Loaded by a process for each instance.
    #[cfg(unix)]
    Apart(Worker, PathBuf),
}

#[derive(Clone)]
pub(super) enum Library {
    V2(Arc<Fmi2Library>),
    V3(Arc<Fmi3Library>),
}

impl Fmu {
    /// Unpacks the FMU into a temporary folder, which goes when the FMU and its instances are dropped, reads its
    /// description and loads its binary into this process: for FMUs that are trusted as this program is. One that crashes, hangs or calls
    /// `exit` takes this program with it.
    ///
    /// # Errors
    /// [`CosimError`]: no zip archive, a description that is wrong, no binary for this machine, or one that cannot
    /// be loaded.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, CosimError> {
        let path = path.as_ref();
        Self::found(path, opened(path)?, Self::here)
    }

    /// The bytes of an FMU's file, for whoever has to know what exactly [`open_read`](Self::open_read) loads.
    ///
    /// # Errors
    /// [`CosimError::Archive`]: it cannot be read, or is too large.
    pub fn read(path: &Path) -> Result<Vec<u8>, CosimError> {
        cable_robot_files::read(path, MOST_PACKED).map_err(|reason| no_archive(path, reason.to_string()))
    }

    /// As [`open`](Self::open), of the bytes that were [`read`](Self::read) from `path`: the file is not looked at again.
    ///
    /// # Errors
    /// As of [`open`](Self::open).
    pub fn open_read(path: &Path, bytes: &[u8]) -> Result<Self, CosimError> {
        Self::found(path, Cursor::new(bytes), Self::here)
    }

    fn here(fmu: &str, version: FmiVersion, file: PathBuf) -> Result<Binary, CosimError> {
        let library = Library::load(version, &file);
        Ok(Binary::Here(library.map_err(|reason| CosimError::Library { fmu: fmu.to_owned(), reason })?))
    }

    /// As [`open`](Self::open), but no code of the FMU runs in this process: each instance gets a process of its own, in which `worker` loads the
    /// binary. A crash, a call of `exit` or one that does not return is [`CosimError::Lost`].
    ///
    /// # Errors
    /// [`CosimError`], as of [`open`](Self::open); that the binary cannot be loaded [`instantiate`](Self::instantiate) says.
    #[cfg(unix)]
    pub fn open_apart(path: impl AsRef<Path>, worker: &Worker) -> Result<Self, CosimError> {
        let path = path.as_ref();
        Self::found(path, opened(path)?, |_, _, file| Ok(Binary::Apart(worker.clone(), file)))
    }

    fn found(
        path: &Path,
        archive: impl Read + Seek,
        binary: impl FnOnce(&str, FmiVersion, PathBuf) -> Result<Binary, CosimError>,
    ) -> Result<Self, CosimError> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let folder = unpack(archive).map_err(|reason| no_archive(path, reason))?;
        let description = describe(folder.path())
            .map_err(|problem| CosimError::Description { fmu: name.clone(), problem })?;
        let binary = binary(&name, description.version, find(&name, folder.path(), &description)?)?;
        Ok(Self { name, description: Arc::new(description), binary, folder: Arc::new(folder) })
    }

    /// What the FMU says of itself.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// A new instance with the start values of the description. Every message it logs goes to `log`; what it
    /// complains of also stands in the error that follows.
    ///
    /// # Errors
    /// [`CosimError::Instantiation`] with the FMU's reason, [`CosimError::MissingFunction`], [`CosimError::Lost`], [`CosimError::Library`].
    pub fn instantiate(&self, name: &str, log: LogCallback) -> Result<Instance, CosimError> {
        let log = Arc::new(LogSink::new(name, log));
        let failed = |failure| match failure {
            Failure::Missing(function) => CosimError::MissingFunction { instance: name.to_owned(), function },
            Failure::Library(reason) => CosimError::Library { fmu: self.name.clone(), reason },
            Failure::Lost(how) => CosimError::Lost {
                instance: name.to_owned(),
                action: "instantiating".to_owned(),
                how,
                said: log.take_complaints(),
            },
            _ => CosimError::Instantiation { instance: name.to_owned(), said: log.take_complaints() },
        };
        let slave = self.slave(name, &log).map_err(failed)?;
        Ok(Instance::new(name, self.clone(), slave, log))
    }

    fn slave(&self, name: &str, log: &Arc<LogSink>) -> Result<Rc<dyn Slave>, Failure> {
        let (token, log) = (&self.description.token, Arc::clone(log));
        let resources = self.folder.path().join("resources");
        match &self.binary {
            Binary::Here(library) => instantiate(library, name, token, &resources, log),
            #[cfg(unix)]
            Binary::Apart(worker, library) => {
                let start = Start {
                    version: self.description.version,
                    library: library.into(),
                    name: name.to_owned(),
                    token: token.clone(),
                    resources: resources.into(),
                };
                Ok(Rc::new(Remote::start(worker, &start, log)?))
            }
        }
    }
}

fn opened(path: &Path) -> Result<File, CosimError> {
    cable_robot_files::open(path).map_err(|reason| no_archive(path, reason.to_string()))
}

fn no_archive(path: &Path, reason: String) -> CosimError {
    CosimError::Archive { path: path.to_owned(), reason }
}

impl Library {
    /// Loads a binary; the reason if that fails.
    pub(super) fn load(version: FmiVersion, file: &Path) -> Result<Self, String> {
        // SAFETY: loading runs the binary's initialisers, which is what the caller asked for by opening this FMU. The
        // bindings are generated from the standard's headers, so the signatures are those the FMU must have.
        let loaded = unsafe {
            match version {
                FmiVersion::V2 => Fmi2Library::new(file).map(|library| Self::V2(Arc::new(library))),
                FmiVersion::V3 => Fmi3Library::new(file).map(|library| Self::V3(Arc::new(library))),
            }
        };
        // The error itself says no more than "dlopen failed"; the reason is its source.
        loaded.map_err(|error| error.source().map_or_else(|| error.to_string(), ToString::to_string))
    }
}

/// An instance in this process.
pub(super) fn instantiate(
    library: &Library,
    name: &str,
    token: &str,
    resources: &Path,
    log: Arc<LogSink>,
) -> Result<Rc<dyn Slave>, Failure> {
    // No XML, path or name of a sane caller holds a zero byte.
    let text = |text: &str| CString::new(text).map_err(|_| Failure::NoInstance);
    let (name, token) = (text(name)?, text(token)?);
    Ok(match library {
        Library::V2(library) => {
            let resources = text(&file_uri(resources))?;
            Rc::new(Slave2::new(Arc::clone(library), &name, &token, &resources, log)?)
        }
        Library::V3(library) => {
            // FMI 3 wants a path with a trailing separator, which joining nothing adds.
            let resources = text(&resources.join("").to_string_lossy())?;
            Rc::new(Slave3::new(Arc::clone(library), &name, &token, &resources, log)?)
        }
    })
}

/// What an unpacked FMU says of itself; the problem if that is not understood.
fn describe(folder: &Path) -> Result<ModelDescription, String> {
    let path = folder.join("modelDescription.xml");
    let bytes = cable_robot_files::read(&path, LONGEST_DESCRIPTION).map_err(|e| e.to_string())?;
    ModelDescription::parse(&String::from_utf8(bytes).map_err(|e| e.to_string())?)
}

/// The binary for this machine.
fn find(fmu: &str, folder: &Path, description: &ModelDescription) -> Result<PathBuf, CosimError> {
    let wanted =
        format!("binaries/{}/{}{DLL_SUFFIX}", platform(description.version), description.model_identifier);
    let file = folder.join(&wanted);
    if file.is_file() {
        return Ok(file);
    }
    Err(CosimError::Platform { fmu: fmu.to_owned(), wanted, present: platforms(folder) })
}

/// The folder below `binaries/` for this machine: `linux64` in FMI 2, `x86_64-linux` in FMI 3. FMI 2 has no name for Linux on ARM; that of FMI 3
/// stands for it.
pub fn platform(version: FmiVersion) -> String {
    match (version, OS) {
        (FmiVersion::V2, "macos") => "darwin64".to_owned(),
        (FmiVersion::V2, "windows") => format!("win{}", usize::BITS),
        (FmiVersion::V2, _) if ARCH != "aarch64" => format!("{OS}{}", usize::BITS),
        (FmiVersion::V3, "macos") => format!("{ARCH}-darwin"),
        _ => format!("{ARCH}-{OS}"),
    }
}

/// The folders below `binaries/`, sorted.
fn platforms(folder: &Path) -> String {
    let entries = fs::read_dir(folder.join("binaries")).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// `file:///tmp/a%20b`: every byte but the unreserved ones of RFC 3986 and `/` is percent-encoded.
fn file_uri(path: &Path) -> String {
    let mut uri = String::from("file://");
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(byte.into())
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use zip::write::SimpleFileOptions;

    use super::*;

    /// A zip archive with these files.
    fn archive(files: &[(&str, &[u8])]) -> tempfile::NamedTempFile {
        let file = tempfile::Builder::new().suffix(".fmu").tempfile().expect("a temporary file");
        let mut zip = zip::ZipWriter::new(file.reopen().expect("the same file"));
        for (name, bytes) in files {
            zip.start_file(*name, SimpleFileOptions::default()).expect("a new entry");
            zip.write_all(bytes).expect("space on disk");
        }
        zip.finish().expect("a whole archive");
        file
    }

    fn error_of(files: &[(&str, &[u8])]) -> String {
        Fmu::open(archive(files).path()).err().expect("this FMU is broken").to_string()
    }

    const XML: &[u8] = br#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t">
        <CoSimulation modelIdentifier="M"/><ModelVariables/></fmiModelDescription>"#;

    /// Between hash and loading the file could be exchanged.
    #[test]
    fn what_was_read_is_what_is_opened_whatever_is_in_the_file_by_then() {
        let xml = br#"<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="b">
            <CoSimulation modelIdentifier="c"/></fmiModelDescription>"#;
        let file = archive(&[("modelDescription.xml", xml)]);
        let bytes = Fmu::read(file.path()).unwrap();
        fs::write(file.path(), "no zip").unwrap();
        assert!(matches!(Fmu::open_read(file.path(), &bytes), Err(CosimError::Platform { .. })));
        assert!(matches!(Fmu::open(file.path()), Err(CosimError::Archive { .. })));
    }

    #[test]
    fn uri_encodes_spaces_umlauts_and_percent() {
        assert_eq!(file_uri(Path::new("/tmp/a b/ü%/x_1.~-")), "file:///tmp/a%20b/%C3%BC%25/x_1.~-");
    }

    #[test]
    fn no_archive_is_named() {
        let missing = Fmu::open("/no/such.fmu").err().expect("no such file").to_string();
        assert!(missing.starts_with("/no/such.fmu cannot be opened as an FMU: "), "{missing}");
        let text = tempfile::NamedTempFile::new().expect("a temporary file");
        fs::write(text.path(), "no zip").expect("space on disk");
        assert!(matches!(Fmu::open(text.path()), Err(CosimError::Archive { .. })));
    }

    #[test]
    fn missing_description_is_named() {
        let error = error_of(&[("binaries/x", b"")]);
        assert!(error.contains(".fmu: modelDescription.xml: "), "{error}");
    }

    #[test]
    fn missing_platform_lists_those_present() {
        let error = error_of(&[
            ("modelDescription.xml", XML),
            ("binaries/riscv64-linux/M.so", b""),
            ("binaries/riscv32-linux/M.so", b""),
        ]);
        let wanted =
            format!("has no binary binaries/{ARCH}-{OS}/M{DLL_SUFFIX}; it has: riscv32-linux, riscv64-linux");
        assert!(error.ends_with(&wanted), "{error}");
    }

    #[test]
    fn a_binary_that_is_none_is_an_error() {
        let binary = format!("binaries/{ARCH}-{OS}/M{DLL_SUFFIX}");
        let error = error_of(&[("modelDescription.xml", XML), (&binary, b"no ELF")]);
        assert!(error.contains("the binary cannot be loaded") && error.contains("file too short"), "{error}");
    }
}
