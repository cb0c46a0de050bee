//! Everything that can fail, and how soon it ends the controller's tensions.

use super::*;
use crate::canopen::NmtCommand;
use crate::cia402::MAX_TORQUE;
use crate::simulated::{CellFault, LinkFaults, Support};
use cable_robot::plan::ControllerInputs;
use cable_robot::sim::{ControllerModel, ModelError};

/// Injects a fault 0.4 s into the move. Returns the fault, in how many cycles the controller's tensions ended, and the bench
/// a second later, when the safe output must be there.
fn reaction(
    mut bench: Bench,
    inject: impl FnOnce(&mut Bench),
    mut every_cycle: impl FnMut(&mut Bench),
) -> (Fault, u32, Bench) {
    bench = moving(bench, 0.4);
    inject(&mut bench);
    let mut cycles = 0;
    while bench.bridge.state() == State::Enabled {
        every_cycle(&mut bench);
        bench.cycle();
        cycles += 1;
        assert!(cycles < 1000, "nothing happened");
    }
    for _ in 0..250 {
        every_cycle(&mut bench);
        bench.cycle();
    }
    let last = bench.cycle();
    assert_eq!(last.state, State::Fault);
    (last.fault.unwrap(), cycles, bench)
}

fn nothing(_: &mut Bench) {}

/// The cables carry the platform, level and nearly at rest.
fn assert_held(bench: &Bench, name: &str) {
    let plant = bench.rig.plant();
    let (speed, tilt) = (plant.velocity.norm(), plant.encoder_pose.angles().amax());
    println!(
        "{name}: held with {speed:.3} m/s, turned by {tilt:.3} rad, tensions {:.1?}",
        bench.rig.motor_tension()
    );
    assert_eq!(bench.rig.support(), Support::Cables, "{name}");
    assert!(speed < 0.15 && tilt < 0.3, "{name}: {speed} m/s, {tilt} rad");
}

/// Cycles until a silence is a fault: those bridged, one more, and one that is on its way.
const SILENCE: u32 = 4 + 1 + 1;

