//! What an FMU contains besides the library: XML, documentation, icon and licence, rendered from the variable tables.
//! What a person may want to read is checked in under `modelDescription/`, and a test fails when it drifts.

mod drawing;
mod fmi2;
mod fmi3;
mod page;
mod ssp;
mod xml;

use super::models::{Interface, MODELS, Model, Use};
use super::variables::Kind;

/// Version of the standard that an FMU follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0
    Fmi2,
    /// FMI 3.0
    Fmi3,
}

/// Both versions.
pub const VERSIONS: [Version; 2] = [Version::Fmi2, Version::Fmi3];

const MIT: &str = include_str!("../../../../modelDescription/licenses/MIT.txt");
const APACHE: &str = include_str!("../../../../modelDescription/licenses/Apache-2.0.txt");
const LICENSE: &str = include_str!("../../../../modelDescription/licenses/license.txt");
const THIRD_PARTY: &str = include_str!("../../../../modelDescription/licenses/THIRD-PARTY.txt");
const ICON: &[u8] = include_bytes!("../../../../modelDescription/icon.png");
const ICON_DRAWING: &str = include_str!("../../../../modelDescription/icon.svg");

impl Version {
    /// Short name, as in the folders of FMUs.
    pub fn name(self) -> &'static str {
        match self {
            Version::Fmi2 => "fmi2",
            Version::Fmi3 => "fmi3",
        }
    }

    /// What it calls the type of a variable.
    pub fn type_name(self, kind: Kind) -> &'static str {
        match (self, kind) {
            (Version::Fmi2, Kind::Float64) => "Real",
            (Version::Fmi2, Kind::Int32) => "Integer",
            _ => kind.name(),
        }
    }
}

/// modelDescription.xml.
pub fn model_description(interface: &Interface, version: Version) -> String {
    match version {
        Version::Fmi2 => fmi2::model_description(interface),
        Version::Fmi3 => fmi3::model_description(interface),
    }
}

pub use ssp::System;

/// documentation/index.html.
pub fn documentation(interface: &Interface, version: Version) -> String {
    page::render(interface, version)
}

/// Everything in the FMU but the library: path in the zip file and content.
pub fn shipped_files(interface: &Interface, version: Version) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        ("modelDescription.xml", model_description(interface, version).into_bytes()),
        ("documentation/index.html", documentation(interface, version).into_bytes()),
        ("documentation/licenses/license.txt", LICENSE.into()),
        ("documentation/licenses/MIT.txt", MIT.into()),
        ("documentation/licenses/Apache-2.0.txt", APACHE.into()),
        ("documentation/licenses/THIRD-PARTY.txt", THIRD_PARTY.into()),
    ];
    match version {
        Version::Fmi2 => files.push(("model.png", ICON.into())),
        Version::Fmi3 => files.extend([
            ("terminalsAndIcons/icon.png", ICON.into()),
            ("terminalsAndIcons/icon.svg", ICON_DRAWING.into()),
            ("terminalsAndIcons/terminalsAndIcons.xml", fmi3::terminals(interface).into_bytes()),
        ]),
    }
    if interface.model().usage() == Use::OnBuses {
        files.push((MANIFEST, fmi3::manifest().into_bytes()));
    }
    files.into_iter().map(|(path, content)| (path.to_owned(), content)).collect()
}

/// Where FMI-LS-BUS looks for its own.
const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml";

/// What is rendered and checked in: path under `modelDescription/` and content. `cargo fmu describe` writes it.
pub fn checked_in() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for interface in MODELS.map(Model::interface) {
        let folder = interface.model().identifier();
        for version in VERSIONS {
            let path = format!("{folder}/{}/modelDescription.xml", version.name());
            files.push((path, model_description(&interface, version).into_bytes()));
            let path = format!("{folder}/{}/index.html", version.name());
            files.push((path, documentation(&interface, version).into_bytes()));
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Scalar;
    use crate::variables::Causality;
    use cable_robot::robot::RigFile;

    #[test]
    fn what_is_checked_in_is_what_the_tables_say() {
        let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../modelDescription"));
        for (path, content) in checked_in() {
            let there = std::fs::read(folder.join(&path)).unwrap_or_default();
            assert!(there == content, "modelDescription/{path} has drifted: run `cargo fmu describe`");
        }
    }

    /// The page in the FMI 2 archives spoke of Float64.
    #[test]
    fn the_page_names_the_types_of_its_own_version() {
        for interface in MODELS.map(Model::interface) {
            let [of_2, of_3] = VERSIONS.map(|version| documentation(&interface, version));
            assert!(of_2.contains("<td>Real</td>") && !of_2.contains("Float64") && !of_2.contains("Int32"));
            assert!(of_3.contains("<td>Float64</td>") && !of_3.contains("<td>Real</td>"));
        }
    }

    #[test]
    fn both_versions_name_every_scalar_and_the_token() {
        for interface in interfaces() {
            for version in VERSIONS {
                let text = model_description(&interface, version);
                assert!(text.contains(interface.token()));
                for scalar in interface.scalars() {
                    let wanted =
                        format!("name=\"{}\" valueReference=\"{}\"", scalar.name(), scalar.reference);
                    let left_out = version == Version::Fmi2 && scalar.row.causality == Causality::Independent;
                    assert_eq!(text.matches(&wanted).count(), usize::from(!left_out), "{wanted}");
                }
            }
        }
    }

    /// The crates `fmi` and fmi-sim know unit and nominal in types only, and refused the FMI 3 archives.
    #[test]
    fn another_reader_finds_every_scalar() {
        use fmi_schema::{deserialize, fmi3::Fmi3ModelDescription};
        for interface in interfaces() {
            let text = model_description(&interface, Version::Fmi3);
            let read = deserialize::<Fmi3ModelDescription>(&text).unwrap();
            // It passes over enumerations, which are there as numbers too.
            let is_read = |scalar: &Scalar| !matches!(scalar.row.kind, Kind::Enumeration(_));
            assert_eq!(read.model_variables.len(), interface.scalars().filter(is_read).count());
        }
    }

    /// Of the paper's rig and of one with eight cables.
    fn interfaces() -> impl Iterator<Item = Interface> {
        let eight = RigFile::parse(include_str!("../../../../rigs/eight.toml")).unwrap();
        let of_eight = MODELS.map(|model| Interface::of_rig(model, &eight));
        MODELS.map(Model::interface).into_iter().chain(of_eight)
    }
}
