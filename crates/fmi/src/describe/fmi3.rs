//! modelDescription.xml and the terminals in FMI 3.0.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use super::xml::{
    Xml, about, categories_and_experiment, dependencies, document, enumerations, identity, is,
    is_initial_unknown, items, leaf, measure, node, number, output_dependencies, range, state_of, units,
};
use crate::models::exchange::INDICATORS;
use crate::models::node::{ROOM, of_bus};
use crate::models::{Interface, Scalar, Use, Variant};
use crate::variables::{Causality, Kind, Row};

/// The XML of a model for a rig.
pub fn model_description(interface: &Interface) -> String {
    let mut root = vec![is("fmiVersion", "3.0"), is("instantiationToken", interface.token())];
    root.extend(about(interface));
    document(|xml| {
        node(xml, "fmiModelDescription", &root, |xml| {
            capabilities(xml, interface)?;
            units(xml, interface)?;
            types(xml, interface)?;
            categories_and_experiment(xml)?;
            variables(xml, interface)?;
            structure(xml, interface)
        })
    })
}

/// What two wires carry between controller and plant: the names of the terminals and their rows.
const TERMINALS: [(&str, &[&str]); 2] =
    [("motors", &["motorTension"]), ("sensors", &["encoderPose", "cableLength", "measuredTension"])];

/// terminalsAndIcons.xml. The icon is square and needs no place; fmucontainer looks for terminals in the first element alone.
pub fn terminals(interface: &Interface) -> String {
    document(|xml| {
        node(xml, "fmiTerminalsAndIcons", &[is("fmiVersion", "3.0")], |xml| {
            node(xml, "Terminals", &[], |xml| {
                if interface.model().usage() == Use::OnBuses {
                    return interface
                        .buses()
                        .iter()
                        .enumerate()
                        .try_for_each(|(bus, name)| network(xml, bus, name));
                }
                TERMINALS.into_iter().try_for_each(|(name, rows)| terminal(xml, interface, name, rows))
            })
        })
    })
}

fn terminal(xml: &mut Xml, interface: &Interface, name: &str, rows: &[&str]) -> io::Result<()> {
    let kind = is("terminalKind", format!("cable-robot.{name}"));
    node(xml, "Terminal", &[is("name", name), is("matchingRule", "plug"), kind], |xml| {
        let is_full = interface.variant() == Variant::Full;
        let members = interface.scalars().filter(|scalar| rows.contains(&scalar.row.name));
        let members = members.filter(|scalar| interface.is_shown(scalar));
        let name = |scalar: Scalar| if is_full { scalar.row.name.to_owned() } else { scalar.name() };
        members.map(name).try_for_each(|name| {
            let attributes =
                [is("variableName", &name), is("memberName", &name), is("variableKind", "signal")];
            leaf(xml, "TerminalMemberVariable", &attributes)
        })
    })
}

/// A bus, as FMI-LS-BUS wants it ("Bus Terminal").
fn network(xml: &mut Xml, bus: usize, name: &str) -> io::Result<()> {
    let attributes = [
        is("name", name),
        is("matchingRule", "org.fmi-ls-bus.transceiver"),
        is("terminalKind", "org.fmi-ls-bus.network-terminal"),
    ];
    node(xml, "Terminal", &attributes, |xml| {
        of_bus(bus).into_iter().try_for_each(|(_, member)| {
            let variable = is("variableName", format!("{name}.{member}"));
            leaf(
                xml,
                "TerminalMemberVariable",
                &[variable, is("memberName", member), is("variableKind", "signal")],
            )
        })
    })
}

/// The variables of a bus: binary ones, and the clocks that they belong to.
fn of_network(xml: &mut Xml, bus: usize, name: &str) -> io::Result<()> {
    let [rx_data, tx_data, rx_clock, tx_clock] = of_bus(bus);
    let named = |(reference, member): (u32, &str), causality: &str| {
        let name = format!("{name}.{member}");
        vec![is("name", name), is("valueReference", reference), is("causality", causality)]
    };
    let clocked = |clock: (u32, &str), initial: &str| {
        vec![
            is("variability", "discrete"),
            is("initial", initial),
            is("clocks", clock.0),
            is("mimeType", CAN),
            is("maxSize", ROOM),
        ]
    };
    let triggered = is("intervalVariability", "triggered");
    node(xml, "Binary", &[named(rx_data, "input"), clocked(rx_clock, "exact")].concat(), |xml| {
        leaf(xml, "Start", &[is("value", "")])
    })?;
    leaf(xml, "Binary", &[named(tx_data, "output"), clocked(tx_clock, "calculated")].concat())?;
    leaf(xml, "Clock", &[named(rx_clock, "input"), vec![triggered.clone()]].concat())?;
    leaf(xml, "Clock", &[named(tx_clock, "output"), vec![triggered]].concat())
}