#[test]
fn what_fails_at_a_drive_ends_in_the_safe_output() {
    type Case = (&'static str, fn(&mut Bench), fn(&Fault) -> bool, u32);
    let cases: [Case; 9] = [
        (
            "silent",
            |b| b.rig.drives[2].faults.is_silent = true,
            |f| *f == Fault::EncoderSilent { cable: 3 },
            SILENCE,
        ),
        (
            "frozen",
            |b| b.rig.drives[2].faults.is_encoder_frozen = true,
            |f| *f == Fault::EncoderFrozen { cable: 3 },
            SILENCE + 1,
        ),
        (
            "jump",
            |b| b.rig.drives[2].faults.encoder_error = 20_000,
            |f| matches!(f, Fault::EncoderJump { cable: 3, .. }),
            2,
        ),
        (
            "emergency",
            |b| {
                let mut sent = vec![];
                b.rig.drives[4].fail(0x2310, &mut sent);
                sent.into_iter().for_each(|frame| b.inject(0, frame));
            },
            |f| matches!(f, Fault::Emergency(e) if (e.node, e.code) == (5, 0x2310)),
            1,
        ),
        (
            "fault without an emergency message",
            |b| b.rig.drives[4].fail(0x2310, &mut vec![]),
            |f| *f == Fault::DriveFault { node: 5, state: DriveState::Fault },
            2,
        ),
        (
            "reboot",
            |b| b.rig.drives[0].reboot(b.now),
            |f| matches!(f, Fault::EncoderSilent { cable: 1 } | Fault::Rebooted { node: 1 }),
            SILENCE,
        ),
        (
            "no heartbeat",
            |b| b.rig.drives[5].node.faults.no_heartbeat = true,
            |f| *f == Fault::HeartbeatLost { node: 6 },
            100 / 4 + 1,
        ),
        (
            "stopped by somebody",
            |b| b.rig.on_frame(0, &NmtCommand::Stop.frame(Some(3)), b.now, &mut vec![]),
            |f| {
                matches!(
                    f,
                    Fault::NotOperational { node: 3, state: NmtState::Stopped }
                        | Fault::EncoderSilent { cable: 3 }
                        | Fault::Emergency(Emergency { node: 3, .. })
                )
            },
            SILENCE,
        ),
        (
            "dead",
            |b| b.rig.drives[1].node.faults.is_dead = true,
            |f| *f == Fault::EncoderSilent { cable: 2 },
            SILENCE,
        ),
    ];
    for (name, inject, is_expected, most) in cases {
        let (fault, cycles, bench) = reaction(bench(), inject, nothing);
        println!("{name}: {fault}, {cycles} cycles");
        if bench.rig.drives.iter().all(|drive| drive.state() == DriveState::OperationEnabled) {
            assert_held(&bench, name);
        }
        assert!(is_expected(&fault), "{name}: {fault:?}");
        assert!(cycles <= most, "{name}: {cycles} cycles");
    }
}

#[test]
fn what_fails_at_a_load_cell_ends_in_the_safe_output() {
    type Case = (&'static str, fn(&mut Bench), fn(&Fault) -> bool, u32);
    let cases: [Case; 5] = [
        (
            "silent",
            |b| b.rig.cells[3].is_silent = true,
            |f| *f == Fault::LoadCellSilent { cable: 4 },
            SILENCE,
        ),
        (
            "not a number",
            |b| b.rig.cells[3].cells[0].2 = CellFault::Says(f64::NAN),
            |f| matches!(f, Fault::LoadCellAbsurd { cable: 4, tension } if tension.is_nan()),
            SILENCE,
        ),
        (
            "out of range",
            |b| b.rig.cells[3].cells[0].2 = CellFault::Says(1e5),
            |f| matches!(f, Fault::LoadCellAbsurd { cable: 4, .. }),
            SILENCE,
        ),
        (
            "wrong",
            |b| b.rig.cells[3].cells[0].2 = CellFault::Says(100.0),
            |f| matches!(f, Fault::LoadCellDisagrees { cable: 4, .. } | Fault::LoadCellStuck { cable: 4 }),
            25 + 2,
        ),
        (
            "stuck",
            |b| b.rig.cells[3].cells[0].2 = CellFault::Stuck,
            |f| matches!(f, Fault::LoadCellStuck { cable: 4 } | Fault::LoadCellDisagrees { cable: 4, .. }),
            1000,
        ),
    ];
    for (name, inject, is_expected, most) in cases {
        let (fault, cycles, bench) = reaction(bench(), inject, nothing);
        println!("{name}: {fault}, {cycles} cycles");
        if bench.rig.drives.iter().all(|drive| drive.state() == DriveState::OperationEnabled) {
            assert_held(&bench, name);
        }
        assert!(is_expected(&fault), "{name}: {fault:?}");
        assert!(cycles <= most, "{name}: {cycles} cycles");
    }
}

#[test]
fn what_fails_at_the_bus_ends_in_the_safe_output() {
    let bus_off =
        |b: &mut Bench| b.inject(0, crate::candump::parse_frame("20000040#0000000000000000").unwrap());
    let (fault, cycles, _) = reaction(bench(), bus_off, nothing);
    assert_eq!((fault, cycles), (Fault::BusOff { bus: 0 }, 1));

    for error in [TransportError::Down, TransportError::Gone] {
        let (fault, cycles, bench) = reaction(bench(), |b| b.bridge.on_transport_error(0, error), nothing);
        assert_held(&bench, "link");
        assert_eq!((fault, cycles), (Fault::Transport { bus: 0, error }, 1));
    }

    let no_room = |b: &mut Bench| b.bridge.on_transport_error(0, TransportError::NoRoom);
    let (fault, cycles, _) = reaction(bench(), nothing, no_room);
    assert_eq!((fault, cycles), (Fault::Transport { bus: 0, error: TransportError::NoRoom }, 4 + 1));
}

#[test]
fn now_and_then_no_room_is_no_fault() {
    let mut bench = moving(bench(), 0.0);
    for k in 0..1000 {
        if k % 5 != 0 {
            bench.bridge.on_transport_error(0, TransportError::NoRoom);
        }
        bench.cycle();
    }
    assert_eq!(bench.bridge.state(), State::Enabled);
}

#[test]
fn with_the_cable_cut_the_drives_stop_by_themselves() {
    let mut bench = moving(bench(), 0.4);
    bench.link.faults.is_cut = true;
    bench.run(0.15);
    assert_eq!(bench.bridge.fault, Some(Fault::EncoderSilent { cable: 1 }));
    assert!(bench.rig.drives.iter().all(|drive| drive.state() == DriveState::Fault));
    assert_eq!(bench.rig.motor_tension(), [0.0; 6]);
}

/// A controller that goes wrong after a while.
struct Failing {
    controller: LibraryController,
    good_until: f64,
    answer: fn(ControllerOutputs) -> Result<ControllerOutputs, ModelError>,
}

impl ControllerModel for Failing {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        self.controller.start(inputs)
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        let outputs = self.controller.step(time, h, inputs)?;
        if time < self.good_until { Ok(outputs) } else { (self.answer)(outputs) }
    }
}

#[test]
fn what_fails_at_the_controller_ends_in_the_safe_output() {
    type Answer = fn(ControllerOutputs) -> Result<ControllerOutputs, ModelError>;
    type Case = (Answer, fn(&Fault) -> bool);
    let cases: [Case; 5] = [
        (|_| Err("fmi2Error".into()), |f| *f == Fault::ControllerFailed),
        (
            |o| Ok(pulling(o, f64::NAN)),
            |f| matches!(f, Fault::ControllerOutput { cable: 2, tension } if tension.is_nan()),
        ),
        (|o| Ok(pulling(o, 1e3)), |f| *f == Fault::ControllerOutput { cable: 2, tension: 1e3 }),
        (|o| Ok(pulling(o, -0.1)), |f| *f == Fault::ControllerOutput { cable: 2, tension: -0.1 }),
        (
            |o| Ok(ControllerOutputs { status: Status::SensorFault, ..o }),
            |f| *f == Fault::ControllerSensorFault,
        ),
    ];
    fn pulling(mut outputs: ControllerOutputs, tension: f64) -> ControllerOutputs {
        outputs.motor_tension[1] = tension;
        outputs
    }
    for (answer, is_expected) in cases {
        let (fault, cycles, _) = reaction(
            bench(),
            |b| {
                let good = LibraryController::new(cable_robot::plan::ControllerParameters::default());
                b.controller = Box::new(Failing { controller: good, good_until: 0.0, answer });
            },
            nothing,
        );
        assert!(is_expected(&fault) && cycles == 1, "{fault:?} after {cycles} cycles");
    }
}

#[test]
fn a_late_cycle_is_a_fault_and_a_slightly_late_one_is_not() {
    let period = config().period;
    let mut late = moving(bench(), 0.4);
    late.cycle_at(late.now + 3 * period);
    assert_eq!(late.bridge.state(), State::Enabled);
    let report = late.cycle_at(late.now + 6 * period);
    assert_eq!((report.state, report.fault), (State::Stopping, Some(Fault::Overrun { gap: 6 * period })));
}

/// The drives' heartbeat consumers answer a bridge that stood still: 0x8130 was said to be the cause.
#[test]
fn the_first_fault_of_a_suspended_bridge_is_its_late_cycle() {
    let mut bench = moving(bench(), 0.4);
    let gap = 500_000_000;
    bench.inject(0, Emergency { node: 3, code: 0x8130, register: 0x11, maker: [0; 5] }.frame());
    let report = bench.cycle_at(bench.now + gap);
    assert_eq!((report.state, report.fault), (State::Stopping, Some(Fault::Overrun { gap })));
    let follows = |event: &Event| matches!(event, Event::Fault(Fault::Emergency(e)) if e.code == 0x8130);
    assert!(bench.events.iter().any(|(_, event)| follows(event)), "what follows from it is said as well");
}

#[test]
fn an_emergency_that_the_fieldbus_file_ignores_is_logged_and_ends_nothing() {
    let named = format!("{AKD}\n[[ignored_emergencies]]\ncode = 0x8140\nnode = 3\nregister = 0x01\n");
    let mut bench = moving(with_noise(parse(&named).unwrap()), 0.4);
    let emergency = |node| Emergency { node, code: 0x8140, register: 0x11, maker: [0; 5] };
    bench.inject(0, emergency(3).frame());
    bench.run(0.1);
    assert_eq!(bench.bridge.state(), State::Enabled);
    assert!(bench.events.iter().any(|(_, event)| *event == Event::Emergency(emergency(3))));
    bench.inject(0, emergency(4).frame());
    assert_eq!(bench.cycle().fault, Some(Fault::Emergency(emergency(4))));
}

/// CiA 402 has no word for it: the drive leaves for Switch on disabled without a fault.
#[test]
fn safe_torque_off_is_named_where_a_drive_leaves_without_a_fault() {
    let state = DriveState::SwitchOnDisabled;
    for fault in [Fault::DriveLeft { node: 3, state }, Fault::DriveStuck { node: 3, state }] {
        assert!(fault.to_string().contains("safe torque off (STO"), "{fault}");
    }
    let fault = Fault::DriveStuck { node: 3, state: DriveState::Fault };
    assert_eq!(fault.to_string(), "drive 3 stays in \"Fault\"");
}

#[test]
fn a_clock_that_goes_back_is_a_fault_and_the_way_to_the_safe_output_goes_on() {
    let mut bench = moving(bench(), 0.4);
    let back = bench.now - 1_000_000_000;
    let mut controller = LibraryController::new(cable_robot::plan::ControllerParameters::default());
    let mut out = FrameQueue::new();
    let report = bench.bridge.cycle(back, &mut controller, &mut out);
    assert_eq!(
        (report.state, report.fault),
        (State::Stopping, Some(Fault::ClockBackwards { by: 1_000_000_000 }))
    );
    for k in 1..=75 {
        bench.bridge.cycle(back + k * bench.bridge.config.period, &mut controller, &mut out);
    }
    assert_eq!(bench.bridge.state(), State::Fault);
}

#[test]
fn after_a_kill_the_drives_stop_by_themselves() {
    let mut bench = moving(bench(), 0.4);
    let killed = bench.now;
    let watchdog = bench.bridge.config.heartbeat.drive_watchdog;
    let mut sent = vec![];
    for k in 1..=(watchdog / 1_000_000 + 1) {
        bench.rig.tick(killed + k * 1_000_000, &mut sent);
    }
    assert_eq!(bench.rig.motor_tension(), [0.0; 6]);
    // Heartbeat or torque frame: which of the two was missing first is a matter of when the last heartbeat was sent.
    let is_watchdog = |e: Emergency| [0x8130, 0x8250].contains(&e.code);
    assert!(sent.iter().any(|(_, frame)| Emergency::parse(frame).is_some_and(is_watchdog)));
}

#[test]
fn a_fault_is_left_only_by_a_reset_and_then_everything_is_set_up_anew() {
    let inject = |b: &mut Bench| b.rig.drives[4].fail(0x2310, &mut vec![]);
    let (_, _, mut bench) = reaction(bench(), inject, nothing);
    bench.run(2.0);
    assert_eq!(bench.bridge.state(), State::Fault);
    assert_eq!(bench.rig.drives[4].state(), DriveState::Fault, "nobody asked to reset it");
    bench.bridge.operator(OperatorCommand::Reset, bench.now).unwrap();
    assert!(bench.run_until(State::Homing, 25.0), "{:?}", bench.events);
    bench.run(0.1);
    assert_eq!(bench.rig.drives[4].state(), DriveState::SwitchOnDisabled);
}

#[test]
fn what_is_wrong_at_the_start_is_said_and_nothing_is_pulled() {
    type Case = (fn(&mut Bench), fn(&Fault) -> bool);
    let cases: [Case; 3] = [
        (
            |b| b.rig.drives[1].node.faults.refuses = Some((MAX_TORQUE, 0x0609_0031)),
            |f| *f == Fault::Refused { node: 2, object: MAX_TORQUE, code: 0x0609_0031 },
        ),
        (|b| b.rig.cells[4].node.faults.is_dead = true, |f| *f == Fault::NoBoot { node: 15 }),
        (|b| b.link.faults.is_cut = true, |f| *f == Fault::NoBoot { node: 1 }),
    ];
    for (inject, is_expected) in cases {
        let mut bench = bench();
        inject(&mut bench);
        assert!(bench.run_until(State::Fault, 15.0));
        let fault = bench.bridge.fault.unwrap();
        assert!(is_expected(&fault), "{fault:?}");
        assert_eq!(bench.rig.motor_tension(), [0.0; 6]);
        assert!(bench.bridge.operator(OperatorCommand::Home, bench.now).is_err());
        assert!(bench.bridge.operator(OperatorCommand::Enable, bench.now).is_err());
    }
}

#[test]
fn a_load_cell_that_is_dead_wrongly_scaled_or_of_another_cable_never_gets_ready() {
    type Case = (&'static str, fn(&mut Bench));
    let cases: [Case; 5] = [
        ("dead", |b| b.rig.cells[2].cells[0].2 = CellFault::Says(0.0)),
        ("a ten-thousandth", |b| b.rig.cells[2].cells[0].1.scale = 1e4),
        ("three times as much", |b| b.rig.cells[2].cells[0].1.scale = 1.0 / 3.0),
        ("half", |b| b.rig.cells[2].cells[0].1.scale = 2.0),
        ("swapped with the next", |b| (b.rig.cells[2].cells[0].0, b.rig.cells[3].cells[0].0) = (3, 2)),
    ];
    for (name, is_wrong) in cases {
        let mut bench = bench();
        is_wrong(&mut bench);
        assert!(!bench.start(), "{name}: enabled");
        let fault = bench.bridge.fault.unwrap();
        println!("{name}: {fault}");
        let is_expected = |fault| {
            matches!(fault, Fault::LoadCellDisagrees { cable: 3, .. } | Fault::LoadCellStuck { cable: 3 })
        };
        assert!(is_expected(fault), "{name}: {fault}");
        assert_eq!((bench.bridge.state(), bench.rig.support()), (State::Fault, Support::Stand), "{name}");
    }
}

/// A motor that is wired the other way round, or whose direction is wrong in the fieldbus file.
#[test]
fn a_cable_that_is_paid_out_while_slack_is_taken_up_is_a_fault() {
    let mut bench = bench();
    assert!(bench.run_until(State::Homing, 20.0));
    bench.run(0.1);
    let winch = bench.bridge.config.drives[2].winch;
    for k in 0..200 {
        let _ = bench.bridge.operator(OperatorCommand::Home, bench.now);
        bench.rig.drives[2].faults.encoder_error = winch.counts(0.001 * f64::from((k - 100).max(0)), 0);
        bench.run(0.01);
    }
    assert!(
        matches!(bench.bridge.fault, Some(Fault::LooseCable { cable: 3, length }) if length < -0.05),
        "{:?}",
        bench.bridge.fault
    );
}

/// Five values of a sensor in a row must be missing: with 3 % of the frames lost (of SYNC or of the answer) in 24,000 values once in sixty runs, with 5 % once in five.
#[test]
fn lost_and_doubled_frames_are_ridden_through() {
    for link in [
        LinkFaults { loss: 0.01, ..LinkFaults::default() },
        LinkFaults { loss: 0.03, ..LinkFaults::default() },
        LinkFaults { duplicates: 0.2, ..LinkFaults::default() },
    ] {
        let mut bench = moving(bench(), 0.0);
        bench.link.faults = link;
        let reports = bench.run(8.0);
        assert_eq!(bench.bridge.state(), State::Enabled, "{link:?} {:?}", bench.events.last());
        let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
        println!("{link:?}: smallest tension {least:.3} N");
        assert!(least > 0.0, "{link:?}: {least}");
    }
}

#[test]
fn a_fifth_of_the_frames_lost_ends_in_the_safe_output() {
    let mut bench = moving(bench(), 0.0);
    bench.link.faults.loss = 0.2;
    assert!(bench.run_until(State::Fault, 60.0));
    let fault = bench.bridge.fault.unwrap();
    println!("{fault}");
    assert!(matches!(
        fault,
        Fault::EncoderSilent { .. } | Fault::LoadCellSilent { .. } | Fault::HeartbeatLost { .. }
    ));
}

#[test]
fn an_encoder_that_froze_at_rest_is_found_when_the_others_move() {
    let mut bench = moving(bench(), 10.0);
    bench.rig.drives[2].faults.is_encoder_frozen = true;
    bench.go_to(-0.1, 0.0, 1.0);
    assert!(bench.run_until(State::Fault, 10.0));
    assert_eq!(bench.bridge.fault, Some(Fault::EncoderFrozen { cable: 3 }));
    bench.run(2.0);
    assert_held(&bench, "frozen at rest");
}

/// The rig's clock goes on, the bridge's is set back by a second.
#[test]
fn a_clock_that_goes_back_while_nothing_moves_does_no_harm() {
    let mut bench = bench();
    assert!(bench.run_until(State::Homing, 20.0));
    bench.run(2.0);
    let mut controller = LibraryController::new(bench.parameters());
    let (mut out, mut coming) = (FrameQueue::new(), vec![]);
    for k in 1..=200 {
        let now = bench.now + k * bench.bridge.config.period;
        let late = now - 1_000_000_000;
        bench.rig.tick(now, &mut coming);
        coming.drain(..).for_each(|(bus, frame)| bench.bridge.on_frame(bus, &frame, late));
        let report = bench.bridge.cycle(late, &mut controller, &mut out);
        assert_eq!((report.state, report.fault), (State::Homing, None));
        out.frames().iter().for_each(|(bus, frame)| bench.rig.on_frame(*bus, frame, now, &mut coming));
    }
}

/// CiA 402 has no control word that keeps one drive enabled and does not lead up another that shares its frame.
#[test]
fn a_drive_that_fell_out_pulls_nothing_even_if_the_word_it_shares_leads_it_up() {
    for text in [on_two_buses(), AKD.to_owned()] {
        let mut bench = moving(with_noise(parse(&text).unwrap()), 0.4);
        bench.suffer("drive 2 blocked").unwrap();
        bench.run(1.0);
        assert_eq!(bench.bridge.state(), State::Fault);
        assert_eq!(bench.bridge.fault, Some(Fault::DriveLeft { node: 2, state: DriveState::SwitchedOn }));
        bench.suffer("drive 2 well").unwrap();
        bench.run(1.0);
        let pulls = bench.rig.motor_tension();
        assert!(pulls[1] == 0.0 && pulls[0] > 1.0 && pulls[2] > 1.0, "{pulls:?}");
    }
}

#[test]
fn what_fails_after_the_first_fault_is_logged_once_each() {
    let mut bench = moving(bench(), 0.4);
    bench.rig.drives[2].faults.is_silent = true;
    bench.run(1.0);
    assert_eq!(bench.bridge.state(), State::Fault);
    bench.rig.drives[5].node.faults.no_heartbeat = true;
    bench.run(0.5);
    for _ in 0..10 {
        bench.bridge.on_transport_error(0, TransportError::Down);
        bench.cycle();
    }
    let faults: Vec<_> = bench.events.iter().filter(|(_, event)| matches!(event, Event::Fault(_))).collect();
    println!("{faults:?}");
    let expected = [
        Fault::EncoderSilent { cable: 3 },
        Fault::HeartbeatLost { node: 6 },
        Fault::Transport { bus: 0, error: TransportError::Down },
    ];
    for fault in expected {
        assert_eq!(faults.iter().filter(|(_, event)| *event == Event::Fault(fault)).count(), 1, "{fault}");
    }
    assert_eq!(bench.bridge.fault, Some(Fault::EncoderSilent { cable: 3 }));
}

#[test]
fn a_burst_of_emergency_messages_hides_neither_the_fault_nor_the_state() {
    let mut bench = moving(bench(), 0.4);
    for _ in 0..300 {
        bench.inject(0, Emergency { node: 3, code: 0x2310, register: 1, maker: [0; 5] }.frame());
    }
    bench.cycle();
    let has = |wanted: fn(&Event) -> bool| bench.events.iter().any(|(_, event)| wanted(event));
    assert!(has(|event| matches!(event, Event::Fault(Fault::Emergency(_)))));
    assert!(has(|event| *event == Event::Entered(State::Stopping)));
    assert!(has(|event| *event == Event::Lost(300 - 64)));
}
