//! modelDescription.xml of FMI 2.0.

use std::io;

use super::xml::{
    Xml, about, categories_and_experiment, dependencies, document, enumerations, identity, is, items,
    kind_of, leaf, node, scalars, units,
};
use crate::fmi::models::Model;
use crate::fmi::variables::{Causality, Kind, Row};

/// The XML of a model.
pub fn model_description(model: Model) -> String {
    let mut root = vec![is("fmiVersion", "2.0"), is("guid", model.token())];
    root.extend(about(model));
    document(|xml| {
        node(xml, "fmiModelDescription", &root, |xml| {
            capabilities(xml, model)?;
            units(xml, model)?;
            types(xml, model)?;
            categories_and_experiment(xml)?;
            variables(xml, model)?;
            structure(xml, model)
        })
    })
}

fn capabilities(xml: &mut Xml, model: Model) -> io::Result<()> {
    let attributes = [
        is("modelIdentifier", model.identifier()),
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

fn types(xml: &mut Xml, model: Model) -> io::Result<()> {
    let kinds = enumerations(model);
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
fn listed(model: Model) -> impl Iterator<Item = (&'static Row, u32)> {
    scalars(model).filter(|(row, _)| row.causality != Causality::Independent)
}

fn variables(xml: &mut Xml, model: Model) -> io::Result<()> {
    node(xml, "ModelVariables", &[], |xml| {
        listed(model).try_for_each(|(row, reference)| {
            let element = match row.kind {
                Kind::Float64 => "Real",
                Kind::Int32 => "Integer",
                Kind::Boolean => "Boolean",
                Kind::Enumeration(_) => "Enumeration",
            };
            node(xml, "ScalarVariable", &identity(row, reference), |xml| {
                leaf(xml, element, &kind_of(row, reference))
            })
        })
    })
}

/// FMI 2 counts variables from 1 in the order of the XML. Outputs change in a step only, so at a communication point
/// they depend on nothing; at the start they depend on what the table says.
fn structure(xml: &mut Xml, model: Model) -> io::Result<()> {
    let index_of = |wanted| 1 + listed(model).take_while(|&(_, reference)| reference != wanted).count();
    let outputs = || listed(model).filter(|(row, _)| row.causality == Causality::Output);
    node(xml, "ModelStructure", &[], |xml| {
        node(xml, "Outputs", &[], |xml| {
            outputs().try_for_each(|(_, reference)| {
                leaf(xml, "Unknown", &[is("index", index_of(reference)), is("dependencies", "")])
            })
        })?;
        node(xml, "InitialUnknowns", &[], |xml| {
            outputs().try_for_each(|(row, reference)| {
                let dependencies = is("dependencies", dependencies(row, index_of));
                leaf(xml, "Unknown", &[is("index", index_of(reference)), dependencies])
            })
        })
    })
}
