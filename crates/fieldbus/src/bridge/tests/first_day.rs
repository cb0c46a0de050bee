//! The first day at a rig: what is not as the files say, and what drives do that only they know of.

use super::*;
use crate::simulated::Support;

/// A rig as the example says but for one text, before a bridge that goes by the example.
fn rig_with(from: &str, to: &str) -> Bench {
    assert!(AKD.contains(from), "{from}");
    let truth = parse(&AKD.replacen(from, to, 1)).unwrap();
    let imperfections = PlantParameters {
        friction: 0.2,
        motor_lag: 2e-3,
        load_cell_noise: 0.05,
        ..PlantParameters::default()
    };
    Bench::believing(truth, config(), imperfections).unwrap()
}

fn as_said() -> Bench {
    rig_with("gear", "gear")
}

/// Until the bridge waits for the operator to say that the platform stands at home.
fn at_homing(mut bench: Bench) -> Bench {
    assert!(bench.run_until(State::Homing, 20.0), "{:?}", bench.events);
    bench.run(0.1);
    bench
}

#[test]
fn a_cable_with_12_mm_of_slack_is_taken_up_and_no_encoder_called_frozen() {
    for (slack, most) in [(0.0, 0.05), (7.0, 0.05), (12.0, 0.05), (49.0, 0.05), (100.0, 0.11)] {
        for cable in [1, 4] {
            let mut belief = config();
            belief.slack.most = most;
            let mut bench = Bench::believing(config(), belief, PlantParameters::default()).unwrap();
            bench.suffer(&format!("cable {cable} slack {slack}")).unwrap();
            assert!(bench.start(), "{slack} mm in cable {cable}: {:?}", bench.events);
            bench.run(1.0);
            assert_eq!((bench.bridge.state(), bench.bridge.fault), (State::Enabled, None));
            let away = (bench.bridge.pose.position() - bench.rig.plant().encoder_pose.position()).norm();
            assert!(away < 1e-4, "{slack} mm in cable {cable}: the pose is wrong by {away} m");
        }
    }
}

#[test]
fn more_slack_than_allowed_is_said_of_the_cable_that_has_it() {
    let mut bench = as_said();
    bench.suffer("cable 4 slack 60").unwrap();
    assert!(!bench.start());
    assert!(matches!(bench.bridge.fault, Some(Fault::LooseCable { cable: 4, .. })), "{:?}", bench.events);
}

/// Cycles until the controller's tensions end, 0.4 s into the move, and why.
fn ended(words: &str) -> (u32, Fault, Bench) {
    let mut bench = moving(as_said(), 0.4);
    bench.suffer(words).unwrap();
    let mut cycles = 0;
    while bench.bridge.state() == State::Enabled {
        bench.cycle();
        cycles += 1;
        assert!(cycles < 1000, "{words}: nothing happened");
    }
    (cycles, bench.bridge.fault.unwrap(), bench)
}

#[test]
fn a_torque_frame_that_is_lost_one_way_ends_in_a_fault_of_its_drive() {
    let (cycles, fault, _) = ended("lose 0x203");
    println!("{cycles} cycles: {fault}");
    let is_of_three = |fault: &Fault| {
        matches!(
            fault,
            Fault::TorqueNotFollowed { cable: 3, .. }
                | Fault::Emergency(Emergency { node: 3, code: 0x8250, .. })
        )
    };
    assert!(is_of_three(&fault), "{fault}");
    assert!(cycles <= 100 / 4 + 2, "{cycles} cycles");
}

/// A drive that knows no deadline for its frames: then only what it pulls tells.
#[test]
fn without_a_deadline_a_lost_torque_frame_is_found_once_the_command_has_moved_on() {
    let mut bench = as_said();
    bench.suffer("drive 3 refuses 0x1400:5 0x06090011").unwrap();
    let mut bench = moving(bench, 0.4);
    bench.suffer("lose 0x203").unwrap();
    let told = bench.cycle().tension[2];
    let (mut away, mut reports) = (None, 0);
    while bench.bridge.state() == State::Enabled && reports < 500 {
        let now = bench.cycle().tension[2];
        reports += 1;
        away = away.or(((now - told).abs() > bench.bridge.config.limits.torque_error).then_some(reports));
    }
    let fault = bench.bridge.fault;
    let late = reports - away.unwrap();
    println!("{reports} cycles, {late} of them with another command: {fault:?}");
    assert!(late <= 4 + 3, "{late} cycles");
    assert!(matches!(fault, Some(Fault::TorqueNotFollowed { cable: 3, .. })), "{fault:?}");
}

