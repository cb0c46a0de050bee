//! The simulated rig, which is not what its files say, surveyed through the bridge.

use cable_robot::robot::Pose;
use cable_robot::sim::PlantParameters;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::tests::placed_badly;
use super::*;
use crate::bridge::Event;
use crate::config::Config;
use crate::config::tests::{AKD, parse};
use crate::simulated::Bench;
use crate::{OperatorCommand, State};

/// The rig is as `truth` says, and surveyed by a bridge that believes the shipped files.
fn survey(truth: Config, mishaps: &[&str], accuracy: &Accuracy, seed: u64) -> Verdict {
    let belief = parse(AKD).unwrap();
    let plan = Plan::new(&belief, accuracy);
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let standing = Config { home: placed_badly(&truth.home, accuracy, &mut random), ..truth };
    let imperfections = PlantParameters {
        friction: 0.2,
        load_cell_noise: 0.05,
        motor_lag: 2e-3,
        ..PlantParameters::default()
    };
    let mut bench = Bench::believing(standing, belief.clone(), imperfections).unwrap().surveying();
    mishaps.iter().for_each(|mishap| bench.suffer(mishap).unwrap());
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    for pose in &plan.poses {
        let put = placed_badly(pose, accuracy, &mut random).0;
        bench.suffer(&put.iter().fold("place".to_owned(), |text, x| text + &format!(" {x}"))).unwrap();
        bench.run(15.0);
        let placed = bench.bridge.operator(OperatorCommand::Placed(*pose), bench.now);
        assert!(placed.is_ok(), "{placed:?} {:?}", bench.events);
        bench.cycle();
    }
    assert_eq!((bench.bridge.state(), bench.bridge.fault()), (State::Ready, None), "{:?}", bench.events);
    let placements: Vec<_> = bench.events.iter().filter_map(|(_, event)| placement(event)).collect();
    assert_eq!(placements.len(), plan.poses.len());
    Verdict::new(&World::of(&belief), &placements, accuracy)
}

fn placement(event: &Event) -> Option<Placement> {
    match *event {
        Event::Placed(pose, lengthening) => Some(Placement { pose, lengthening }),
        _ => None,
    }
}

fn names(verdict: &Verdict) -> Vec<String> {
    verdict.explanations.iter().map(ToString::to_string).collect()
}

fn blocks() -> Accuracy {
    Accuracy { position: 0.001, angle: 0.002, length: 0.001 }
}

fn with(change: impl FnOnce(&mut Config)) -> Config {
    let mut truth = parse(AKD).unwrap();
    change(&mut truth);
    truth
}

#[test]
fn a_rig_that_is_as_its_files_say_passes() {
    for seed in 1..=3 {
        let verdict = survey(parse(AKD).unwrap(), &[], &blocks(), seed);
        assert!(verdict.is_good(), "{verdict:?}");
    }
}

/// Every wrong file that used to pass all checks up to Enabled.
#[test]
fn wrong_files_that_every_check_of_lengths_passes_are_found_and_named_before_the_lift() {
    let shipped = || parse(AKD).unwrap();
    let backwards = [1, 2, 3, 4, 5, 6].map(|cable| format!("drive {cable} counts-backwards"));
    let backwards = backwards.each_ref().map(String::as_str);
    let wrong: [(&str, Config, &[&str]); 8] = [
        (
            "lengths of all cables read 4 times as long",
            with(|truth| truth.drives.iter_mut().for_each(|drive| drive.winch.counts_per_turn *= 4.0)),
            &[],
        ),
        ("sign of the encoder of cable 3", shipped(), &backwards[2..3]),
        ("sign of the encoder of all cables", shipped(), &backwards),
        (
            "drives of cables 1 and 2 exchanged",
            with(|truth| {
                truth.drives.swap(0, 1);
                truth.load_cells.swap(0, 1);
            }),
            &[],
        ),
        (
            "cables numbered the other way round: cable 1 of the file is cable 6",
            with(|truth| {
                truth.drives.reverse();
                truth.load_cells.reverse();
            }),
            &[],
        ),
        ("home, x: +5", with(|truth| truth.home = Pose::at(0.05, 0.0, 1.0)), &[]),
        (
            "pulley radius, all cables: +",
            with(|truth| truth.drives.iter_mut().for_each(|drive| drive.winch.pulley_radius = 0.030)),
            &[],
        ),
        (
            "size of the base: +2",
            with(|truth| truth.rig.cables.iter_mut().for_each(|cable| cable.anchor *= 1.25)),
            &[],
        ),
    ];
    for (expected, truth, mishaps) in wrong {
        let verdict = survey(truth, mishaps, &blocks(), 7);
        println!("{expected}: {:?}, residual {:.2}", names(&verdict), verdict.residual);
        assert!(!verdict.is_good() && verdict.is_explained, "{expected}: {verdict:?}");
        assert!(names(&verdict)[0].starts_with(expected), "{expected}: {:?}", names(&verdict));
    }
}
