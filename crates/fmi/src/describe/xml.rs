//! What the XML of both versions has in common, written with quick-xml.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use crate::log::CATEGORIES;
use crate::models::exchange::STATES;
use crate::models::{Interface, Scalar, Use};
use crate::variables::{ABOVE_ZERO, Causality, Enumeration, Kind, Row, Unit};

/// Where elements go.
pub type Xml = Writer<Vec<u8>>;

/// Attributes in the order in which they are written; those without value are left out.
pub type Attributes<'a> = &'a [(&'a str, Option<String>)];

/// The preferred communication step, s.
const STEP_SIZE: &str = "0.001";
/// When this version's descriptions were changed last: the same sources give the same bytes.
const DATE: &str = "2026-11-29T00:00:00Z";
/// Long enough for the paper's manoeuvre, s.
const STOP_TIME: &str = "12";

/// A whole document.
pub fn document(body: impl FnOnce(&mut Xml) -> io::Result<()>) -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let written = xml
        .write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))
        .and_then(|()| body(&mut xml));
    written.expect("writing to memory does not fail");
    let mut text = String::from_utf8(xml.into_inner()).expect("names and descriptions are UTF-8");
    text.push('\n');
    text
}

/// An attribute that is always there.
pub fn is(name: &str, value: impl ToString) -> (&str, Option<String>) {
    (name, Some(value.to_string()))
}

/// An element without content.
pub fn leaf(xml: &mut Xml, name: &str, attributes: Attributes) -> io::Result<()> {
    xml.create_element(name).with_attributes(present(attributes)).write_empty().map(|_| ())
}

/// An element with content.
pub fn node(
    xml: &mut Xml,
    name: &str,
    attributes: Attributes,
    body: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    xml.create_element(name).with_attributes(present(attributes)).write_inner_content(body).map(|_| ())
}

fn present<'a>(attributes: Attributes<'a>) -> impl Iterator<Item = (&'a str, &'a str)> {
    attributes.iter().filter_map(|(name, value)| Some((*name, value.as_deref()?)))
}

/// What the root element says of the model in both versions.
pub fn about(interface: &Interface) -> Vec<(&'static str, Option<String>)> {
    vec![
        is("modelName", interface.model().identifier()),
        is("description", interface.description()),
        is("version", env!("CARGO_PKG_VERSION")),
        is("author", "the authors of cable-robot"),
        is("license", env!("CARGO_PKG_LICENSE")),
        is("generationTool", concat!("cable-robot ", env!("CARGO_PKG_VERSION"))),
        is("generationDateAndTime", DATE),
        is("variableNamingConvention", "structured"),
    ]
}

/// The units in use.
pub fn units(xml: &mut Xml, interface: &Interface) -> io::Result<()> {
    let mut units: Vec<&Unit> = Vec::new();
    for unit in interface.scalars().filter_map(|scalar| scalar.row.unit_of(scalar.position)) {
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    node(xml, "UnitDefinitions", &[], |xml| {
        units.iter().try_for_each(|unit| {
            node(xml, "Unit", &[is("name", unit.name)], |xml| {
                let base: Vec<_> = unit.base.iter().map(|(name, exponent)| is(name, exponent)).collect();
                leaf(xml, "BaseUnit", &base)?;
                unit.display.iter().try_for_each(|(name, factor)| {
                    leaf(xml, "DisplayUnit", &[is("name", name), is("factor", factor)])
                })
            })
        })
    })
}

/// The enumeration types in use.
pub fn enumerations(interface: &Interface) -> Vec<&'static Enumeration> {
    let kinds = interface.rows().iter().map(|row| interface.kind(row));
    kinds.filter_map(|kind| if let Kind::Enumeration(kind) = kind { Some(kind) } else { None }).collect()
}

/// The items of an enumeration type.
pub fn items(xml: &mut Xml, kind: &Enumeration) -> io::Result<()> {
    kind.numbered().try_for_each(|(value, name, description)| {
        leaf(xml, "Item", &[is("name", name), is("value", value), is("description", description)])
    })
}

