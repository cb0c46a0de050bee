//! One cable in or out with a held button, in Homing.

use super::*;
use crate::simulated::Support;
use JogDirection::{In, Out};

/// In Homing, after mishaps.
fn homing(mut bench: Bench, mishaps: &[&str]) -> Bench {
    mishaps.iter().for_each(|mishap| bench.suffer(mishap).unwrap());
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    bench
}

fn rig(config: Config, friction: f64) -> Bench {
    let imperfections =
        PlantParameters { friction, motor_lag: 2e-3, load_cell_noise: 0.05, ..PlantParameters::default() };
    Bench::new(config, imperfections).unwrap()
}

/// Each winch with 0.2 N of friction.
fn at_homing(mishaps: &[&str]) -> Bench {
    homing(rig(config(), 0.2), mishaps)
}

/// What came of a jog, as the rig has it.
#[derive(Debug)]
struct Jogged {
    /// m, and m/s at most.
    came_in: f64,
    fastest: f64,
    /// N, of the motor: least and greatest; and of all others.
    pull: [f64; 2],
    others: f64,
    cause: Option<Cause>,
}

/// Holds the button for so long, or until it does nothing any more.
fn jog(bench: &mut Bench, cable: usize, direction: JogDirection, seconds: f64) -> Jogged {
    let (end, seen, period) =
        (bench.now + (seconds * 1e9) as u64, bench.events.len(), bench.bridge.config().period);
    let (from, mut last) = (bench.rig.paid_out()[cable], bench.rig.paid_out()[cable]);
    let mut jogged = Jogged { came_in: 0.0, fastest: 0.0, pull: [0.0; 2], others: 0.0, cause: None };
    while bench.now < end && bench.bridge.operator(OperatorCommand::Jog(cable, direction), bench.now).is_ok()
    {
        bench.cycle();
        let (now, pull) = (bench.rig.paid_out()[cable], bench.rig.drives[cable].tension());
        jogged.fastest = jogged.fastest.max((now - last).abs() * 1e9 / period as f64);
        jogged.pull = [jogged.pull[0].min(pull), jogged.pull[1].max(pull)];
        let others = bench.rig.drives.iter().enumerate().filter(|(i, _)| *i != cable);
        jogged.others = others.fold(jogged.others, |most, (_, drive)| most.max(drive.tension().abs()));
        last = now;
    }
    jogged.came_in = from - last;
    jogged.cause = bench.events[seen..].iter().find_map(|(_, event)| match event {
        Event::LetGo(cause) => Some(*cause),
        _ => None,
    });
    jogged
}

/// What was said of the last one.
fn said(bench: &Bench) -> (usize, f64, f64) {
    let said = bench.events.iter().rev().find_map(|(_, event)| match event {
        Event::Jogged { cable, came_in, measured } => Some((*cable, *came_in, *measured)),
        _ => None,
    });
    said.unwrap_or_else(|| panic!("{:?}", bench.events))
}

fn release(bench: &mut Bench) {
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(0.5);
}

/// Of the law: `slack.most` per `slack.ramp`, m/s.
const SPEED: f64 = 0.05 / 2.0;

#[test]
fn fifteen_centimetres_of_slack_are_jogged_in_and_homing_then_works() {
    let mut bench = at_homing(&["cable 4 slack 150"]);
    assert!(!bench.take_up_slack());
    assert!(matches!(bench.bridge.fault, Some(Fault::LooseCable { cable: 4, .. })), "{:?}", bench.events);

    let mut bench = at_homing(&["cable 4 slack 150"]);
    let jogged = jog(&mut bench, 3, In, 20.0);
    println!("{jogged:?}");
    assert_eq!(
        (jogged.cause, bench.bridge.state()),
        (Some(Cause::Taut), State::Homing),
        "{:?}",
        bench.events
    );
    assert!((jogged.came_in - 0.15).abs() < 1e-4, "{jogged:?}");
    let (cable, came_in, measured) = said(&bench);
    assert_eq!(cable, 3);
    assert!((came_in - 0.15).abs() < 1e-3 && (measured - 2.8).abs() < 0.5, "{came_in} {measured}");
    assert!(jogged.pull[1] <= 3.0 && jogged.pull[0] > -0.5 && jogged.others == 0.0, "{jogged:?}");
    // It is still pressed, and nothing moves.
    for command in [OperatorCommand::Jog(3, In), OperatorCommand::Home] {
        assert_eq!(bench.bridge.operator(command, bench.now), Err(Refusal::StillPressed));
    }
    release(&mut bench);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    assert_eq!((bench.rig.support(), bench.bridge.fault), (Support::Stand, None));
}

