//! What an operator does, and what is pulled then.

use super::*;
use crate::config::Safe;
use crate::simulated::Support;

#[test]
fn letting_go_and_not_pressing_again_in_time_ramp_to_the_safe_output() {
    let mut released = moving(bench(), 0.4);
    released.is_pressed = false;
    released.bridge.operator(OperatorCommand::Release, released.now).unwrap();
    assert_eq!(released.cycle().state, State::Stopping);
    assert!(released.run_until(State::Safe, 0.31));
    released.is_pressed = true;
    assert!(released.run_until(State::Enabled, 0.1), "enabled anew");

    let mut forgotten = moving(bench(), 0.4);
    forgotten.is_pressed = false;
    forgotten.run(0.49);
    assert_eq!(forgotten.bridge.state(), State::Enabled);
    forgotten.run(0.02);
    assert_eq!(forgotten.bridge.state(), State::Stopping);
    forgotten.is_pressed = true;
    forgotten.run(1.0);
    assert_eq!(forgotten.bridge.state(), State::Safe, "a command that was late does not enable by itself");
    forgotten.bridge.operator(OperatorCommand::Release, forgotten.now).unwrap();
    assert!(forgotten.run_until(State::Enabled, 0.1));
}

#[test]
fn shutting_down_goes_through_the_safe_output_and_the_stand_to_drives_that_are_off() {
    let mut bench = moving(bench(), 0.4);
    bench.bridge.operator(OperatorCommand::Shutdown, bench.now).unwrap();
    assert_eq!(bench.cycle().state, State::Stopping);
    assert!(bench.run_until(State::Lowering, 0.31));
    assert!(bench.run_until(State::Off, 20.0));
    assert_eq!(bench.rig.support(), Support::Stand);
    bench.run(0.02);
    assert!(bench.bridge.is_off());
    assert!(bench.rig.drives.iter().all(|drive| drive.state() == DriveState::SwitchOnDisabled));
}

#[test]
fn each_safe_output_is_what_it_says() {
    let stopped = |output| {
        let mut config = config();
        config.safe = Safe { output, stiffness: 0.0, damping: 0.0, ..config.safe };
        let mut bench = moving(with_noise(config), 0.4);
        let before = bench.cycle().tension;
        bench.inject(0, Frame::new(FrameKind::Error, error_class::BUS_OFF, &[0; 8]).unwrap());
        let first = bench.cycle();
        assert_eq!(first.state, State::Stopping);
        bench.run(0.5);
        (before, first.tension, bench.cycle(), bench)
    };
    let (before, first, last, _) = stopped(SafeOutput::Hold);
    assert_eq!((first, last.tension), (before, before));
    let (before, first, last, bench) = stopped(SafeOutput::GravityRamp);
    assert_eq!(first, before, "the ramp begins where the controller left");
    assert_ne!(last.tension, before);
    assert_eq!(bench.rig.support(), Support::Cables);
    let (_, first, last, bench) = stopped(SafeOutput::TorqueOff);
    assert!(
        [first, last.tension].iter().flatten().all(|tension| *tension == 0.0),
        "{first:?} {:?}",
        last.tension
    );
    assert!(bench.rig.drives.iter().all(|drive| drive.state() == DriveState::SwitchOnDisabled));
}

#[test]
fn winches_that_resist_keep_the_platform_level_where_constant_tensions_turn_it_over() {
    let turned_after_release = |is_stiff: bool| {
        let mut config = config();
        config.limits.tilt = 1.4;
        if !is_stiff {
            config.safe = Safe { stiffness: 0.0, damping: 0.0, ..config.safe };
        }
        let mut bench = moving(with_noise(config), 12.0);
        bench.is_pressed = false;
        bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
        bench.run(4.0);
        bench.rig.plant().encoder_pose.angles().amax()
    };
    let (stiff, loose) = (turned_after_release(true), turned_after_release(false));
    println!("turned by {stiff:.4} rad with winches that resist, {loose:.2} rad with constant tensions");
    assert!(stiff < 0.03 && loose > 0.3, "{stiff} {loose}");
}

#[test]
fn an_enable_that_was_held_all_along_does_not_lift_the_platform() {
    let mut bench = bench();
    assert!(bench.run_until(State::Homing, 20.0));
    bench.run(0.1);
    bench.is_pressed = true;
    bench.run(0.1);
    assert!(bench.take_up_slack());
    bench.run(1.0);
    assert_eq!(bench.bridge.state(), State::Ready);
    assert_eq!(bench.bridge.operator(OperatorCommand::Enable, bench.now), Err(Refusal::StillPressed));
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(1.0);
    assert_eq!((bench.bridge.state(), bench.rig.motor_tension()), (State::Homing, PerCable::filled(6, 0.0)));
}

/// The platform falls; what its encoders say then is no fault.
#[test]
fn a_release_to_torque_off_stays_a_release_while_the_platform_falls() {
    let mut bench = moving(with_safe_output(SafeOutput::TorqueOff), 0.4);
    bench.is_pressed = false;
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(2.0);
    assert_eq!((bench.bridge.state(), bench.bridge.fault), (State::Safe, None));
    assert_eq!(bench.rig.support(), Support::Floor);
}

/// It falls on the floor and stops there within a cycle.
#[test]
fn after_a_reset_of_a_hanging_platform_the_encoders_are_believed_again() {
    let mut bench = moving(bench(), 0.4);
    bench.is_pressed = false;
    bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
    bench.run(1.0);
    bench.bridge.operator(OperatorCommand::Reset, bench.now).unwrap();
    assert!(bench.run_until(State::Homing, 25.0), "{:?}", bench.events.last());
    // As an encoder sees a fall that ends.
    let winch = bench.bridge.config.drives[2].winch;
    for k in 0..200 {
        bench.rig.drives[2].faults.encoder_error = winch.counts(0.004 * f64::from(k.min(20)), 0);
        bench.cycle();
    }
    bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap();
    assert_eq!(bench.bridge.state(), State::TakingUpSlack);
}