/// What follows the types and precedes the variables.
pub fn categories_and_experiment(xml: &mut Xml) -> io::Result<()> {
    node(xml, "LogCategories", &[], |xml| {
        CATEGORIES.into_iter().try_for_each(|category| {
            let name = is("name", category.name().to_string_lossy());
            leaf(xml, "Category", &[name, is("description", category.description())])
        })
    })?;
    leaf(
        xml,
        "DefaultExperiment",
        &[is("startTime", 0), is("stopTime", STOP_TIME), is("stepSize", STEP_SIZE)],
    )
}

/// Name, reference, description, causality, variability and initial of a scalar.
pub fn identity(scalar: &Scalar) -> Vec<(&'static str, Option<String>)> {
    let row = scalar.row;
    vec![
        is("name", scalar.name()),
        is("valueReference", scalar.reference),
        is("description", row.description),
        is("causality", row.causality.name()),
        is("variability", row.variability.name()),
        ("initial", row.initial().map(str::to_owned)),
    ]
}

/// Unit, quantity and nominal of reals; FMI 3's readers look for them in types.
pub fn measure(scalar: &Scalar) -> Vec<(&'static str, Option<String>)> {
    let (unit, nominal) = (scalar.row.unit_of(scalar.position), scalar.row.nominal);
    vec![
        ("quantity", unit.map(|unit| unit.quantity.to_owned())),
        ("unit", unit.map(|unit| unit.name.to_owned())),
        ("displayUnit", unit.and_then(|unit| unit.display).map(|(name, _)| name.to_owned())),
        ("nominal", nominal.map(|nominal| nominal.to_string())),
    ]
}

/// Range and start of a scalar.
pub fn range(interface: &Interface, scalar: &Scalar) -> Vec<(&'static str, Option<String>)> {
    let row = scalar.row;
    let kind = interface.kind(row);
    // Of reals that stand for something else.
    let [first, last] = match (row.kind, kind) {
        (Kind::Boolean, Kind::Float64) => [Some(0.0), Some(1.0)],
        (Kind::Enumeration(items), Kind::Float64) => items.bounds().map(Some),
        _ => [None, None],
    };
    let least = |min: f64| if min == ABOVE_ZERO { format!("{min:e}") } else { min.to_string() };
    vec![
        ("min", row.min.or(first).map(least)),
        ("max", row.max.or(last).map(|max| max.to_string())),
        ("start", interface.start_of(scalar).map(|start| number(kind, start))),
    ]
}

/// A value as the XML has it.
pub fn number(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Boolean => (value != 0.0).to_string(),
        _ if value.abs() >= 1e15 => format!("{value:e}"),
        _ => value.to_string(),
    }
}

/// The value reference of the state whose derivative a scalar is.
pub fn state_of(scalar: &Scalar) -> Option<u32> {
    scalar.row.derivative_of.map(|row| row.reference(scalar.position))
}

/// Whether initialisation must calculate a scalar: outputs, states and their derivatives.
pub fn is_initial_unknown(scalar: &Scalar) -> bool {
    let is_state = STATES.iter().any(|(row, _)| row.first == scalar.row.first);
    scalar.row.causality == Causality::Output || is_state || state_of(scalar).is_some()
}

/// What outputs depend on while the model runs: nothing in co-simulation, else not said, which is all.
pub fn output_dependencies(interface: &Interface) -> Option<String> {
    (interface.model().usage() != Use::ModelExchange).then(String::new)
}

/// The scalars that an output depends on at the start, as `number_of` counts them, in ascending order.
pub fn dependencies(interface: &Interface, row: &'static Row, number_of: impl Fn(u32) -> usize) -> String {
    let known = interface.dependencies(row).flat_map(|known| interface.scalars_of(known));
    let known = known.filter(|scalar| interface.is_shown(scalar));
    let mut numbers: Vec<usize> = known.map(|scalar| number_of(scalar.reference)).collect();
    numbers.sort_unstable();
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
}
