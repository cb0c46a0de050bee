//! Trials of a survey: one motor pulls, the drives lose the bridge.

use super::*;

/// In Homing, each cable with 20 mm of slack.
fn survey(mishaps: &[&str]) -> Bench {
    let mut bench = bench().surveying();
    (1..=6).for_each(|cable| bench.suffer(&format!("cable {cable} slack 20")).unwrap());
    mishaps.iter().for_each(|mishap| bench.suffer(mishap).unwrap());
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    bench
}

/// Holds the button for as long as it does something. What came of it, and the greatest pull of each motor.
fn pull(bench: &mut Bench, cable: usize) -> (Option<(f64, PerCable<f64>)>, PerCable<f64>) {
    let mut most = PerCable::<f64>::filled(6, 0.0);
    while bench.bridge.operator(OperatorCommand::Pull(cable), bench.now).is_ok() {
        bench.cycle();
        most = PerCable::from_fn(6, |i| most[i].max(bench.rig.drives[i].tension().abs()));
    }
    let pulled = bench.events.iter().rev().find_map(|(_, event)| match event {
        Event::Pulled { cable: of, tension, came_in } if *of == cable => Some((*tension, *came_in)),
        _ => None,
    });
    (pulled, most)
}

#[test]
fn a_motor_pulls_its_own_cable_in_by_some_millimetres_and_stops() {
    let mut bench = survey(&[]);
    for cable in 0..6 {
        let (pulled, most) = pull(&mut bench, cable);
        let (tension, came_in) = pulled.unwrap();
        println!("cable {}: {tension:.2} N, {:.1} mm", cable + 1, 1e3 * came_in[cable]);
        assert!(came_in[cable] > 0.005 && came_in[cable] < 0.015, "{came_in:?}");
        assert!(
            (0..6).all(|i| i == cable || came_in[i].abs() < 1e-5 && most[i] == 0.0),
            "{came_in:?} {most:?}"
        );
        assert!(most[cable] <= bench.bridge.config().slack.pretension, "{most:?}");
        assert_eq!(bench.bridge.state(), State::Homing);
        // It is still pressed, and nothing moves.
        let refused = bench.bridge.operator(OperatorCommand::Pull(cable), bench.now);
        assert_eq!(refused, Err(Refusal::StillPressed));
        bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
        bench.run(0.5);
    }
}

#[test]
fn an_encoder_that_counts_backwards_and_exchanged_encoders_show_in_a_pull() {
    let mut bench = survey(&["drive 2 counts-backwards"]);
    let (pulled, _) = pull(&mut bench, 1);
    assert!(pulled.unwrap().1[1] < -0.005, "{pulled:?}");
}

#[test]
fn a_pull_ends_when_the_button_is_let_go_or_not_given_again() {
    for release in [true, false] {
        let mut bench = survey(&["cable 3 slack 0"]);
        bench.bridge.operator(OperatorCommand::Pull(2), bench.now).unwrap();
        bench.run(0.2);
        assert_eq!(bench.bridge.state(), State::Trying);
        if release {
            bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
            bench.run(0.02);
        } else {
            bench.run(0.5);
        }
        assert_eq!(bench.bridge.state(), State::Homing);
        assert_eq!(bench.rig.drives[2].tension(), 0.0);
    }
}

/// The drive was led up again and again, and the pull ended as one that moves nothing.
#[test]
fn a_drive_that_fails_while_it_pulls_is_a_fault() {
    for words in ["drive 3 fault", "drive 3 emcy 0x2310", "drive 3 blocked", "drive 3 ignores-torque"] {
        let mut bench = survey(&["cable 3 slack 0"]);
        bench.bridge.operator(OperatorCommand::Pull(2), bench.now).unwrap();
        bench.run(0.15);
        bench.suffer(words).unwrap();
        bench.run(0.1);
        assert_eq!(bench.bridge.state(), State::Fault, "{words}: {:?}", bench.events);
        assert_eq!(bench.rig.drives[2].tension(), 0.0, "{words}");
    }
}

