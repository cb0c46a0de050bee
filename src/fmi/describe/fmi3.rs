//! modelDescription.xml and the icon's place in FMI 3.0.

use std::io;

use super::xml::{
    Xml, about, categories_and_experiment, dependencies, document, enumerations, identity, is, items,
    kind_of, leaf, node, scalars, units,
};
use crate::fmi::models::Model;
use crate::fmi::variables::Causality;

/// The XML of a model.
pub fn model_description(model: Model) -> String {
    let mut root = vec![is("fmiVersion", "3.0"), is("instantiationToken", model.token())];
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

/// terminalsAndIcons.xml: a square icon.
pub fn icon_place() -> String {
    let corners = [is("x1", -100), is("y1", -100), is("x2", 100), is("y2", 100)];
    let mut system = corners.to_vec();
    system.push(is("suggestedScalingFactorTo_mm", 0.1));
    document(|xml| {
        node(xml, "fmiTerminalsAndIcons", &[is("fmiVersion", "3.0")], |xml| {
            node(xml, "GraphicalRepresentation", &[], |xml| {
                leaf(xml, "CoordinateSystem", &system)?;
                leaf(xml, "Icon", &corners)
            })
        })
    })
}

fn capabilities(xml: &mut Xml, model: Model) -> io::Result<()> {
    let attributes = [
        is("modelIdentifier", model.identifier()),
        is("needsExecutionTool", false),
        is("canBeInstantiatedOnlyOncePerProcess", false),
        is("canGetAndSetFMUState", true),
        is("canSerializeFMUState", true),
        is("providesDirectionalDerivatives", false),
        is("providesAdjointDerivatives", false),
        is("providesPerElementDependencies", false),
        is("canHandleVariableCommunicationStepSize", true),
        is("maxOutputDerivativeOrder", 0),
        is("providesIntermediateUpdate", false),
        is("mightReturnEarlyFromDoStep", false),
        is("canReturnEarlyAfterIntermediateUpdate", false),
        is("hasEventMode", false),
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
            let attributes = [is("name", kind.name), is("description", kind.description)];
            node(xml, "EnumerationType", &attributes, |xml| items(xml, kind))
        })
    })
}

fn variables(xml: &mut Xml, model: Model) -> io::Result<()> {
    node(xml, "ModelVariables", &[], |xml| {
        scalars(model).try_for_each(|(row, reference)| {
            let attributes = [identity(row, reference), kind_of(row, reference)].concat();
            leaf(xml, row.kind.name(), &attributes)
        })
    })
}

/// Outputs change in a step only, so at a communication point they depend on nothing; at the start they depend on what
/// the table says.
fn structure(xml: &mut Xml, model: Model) -> io::Result<()> {
    let outputs = || scalars(model).filter(|(row, _)| row.causality == Causality::Output);
    node(xml, "ModelStructure", &[], |xml| {
        outputs().try_for_each(|(_, reference)| {
            leaf(xml, "Output", &[is("valueReference", reference), is("dependencies", "")])
        })?;
        outputs().try_for_each(|(row, reference)| {
            let dependencies = is("dependencies", dependencies(row, |known| known as usize));
            leaf(xml, "InitialUnknown", &[is("valueReference", reference), dependencies])
        })
    })
}
