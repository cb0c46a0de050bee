//! The simulated rig, which is not what its files say, surveyed through the bridge.

use cable_robot::robot::Pose;
use cable_robot::sim::PlantParameters;
use nalgebra::{Matrix3, Vector3};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::tests::placed_badly;
use super::*;
use crate::bridge::{Event, Fault};
use crate::config::Config;
use crate::config::tests::{AKD, parse};
use crate::simulated::Bench;
use crate::{OperatorCommand, State};

/// The rig is as `truth` says, and surveyed by a bridge that believes the shipped files.
fn survey(truth: Config, mishaps: &[&str], accuracy: &Accuracy, seed: u64) -> Verdict {
    let belief = parse(AKD).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let standing = Config { home: placed_badly(&truth.home, accuracy, &mut random), ..truth };
    let mut bench = Bench::believing(standing, belief.clone(), imperfections()).unwrap().surveying();
    mishaps.iter().for_each(|mishap| bench.suffer(mishap).unwrap());
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    measure_poses(&mut bench, &belief, accuracy, &mut random)
}

/// The platform is put where the program asks for it, in Ready.
fn measure_poses(bench: &mut Bench, belief: &Config, accuracy: &Accuracy, random: &mut Pcg64Mcg) -> Verdict {
    let plan = Plan::new(belief, accuracy);
    for pose in &plan.poses {
        put(bench, &placed_badly(pose, accuracy, random));
        let placed = bench.bridge.operator(OperatorCommand::Placed(*pose), bench.now);
        assert!(placed.is_ok(), "{placed:?} {:?}", bench.events);
        bench.cycle();
    }
    assert_eq!((bench.bridge.state(), bench.bridge.fault()), (State::Ready, None), "{:?}", bench.events);
    let placements: Vec<_> = bench.events.iter().filter_map(|(_, event)| placement(event)).collect();
    assert_eq!(placements.len(), plan.poses.len());
    Verdict::new(&World::of(belief), &placements, accuracy)
}

/// As a hand puts it, which takes its time.
fn put(bench: &mut Bench, pose: &Pose) {
    bench.suffer(&pose.0.iter().fold("place".to_owned(), |text, x| text + &format!(" {x}"))).unwrap();
    bench.run(15.0);
}