#[test]
fn a_pull_and_the_watchdogs_trial_are_refused_outside_of_a_survey() {
    let mut bench = bench();
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    for command in [
        OperatorCommand::Pull(0),
        OperatorCommand::TryWatchdog,
        OperatorCommand::Placed(Pose::at(0.0, 0.0, 1.0)),
    ] {
        let refused = bench.bridge.operator(command, bench.now);
        assert!(matches!(refused, Err(Refusal::State { .. })), "{refused:?}");
    }
}

#[test]
fn load_cells_of_slack_cables_are_read_in_the_mean() {
    let mut bench = survey(&["cell 5 says 0.7"]);
    bench.bridge.operator(OperatorCommand::Zero, bench.now).unwrap();
    assert_eq!(bench.bridge.state(), State::Trying);
    assert!(bench.run_until(State::Homing, 2.0), "{:?}", bench.events);
    let zeroed = bench.events.iter().find_map(|(_, event)| match event {
        Event::Zeroed(reading) => Some(*reading),
        _ => None,
    });
    let expected = PerCable::from_fn(6, |i| if i == 4 { 0.7 } else { 0.0 });
    let off = |i: usize| (zeroed.unwrap()[i] - expected[i]).abs();
    assert!((0..6).all(|i| off(i) < 0.02), "{zeroed:?}");
}

#[test]
fn drives_that_stop_without_the_bridge_pass_and_are_set_up_anew() {
    let mut bench = survey(&[]);
    bench.bridge.operator(OperatorCommand::TryWatchdog, bench.now).unwrap();
    assert!(!bench.run_until(State::Fault, 2.0), "{:?}", bench.events);
    assert!(bench.events.iter().any(|(_, event)| *event == Event::WatchdogProved), "{:?}", bench.events);
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.5);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
}

#[test]
fn a_drive_that_goes_on_without_the_bridge_is_named() {
    let mut bench = survey(&["drive 4 ignores-watchdog"]);
    bench.bridge.operator(OperatorCommand::TryWatchdog, bench.now).unwrap();
    assert!(bench.run_until(State::Fault, 5.0), "{:?}", bench.events);
    let fault = bench.bridge.fault();
    assert!(matches!(fault, Some(Fault::WatchdogIgnored { node: 4, .. })), "{fault:?}");
    assert!(
        fault.unwrap().to_string().contains("(\"Operation enabled\", NMT Operational, no EMCY)"),
        "{fault:?}"
    );
    bench.run(0.1);
    assert!(bench.rig.drives.iter().all(|drive| drive.tension() == 0.0));
}

/// What was found of each drive, in words, and how the trial ended.
fn after_silence(mishaps: &[&str]) -> (PerCable<AfterSilence>, Bench) {
    let mut bench = survey(mishaps);
    bench.bridge.operator(OperatorCommand::TryWatchdog, bench.now).unwrap();
    while bench.bridge.state() == State::Trying {
        bench.cycle();
    }
    let found = bench.events.iter().find_map(|(_, event)| match event {
        Event::WatchdogTried(found) => Some(*found),
        _ => None,
    });
    (found.unwrap_or_else(|| panic!("{:?}", bench.events)), bench)
}

/// As CiA 301 has it a node leaves Operational when its master is missing, and some drives start again: that was a fault of the node,
/// and the drives were not judged.
#[test]
fn drives_that_leave_operational_stop_or_boot_anew_in_silence_are_judged_and_pass() {
    let mishaps = ["drive 2 leaves-operational", "drive 3 stops-itself", "drive 5 boots-anew"];
    let (found, mut bench) = after_silence(&mishaps);
    let heartbeat = "EMCY 0x8130 (life guard or heartbeat error), error register 0x01";
    let expected = [
        format!("\"Fault\", NMT Operational, {heartbeat}"),
        format!("\"Fault\", NMT Pre-operational, {heartbeat}"),
        format!("\"Fault\", NMT Stopped, {heartbeat}"),
        format!("\"Fault\", NMT Operational, {heartbeat}"),
        "\"Switch on disabled\", NMT Initialisation, no EMCY".to_owned(),
        format!("\"Fault\", NMT Operational, {heartbeat}"),
    ];
    let found: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found, expected);
    assert!(bench.events.iter().any(|(_, event)| *event == Event::WatchdogProved), "{:?}", bench.events);
    assert_eq!(bench.bridge.fault(), None);
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.5);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
}