#[test]
fn a_cable_is_paid_out_with_a_pull_outwards_and_hauled_in_again() {
    let mut bench = at_homing(&[]);
    let out = jog(&mut bench, 1, Out, 4.0);
    println!("{out:?}");
    assert!(out.came_in < -0.08 && out.came_in > -0.11 && out.others == 0.0, "{out:?}");
    assert!(out.pull[0] >= -3.0 && out.pull[1] < 0.5, "{out:?}");
    release(&mut bench);
    let (cable, came_in, _) = said(&bench);
    assert!(cable == 1 && (came_in - out.came_in).abs() < 1e-3, "{came_in} {out:?}");
    let back = jog(&mut bench, 1, In, 20.0);
    assert!(back.cause == Some(Cause::Taut) && (back.came_in + out.came_in).abs() < 1e-3, "{back:?} {out:?}");
    assert_eq!(bench.rig.support(), Support::Stand);
}

/// A torque that falls to nothing at this speed in a straight line swung a free winch, which is light, between full torque either way.
#[test]
fn a_jogged_cable_is_no_faster_than_twice_the_speed_at_any_rate_with_and_without_friction() {
    // A link that may be slow and is not is no reason for more damping.
    for (rate, latency) in [(100, 26.0), (250, 5.0), (349, 5.0)] {
        for friction in [0.0, 0.2, 1.0] {
            for (direction, slack) in [(In, "cable 5 slack 120"), (Out, "cable 5 slack 1")] {
                let mut config = parse(&AKD.replacen("rate = 250.0", &format!("rate = {rate}"), 1)).unwrap();
                config.limits.latency = latency;
                let mut bench = homing(rig(config, friction), &[slack]);
                let jogged = jog(&mut bench, 4, direction, 4.0);
                let times = jogged.fastest / SPEED;
                println!("{rate} Hz, {friction} N of friction, {direction}: {times:.2} times, {jogged:?}");
                assert!(times < 2.0 && jogged.came_in.abs() > 0.06, "{jogged:?}");
                assert!(jogged.pull.iter().all(|pull| pull.abs() <= 3.0), "{jogged:?}");
            }
        }
    }
}

/// The delay takes from the damping as much as it may.
#[test]
fn over_a_link_as_slow_as_allowed_a_jogged_cable_is_still_bounded_in_speed() {
    for friction in [0.0, 0.2] {
        for direction in [In, Out] {
            let mut bench = homing(rig(config(), friction), &["cable 5 slack 120", "delay 8"]);
            let jogged = jog(&mut bench, 4, direction, 4.0);
            let times = jogged.fastest / SPEED;
            println!("{friction} N of friction, {direction}: {times:.2} times, {jogged:?}");
            assert!(times < 4.0 && jogged.came_in.abs() > 0.06, "{jogged:?} {:?}", bench.events);
        }
    }
}

#[test]
fn letting_go_of_a_jog_switches_its_motor_off_within_a_cycle() {
    for direction in [In, Out] {
        for command in [
            Some(OperatorCommand::Release),
            Some(OperatorCommand::Lower),
            Some(OperatorCommand::Reset),
            Some(OperatorCommand::Shutdown),
            Some(OperatorCommand::Jog(2, direction)),
            None,
        ] {
            let mut bench = at_homing(&["cable 4 slack 100"]);
            jog(&mut bench, 3, direction, 1.0);
            assert_eq!(bench.bridge.state(), State::Jogging, "{:?}", bench.events);
            match command {
                Some(command) => _ = bench.bridge.operator(command, bench.now),
                // Not given again.
                None => _ = bench.run(0.5),
            }
            let report = bench.cycle();
            assert_eq!(report.target_torque, [0; 6], "{command:?}");
            let is_off = |drive: &SimulatedDrive| drive.state() == DriveState::SwitchOnDisabled;
            assert!(bench.rig.drives.iter().all(is_off), "{command:?}");
            assert_eq!(said(&bench).0, 3, "{command:?}");
        }
    }
}