#[test]
fn a_drive_that_leaves_its_mode_while_enabled_is_a_fault() {
    let (cycles, fault, mut bench) = ended("drive 2 mode 8");
    println!("{cycles} cycles: {fault}");
    assert!(matches!(fault, Fault::TorqueNotFollowed { cable: 2, .. } | Fault::ModeLeft { node: 2, .. }));
    assert!(cycles <= 4 + 2, "{cycles} cycles");
    bench.run(0.2);
    let left = |(_, event): &(u64, Event)| *event == Event::Fault(Fault::ModeLeft { node: 2, found: 8 });
    assert!(bench.events.iter().any(left), "{:?}", bench.events);
}

#[test]
fn a_drive_that_says_that_it_does_not_obey_is_a_fault() {
    for (words, bit) in
        [("drive 5 ignores-torque", 1 << 12), ("drive 5 limited", 1 << 11), ("drive 5 local", 1 << 9)]
    {
        let (cycles, fault, bench) = ended(words);
        println!("{words}, {cycles} cycles: {fault}");
        let is_of_five = |fault: &Fault| {
            matches!(fault, Fault::TorqueNotFollowed { cable: 5, .. } | Fault::DriveDisobeys { node: 5, .. })
        };
        assert!(is_of_five(&fault) && cycles <= 4 + 2, "{words}: {cycles} cycles, {fault}");
        let mut bench = bench;
        bench.run(0.1);
        let said =
            |(_, event): &(u64, Event)| *event == Event::Fault(Fault::DriveDisobeys { node: 5, bits: bit });
        assert!(bench.events.iter().any(said), "{words}: {:?}", bench.events);
    }
}

#[test]
fn a_load_cell_that_shows_a_load_with_motors_off_is_refused_before_torque() {
    let mut bench = as_said();
    bench.suffer("cell 4 says 40").unwrap();
    let mut bench = at_homing(bench);
    let refusal = bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap_err().to_string();
    assert_eq!(refusal, "not yet: load cell 4 says 40.00 N while its motor pulls 0.00 N");
    assert_eq!(bench.bridge.state(), State::Homing);
}

#[test]
fn a_gear_of_five_for_one_is_found_while_slack_is_taken_up_with_the_platform_on_its_stand() {
    let mut bench = rig_with("node = 3\ngear = 1.0", "node = 3\ngear = 5.0");
    assert!(!bench.start());
    let most = bench.rig.plant().measured_tension;
    println!("{:?}, {most:.1?} N", bench.bridge.fault);
    assert!(matches!(bench.bridge.fault, Some(Fault::LoadCellDisagrees { cable: 3, .. })));
    assert_eq!(bench.rig.support(), Support::Stand);
    let fault = bench.events.iter().find(|(_, event)| matches!(event, Event::Fault(_))).unwrap().0;
    let begun = bench.events.iter().find(|(_, e)| *e == Event::Entered(State::TakingUpSlack)).unwrap().0;
    assert!(fault - begun < 1_000_000_000, "in the first half of the ramp");
}

#[test]
fn letting_go_of_home_stops_the_motors_in_taking_up_slack_and_in_ready() {
    let is_off =
        |bench: &Bench| bench.rig.drives.iter().all(|drive| drive.state() == DriveState::SwitchOnDisabled);
    for (command, state) in
        [(OperatorCommand::Release, State::Homing), (OperatorCommand::Reset, State::Configuring)]
    {
        for until_ready in [false, true] {
            let mut bench = at_homing(as_said());
            bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap();
            if until_ready {
                assert!(bench.take_up_slack());
            } else {
                bench.run(0.4);
            }
            bench.run(0.05);
            assert!(
                bench.rig.motor_tension().iter().all(|tension| *tension > 0.0),
                "{command:?} {until_ready}"
            );
            bench.bridge.operator(command, bench.now).unwrap();
            assert_eq!(bench.bridge.state(), state);
            bench.run(0.02);
            assert!(is_off(&bench), "{command:?} {until_ready}");
        }
    }
}

#[test]
fn home_that_is_not_given_again_stops_the_motors_and_one_that_comes_late_starts_nothing() {
    let mut bench = at_homing(as_said());
    bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap();
    bench.run(0.49);
    assert_eq!(bench.bridge.state(), State::TakingUpSlack);
    bench.run(0.02);
    assert_eq!(bench.bridge.state(), State::Homing);
    assert!(bench.events.iter().any(|(_, event)| *event == Event::LetGo(Cause::EnableExpired)));
    bench.run(0.02);
    assert_eq!(bench.rig.motor_tension(), PerCable::filled(6, 0.0));
    assert_eq!(bench.bridge.operator(OperatorCommand::Home, bench.now), Err(Refusal::StillPressed));
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(0.1);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
}

