//! The packed FMUs in target/fmu, loaded as any importer would, on the paper's manoeuvre (Section VI).

use std::path::{Path, PathBuf};

use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Coordinates, Pose, RigFile};
use cable_robot::sim::{ClosedLoop, PlantInputs};
use cable_robot_cosim::FmuModel;
use cable_robot_fmi::models::controller;
use cable_robot_import::{CosimError, Fmu, Instance, Value, Worker};
use cable_robot_report::run_folder::{FORMAT, RunFolder, RunInfo};
use cable_robot_report::{Recording, Run};

const VERSIONS: [&str; 2] = ["fmi2", "fmi3"];

/// A packed FMU.
fn packed(version: &str, model: &str) -> PathBuf {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join(format!("target/fmu/{version}/{model}.fmu"));
    assert!(path.is_file(), "{} is missing: run `cargo fmu build` first", path.display());
    path
}

/// Loads into this process, or has a process of its own load.
type Open = fn(&Path) -> Result<Fmu, CosimError>;

/// Both versions, each in both ways.
fn ways() -> impl Iterator<Item = (&'static str, Open)> {
    let here: Open = |path| Fmu::open(path);
    let apart: Open =
        |path| Fmu::open_apart(path, &Worker::new(env!("CARGO_BIN_EXE_cable-robot"), &["fmu-worker"]));
    VERSIONS.into_iter().flat_map(move |version| [(version, here), (version, apart)])
}

/// An instance of a packed FMU.
fn instance(open: Open, version: &str, model: &str, name: &str) -> Instance {
    let fmu = open(&packed(version, model)).unwrap_or_else(|e| panic!("{e}"));
    fmu.instantiate(name, Box::new(|_| {})).unwrap_or_else(|e| panic!("{e}"))
}

/// A plant under way, its first cable pulled more than the others.
fn plant(open: Open, version: &str, name: &str) -> Instance {
    let plant = instance(open, version, "CableRobotPlant", name);
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

/// Runs controller and plant of one version from the paper's start to `goal` for `stop` s, or until the goal is reached if that `ends` it.
fn run(version: &str, parameters: &ControllerParameters, goal: Pose, stop: f64, ends: bool) -> RunFolder {
    let rig = RigFile::default();
    let open = |model| FmuModel::open(&packed(version, model), &rig, Box::new(|_| {})).unwrap();
    let (mut controller, plant) = (open("CableRobotController"), open("CableRobotPlant"));
    controller
        .set_parameters(|interface, values| {
            controller::write_parameters(interface, parameters, values);
            Ok(())
        })
        .unwrap();
    let info = RunInfo {
        format: FORMAT,
        program_version: String::new(),
        title: String::new(),
        scenario: None,
        controller: controller.info(),
        plant: plant.info(),
        rig: rig.name.clone(),
        orbit: None,
        step: 1e-3,
        controller_parameters: *parameters,
        plant_parameters: Default::default(),
    };
    let mut closed_loop = ClosedLoop::with_models(controller, plant, goal, &PlantInputs::none(6)).unwrap();
    let mut recording = Recording::new(6);
    recording.push(closed_loop.moment()).unwrap();
    while closed_loop.moment().time < stop && !(ends && closed_loop.moment().controller.at_goal) {
        recording.push(closed_loop.step(1e-3).unwrap()).unwrap();
    }
    RunFolder { info, table: recording.into_table() }
}

/// Runs the manoeuvre with the FMUs of one version.
fn manoeuvre(version: &str) -> Run {
    run(version, &ControllerParameters::default(), Pose::at(0.15, 0.15, 1.0), 12.0, false).run().unwrap()
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
        let parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
        let goal = Pose(Coordinates::new(0.05, 0.0, 0.9, 0.1, 0.0, 0.6));
        let recorded = run(version, &parameters, goal, 8.0, true);
        let summary = recorded.run().unwrap().summary();
        assert!(summary.time_to_goal.is_some() && summary.slack.is_empty(), "{summary:?}");
        let last = |name: &str| *recorded.table.column(name).unwrap().last().unwrap();
        assert_eq!((last("controller.setPoint.yaw"), last("controller.status")), (0.6, 4.0));
        assert!(
            (last("plant.encoderPose.yaw") - 0.6).abs() < 0.01 && last("controller.setPointIndex") == 1.0
        );
    }
}

#[test]
fn a_state_goes_back_and_goes_over_to_another_instance() {
    for (version, open) in ways() {
        let (first, second) = (plant(open, version, "first"), plant(open, version, "second"));
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
    for (version, open) in ways() {
        let plant = plant(open, version, "p");
        let message = |result: Result<(), CosimError>| result.expect_err("wrong on purpose").to_string();
        assert_eq!(message(plant.variable("nope").map(drop)), "p has no variable nope");
        let slack = plant.variable("slack[1]").unwrap();
        assert_eq!(message(plant.set(slack, 2.0)), "p.slack[1] is of type Boolean and cannot be set to 2");
        let seed = plant.variable("noiseSeed").unwrap();
        let too_big = message(plant.set(seed, 1 << 40));
        assert_eq!(too_big, "p.noiseSeed is of type Int32 and cannot be set to 1099511627776");
        let tensions = [1, 2].map(|i| plant.variable(&format!("motorTension[{i}]")).unwrap().clone());
        let refused = message(plant.set_all(&tensions, &[1.0.into(), true.into()]));
        assert_eq!(refused, "p.motorTension[2] is of type Float64 and cannot be set to true");
        let refused = message(plant.set_all(&tensions, &[1.0.into(), f64::NAN.into()]));
        assert!(refused.starts_with("p: setting motorTension[2] = NaN: fmi"), "{refused}");
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
    for (version, open) in ways() {
        let plant = instance(open, version, "CableRobotPlant", "p");
        plant.set_parameters(&[("m", Value::Float(-6.0))]).unwrap();
        plant.enter_initialization(0.0, None).unwrap();
        let error = plant.exit_initialization().expect_err("a negative mass").to_string();
        assert!(error.contains("m = -6"), "{error}");
    }
}