#[test]
fn a_drive_that_leaves_operational_and_pulls_on_is_named_with_its_nmt_state() {
    let (_, bench) = after_silence(&["drive 4 leaves-operational", "drive 4 ignores-watchdog"]);
    let text = bench.bridge.fault().unwrap().to_string();
    assert!(text.contains("drive 4 goes on"), "{text}");
    assert!(text.contains("(\"Operation enabled\", NMT Pre-operational, no EMCY)"), "{text}");
}

/// As if the bridge had been killed: not a frame.
#[test]
fn nothing_at_all_is_sent_while_the_watchdogs_are_tried() {
    let mut bench = survey(&[]);
    bench.bridge.operator(OperatorCommand::TryWatchdog, bench.now).unwrap();
    let watchdog = bench.bridge.config().heartbeat.drive_watchdog;
    let (mut quiet, mut longest) = (0, 0);
    for _ in 0..500 {
        bench.cycle();
        quiet = if bench.sent().is_empty() { quiet + bench.bridge.config().period } else { 0 };
        longest = longest.max(quiet);
    }
    assert!(longest >= 2 * watchdog, "{longest}");
}

#[test]
fn a_drive_that_was_exchanged_after_commissioning_is_found_before_any_torque() {
    let identities = survey(&[]).bridge.identities();
    assert_eq!(identities[2], [Some(0), Some(402), Some(1), Some(1003)]);
    for exchanged in [false, true] {
        let mut expected = identities;
        if exchanged {
            expected[2][3] = Some(77);
        }
        let mut bench = bench();
        bench.bridge = Bridge::new(bench.bridge.config().clone()).expecting(expected);
        let state = if exchanged { State::Fault } else { State::Homing };
        assert!(bench.run_until(state, 20.0), "{:?}", bench.events);
        assert_eq!(bench.bridge.fault(), exchanged.then_some(Fault::AnotherDrive { node: 3 }));
    }
}

/// In Ready, with a platform that weighs this share of what is believed.
fn ready(belief: Config, share: f64) -> Bench {
    let mut truth = belief.clone();
    truth.rig.mass *= share;
    let imperfections = PlantParameters {
        friction: 0.2,
        load_cell_noise: 0.05,
        motor_lag: 2e-3,
        ..PlantParameters::default()
    };
    let mut bench = Bench::believing(truth, belief, imperfections).unwrap().surveying();
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    bench
}

/// Holds the button until it does nothing any more. The highest and the most tilted that the platform was.
fn weigh(bench: &mut Bench) -> (Option<Event>, f64, f64) {
    let (mut highest, mut tilt) = (0f64, 0f64);
    while bench.bridge.operator(OperatorCommand::Weigh, bench.now).is_ok() {
        bench.cycle();
        let pose = bench.rig.plant().encoder_pose;
        let rise = bench.bridge.config().home.0[2] - pose.0[2];
        (highest, tilt) = (highest.max(rise.abs()), tilt.max(pose.angles().amax()));
    }
    let is_weight = |event: &Event| matches!(event, Event::Weighed { .. } | Event::NotLifted);
    (bench.events.iter().map(|(_, event)| *event).rfind(is_weight), highest, tilt)
}

