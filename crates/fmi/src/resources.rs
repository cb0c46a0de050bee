//! What the library reads from its FMU's resources: the rig file of an FMU for another rig than the paper's.

use std::path::{Path, PathBuf};

use super::error::FmiError;
use super::models::{Interface, MODELS, Model, VARIANTS};
use super::node::Node;
use cable_robot::robot::RigFile;

/// Name of the rig file in the resources.
pub const RIG_FILE: &str = "rig.toml";

/// Name of the fieldbus file in the resources, of a node on buses.
pub const FIELDBUS_FILE: &str = "fieldbus.toml";

/// What is beside the values of a node on buses.
type Beside = Option<Box<dyn Node>>;

/// The model that has this token.
///
/// # Errors
/// As [`interface`].
pub fn model(token: &str, resources: Option<&Path>) -> Result<(Interface, Beside), FmiError> {
    #[cfg(feature = "can")]
    if let Some(folder) = resources.filter(|folder| folder.join(FIELDBUS_FILE).exists()) {
        return crate::can::node(token, folder).map(|(interface, node)| (interface, Some(node)));
    }
    Ok((interface(token, resources)?, None))
}

/// The interface that has this token: of the paper's rig, or of the rig in the resources.
///
/// # Errors
/// [`FmiError::Token`] if there is none, [`FmiError::Resource`] for a rig file that cannot be used.
pub fn interface(token: &str, resources: Option<&Path>) -> Result<Interface, FmiError> {
    let of_rig = match resources.map(|folder| folder.join(RIG_FILE)).filter(|path| path.exists()) {
        Some(path) => {
            let rig =
                read(&path).map_err(|why| FmiError::Resource { path: path.display().to_string(), why })?;
            Some(MODELS.map(|model| Interface::of_rig(model, &rig)))
        }
        None => None,
    };
    let known = of_rig.unwrap_or_else(|| MODELS.map(Model::interface));
    let name = |interface: &Interface| format!("{} of {}", interface.token(), interface.model().identifier());
    let shown = |variant| known.iter().map(move |interface| interface.clone().shown_as(variant));
    let found = VARIANTS.into_iter().flat_map(shown).find(|interface| interface.token() == token);
    found.ok_or_else(|| FmiError::Token {
        given: token.to_owned(),
        known: known.each_ref().map(name).join(", "),
    })
}

fn read(path: &Path) -> Result<RigFile, String> {
    let text = cable_robot_files::read_text(path).map_err(|error| error.to_string())?;
    RigFile::parse(&text).map_err(|error| error.to_string())
}

/// The path that a `file:` URI of FMI 2 names; `None` for another kind of URI. Importers write one to three slashes.
pub fn path_of_uri(uri: &str) -> Option<PathBuf> {
    let rest = uri.strip_prefix("file:")?;
    let path = match rest.strip_prefix("//") {
        Some(behind) => {
            behind.strip_prefix("localhost").filter(|path| path.starts_with('/')).unwrap_or(behind)
        }
        None => rest,
    };
    let mut bytes = vec![];
    let mut left = path.bytes();
    while let Some(byte) = left.next() {
        let coded = (byte == b'%').then(|| {
            let mut digit = || char::from(left.next()?).to_digit(16);
            Some((digit()? * 16 + digit()?) as u8)
        });
        bytes.push(coded.map_or(Some(byte), |coded| coded)?);
    }
    let path = String::from_utf8(bytes).ok()?;
    // On Windows a drive follows the third slash.
    let drive = path.strip_prefix('/').filter(|path| path.as_bytes().get(1) == Some(&b':'));
    Some(PathBuf::from(drive.unwrap_or(&path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_of_all_importers_are_understood() {
        for uri in
            ["file:///tmp/a%20b/resources", "file:/tmp/a b/resources", "file://localhost/tmp/a%20b/resources"]
        {
            assert_eq!(path_of_uri(uri), Some(PathBuf::from("/tmp/a b/resources")), "{uri}");
        }
        assert_eq!(path_of_uri("file:///C:/fmu/resources"), Some(PathBuf::from("C:/fmu/resources")));
        for uri in ["http://example.org/x", "/tmp/resources", "file:///tmp/%zz", "file:///tmp/%4"] {
            assert_eq!(path_of_uri(uri), None, "{uri}");
        }
    }

    #[test]
    fn the_rig_is_found_by_its_token_and_a_bad_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let text = include_str!("../../../rigs/eight.toml");
        let eight = Interface::of_rig(Model::Plant, &RigFile::parse(text).unwrap());
        let ours = Model::Plant.interface();
        assert_eq!(interface(ours.token(), None).unwrap().cables(), 6);
        assert_eq!(interface(ours.token(), Some(folder.path())).unwrap().cables(), 6);
        std::fs::write(folder.path().join(RIG_FILE), text).unwrap();
        assert_eq!(interface(eight.token(), Some(folder.path())).unwrap().cables(), 8);
        let error = interface(ours.token(), Some(folder.path())).unwrap_err().to_string();
        assert!(error.contains(eight.token()), "{error}");
        std::fs::write(folder.path().join(RIG_FILE), text.replacen("mass = 30.0", "mass = -1.0", 1)).unwrap();
        let error = interface(eight.token(), Some(folder.path())).unwrap_err().to_string();
        assert!(error.contains("rig.toml") && error.contains("platform.mass = -1"), "{error}");
    }
}