/// The MIME type of CAN in FMI-LS-BUS 1.0.0.
const CAN: &str = "application/org.fmi-standard.fmi-ls-bus.can; version=\"1.0.0\"";

/// extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml
pub fn manifest() -> String {
    let attributes = [
        is("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        is("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-bus"),
        is("fmi-ls:fmi-ls-version", "1.0.0"),
        is(
            "fmi-ls:fmi-ls-description",
            "Layered Standard for Network Communication: network abstraction, CAN",
        ),
        is("isBusSimulationFMU", false),
    ];
    document(|xml| leaf(xml, "fmiLayeredStandardManifest", &attributes))
}

fn capabilities(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    if interface.model().usage() == Use::ModelExchange {
        let attributes = [
            is("modelIdentifier", interface.model().identifier()),
            is("needsExecutionTool", false),
            is("canBeInstantiatedOnlyOncePerProcess", false),
            is("canGetAndSetFMUState", true),
            is("canSerializeFMUState", true),
            is("providesDirectionalDerivatives", true),
            is("providesAdjointDerivatives", false),
            is("providesPerElementDependencies", false),
            is("needsCompletedIntegratorStep", false),
        ];
        return leaf(xml, "ModelExchange", &attributes);
    }
    let is_full = interface.variant() == Variant::Full;
    let is_on_buses = interface.model().usage() == Use::OnBuses;
    let attributes = [
        is("modelIdentifier", interface.model().identifier()),
        is("needsExecutionTool", false),
        is("canBeInstantiatedOnlyOncePerProcess", false),
        is("canGetAndSetFMUState", !is_on_buses),
        is("canSerializeFMUState", !is_on_buses),
        is("providesDirectionalDerivatives", false),
        is("providesAdjointDerivatives", false),
        is("providesPerElementDependencies", false),
        is("canHandleVariableCommunicationStepSize", true),
        is("maxOutputDerivativeOrder", 0),
        is("providesIntermediateUpdate", false),
        is("mightReturnEarlyFromDoStep", is_full),
        is("canReturnEarlyAfterIntermediateUpdate", false),
        is("hasEventMode", is_full || is_on_buses),
    ];
    leaf(xml, "CoSimulation", &attributes)
}

/// The type that carries unit and nominal of a scalar, if it has any; some readers know them in types only.
fn type_name(scalar: &Scalar) -> Option<String> {
    let quantity = scalar.row.unit_of(scalar.position).map(|unit| unit.quantity);
    match (quantity, scalar.row.nominal) {
        (None, None) => None,
        (quantity, None) => quantity.map(str::to_owned),
        (quantity, Some(nominal)) => Some(format!("{}_{nominal}", quantity.unwrap_or("Number"))),
    }
}

fn types(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    let kinds = enumerations(interface);
    let mut named = BTreeMap::new();
    for scalar in interface.scalars() {
        if let Some(name) = type_name(&scalar) {
            named.insert(name, measure(&scalar));
        }
    }
    node(xml, "TypeDefinitions", &[], |xml| {
        named.into_iter().try_for_each(|(name, measure)| {
            leaf(xml, "Float64Type", &[vec![("name", Some(name))], measure].concat())
        })?;
        kinds.iter().try_for_each(|kind| {
            // No description: fmpy 0.3.12 to 0.3.23 cannot read one here.
            node(xml, "EnumerationType", &[is("name", kind.name)], |xml| items(xml, kind))
        })
    })
}

fn variables(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    node(xml, "ModelVariables", &[], |xml| {
        if interface.variant() == Variant::Full {
            return interface.rows().iter().try_for_each(|row| array(xml, interface, row));
        }
        interface.scalars().try_for_each(|scalar| {
            let kind = interface.kind(scalar.row);
            let declared = match kind {
                Kind::Enumeration(kind) => Some(kind.name.to_owned()),
                _ => type_name(&scalar),
            };
            let derivative = ("derivative", state_of(&scalar).map(|state| state.to_string()));
            let attributes = [
                identity(&scalar),
                vec![("declaredType", declared)],
                range(interface, &scalar),
                vec![derivative],
            ]
            .concat();
            leaf(xml, kind.name(), &attributes)
        })?;
        interface.buses().iter().enumerate().try_for_each(|(bus, name)| of_network(xml, bus, name))
    })
}

/// All scalars of a row as one variable. What has several units has none in it.
fn array(xml: &mut Xml, interface: &Interface, row: &'static Row) -> io::Result<()> {
    let scalars: Vec<Scalar> = interface.scalars_of(row).collect();
    let kind = interface.kind(row);
    let types: BTreeSet<_> = scalars.iter().map(type_name).collect();
    let declared = match kind {
        Kind::Enumeration(kind) => Some(kind.name.to_owned()),
        _ if types.len() == 1 => type_name(&scalars[0]),
        _ => None,
    };
    let starts = scalars.iter().filter_map(|scalar| interface.start_of(scalar));
    let start = starts.map(|start| number(kind, start)).collect::<Vec<_>>().join(" ");
    let mut attributes = identity(&scalars[0]);
    attributes[0] = is("name", row.name);
    if matches!(kind, Kind::Clock) {
        attributes.retain(|(name, _)| !["initial", "variability"].contains(name));
        attributes.push(is("intervalVariability", "triggered"));
    }
    attributes.push(("declaredType", declared));
    let limits = range(interface, &scalars[0]);
    attributes.extend(limits.into_iter().filter(|(name, _)| *name != "start"));
    attributes.push(("start", (!start.is_empty()).then_some(start)));
    let dimensions = row.dimensions(interface.cables());
    if dimensions.is_empty() {
        return leaf(xml, kind.name(), &attributes);
    }
    node(xml, kind.name(), &attributes, |xml| {
        dimensions.iter().try_for_each(|size| leaf(xml, "Dimension", &[is("start", size)]))
    })
}

/// Outputs of co-simulation change in a step only, so at a communication point they depend on nothing; at the start unknowns depend on what
/// the table says.
fn structure(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    let variables = || interface.scalars().filter(|scalar| interface.is_shown(scalar));
    let outputs = || variables().filter(|scalar| scalar.row.causality == Causality::Output);
    node(xml, "ModelStructure", &[], |xml| {
        outputs().try_for_each(|Scalar { reference, .. }| {
            let reference = is("valueReference", reference);
            leaf(xml, "Output", &[reference, ("dependencies", output_dependencies(interface))])
        })?;
        (0..interface.buses().len()).map(of_bus).try_for_each(|[_, data, _, clock]| {
            [data, clock].into_iter().try_for_each(|(reference, _)| {
                leaf(xml, "Output", &[is("valueReference", reference), is("dependencies", "")])
            })
        })?;
        interface.scalars().filter(|scalar| state_of(scalar).is_some()).try_for_each(|scalar| {
            leaf(xml, "ContinuousStateDerivative", &[is("valueReference", scalar.reference)])
        })?;
        variables().filter(is_initial_unknown).try_for_each(|Scalar { row, reference, .. }| {
            let dependencies = is("dependencies", dependencies(interface, row, |known| known as usize));
            leaf(xml, "InitialUnknown", &[is("valueReference", reference), dependencies])
        })?;
        // What is clocked is none, its clock is.
        (0..interface.buses().len()).map(of_bus).try_for_each(|[.., (clock, _)]| {
            leaf(xml, "InitialUnknown", &[is("valueReference", clock), is("dependencies", "")])
        })?;
        let indicators = interface.rows().iter().filter(|row| row.first == INDICATORS.first);
        indicators.flat_map(|row| interface.scalars_of(row)).try_for_each(|Scalar { reference, .. }| {
            leaf(xml, "EventIndicator", &[is("valueReference", reference)])
        })
    })
}
