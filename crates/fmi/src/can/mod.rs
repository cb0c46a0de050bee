//! The nodes on CAN buses as FMUs, with the feature `can`: the library of the other FMUs has nothing of it.

mod controller;
mod parameters;
mod rig;

use std::error::Error;
use std::path::Path;

use super::archive;
use super::describe::Version;
use super::error::{FmiError, Status};
use super::log::{Category, Log};
use super::models::Interface;
use super::models::node::{LONGEST_STEP, NODES, NodeKind, ROOM};
use super::node::Node;
use super::resources::{FIELDBUS_FILE, RIG_FILE};
use cable_robot::robot::RigFile;
use cable_robot_fieldbus::ls_bus::Notice;
use cable_robot_fieldbus::{Config, Files, ls_bus};

// What the descriptions say is what the nodes do.
const _: () = assert!(ls_bus::ROOM == ROOM && ls_bus::CYCLES == LONGEST_STEP);

pub use parameters::{GivenError, controller_parameters, write_parameters};

/// The variables of a node that is made for these files.
pub fn interface(kind: NodeKind, files: &Files) -> Interface {
    let buses = files.config.buses.iter().map(|bus| bus.name.clone()).collect();
    Interface::on_buses(kind, &rig_file(&files.config), buses, [&files.fieldbus, &files.rig])
}

/// An FMU of a node that is made for these files.
pub fn contents(kind: NodeKind, files: &Files, libraries: &archive::Files) -> archive::Files {
    let resources = [(FIELDBUS_FILE, files.fieldbus.as_str()), (RIG_FILE, files.rig.as_str())];
    archive::contents(&interface(kind, files), Version::Fmi3, libraries, &resources)
}

/// The node that has this token, of the fieldbus file and the rig file in these resources.
///
/// # Errors
/// [`FmiError::Token`] if there is none, [`FmiError::Resource`] for a file that cannot be used.
pub fn node(token: &str, resources: &Path) -> Result<(Interface, Box<dyn Node>), FmiError> {
    let path = resources.join(FIELDBUS_FILE);
    let refused = |why| FmiError::Resource { path: path.display().to_string(), why };
    let files =
        Files::read_with_rig(&path, &resources.join(RIG_FILE)).map_err(|error| refused(chain(&error)))?;
    let known = NODES.map(|kind| (kind, interface(kind, &files)));
    let name = |(_, interface): &(_, Interface)| {
        format!("{} of {}", interface.token(), interface.model().identifier())
    };
    let names = known.each_ref().map(name).join(", ");
    let found = known.into_iter().find(|(_, interface)| interface.token() == token);
    let (kind, interface) = found.ok_or_else(|| FmiError::Token { given: token.to_owned(), known: names })?;
    let node: Box<dyn Node> = match kind {
        NodeKind::Controller => {
            Box::new(controller::Controller::new(files.config).map_err(|error| refused(error.to_string()))?)
        }
        NodeKind::Rig => Box::new(rig::Rig::new(files.config)?),
    };
    Ok((interface, node))
}

/// The rig with its stand for a home.
pub fn rig_file(config: &Config) -> RigFile {
    let (lambda, eta) = (config.controller.lambda, config.controller.eta);
    RigFile { name: config.name.clone(), rig: config.rig, home: config.home, lambda, eta }
}

/// An error with its reasons, on one line.
fn chain(error: &dyn Error) -> String {
    let cause = error.source().map_or(String::new(), |cause| format!(": {}", chain(cause)));
    format!("{error}{cause}")
}

/// Says what is odd on a bus.
fn say(log: &Log, bus: &str, notice: Notice) {
    if log.is_enabled(Category::Warning) {
        log.send(Status::Ok, Category::Warning, &format!("{bus}: {notice}"));
    }
}

#[cfg(test)]
mod tests;
