//! The packed FMUs in target/fmu, loaded as any importer would, on the paper's manoeuvre (Section VI).

use std::path::Path;

use cable_robot::cosim::Fmu;
use cable_robot::report::{ClosedLoop, Run};

/// Runs the manoeuvre with the FMUs of one version.
fn manoeuvre(version: &str) -> Run {
    let open = |model: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("target/fmu/{version}/{model}.fmu"));
        assert!(path.is_file(), "{} is missing: run `cargo fmu build` first", path.display());
        Fmu::open(path).unwrap_or_else(|e| panic!("{e}"))
    };
    let quiet = || Box::new(|_: &_| {});
    let controller = open("CableRobotController").instantiate("controller", quiet()).unwrap();
    let plant = open("CableRobotPlant").instantiate("plant", quiet()).unwrap();
    let mut closed_loop = ClosedLoop::new(controller, plant, [0.15, 0.15, 1.0], 1e-3).unwrap();
    closed_loop.run(12.0, 1.0, |_| {}).unwrap();
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
    assert_eq!(summary.slack, None);
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
