//! `modelDescription.xml`: what an FMU says of itself.

use std::fmt;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use serde::{Deserialize, Serialize};

use super::Value;
use super::limits::{DEEPEST, MOST_VARIABLES};

/// Version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FmiVersion {
    /// FMI 2.0.x.
    V2,
    /// FMI 3.0.x.
    V3,
}

/// Type of a variable, in the names of FMI 3; FMI 2's `Real` is `Float64`, its `Integer` is `Int32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the standard's own names")]
pub enum VariableType {
    Float64,
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    Enumeration,
    String,
    Binary,
    Clock,
}

/// Role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the standard's own names")]
pub enum Causality {
    Parameter,
    CalculatedParameter,
    StructuralParameter,
    Input,
    Output,
    Local,
    Independent,
}

/// One variable of an FMU.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, unique in the FMU.
    pub name: String,
    /// What the C functions call it.
    pub reference: u32,
    /// Type.
    pub kind: VariableType,
    /// Role.
    pub causality: Causality,
    /// Start value, if the description gives one and the variable is a scalar number or Boolean.
    pub start: Option<Value>,
    /// Whether it is an array (FMI 3).
    pub array: bool,
}

/// What `modelDescription.xml` says, as far as a co-simulation needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelDescription {
    /// Version of the standard.
    pub version: FmiVersion,
    /// Name for people.
    pub model_name: String,
    /// File name of the binary, without its extension.
    pub model_identifier: String,
    /// `guid` (FMI 2) or `instantiationToken` (FMI 3).
    pub token: String,
    /// Whether states can be taken and put back.
    pub can_get_and_set_state: bool,
    /// Whether a state can become bytes.
    pub can_serialize_state: bool,
    /// `stopTime` of the default experiment, s.
    pub stop_time: Option<f64>,
    /// `stepSize` of the default experiment, s.
    pub step_size: Option<f64>,
    /// In the order of the file.
    pub variables: Vec<Variable>,
}

impl ModelDescription {
    /// Reads the text of a `modelDescription.xml`.
    ///
    /// # Errors
    /// A sentence that names the element, the attribute and the value that is missing or wrong.
    pub fn parse(xml: &str) -> Result<Self, String> {
        let mut reader = Reader::from_str(xml);
        reader.config_mut().expand_empty_elements = true;
        let mut path: Vec<String> = Vec::new();
        let mut found = Found::default();
        loop {
            let event = reader.read_event();
            match event.map_err(|e| format!("no XML at byte {}: {e}", reader.error_position()))? {
                Event::Start(element) => {
                    found.element(path.last().map(String::as_str), &element)?;
                    path.push(element.name().as_ref().to_owned());
                    if path.len() > DEEPEST {
                        return Err(format!("more than {DEEPEST} elements inside one another"));
                    }
                    if found.variables.len() > MOST_VARIABLES {
                        return Err(format!("more than {MOST_VARIABLES} variables, the most that are read"));
                    }
                }
                Event::End(_) => drop(path.pop()),
                Event::Eof => break,
                _ => {}
            }
        }
        match path.last() {
            Some(open) => Err(format!("the file ends inside <{open}>")),
            None => found.finish(),
        }
    }

