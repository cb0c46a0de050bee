//! A rig of eight cables: a fieldbus file of its own, the tension distribution's tensions, a drive that dies.

use super::*;
use cable_robot::robot::RigFile;

fn eight() -> Bench {
    let imperfections = PlantParameters {
        friction: 0.5,
        motor_lag: 2e-3,
        load_cell_noise: 0.1,
        ..PlantParameters::default()
    };
    Bench::new(crate::config::tests::eight(), imperfections).unwrap()
}

#[test]
fn a_rig_of_eight_cables_makes_its_move_within_the_limits_of_its_rig_file() {
    let mut bench = eight();
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    // Its stand is below.
    bench.go_to(0.3, 0.2, 1.9);
    let reports = bench.run(12.0);
    let last = reports.last().unwrap();
    assert_eq!((last.state, last.fault), (State::Enabled, None), "{:?}", bench.events);
    let there = bench.rig.plant().encoder_pose.position();
    assert!((there - nalgebra::Vector3::new(0.3, 0.2, 1.9)).norm() < 0.01, "{there}");
    let measured = || reports.iter().flat_map(|report| report.measured);
    let (least, most) = (measured().fold(f64::INFINITY, f64::min), measured().fold(0.0, f64::max));
    println!("between {least:.1} and {most:.1} N");
    assert!(least > 5.0 && most < 400.0, "{least} {most}");
}

#[test]
fn drive_eight_dead_leads_to_a_fault_that_names_its_node() {
    let mut bench = eight();
    assert!(bench.start(), "{:?}", bench.events);
    bench.suffer("drive 8 dead").unwrap();
    assert!(bench.run_until(State::Fault, 5.0), "{:?}", bench.events);
    let is_of_eight =
        |fault: Fault| matches!(fault, Fault::EncoderSilent { cable: 8 } | Fault::HeartbeatLost { node: 8 });
    assert!(bench.bridge.fault.is_some_and(is_of_eight), "{:?}", bench.bridge.fault);
}

#[test]
fn a_file_of_six_drives_is_refused_for_eight_cables() {
    let rig = RigFile::parse(include_str!("../../../../../rigs/eight.toml")).unwrap();
    let error = Config::parse(AKD, &rig).unwrap_err().to_string();
    assert!(error.contains("number of [[drives]] = 6 is not allowed: must be 8"), "{error}");
}