fn imperfections() -> PlantParameters {
    PlantParameters { friction: 0.2, load_cell_noise: 0.05, motor_lag: 2e-3, ..PlantParameters::default() }
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

/// A person who takes the rig into service: what the program says is mended in the files, and the next step is done with those.
struct Day {
    truth: Config,
    mishaps: Vec<&'static str>,
    belief: Config,
    accuracy: Accuracy,
    random: Pcg64Mcg,
}

impl Day {
    fn begin(&mut self, is_slack: bool) -> Bench {
        let standing = self.truth.clone();
        let mut bench = Bench::believing(standing, self.belief.clone(), imperfections()).unwrap().surveying();
        self.mishaps.iter().for_each(|mishap| bench.suffer(mishap).unwrap());
        if is_slack {
            (1..=6).for_each(|cable| bench.suffer(&format!("cable {cable} slack 20")).unwrap());
        }
        assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
        bench.run(0.1);
        bench
    }

    /// The motor of each cable of the files pulls alone; what is seen and what the encoders say is mended, drive by drive. What was found.
    fn pulls(&mut self) -> Vec<String> {
        let mut bench = self.begin(true);
        let (mut found, mut exchanged) = (vec![], vec![]);
        for cable in 0..6 {
            let node = self.belief.drives[cable].node;
            let true_cable = self.truth.drives.iter().position(|drive| drive.node == node).unwrap();
            let mut seen = 0f64;
            while bench.bridge.operator(OperatorCommand::Pull(cable), bench.now).is_ok() {
                bench.cycle();
                seen += bench.rig.drives[true_cable].tension();
            }
            bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
            bench.run(0.5);
            let came_in = bench.events.iter().rev().find_map(|(_, event)| match event {
                Event::Pulled { came_in, .. } => Some(came_in[cable]),
                _ => None,
            });
            if seen < 0.0 {
                found.push(format!("{} went out", cable + 1));
                self.belief.drives[cable].winch.direction *= -1.0;
            } else if came_in.unwrap() < 0.0 {
                found.push(format!("{} counts backwards", cable + 1));
                self.mishaps.retain(|mishap| *mishap != format!("drive {node} counts-backwards"));
            }
            if true_cable != cable {
                found.push(format!("{} moved {}", cable + 1, true_cable + 1));
                exchanged.push((cable, true_cable));
            }
        }
        let believed = self.belief.clone();
        for (cable, true_cable) in exchanged {
            self.belief.drives[true_cable] = believed.drives[cable];
            self.belief.load_cells[true_cable] = believed.load_cells[cable];
        }
        found
    }

    /// The verdict, and the platform back on its stand in Ready.
    fn survey(&mut self) -> (Verdict, Bench) {
        let mut bench = self.begin(false);
        assert!(bench.take_up_slack(), "{:?}", bench.events);
        let verdict = measure_poses(&mut bench, &self.belief, &self.accuracy, &mut self.random);
        let home = placed_badly(&self.truth.home, &self.accuracy, &mut self.random);
        put(&mut bench, &home);
        (verdict, bench)
    }
}

/// The mass and the readings, or why the lift ended.
fn weigh(bench: &mut Bench) -> Result<(f64, Weighing), Fault> {
    while bench.bridge.operator(OperatorCommand::Weigh, bench.now).is_ok() {
        bench.cycle();
    }
    bench.bridge.fault().map_or(Ok(()), Err)?;
    let weighed = bench.events.iter().rev().find_map(|(_, event)| match *event {
        Event::Weighed { mass, pose, reading, .. } => Some((mass, Weighing { pose, reading })),
        _ => None,
    });
    Ok(weighed.unwrap_or_else(|| panic!("{:?}", bench.events)))
}

/// A platform with the moments of inertia of a uniform disc of its size, under gains of 8 1/s. With those of Table I, a seventh of them, and its 3 1/s a load
/// cell that is a hundredth off tilts it by `limits.tilt`.
fn disc() -> Config {
    with(|config| {
        config.rig.inertia = Matrix3::from_diagonal(&Vector3::new(0.125, 0.125, 0.25));
        (config.controller.lambda, config.controller.eta) = (8.0, 8.0);
    })
}

/// A sign, a numbering, pulleys, home, the mass and a load cell are wrong together: each is found by the step that is for it.
#[test]
fn a_whole_first_day_on_a_rig_that_is_wrong_in_everything() {
    let mut day = Day {
        truth: with(|truth| {
            truth.rig = disc().rig;
            truth.drives.swap(0, 1);
            truth.load_cells.swap(0, 1);
            truth.drives[3].winch.direction *= -1.0;
            truth.drives.iter_mut().for_each(|drive| drive.winch.pulley_radius = 0.026);
            truth.home = Pose::at(0.03, -0.02, 1.0);
            truth.rig.mass *= 1.08;
            truth.load_cells[4].cell.scale /= 1.2;
        }),
        mishaps: vec!["drive 6 counts-backwards"],
        belief: disc(),
        accuracy: blocks(),
        random: Pcg64Mcg::seed_from_u64(14),
    };
    let found = day.pulls();
    assert_eq!(found, ["1 moved 2", "2 moved 1", "4 went out", "6 counts backwards"]);
    assert_eq!(day.pulls(), Vec::<String>::new());

    let (verdict, bench) = day.survey();
    println!("first survey: {:?}", names(&verdict));
    assert!(!verdict.is_good() && verdict.is_explained, "{verdict:?}");
    drop(bench);
    let Explanation { mistake: None, quantities } = &verdict.explanations[0] else { panic!("{verdict:?}") };
    let file = World::of(&day.belief);
    let mended = quantities.iter().fold(file, |world, fitted| fitted.quantity.truth(&world, fitted.amount));
    day.belief.home = mended.home;
    (0..6).for_each(|i| day.belief.drives[i].winch.pulley_radius /= mended.scale[i]);

    let (verdict, mut bench) = day.survey();
    println!("second survey: {:?}, residual {:.2}", names(&verdict), verdict.residual);
    assert!(verdict.is_good(), "{verdict:?}");
    let Err(Fault::LoadCellDisagrees { cable: 5, measured, commanded }) = weigh(&mut bench) else {
        panic!("{:?}", bench.events)
    };
    println!("cell 5 says {measured:.1} N for {commanded:.1} N");
    day.belief.load_cells[4].cell.scale *= commanded / measured;

    let (verdict, mut bench) = day.survey();
    assert!(verdict.is_good(), "{verdict:?}");
    let (mass, weighing) = weigh(&mut bench).unwrap();
    println!("weighed {mass:.2} kg, truth {:.2}", day.truth.rig.mass);
    assert!((mass / day.truth.rig.mass - 1.0).abs() < 0.02, "{mass}");
    day.belief.rig.mass = mass;
    let noise = 0.25 * day.belief.limits.disagreement / 3f64.sqrt();
    let gains = Gains::new(&day.belief.rig, &[weighing], noise).unwrap();
    println!("gains {:.3?}, standard deviations {:.3?}", &gains.gain[..], &gains.deviation[..]);
    assert!((0..6).all(|i| !gains.is_blamed(i)), "{gains:?}");

    // The paper's move with the files that were mended.
    let mut bench = Bench::believing(day.truth, day.belief, imperfections()).unwrap();
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    bench.go_to(0.15, 0.15, 1.0);
    let reports = bench.run(15.0);
    let last = reports.last().unwrap();
    assert_eq!((last.state, last.fault), (State::Enabled, None), "{:?}", bench.events);
    let away = (bench.rig.plant().encoder_pose.position() - Vector3::new(0.15, 0.15, 1.0)).norm();
    let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
    println!("smallest tension {least:.2} N, {:.1} mm from the goal", 1e3 * away);
    assert!(least > 0.3 && away < 0.01, "{least} {away}");
}

/// How far the platform is turned at rest at home by what is left after commissioning, rad: docs/commissioning.md.
#[test]
fn a_load_cell_a_hundredth_off_tilts_most() {
    let home: fn(&mut Config) = |truth| truth.home.0[0] += 2e-3;
    let anchor: fn(&mut Config) = |truth| truth.rig.cables[0].anchor.x += 4e-3;
    let cell: fn(&mut Config) = |truth| truth.load_cells[4].cell.scale *= 1.01;
    let wrongs = [("home 2 mm", home), ("anchor 1 4 mm", anchor), ("cell 5 1 %", cell)];
    for (belief, most) in
        [(parse(AKD).unwrap(), [0.005, 0.04, f64::INFINITY]), (disc(), [0.0005, 0.001, 0.005])]
    {
        for ((name, wrong), most) in wrongs.into_iter().zip(most) {
            let mut truth = belief.clone();
            wrong(&mut truth);
            let mut bench = Bench::believing(truth, belief.clone(), PlantParameters::default()).unwrap();
            assert!(bench.start(), "{:?}", bench.events);
            bench.run(6.0);
            let turned = bench.rig.plant().encoder_pose.angles().amax();
            println!(
                "gains of {} 1/s, {name}: turned by {turned:.4} rad, {:?}",
                belief.controller.lambda,
                bench.bridge.fault()
            );
            assert!(turned < most, "{name}: {turned}");
            let is_tilted = matches!(bench.bridge.fault(), Some(Fault::Tilted { .. }));
            assert_eq!(is_tilted, most.is_infinite(), "{name}: {:?}", bench.events);
        }
    }
}