    /// The variable of this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}

/// What has been read so far.
#[derive(Default)]
struct Found {
    root: Option<(FmiVersion, String, String)>,
    model_identifier: Option<String>,
    can_get_and_set_state: bool,
    can_serialize_state: bool,
    stop_time: Option<f64>,
    step_size: Option<f64>,
    variables: Vec<Variable>,
}

impl Found {
    /// Takes what matters from an element below `parent`.
    fn element(&mut self, parent: Option<&str>, element: &BytesStart) -> Result<(), String> {
        let name = element.name();
        match (parent, name.as_ref()) {
            (None, "fmiModelDescription") => self.root = Some(root(element)?),
            (None, other) => return Err(format!("the root is <{other}>, not <fmiModelDescription>")),
            (Some("fmiModelDescription"), "CoSimulation") => self.co_simulation(element)?,
            (Some("fmiModelDescription"), "DefaultExperiment") => {
                self.stop_time = optional(element, "stopTime")?.map(|t| float("stopTime", &t)).transpose()?;
                self.step_size = optional(element, "stepSize")?.map(|t| float("stepSize", &t)).transpose()?;
            }
            // The type of an FMI 2 variable stands in the element inside it, which comes next.
            (Some("ModelVariables"), "ScalarVariable") => {
                self.variables.push(variable(element, VariableType::Float64)?);
            }
            (Some("ScalarVariable"), kind) => {
                if let (Some(kind), Some(last)) = (variable_type(kind), self.variables.last_mut()) {
                    last.kind = kind;
                    last.start = start(element, &last.name, kind)?;
                }
            }
            (Some("ModelVariables"), kind) => {
                let kind = variable_type(kind).ok_or_else(|| format!("<{kind}> is no type of FMI 3"))?;
                let mut variable = variable(element, kind)?;
                // An array's start is a list.
                variable.start = start(element, &variable.name, kind).ok().flatten();
                self.variables.push(variable);
            }
            (Some(_), "Dimension") => {
                if let Some(last) = self.variables.last_mut() {
                    last.array = true;
                    last.start = None;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn co_simulation(&mut self, element: &BytesStart) -> Result<(), String> {
        self.model_identifier = Some(identifier(required(element, "modelIdentifier")?)?);
        let flag = |fmi2, fmi3| -> Result<bool, String> {
            let text = optional(element, fmi2)?.or(optional(element, fmi3)?);
            text.map_or(Ok(false), |text| boolean(fmi3, &text))
        };
        self.can_get_and_set_state = flag("canGetAndSetFMUstate", "canGetAndSetFMUState")?;
        self.can_serialize_state = flag("canSerializeFMUstate", "canSerializeFMUState")?;
        Ok(())
    }

    fn finish(self) -> Result<ModelDescription, String> {
        let (version, model_name, token) = self.root.ok_or("there is no <fmiModelDescription>")?;
        Ok(ModelDescription {
            version,
            model_name,
            token,
            model_identifier: self
                .model_identifier
                .ok_or("there is no <CoSimulation>; this FMU is no slave")?,
            can_get_and_set_state: self.can_get_and_set_state,
            can_serialize_state: self.can_serialize_state,
            stop_time: self.stop_time,
            step_size: self.step_size,
            variables: self.variables,
        })
    }
}

/// Version, model name and token.
fn root(element: &BytesStart) -> Result<(FmiVersion, String, String), String> {
    let text = required(element, "fmiVersion")?;
    let (version, token) = match text.split('.').next() {
        Some("2") => (FmiVersion::V2, "guid"),
        Some("3") => (FmiVersion::V3, "instantiationToken"),
        _ => return Err(format!("fmiVersion is \"{text}\"; this importer reads 2.x and 3.x")),
    };
    Ok((version, required(element, "modelName")?, required(element, token)?))
}

/// A name of C, which no path can be.
fn identifier(text: String) -> Result<String, String> {
    let is_start = |c: char| c.is_ascii_alphabetic() || c == '_';
    let is_name = text.starts_with(is_start) && text.chars().all(|c| is_start(c) || c.is_ascii_digit());
    let wanted = "must be letters, digits and _, no digit first: it names the binary";
    if is_name { Ok(text) } else { Err(format!("modelIdentifier is {text:?}; it {wanted}")) }
}

/// A variable without its start value.
fn variable(element: &BytesStart, kind: VariableType) -> Result<Variable, String> {
    let name = required(element, "name")?;
    let reference = required(element, "valueReference")?;
    let reference = reference.parse().map_err(|_| {
        format!("{name}: valueReference is \"{reference}\", not a number from 0 to 4294967295")
    })?;
    let causality = match optional(element, "causality")?.as_deref().unwrap_or("local") {
        "parameter" => Causality::Parameter,
        "calculatedParameter" => Causality::CalculatedParameter,
        "structuralParameter" => Causality::StructuralParameter,
        "input" => Causality::Input,
        "output" => Causality::Output,
        "local" => Causality::Local,
        "independent" => Causality::Independent,
        other => return Err(format!("{name}: causality is \"{other}\", which neither FMI 2 nor 3 knows")),
    };
    Ok(Variable { name, reference, kind, causality, start: None, array: false })
}

/// The type that an element's name stands for, in either version.
fn variable_type(name: &str) -> Option<VariableType> {
    Some(match name {
        "Real" | "Float64" => VariableType::Float64,
        "Float32" => VariableType::Float32,
        "Int8" => VariableType::Int8,
        "UInt8" => VariableType::UInt8,
        "Int16" => VariableType::Int16,
        "UInt16" => VariableType::UInt16,
        "Integer" | "Int32" => VariableType::Int32,
        "UInt32" => VariableType::UInt32,
        "Int64" => VariableType::Int64,
        "UInt64" => VariableType::UInt64,
        "Boolean" => VariableType::Boolean,
        "Enumeration" => VariableType::Enumeration,
        "String" => VariableType::String,
        "Binary" => VariableType::Binary,
        "Clock" => VariableType::Clock,
        _ => return None,
    })
}

/// The start value, if there is one and [`Value`] can hold it.
fn start(element: &BytesStart, name: &str, kind: VariableType) -> Result<Option<Value>, String> {
    let Some(text) = optional(element, "start")? else { return Ok(None) };
    let value = match kind {
        VariableType::Float64 | VariableType::Float32 => Value::Float(float(name, &text)?),
        VariableType::Boolean => Value::Bool(boolean(name, &text)?),
        VariableType::String | VariableType::Binary | VariableType::Clock => return Ok(None),
        _ => Value::Int(text.trim().parse().map_err(|_| format!("{name}: \"{text}\" is no integer"))?),
    };
    Ok(Some(value))
}

fn float(name: &str, text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("{name}: \"{text}\" is no number"))
}

fn boolean(name: &str, text: &str) -> Result<bool, String> {
    match text.trim() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(format!("{name}: \"{text}\" is no Boolean (true, false, 1, 0)")),
    }
}

fn required(element: &BytesStart, attribute: &str) -> Result<String, String> {
    optional(element, attribute)?
        .ok_or_else(|| format!("<{}> has no attribute {attribute}", element.name().as_ref()))
}

fn optional(element: &BytesStart, attribute: &str) -> Result<Option<String>, String> {
    let told = |e: &dyn fmt::Display| format!("<{}> {attribute}: {e}", element.name().as_ref());
    let Some(found) = element.try_get_attribute(attribute).map_err(|e| told(&e))? else { return Ok(None) };
    let value = found.normalized_value(XmlVersion::Implicit1_0).map_err(|e| told(&e))?;
    Ok(Some(value.into_owned()))
}

#[cfg(test)]
mod tests;