#[test]
fn a_platform_is_weighed_within_two_centimetres_of_its_stand() {
    for belief in [parse(AKD).unwrap(), crate::config::tests::eight()] {
        for share in [0.67, 0.92, 1.0, 1.08, 1.33] {
            let mass = share * belief.rig.mass;
            let mut bench = ready(belief.clone(), share);
            let (event, highest, tilt) = weigh(&mut bench);
            println!("{mass:.2} kg: {event:?}, at most {:.1} mm up, {tilt:.4} rad", 1e3 * highest);
            assert_eq!(bench.bridge.fault(), None, "{:?}", bench.events);
            let Some(Event::Weighed { mass: weighed, .. }) = event else { panic!("{mass}: {event:?}") };
            assert!((weighed - mass).abs() < 0.02 * mass, "{mass}: {weighed}");
            assert!(highest < 0.02 && tilt < 0.05, "{mass}: {highest} {tilt}");
            assert_eq!(bench.bridge.state(), State::Ready);
            assert_eq!(bench.rig.support(), crate::simulated::Support::Stand);
        }
    }
}

/// Placed some millimetres and a degree off what was said: heights count from where it stands.
#[test]
fn a_platform_is_weighed_on_blocks_where_it_was_placed_too() {
    for belief in [parse(AKD).unwrap(), crate::config::tests::eight()] {
        let mass = belief.rig.mass;
        let mut bench = ready(belief, 1.0);
        let mut pose = bench.bridge.config().home;
        (pose.0[0], pose.0[1], pose.0[2]) = (0.08, -0.05, pose.0[2] - 0.1);
        let put = [pose.0[0] + 0.003, pose.0[1] - 0.002, pose.0[2] + 0.003, 0.0, 0.01, -0.01];
        bench.suffer(&put.iter().fold("place".to_owned(), |text, x| text + &format!(" {x}"))).unwrap();
        bench.run(15.0);
        let refused = bench.bridge.operator(OperatorCommand::Weigh, bench.now);
        assert!(matches!(refused, Err(Refusal::NotAtHome { .. })), "{refused:?}");
        bench.bridge.operator(OperatorCommand::Placed(pose), bench.now).unwrap();
        let (event, ..) = weigh(&mut bench);
        assert_eq!(bench.bridge.fault(), None, "{:?}", bench.events);
        let Some(Event::Weighed { mass: weighed, rise, pose: at, .. }) = event else { panic!("{event:?}") };
        println!(
            "{weighed:.3} of {mass} kg, {:.1} mm above the blocks, at {:.3?}",
            1e3 * rise,
            at.0.as_slice()
        );
        assert!((weighed - mass).abs() < 0.02 * mass && (0.0..0.02).contains(&rise), "{weighed} {rise}");
        assert_eq!(bench.rig.support(), crate::simulated::Support::Stand);
    }
}

#[test]
fn a_platform_that_is_too_heavy_or_held_is_not_lifted() {
    let mut bench = ready(parse(AKD).unwrap(), 2.0);
    let (event, highest, _) = weigh(&mut bench);
    assert_eq!((event, highest), (Some(Event::NotLifted), 0.0), "{:?}", bench.events);
}

#[test]
fn a_lift_ends_when_it_is_let_go_and_is_refused_away_from_home() {
    let mut bench = ready(parse(AKD).unwrap(), 1.0);
    for _ in 0..1200 {
        bench.bridge.operator(OperatorCommand::Weigh, bench.now).unwrap();
        bench.cycle();
    }
    assert!(bench.rig.plant().encoder_pose.0[2] < 0.999, "it hangs");
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    assert!(bench.run_until(State::Ready, 5.0), "{:?}", bench.events);
    assert!(!bench.events.iter().any(|(_, event)| matches!(event, Event::Weighed { .. })));
    bench.suffer("place 0.1 0 1 0 0 0").unwrap();
    bench.run(5.0);
    let refused = bench.bridge.operator(OperatorCommand::Weigh, bench.now);
    assert!(matches!(refused, Err(Refusal::NotAtHome { .. })), "{refused:?}");
}
