//! SystemStructure.ssd of SSP 1.0: controller and plant, connected.

use std::io;

use super::xml::{Xml, document, is, leaf, node};
use crate::models::{Interface, Scalar};
use crate::variables::{Causality, Kind};

const NAMESPACES: [(&str, &str); 3] = [
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
];

const CONTROLLER: &str = "controller";
const PLANT: &str = "plant";
/// What each reads of the other.
const OF_PLANT: [&str; 3] = ["encoderPose", "cableLength", "measuredTension"];
const OF_CONTROLLER: [&str; 1] = ["motorTension"];
/// What comes from outside, and to which of the two; what is shown outside, and of which.
const INPUTS: [(&str, &str); 3] =
    [(CONTROLLER, "goalPose"), (PLANT, "disturbanceForce"), (PLANT, "disturbanceTorque")];
const OUTPUTS: [(&str, &str); 5] = [
    (PLANT, "encoderPose"),
    (CONTROLLER, "motorTension"),
    (CONTROLLER, "atGoal"),
    (CONTROLLER, "statusNumber"),
    (CONTROLLER, "tensionMargin"),
];

/// What connects the two FMUs, which lie in `resources/`. A master that steps both with what the other said a step before lets commands act
/// a `step` (s) late, as `commandDelay` says.
pub fn system_structure(controller: &Interface, plant: &Interface, step: f64) -> String {
    let parts = [(CONTROLLER, controller), (PLANT, plant)];
    let of = |part: &str| if part == PLANT { plant } else { controller };
    let mut root: Vec<_> = NAMESPACES.iter().map(|(name, value)| is(name, value)).collect();
    root.extend([is("name", "CableRobot"), is("version", "1.0")]);
    document(|xml| {
        node(xml, "ssd:SystemStructureDescription", &root, |xml| {
            node(xml, "ssd:System", &[is("name", "CableRobot")], |xml| {
                node(xml, "ssd:Connectors", &[], |xml| {
                    let mut all = |places: &[(&str, &str)], kind| {
                        let scalars = places.iter().flat_map(|(part, row)| scalars(of(part), row));
                        scalars
                            .collect::<Vec<_>>()
                            .iter()
                            .try_for_each(|scalar| connector(xml, controller, scalar, kind))
                    };
                    all(&INPUTS, "input")?;
                    all(&OUTPUTS, "output")
                })?;
                node(xml, "ssd:Elements", &[], |xml| {
                    parts.iter().try_for_each(|(name, interface)| component(xml, name, interface, step))
                })?;
                node(xml, "ssd:Connections", &[], |xml| connections(xml, controller, plant))
            })?;
            leaf(xml, "ssd:DefaultExperiment", &[is("startTime", 0), is("stopTime", 12)])
        })
    })
}

/// The scalars of a row.
fn scalars(interface: &Interface, row: &str) -> Vec<Scalar> {
    interface.scalars().filter(|scalar| scalar.row.name == row).collect()
}

fn connector(xml: &mut Xml, interface: &Interface, scalar: &Scalar, kind: &str) -> io::Result<()> {
    let of_type = match interface.kind(scalar.row) {
        Kind::Float64 => "ssc:Real",
        Kind::Int32 => "ssc:Integer",
        Kind::Boolean => "ssc:Boolean",
        // There as numbers, in variables of their own.
        Kind::Enumeration(_) => return Ok(()),
    };
    node(xml, "ssd:Connector", &[is("name", scalar.name()), is("kind", kind)], |xml| leaf(xml, of_type, &[]))
}

fn component(xml: &mut Xml, name: &str, interface: &Interface, step: f64) -> io::Result<()> {
    let source = format!("resources/{}.fmu", interface.model().identifier());
    let attributes = [is("name", name), is("type", "application/x-fmu-sharedlibrary"), is("source", source)];
    node(xml, "ssd:Component", &attributes, |xml| {
        node(xml, "ssd:Connectors", &[], |xml| {
            interface.scalars().try_for_each(|scalar| match scalar.row.causality {
                // Whether it is enabled stays as it starts: connections that start at 0 would let the platform fall.
                Causality::Input if scalar.row.name != "enable" => {
                    connector(xml, interface, &scalar, "input")
                }
                Causality::Output => connector(xml, interface, &scalar, "output"),
                _ => Ok(()),
            })
        })?;
        if name != CONTROLLER {
            return Ok(());
        }
        node(xml, "ssd:ParameterBindings", &[], |xml| {
            node(xml, "ssd:ParameterBinding", &[], |xml| {
                node(xml, "ssd:ParameterValues", &[], |xml| late(xml, step))
            })
        })
    })
}

/// The parameters for a master that is a step late.
fn late(xml: &mut Xml, step: f64) -> io::Result<()> {
    node(xml, "ssv:ParameterSet", &[is("version", "1.0"), is("name", "late")], |xml| {
        node(xml, "ssv:Parameters", &[], |xml| {
            node(xml, "ssv:Parameter", &[is("name", "commandDelay")], |xml| {
                leaf(xml, "ssv:Real", &[is("value", step)])
            })
        })
    })
}

fn connections(xml: &mut Xml, controller: &Interface, plant: &Interface) -> io::Result<()> {
    let mut connect = |from: Option<&str>, to: Option<&str>, scalar: &Scalar| {
        let name = scalar.name();
        let mut attributes = vec![];
        attributes.extend(from.map(|from| is("startElement", from)));
        attributes.push(is("startConnector", &name));
        attributes.extend(to.map(|to| is("endElement", to)));
        attributes.push(is("endConnector", &name));
        leaf(xml, "ssd:Connection", &attributes)
    };
    let of = |part: &str| if part == PLANT { plant } else { controller };
    for row in OF_PLANT {
        scalars(plant, row).iter().try_for_each(|scalar| connect(Some(PLANT), Some(CONTROLLER), scalar))?;
    }
    for row in OF_CONTROLLER {
        scalars(controller, row)
            .iter()
            .try_for_each(|scalar| connect(Some(CONTROLLER), Some(PLANT), scalar))?;
    }
    for (part, row) in INPUTS {
        scalars(of(part), row).iter().try_for_each(|scalar| connect(None, Some(part), scalar))?;
    }
    for (part, row) in OUTPUTS {
        scalars(of(part), row).iter().try_for_each(|scalar| connect(Some(part), None, scalar))?;
    }
    Ok(())
}