/// The operator holds home for as long as it is taken. All torques that were commanded meanwhile, and the fault if there was one.
fn hold_home(bench: &mut Bench) -> (Vec<PerCable<i16>>, Option<Fault>) {
    let mut torques = vec![];
    while bench.bridge.operator(OperatorCommand::Home, bench.now).is_ok()
        && bench.bridge.state() == State::TakingUpSlack
    {
        torques.push(bench.cycle().target_torque);
    }
    (torques, bench.bridge.fault)
}

fn is_slow(fault: Option<Fault>) -> bool {
    matches!(fault, Some(Fault::SlowReaction { node: 1, most: 20_000_000, .. }))
}

#[test]
fn a_link_with_a_constant_delay_is_refused_before_any_torque() {
    for (each_way, is_late) in [(0, false), (4, false), (15, true), (30, true), (50, true)] {
        let mut bench = as_said();
        bench.suffer(&format!("delay {each_way}")).unwrap();
        let mut bench = at_homing(bench);
        let (torques, fault) = hold_home(&mut bench);
        println!("{each_way} ms each way: {fault:?}");
        if is_late {
            assert!(is_slow(fault), "{:?}", bench.events);
            let text = fault.unwrap().to_string();
            let there_and_back = 4 * (2 * each_way as u64).div_ceil(4);
            let said = format!("drive 1 shows what a control word does {there_and_back}.0 ms after it");
            assert!(text.starts_with(&said) && text.contains("at most 20.0 ms"), "{text}");
            assert!(torques.iter().all(|torques| torques.iter().all(|torque| *torque == 0)));
        } else {
            assert_eq!((bench.bridge.state(), fault), (State::Ready, None), "{:?}", bench.events);
        }
    }
}

#[test]
fn a_link_that_became_slow_is_refused_when_drives_are_led_up_again() {
    let mut bench = at_homing(as_said());
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(1.0);
    bench.suffer("delay 15").unwrap();
    bench.run(1.0);
    let (torques, fault) = hold_home(&mut bench);
    assert!(is_slow(fault), "{:?}", bench.events);
    assert!(torques.iter().all(|torques| torques.iter().all(|torque| *torque == 0)));
}

/// Of healthy drives only the quickest transition tells the age of what is on the wire.
#[test]
fn a_slow_power_stage_is_no_slow_link() {
    for words in ["drive 1 slow-stage 100", "drive 4 slow-stage 400"] {
        let mut bench = as_said();
        bench.suffer(words).unwrap();
        let mut bench = at_homing(bench);
        let (_, fault) = hold_home(&mut bench);
        assert_eq!((bench.bridge.state(), fault), (State::Ready, None), "{words}: {:?}", bench.events);
    }
}

#[test]
fn a_motor_that_follows_late_on_a_quick_link_is_refused_before_the_lift() {
    let imperfections = PlantParameters { motor_lag: 0.03, ..PlantParameters::default() };
    let mut bench = Bench::new(config(), imperfections).unwrap();
    assert!(!bench.start());
    assert!(matches!(bench.bridge.fault, Some(Fault::Late { .. })), "{:?}", bench.events);
    assert_eq!(bench.rig.support(), Support::Stand);
}

/// Of a rig whose platform weighs this: the fault if there was one, and how far the platform went from where it was led.
fn with_mass(mass: f64) -> (Option<Fault>, f64) {
    let mut truth = config();
    truth.rig.mass = mass;
    let imperfections = PlantParameters {
        friction: 0.2,
        motor_lag: 2e-3,
        load_cell_noise: 0.01,
        ..PlantParameters::default()
    };
    let mut bench = Bench::believing(truth, config(), imperfections).unwrap();
    assert!(bench.start(), "{mass} kg: {:?}", bench.events);
    bench.run(2.0);
    if bench.bridge.state() == State::Enabled {
        bench.go_to(0.1, 0.0, 1.0);
        bench.run(12.0);
    }
    let stopped = bench.events.iter().find_map(|(_, event)| match event {
        Event::Fault(fault) => Some(*fault),
        _ => None,
    });
    let away = match stopped {
        Some(Fault::OffCourse { distance, .. }) => distance,
        _ => 0.0,
    };
    println!("{mass} kg: {stopped:?}");
    (stopped, away)
}

