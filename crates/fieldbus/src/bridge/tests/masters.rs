//! Two bridges on one bus, and what a start and a reset find there.

use super::*;
use crate::canopen::{NmtCommand, sync};

/// What a second bridge does that is started beside the bench's, and the bench's last report.
fn beside(mut bench: Bench, seconds: f64) -> (Bridge, usize, CycleReport) {
    let mut second = Bridge::new(config());
    let (mut out, mut controller) = (FrameQueue::new(), LibraryController::new(bench.parameters()));
    let mut sent = 0;
    for _ in 0..(seconds / 0.004) as usize {
        bench.cycle();
        for (bus, frame) in bench.heard().iter().chain(bench.sent()) {
            second.on_frame(*bus, frame, bench.now);
        }
        second.cycle(bench.now, &mut controller, &mut out);
        for (bus, frame) in out.frames() {
            bench.inject(*bus, *frame);
            sent += 1;
        }
    }
    let last = bench.cycle();
    (second, sent, last)
}

#[test]
fn a_second_bridge_does_not_reset_the_drives_of_a_hanging_platform() {
    let (second, sent, first) = beside(moving(bench(), 0.4), 2.0);
    assert_eq!((sent, first.state, first.fault), (0, State::Enabled, None));
    assert_eq!((second.state(), second.has_spoken()), (State::Fault, false));
    assert!(matches!(second.fault, Some(Fault::AnotherMaster { bus: 0, .. })), "{:?}", second.fault);
}

/// One that holds the platform after a fault, and one that waits without torque.
#[test]
fn a_second_bridge_sees_the_first_in_every_state() {
    let mut held = moving(bench(), 0.4);
    held.bridge.on_transport_error(0, TransportError::Down);
    held.run(1.0);
    assert_eq!(held.bridge.state(), State::Fault);
    let mut waiting = bench();
    assert!(waiting.run_until(State::Homing, 20.0));
    let mut failed = bench();
    failed.rig.cells[4].node.faults.is_dead = true;
    assert!(failed.run_until(State::Fault, 20.0));
    for (bench, state) in [(held, State::Fault), (waiting, State::Homing), (failed, State::Fault)] {
        let (second, sent, first) = beside(bench, 1.0);
        assert_eq!((second.state(), sent, first.state), (State::Fault, 0, state));
    }
}

#[test]
fn a_running_bridge_that_hears_another_goes_to_the_safe_output() {
    let own = NmtState::Operational.heartbeat(127);
    for frame in [sync(), own, Frame::data(0x203, [0x0F, 0, 10, 0])] {
        let mut bench = moving(bench(), 0.4);
        bench.bridge.on_frame(0, &frame, bench.now);
        assert_eq!(bench.cycle().state, State::Stopping);
        assert_eq!(bench.bridge.fault, Some(Fault::AnotherMaster { bus: 0, id: frame.id() }));
    }
}

/// A bridge that was killed leaves drives that pull until their watchdogs act; so does one that is reset.
#[test]
fn before_nodes_are_reset_the_drives_are_told_zero_torque_and_voltage_off() {
    let mut killed = moving(bench(), 0.4);
    killed.bridge = Bridge::new(config());
    let mut reset = moving(bench(), 0.4);
    reset.bridge.on_transport_error(0, TransportError::Down);
    reset.run(1.0);
    reset.bridge.operator(OperatorCommand::Reset, reset.now).unwrap();
    for (name, bench) in [("killed", &mut killed), ("reset", &mut reset)] {
        let (mut quiet, mut is_reset) = (0, false);
        while !is_reset {
            bench.cycle();
            let sent: Vec<_> = bench.sent().iter().map(|(_, frame)| *frame).collect();
            is_reset = sent.iter().any(|frame| NmtCommand::parse(frame).is_some());
            let zeros = (1..=6).all(|node| sent.contains(&Frame::data(0x200 + node, [0; 4])));
            quiet += u32::from(zeros && sent.contains(&sync()));
        }
        assert!(quiet >= 5, "{name}: {quiet}");
    }
}

/// Values that were lost are not made up from the last speed where nobody looks at them any more.
#[test]
fn a_drive_whose_encoder_is_silent_is_not_pulled_harder_and_harder() {
    let mut config = config();
    config.limits.lost_cycles = 100;
    let mut bench = moving(with_noise(config), 0.4);
    let speed = |i: &usize| bench.bridge.drives[*i].encoder.rate.abs();
    let i = (0..6).max_by(|i, j| speed(i).total_cmp(&speed(j))).unwrap();
    assert!(speed(&i) > 0.04, "it does not move");
    bench.inject(0, Frame::new(FrameKind::Error, error_class::BUS_OFF, &[0; 8]).unwrap());
    bench.rig.drives[i].faults.is_silent = true;
    let reports = bench.run(1.0);
    let Mode::Fault(Some(held)) = bench.bridge.mode else { panic!("{:?}", bench.bridge.mode) };
    for tension in reports[75..].iter().map(|report| report.tension) {
        assert!((tension[i] - held.tension[i]).abs() < 0.5, "{tension:?}, not {:?}", held.tension);
    }
}
