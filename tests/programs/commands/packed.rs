//! The packed FMUs in target/fmu, loaded as any importer would, on the paper's manoeuvre (Section VI).

use std::path::Path;

use cable_robot_import::{CosimError, Fmu, Instance, Master, Value};
use cable_robot_report::{ClosedLoop, Run};

const VERSIONS: [&str; 2] = ["fmi2", "fmi3"];

/// An instance of a packed FMU.
fn instance(version: &str, model: &str, name: &str) -> Instance {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join(format!("target/fmu/{version}/{model}.fmu"));
    assert!(path.is_file(), "{} is missing: run `cargo fmu build` first", path.display());
    let fmu = Fmu::open(path).unwrap_or_else(|e| panic!("{e}"));
    fmu.instantiate(name, Box::new(|_| {})).unwrap_or_else(|e| panic!("{e}"))
}

/// A plant under way, its first cable pulled more than the others.
fn plant(version: &str, name: &str) -> Instance {
    let plant = instance(version, "CableRobotPlant", name);
    plant.enter_initialization(0.0, None).unwrap();
    for i in 1..=6 {
        let tension = if i == 1 { 12.0 } else { 10.7612 };
        plant.set(plant.variable(&format!("motorTension[{i}]")).unwrap(), tension).unwrap();
    }
    plant.exit_initialization().unwrap();
    plant
}

fn value(instance: &Instance, name: &str) -> Value {
    instance.get(instance.variable(name).unwrap()).unwrap()
}

/// Runs the manoeuvre with the FMUs of one version.
fn manoeuvre(version: &str) -> Run {
    let controller = instance(version, "CableRobotController", "controller");
    let plant = instance(version, "CableRobotPlant", "plant");
    let mut closed_loop = ClosedLoop::new(controller, plant, [0.15, 0.15, 1.0], 1e-3).unwrap();
    closed_loop.run(12.0, 12.0, |_| {}).unwrap();
    closed_loop.recorded_run().unwrap()
}

#[test]
fn the_papers_manoeuvre_takes_four_set_points_and_no_cable_goes_slack() {
    let summary = manoeuvre("fmi3").summary();
    let positions: Vec<_> = summary.set_points.iter().map(|point| point.position).collect();
    assert_eq!(positions.len(), 5, "the start and four set points: {positions:?}");
    for (position, expected) in positions.iter().zip([0.0, 0.0855, 0.1266, 0.1464, 0.15]) {
        let [x, y, z] = *position;
        assert!((x - expected).abs() < 5e-5, "set point {x}, NOTES: {expected}");
        assert!((x - y).abs() < 1e-6 && (z - 1.0).abs() < 1e-6, "off the line x = y: {position:?}");
    }
    let smallest = summary.smallest_tension.expect("samples");
    assert_eq!(smallest.cable, 5, "{smallest}");
    assert!(smallest.value > 0.0, "{smallest}");
    assert_eq!(summary.slack, []);
    assert!(summary.time_to_goal.is_some());
}

#[test]
fn at_the_goal_the_tensions_are_those_of_the_statics() {
    let run = manoeuvre("fmi3");
    for (i, expected) in [13.296, 3.858, 17.319, 19.362, 1.050, 8.410].into_iter().enumerate() {
        let tension = run.tension[i].last().expect("samples");
        assert!((tension - expected).abs() < 5e-3, "u{} = {tension}, expected {expected}", i + 1);
    }
}

#[test]
fn fmi_2_and_fmi_3_give_the_same_bits() {
    assert!(manoeuvre("fmi2") == manoeuvre("fmi3"));
}

#[test]
fn the_exact_planner_turns() {
    for version in VERSIONS {
        let controller = instance(version, "CableRobotController", "controller");
        let settings = [
            ("planner", Value::Int(2)),
            ("goalPose.roll", Value::Float(0.1)),
            ("goalPose.yaw", Value::Float(0.6)),
        ];
        controller.set_parameters(&settings).unwrap();
        let plant = instance(version, "CableRobotPlant", "plant");
        let mut closed_loop = ClosedLoop::new(controller, plant, [0.05, 0.0, 0.9], 1e-3).unwrap();
        closed_loop.run(8.0, 0.1, |_| {}).unwrap();
        let summary = closed_loop.recorded_run().unwrap().summary();
        assert!(summary.time_to_goal.is_some() && summary.slack.is_empty(), "{summary:?}");
        let last = |name: &str| *closed_loop.recorder().column(name).unwrap().last().unwrap();
        assert_eq!((last("controller.setPoint.yaw"), last("controller.status")), (0.6, 4.0));
        assert!(
            (last("plant.encoderPose.yaw") - 0.6).abs() < 0.01 && last("controller.setPointIndex") == 1.0
        );
    }
}

