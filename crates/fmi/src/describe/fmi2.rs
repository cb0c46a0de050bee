//! modelDescription.xml of FMI 2.0.

use std::io;

use super::Version;
use super::xml::{
    Xml, about, categories_and_experiment, dependencies, document, enumerations, identity, is,
    is_initial_unknown, items, leaf, measure, node, output_dependencies, range, state_of, units,
};
use crate::models::exchange::INDICATORS;
use crate::models::{Interface, Scalar, Use};
use crate::variables::{Causality, Kind};

/// The XML of a model for a rig.
pub fn model_description(interface: &Interface) -> String {
    let mut root = vec![is("fmiVersion", "2.0"), is("guid", interface.token())];
    root.extend(about(interface));
    if interface.model().usage() == Use::ModelExchange {
        root.push(is("numberOfEventIndicators", interface.scalars_of(INDICATORS).count()));
    }
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

fn capabilities(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    if interface.model().usage() == Use::ModelExchange {
        let attributes = [
            is("modelIdentifier", interface.model().identifier()),
            is("needsExecutionTool", false),
            is("completedIntegratorStepNotNeeded", true),
            is("canBeInstantiatedOnlyOncePerProcess", false),
            is("canNotUseMemoryManagementFunctions", true),
            is("canGetAndSetFMUstate", true),
            is("canSerializeFMUstate", true),
            is("providesDirectionalDerivative", true),
        ];
        return leaf(xml, "ModelExchange", &attributes);
    }
    let attributes = [
        is("modelIdentifier", interface.model().identifier()),
        is("needsExecutionTool", false),
        is("canHandleVariableCommunicationStepSize", true),
        is("canInterpolateInputs", false),
        is("maxOutputDerivativeOrder", 0),
        is("canRunAsynchronuously", false),
        is("canBeInstantiatedOnlyOncePerProcess", false),
        is("canNotUseMemoryManagementFunctions", true),
        is("canGetAndSetFMUstate", true),
        is("canSerializeFMUstate", true),
        is("providesDirectionalDerivative", false),
    ];
    leaf(xml, "CoSimulation", &attributes)
}

fn types(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    let kinds = enumerations(interface);
    if kinds.is_empty() {
        return Ok(());
    }
    node(xml, "TypeDefinitions", &[], |xml| {
        kinds.iter().try_for_each(|kind| {
            node(xml, "SimpleType", &[is("name", kind.name), is("description", kind.description)], |xml| {
                node(xml, "Enumeration", &[], |xml| items(xml, kind))
            })
        })
    })
}

/// FMI 2 leaves the independent variable out: it is optional there, and the FMI Library misses a start value on it.
fn listed(interface: &Interface) -> impl Iterator<Item = Scalar> {
    interface.scalars().filter(|scalar| scalar.row.causality != Causality::Independent)
}

fn variables(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    node(xml, "ModelVariables", &[], |xml| {
        listed(interface).try_for_each(|scalar| {
            let kind = interface.kind(scalar.row);
            let element = Version::Fmi2.type_name(kind);
            node(xml, "ScalarVariable", &identity(&scalar), |xml| {
                let declared = match kind {
                    Kind::Enumeration(kind) => vec![is("declaredType", kind.name)],
                    _ => vec![],
                };
                let state = state_of(&scalar).map(|state| is("derivative", index_of(interface, state)));
                let derivative = state.into_iter().collect();
                leaf(
                    xml,
                    element,
                    &[declared, measure(&scalar), range(interface, &scalar), derivative].concat(),
                )
            })
        })
    })
}

/// FMI 2 counts variables from 1 in the order of the XML.
fn index_of(interface: &Interface, wanted: u32) -> usize {
    1 + listed(interface).take_while(|scalar| scalar.reference != wanted).count()
}

/// Outputs of co-simulation change in a step only, so at a communication point they depend on nothing; at the start unknowns depend on what the
/// table says.
fn structure(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    let index_of = |wanted| index_of(interface, wanted);
    let outputs = || listed(interface).filter(|scalar| scalar.row.causality == Causality::Output);
    node(xml, "ModelStructure", &[], |xml| {
        node(xml, "Outputs", &[], |xml| {
            outputs().try_for_each(|scalar| {
                let index = is("index", index_of(scalar.reference));
                leaf(xml, "Unknown", &[index, ("dependencies", output_dependencies(interface))])
            })
        })?;
        let derivatives: Vec<_> = listed(interface).filter(|scalar| state_of(scalar).is_some()).collect();
        if !derivatives.is_empty() {
            node(xml, "Derivatives", &[], |xml| {
                derivatives
                    .iter()
                    .try_for_each(|scalar| leaf(xml, "Unknown", &[is("index", index_of(scalar.reference))]))
            })?;
        }
        node(xml, "InitialUnknowns", &[], |xml| {
            listed(interface).filter(is_initial_unknown).try_for_each(|Scalar { row, reference, .. }| {
                let dependencies = is("dependencies", dependencies(interface, row, index_of));
                leaf(xml, "Unknown", &[is("index", index_of(reference)), dependencies])
            })
        })
    })
}
