use super::*;
use cable_robot::plan::PlannerKind;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::config::Parameter;
use cable_robot_fieldbus::simulated::Bench;

fn read(name: &str) -> Files {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../rigs/can"));
    Files::read(&folder.join(name)).unwrap()
}

#[test]
fn the_parameters_of_a_fieldbus_file_are_those_of_the_bench() {
    for name in ["akd.toml", "eight.toml"] {
        let config = read(name).config;
        let bench = Bench::new(config.clone(), PlantParameters::default()).unwrap();
        assert_eq!(controller_parameters(&config), Ok(bench.parameters()), "{name}");
    }
}

#[test]
fn what_a_fieldbus_file_says_of_the_controller_is_heeded_or_refused() {
    let mut config = read("akd.toml").config;
    let mut given = |name: &str, value| {
        config.controller.parameters.insert(name.to_owned(), value);
        controller_parameters(&config)
    };
    assert_eq!(given("lambda", Parameter::Number(2.5)).unwrap().lambda, 2.5);
    let exact = given("planner", Parameter::Item("Exact".to_owned())).unwrap();
    // What it leaves for encoders comes with it.
    assert!(exact.planner == PlannerKind::Exact && exact.encoder_resolution > 0.0);
    let error = given("planner", Parameter::Item("Swift".to_owned())).unwrap_err().to_string();
    assert!(error.contains("planner = Swift: it is one of Bounded, Exact"), "{error}");
    let error = given("planner", Parameter::Number(2.0)).unwrap_err().to_string();
    assert!(error.contains("planner = 2: it is a Enumeration"), "{error}");
}

#[test]
fn a_node_is_found_by_the_token_of_its_files_and_of_no_others() {
    let (files, folder) = (read("akd.toml"), tempfile::tempdir().unwrap());
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(FIELDBUS_FILE, &files.fieldbus);
    write(RIG_FILE, &files.rig);
    let [controller, rig] = NODES.map(|kind| interface(kind, &files));
    assert_ne!(controller.token(), rig.token());
    for known in [&controller, &rig] {
        assert_eq!(node(known.token(), folder.path()).unwrap().0.model(), known.model());
    }
    let other = interface(NodeKind::Rig, &read("eight.toml"));
    let refused = |token: &str| node(token, folder.path()).err().unwrap().to_string();
    let error = refused(other.token());
    assert!(error.contains(controller.token()) && error.contains(rig.token()), "{error}");
    write(FIELDBUS_FILE, &files.fieldbus.replace("rate = 250.0", "rate = 200.0"));
    assert!(refused(rig.token()).contains("belongs to no model"));
    write(FIELDBUS_FILE, &files.fieldbus.replace("rate = 250.0", "rate = 0.0"));
    let error = refused(rig.token());
    assert!(error.contains("fieldbus.toml") && error.contains("rate = 0"), "{error}");
}