#[test]
fn a_state_goes_back_and_goes_over_to_another_instance() {
    for version in VERSIONS {
        let (first, second) = (plant(version, "first"), plant(version, "second"));
        first.do_step(0.0, 0.1).unwrap();
        let (state, then) = (first.state().unwrap(), value(&first, "encoderPose.x"));
        let bytes = first.serialize(&state).unwrap();
        first.do_step(0.1, 0.1).unwrap();
        let later = value(&first, "encoderPose.x");
        assert_ne!(then, later, "the plant moves");

        first.set_state(&state).unwrap();
        assert_eq!(value(&first, "encoderPose.x"), then);
        second.set_state(&second.deserialize(&bytes).unwrap()).unwrap();
        second.do_step(0.1, 0.1).unwrap();
        assert_eq!(value(&second, "encoderPose.x"), later);
        assert!(matches!(second.set_state(&state), Err(CosimError::ForeignState { .. })));
    }
}

#[test]
fn errors_name_the_instance_the_variable_and_the_value() {
    for version in VERSIONS {
        let plant = plant(version, "p");
        let message = |result: Result<(), CosimError>| result.expect_err("wrong on purpose").to_string();
        assert_eq!(message(plant.variable("nope").map(drop)), "p has no variable nope");
        let slack = plant.variable("slack[1]").unwrap();
        assert_eq!(message(plant.set(slack, 2.0)), "p.slack[1] is of type Boolean and cannot be set to 2");
        let seed = plant.variable("noiseSeed").unwrap();
        let too_big = message(plant.set(seed, 1 << 40));
        assert_eq!(too_big, "p.noiseSeed is of type Int32 and cannot be set to 1099511627776");
        let refused = message(plant.set(plant.variable("motorTension[2]").unwrap(), f64::NAN));
        assert!(refused.starts_with("p: setting motorTension[2] = NaN: fmi"), "{refused}");
        assert!(
            message(plant.deserialize(b"garbage").map(drop))
                .starts_with("p: deserialising 7 bytes of state: ")
        );
    }
}

#[test]
fn what_the_fmu_logs_about_a_parameter_stands_in_the_error() {
    for version in VERSIONS {
        let plant = instance(version, "CableRobotPlant", "p");
        plant.set_parameters(&[("m", Value::Float(-6.0))]).unwrap();
        plant.enter_initialization(0.0, None).unwrap();
        let error = plant.exit_initialization().expect_err("a negative mass").to_string();
        assert!(error.contains("m = -6"), "{error}");
    }
}

#[test]
fn the_master_refuses_what_makes_no_sense() {
    let plant = |name: &str| instance("fmi3", "CableRobotPlant", name);
    let refused = |instances: Vec<Instance>, connections: &[(&str, &str)], step: f64| {
        Master::new(instances, connections, step).err().expect("wrong on purpose").to_string()
    };
    let zero = refused(vec![], &[], 0.0);
    assert_eq!(zero, "co-simulation: the step is 0 s; it must be finite and greater than 0");
    let twice = refused(vec![plant("p"), plant("p")], &[], 1e-3);
    assert_eq!(twice, "co-simulation: two instances are called p");
    let unknown = refused(vec![plant("p"), plant("q")], &[("p.m", "r.m")], 1e-3);
    assert_eq!(unknown, "co-simulation: there is no instance r; there are: p, q");
    let no_variable = refused(vec![plant("p")], &[("p.m", "p.mass")], 1e-3);
    assert_eq!(no_variable, "p has no variable mass");
    let no_path = refused(vec![plant("p")], &[("m", "p.m")], 1e-3);
    assert_eq!(no_path, "co-simulation: \"m\" is not of the form instance.variable");
}

#[test]
fn communication_points_do_not_drift() {
    let mut master = Master::new(vec![instance("fmi3", "CableRobotPlant", "p")], &[], 0.1).unwrap();
    master.initialize(0.0, None).unwrap();
    (0..30).for_each(|_| master.step().unwrap());
    assert_eq!(master.time(), 3.0, "not the sum of thirty 0.1");
}