#[test]
fn a_platform_that_weighs_something_else_is_off_course() {
    assert_eq!(with_mass(6.0).0, None);
    for mass in [4.0, 5.5, 8.0] {
        let (fault, away) = with_mass(mass);
        assert!(matches!(fault, Some(Fault::OffCourse { .. })), "{mass} kg: {fault:?}");
        // What is too heavy stays where it stands, 0.1 m from its goal.
        assert!(mass > 6.0 || away < 0.06, "{mass} kg: {away} m");
    }
}

#[test]
fn outside_of_the_box_no_goal_is_taken_and_no_platform_left() {
    let mut narrow = config();
    narrow.limits.space = [[-0.3, 0.05], [-0.3, 0.3], [0.5, 1.2]];
    let mut bench = Bench::believing(config(), narrow, PlantParameters::default()).unwrap();
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    let out = bench.bridge.operator(OperatorCommand::Goal(Pose::at(0.1, 0.0, 1.0)), bench.now);
    assert_eq!(out, Err(Refusal::OutOfBox { axis: 'x', at: 0.1 }));
    // The goal is taken, and then the box gets smaller.
    bench.go_to(0.04, 0.0, 1.0);
    bench.bridge.config.limits.space[0][1] = 0.02;
    bench.run(5.0);
    assert!(
        matches!(bench.bridge.fault, Some(Fault::OutOfBox { axis: 'x', .. })),
        "{:?}",
        bench.bridge.fault
    );
}

#[test]
fn an_encoder_of_1000_counts_a_turn_is_not_called_frozen_in_normal_motion() {
    for counts in [1000, 2000] {
        let text = AKD.replace("counts_per_turn = 65536.0", &format!("counts_per_turn = {counts}.0"));
        let config = parse(&text).unwrap();
        let mut bench = Bench::new(config, PlantParameters::default()).unwrap();
        assert!(bench.start(), "{:?}", bench.events);
        bench.run(1.0);
        bench.go_to(0.1, 0.1, 1.0);
        bench.run(10.0);
        let frozen = |(_, event): &(u64, Event)| matches!(event, Event::Fault(Fault::EncoderFrozen { .. }));
        assert!(!bench.events.iter().any(frozen), "{counts}: {:?}", bench.events);
        println!("{counts} counts: {:?}", bench.bridge.fault);
    }
}

#[test]
fn an_emergency_message_without_an_error_is_logged_and_no_fault() {
    let mut bench = moving(as_said(), 0.2);
    let warning = Emergency { node: 5, code: 0xFF01, register: 0, maker: [0; 5] };
    bench.inject(0, warning.frame());
    bench.run(0.1);
    assert_eq!((bench.bridge.state(), bench.bridge.fault), (State::Enabled, None));
    assert!(bench.events.iter().any(|(_, event)| *event == Event::Emergency(warning)));
}

#[test]
fn after_a_fault_the_pose_is_the_measured_one_or_none() {
    let (_, _, mut bench) = ended("drive 3 jumps 20000");
    assert_eq!(bench.cycle().measured_pose, None, "an encoder that jumped says nothing of the platform");
    let (_, _, mut bench) = ended("cell 4 says 100000");
    for _ in 0..250 {
        let report = bench.cycle();
        let (seen, is) = (report.measured_pose.unwrap(), bench.rig.plant().encoder_pose);
        assert!((seen.position() - is.position()).norm() < 2e-3, "{seen:?} {is:?}");
    }
}

/// It was reset again after a third of its time, and never ended; a second boot-up message was a fault; a mode that is shown when it counts, too.
#[test]
fn healthy_drives_that_boot_slowly_or_twice_or_show_their_mode_late_are_led_up() {
    for words in ["drive 2 boots-late 8000", "drive 3 boots-twice", "drive 4 hides-mode"] {
        let mut bench = as_said();
        bench.suffer(words).unwrap();
        assert!(bench.start(), "{words}: {:?}", bench.bridge.fault);
    }
}

#[test]
fn a_mode_that_is_never_shown_is_refused_before_any_torque() {
    let mut bench = as_said();
    bench.suffer("drive 4 refuses-mode").unwrap();
    assert!(bench.run_until(State::Homing, 20.0));
    bench.run(0.1);
    while bench.bridge.operator(OperatorCommand::Home, bench.now).is_ok() {
        assert!(bench.cycle().target_torque.iter().all(|torque| *torque == 0));
    }
    assert_eq!(bench.bridge.fault, Some(Fault::ModeRefused { node: 4, found: 0 }));
}
