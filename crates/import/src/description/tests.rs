//! What the parser makes of descriptions, right and wrong.

use super::*;

const FMI2: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="A &amp; B" guid="{1}">
  <CoSimulation modelIdentifier="AB" canGetAndSetFMUstate="true" canSerializeFMUstate="false"/>
  <TypeDefinitions><SimpleType name="T"><Enumeration><Item name="x" value="1"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="12.5" stepSize="1e-3"/>
  <ModelVariables>
    <ScalarVariable name="u[1]" valueReference="7" causality="input" variability="continuous"><Real start="1.5"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="7" causality="parameter"><Integer start="-3"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="8" causality="output"><Boolean start="1"/></ScalarVariable>
    <ScalarVariable name="e" valueReference="9"><Enumeration declaredType="T" start="1"/></ScalarVariable>
    <ScalarVariable name="s" valueReference="10"><String start="text"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="3"/></Outputs></ModelStructure>
</fmiModelDescription>"#;

const FMI3: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t">
  <ModelExchange modelIdentifier="no"/>
  <CoSimulation modelIdentifier="M" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent"/>
    <Float64 name="v" valueReference="1" causality="input" start="1 2 3"><Dimension start="3"/></Float64>
    <UInt64 name="n" valueReference="2" causality="structuralParameter" start="3"/>
    <Boolean name="b" valueReference="3" start="false"/>
    <String name="s" valueReference="4"><Start value="x"/></String>
  </ModelVariables>
</fmiModelDescription>"#;

fn parsed(xml: &str) -> ModelDescription {
    ModelDescription::parse(xml).expect("a right description")
}

fn refused(from: &str, to: &str) -> String {
    let broken = FMI2.replace(from, to);
    assert_ne!(broken, FMI2, "the test breaks something");
    ModelDescription::parse(&broken).expect_err("a wrong description")
}

#[test]
fn fmi2_variables_have_the_type_and_start_of_the_inner_element() {
    let model = parsed(FMI2);
    assert_eq!(model.version, FmiVersion::V2);
    assert_eq!((model.model_name.as_str(), model.token.as_str()), ("A & B", "{1}"));
    assert_eq!(model.model_identifier, "AB");
    assert!(model.can_get_and_set_state && !model.can_serialize_state);
    assert_eq!((model.stop_time, model.step_size), (Some(12.5), Some(0.001)));
    let seen: Vec<_> = model
        .variables
        .iter()
        .map(|v| (v.name.as_str(), v.reference, v.kind, v.causality, v.start))
        .collect();
    assert_eq!(
        seen,
        [
            ("u[1]", 7, VariableType::Float64, Causality::Input, Some(Value::Float(1.5))),
            ("n", 7, VariableType::Int32, Causality::Parameter, Some(Value::Int(-3))),
            ("on", 8, VariableType::Boolean, Causality::Output, Some(Value::Bool(true))),
            ("e", 9, VariableType::Enumeration, Causality::Local, Some(Value::Int(1))),
            ("s", 10, VariableType::String, Causality::Local, None),
        ]
    );
}

#[test]
fn fmi3_variables_know_arrays() {
    let model = parsed(FMI3);
    assert_eq!(
        (model.version, model.model_identifier.as_str(), model.token.as_str()),
        (FmiVersion::V3, "M", "t")
    );
    let seen: Vec<_> = model.variables.iter().map(|v| (v.name.as_str(), v.kind, v.array, v.start)).collect();
    assert_eq!(
        seen,
        [
            ("time", VariableType::Float64, false, None),
            ("v", VariableType::Float64, true, None),
            ("n", VariableType::UInt64, false, Some(Value::Int(3))),
            ("b", VariableType::Boolean, false, Some(Value::Bool(false))),
            ("s", VariableType::String, false, None),
        ]
    );
}

#[test]
fn errors_name_the_element_the_attribute_and_the_value() {
    for (from, to, expected) in [
        (
            "fmiVersion=\"2.0\"",
            "fmiVersion=\"1.0\"",
            "fmiVersion is \"1.0\"; this importer reads 2.x and 3.x",
        ),
        ("guid=\"{1}\"", "", "<fmiModelDescription> has no attribute guid"),
        ("CoSimulation", "ModelExchange", "there is no <CoSimulation>; this FMU is no slave"),
        ("start=\"1.5\"", "start=\"1,5\"", "u[1]: \"1,5\" is no number"),
        ("start=\"-3\"", "start=\"x\"", "n: \"x\" is no integer"),
        ("<Boolean start=\"1\"", "<Boolean start=\"yes\"", "on: \"yes\" is no Boolean (true, false, 1, 0)"),
        (
            "causality=\"output\"",
            "causality=\"out\"",
            "on: causality is \"out\", which neither FMI 2 nor 3 knows",
        ),
        (
            "valueReference=\"8\"",
            "valueReference=\"-8\"",
            "on: valueReference is \"-8\", not a number from 0 to 4294967295",
        ),
        ("fmiModelDescription", "html", "the root is <html>, not <fmiModelDescription>"),
        ("</fmiModelDescription>", "", "the file ends inside <fmiModelDescription>"),
    ] {
        assert_eq!(refused(from, to), expected);
    }
    assert!(refused("</ModelVariables>", "</Model>").starts_with("no XML at byte "));
    assert_eq!(ModelDescription::parse("").expect_err("nothing"), "there is no <fmiModelDescription>");
}

#[test]
fn a_model_identifier_that_is_a_path_is_refused() {
    let described = |identifier: &str| {
        ModelDescription::parse(&format!(
            "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"M\" instantiationToken=\"t\">\
             <CoSimulation modelIdentifier=\"{identifier}\"/></fmiModelDescription>"
        ))
    };
    for good in ["M", "_m1", "CableRobotPlant"] {
        assert_eq!(described(good).unwrap().model_identifier, good);
    }
    for bad in ["../../../../outside/lib", "/lib", "a/b", "a.b", "", "1m", "m\u{e9}", "a b"] {
        let said = described(bad).unwrap_err();
        let wanted = "; it must be letters, digits and _, no digit first: it names the binary";
        assert_eq!(said, format!("modelIdentifier is {bad:?}{wanted}"));
    }
}

#[test]
fn elements_without_end_inside_one_another_are_refused_with_the_number() {
    let xml = "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"M\" instantiationToken=\"t\">".to_owned();
    let said = ModelDescription::parse(&(xml + &"<a>".repeat(1000))).unwrap_err();
    assert_eq!(said, "more than 100 elements inside one another");
}