#[test]
fn what_fails_while_a_cable_is_jogged_switches_its_motor_off() {
    for (words, cycles) in [
        ("drive 4 emcy 0x2310", 2),
        ("drive 4 fault", 3),
        ("drive 4 blocked", 3),
        ("drive 4 silent", 8),
        ("drive 4 dead", 8),
        ("drive 4 ignores-torque", 8),
        ("drive 4 limited", 8),
        ("drive 4 mode 8", 8),
        ("cut", 30),
    ] {
        let mut bench = at_homing(&["cable 4 slack 0"]);
        jog(&mut bench, 3, In, 1.5);
        assert_eq!(bench.bridge.state(), State::Jogging, "{words}: {:?}", bench.events);
        bench.suffer(words).unwrap();
        let mut left = 0;
        while bench.bridge.state() == State::Jogging && left < 100 {
            bench.bridge.operator(OperatorCommand::Jog(3, In), bench.now).unwrap();
            left += 1;
            bench.cycle();
        }
        println!("{words}: {left} cycles, {:?}", bench.bridge.fault);
        assert!(bench.bridge.state() == State::Fault && left <= cycles, "{words}: {left} {:?}", bench.events);
        assert_eq!(bench.cycle().target_torque, [0; 6], "{words}");
        assert_eq!(said(&bench).0, 3);
    }
}

#[test]
fn a_jog_over_a_slow_link_is_refused_before_any_torque() {
    let mut bench = at_homing(&["cable 4 slack 50", "delay 15"]);
    let jogged = jog(&mut bench, 3, In, 2.0);
    assert!(matches!(bench.bridge.fault, Some(Fault::SlowReaction { node: 4, .. })), "{:?}", bench.events);
    assert_eq!((jogged.pull, jogged.came_in), ([0.0; 2], 0.0));
}

#[test]
fn a_cable_whose_encoder_counts_backwards_is_not_jogged_on() {
    for direction in [In, Out] {
        let mut bench = at_homing(&["cable 2 slack 50", "drive 2 counts-backwards"]);
        let jogged = jog(&mut bench, 1, direction, 5.0);
        println!("{direction}: {jogged:?}");
        assert_eq!(jogged.cause, Some(Cause::WrongWay), "{:?}", bench.events);
        assert!(jogged.came_in.abs() < 0.005 && bench.bridge.state() == State::Homing, "{jogged:?}");
    }
}

#[test]
fn in_a_survey_nothing_is_jogged_whose_direction_no_pull_has_shown() {
    let mut bench =
        homing(bench().surveying(), &["cable 1 slack 20", "cable 2 slack 20", "drive 2 counts-backwards"]);
    let refused = |bench: &mut Bench, cable| {
        bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
        let refused = bench.bridge.operator(OperatorCommand::Jog(cable, Out), bench.now);
        refused == Err(Refusal::DirectionUnknown { cable: cable + 1 })
    };
    assert!(refused(&mut bench, 0) && refused(&mut bench, 1));
    for cable in [0, 1] {
        bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
        while bench.bridge.operator(OperatorCommand::Pull(cable), bench.now).is_ok() {
            bench.cycle();
        }
    }
    assert!(refused(&mut bench, 1) && refused(&mut bench, 2), "{:?}", bench.events);
    // Known still when everything was set up anew.
    bench.bridge.operator(OperatorCommand::Reset, bench.now).unwrap();
    let mut bench = homing(bench, &[]);
    assert!(jog(&mut bench, 0, Out, 1.0).came_in < -0.005, "{:?}", bench.events);
}

#[test]
fn a_jog_is_refused_where_drives_are_on() {
    let mut bench = bench();
    assert!(bench.start(), "{:?}", bench.events);
    let refused = bench.bridge.operator(OperatorCommand::Jog(0, Out), bench.now);
    assert!(matches!(refused, Err(Refusal::State { state: State::Enabled, .. })), "{refused:?}");
    let mut bench = at_homing(&[]);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    let refused = bench.bridge.operator(OperatorCommand::Jog(0, Out), bench.now);
    assert!(matches!(refused, Err(Refusal::State { state: State::Ready, .. })), "{refused:?}");
}

/// Drives that share its frame are led up with it, and get no torque.
#[test]
fn a_cable_whose_drive_shares_its_frame_is_jogged_alone() {
    let config = parse(&on_two_buses()).unwrap();
    let mut bench = homing(rig(config, 0.2), &["cable 2 slack 60", "cable 3 slack 60"]);
    let jogged = jog(&mut bench, 1, In, 20.0);
    assert!(jogged.cause == Some(Cause::Taut) && jogged.others == 0.0, "{jogged:?} {:?}", bench.events);
    assert!((bench.rig.paid_out()[2] - bench.rig.plant().cable_length[2] - 0.06).abs() < 1e-9);
}
