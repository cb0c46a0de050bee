//! The bridge against the simulated rig, in memory.

mod coming_down;
mod eight;
mod faults;
mod first_day;
mod jog;
mod masters;
mod safe_output;
mod trials;

use super::*;
use crate::canopen::{Emergency, NmtState};
use crate::config::SafeOutput;
use crate::config::tests::{AKD, parse};
use crate::controller::LibraryController;
use crate::frame::{Frame, FrameKind, error_class};
use crate::simulated::{Bench, SimulatedDrive};
use cable_robot::plan::{ControllerParameters, PlannerKind, Status};
use cable_robot::robot::TensionLimits;
use cable_robot::sim::PlantParameters;

fn config() -> Config {
    parse(AKD).unwrap()
}

fn with_safe_output(output: SafeOutput) -> Bench {
    let mut config = config();
    config.safe.output = output;
    with_noise(config)
}

/// With 0.05 N chance decides when the platform is at rest, and so when it sets out.
fn with_noise(config: Config) -> Bench {
    let imperfections = PlantParameters { load_cell_noise: 0.01, ..PlantParameters::default() };
    Bench::new(config, imperfections).unwrap()
}

fn bench() -> Bench {
    with_safe_output(SafeOutput::GravityRamp)
}

/// Under way from (0, 0, 1) to (0.15, 0.15, 1) for so many seconds.
fn moving(mut bench: Bench, seconds: f64) -> Bench {
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    bench.go_to(0.15, 0.15, 1.0);
    bench.run(seconds);
    assert_eq!(bench.bridge.state(), State::Enabled, "{:?}", bench.events.last());
    bench
}

#[test]
fn the_papers_move_is_made_with_all_tensions_positive() {
    let imperfections = PlantParameters {
        friction: 0.2,
        motor_lag: 2e-3,
        load_cell_noise: 0.05,
        ..PlantParameters::default()
    };
    let mut bench = moving(Bench::new(config(), imperfections).unwrap(), 0.0);
    let reports = bench.run(15.0);
    let last = reports.last().unwrap();
    assert_eq!((last.state, last.fault), (State::Enabled, None));
    let there = bench.rig.plant().encoder_pose.position();
    assert!((there - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm() < 5e-3, "{there}");
    let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
    println!("smallest tension {least:.3} N, at goal: {}", last.controller.unwrap().at_goal);
    assert!(least > 0.3, "{least}");
}

/// Half a newton is left for what the planner does not know.
fn plan_in_minimum_time(bench: &mut Bench) {
    let limits = TensionLimits { min: 0.5, max: 60.0 };
    let of_planner = ControllerParameters {
        planner: PlannerKind::MinimumTime,
        rig: bench.bridge.config().rig.with_limits(limits),
        ..bench.parameters()
    };
    bench.controller = Box::new(LibraryController::new(bench.bridge.config().of_drives(of_planner)));
}

/// The fastest motion, on drives that lag, with friction and load cells that make noise: half a newton is left for those. Then goals that change on the way.
#[test]
fn the_papers_move_is_made_in_minimum_time_too() {
    let imperfections = PlantParameters {
        friction: 0.2,
        motor_lag: 2e-3,
        load_cell_noise: 0.01,
        ..PlantParameters::default()
    };
    let mut bench = Bench::new(config(), imperfections).unwrap();
    plan_in_minimum_time(&mut bench);
    let mut bench = moving(bench, 0.0);
    let away =
        |report: &CycleReport| (report.pose.position() - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm();
    let reports = bench.run(4.0);
    let begun = reports.iter().position(|report| away(report) < 0.2).unwrap();
    let arrived = reports.iter().rposition(|report| away(report) > 5e-3).unwrap();
    let tensions = |reports: &[CycleReport]| {
        reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min)
    };
    let seconds = 4e-3 * (arrived - begun) as f64;
    println!(
        "within 5 mm {seconds:.3} s after the first centimetre, smallest tension {:.3} N",
        tensions(&reports)
    );
    let last = reports.last().unwrap();
    assert_eq!((last.state, last.fault), (State::Enabled, None), "{:?}", bench.events.last());
    assert!(tensions(&reports) > 0.1 && seconds < 0.6);
    for (x, y) in [(-0.1, 0.05), (0.1, -0.1), (0.0, 0.0)] {
        bench.go_to(x, y, 1.0);
        let reports = bench.run(0.3);
        println!("to ({x}, {y}): smallest tension {:.3} N", tensions(&reports));
        assert!(reports.iter().all(|report| (report.state, report.fault) == (State::Enabled, None)));
        assert!(tensions(&reports) > 0.1);
    }
}

#[test]
fn the_same_inputs_give_the_same_bits() {
    let run = || {
        let mut bench = moving(bench(), 0.0);
        bench.link.faults.loss = 0.02;
        bench.run(2.0).iter().map(|report| format!("{report:?}")).collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

/// Three drives share a frame, and a bus.
fn on_two_buses() -> String {
    let mut text = AKD.replacen("[[buses]]", "[[buses]]\nname = \"can1\"\nbit_rate = 1e6\n\n[[buses]]", 1);
    for (node, (id, slot)) in
        (1..).zip([("0x201", 1), ("0x201", 2), ("0x201", 3), ("0x204", 1), ("0x204", 2), ("0x204", 3)])
    {
        let entry = format!("bus = \"can0\"\nnode = {node}\n");
        assert!(text.contains(&entry));
        let bus = if node <= 3 { "can1" } else { "can0" };
        text = text.replace(
            &entry,
            &format!("bus = \"{bus}\"\nnode = {node}\ntorque_frame = {{ id = {id}, slot = {slot} }}\n"),
        );
    }
    text
}

#[test]
fn shared_frames_and_two_buses_carry_the_same_move() {
    let mut text = on_two_buses();
    for (cell, (bus, node)) in
        (11..).zip([("can1", 11), ("can1", 11), ("can1", 11), ("can0", 14), ("can0", 14), ("can0", 14)])
    {
        text = text.replace(
            &format!("bus = \"can0\"\nnode = {cell}\n"),
            &format!("bus = \"{bus}\"\nnode = {node}\n"),
        );
    }
    text = text.replace("encoding = \"f32\"", "encoding = \"i16\"").replace("scale = 1.0", "scale = 0.01");
    for (k, subindex) in [(1, 2), (2, 3), (4, 2), (5, 3)] {
        let mut parts: Vec<_> = text.split("[[load_cells]]").map(str::to_owned).collect();
        parts[k + 1] = parts[k + 1].replace("subindex = 1", &format!("subindex = {subindex}"));
        text = parts.join("[[load_cells]]");
    }
    let config = parse(&text).unwrap();
    let loads = crate::bus_load::check(&config).unwrap();
    assert_eq!(loads.iter().map(|bus| bus.frames).collect::<Vec<_>>(), [6, 6]);
    let bench = moving(with_noise(config), 12.0);
    let is_torque = |frame: &Frame| (0x200..0x580).contains(&frame.id());
    let torques = bench.sent().iter().filter(|(_, frame)| is_torque(frame)).map(|(bus, _)| *bus);
    assert_eq!(torques.collect::<Vec<_>>(), [0, 1], "{:?}", bench.sent());
    let there = bench.rig.plant().encoder_pose.position();
    assert!((there - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm() < 5e-3, "{there}");
}

#[test]
fn a_shadow_computes_the_same_and_sends_nothing() {
    let mut bench = bench();
    let mut shadow = Bridge::shadow(config());
    let (mut out, mut controller) = (FrameQueue::new(), LibraryController::new(bench.parameters()));
    let mut compared = 0;
    assert!(bench.run_until(State::Homing, 20.0));
    for k in 0..3000 {
        match (k, bench.bridge.state()) {
            (30, _) => bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap(),
            (_, State::TakingUpSlack) => bench.bridge.operator(OperatorCommand::Home, bench.now).unwrap(),
            (_, State::Ready) => bench.is_pressed = true,
            _ => {}
        }
        let report = bench.cycle();
        for (bus, frame) in bench.heard() {
            shadow.on_frame(*bus, frame, bench.now);
        }
        let shadowed = shadow.cycle(bench.now, &mut controller, &mut out);
        assert!(out.frames().is_empty() && shadowed.state == State::Shadow);
        if report.state == State::Enabled && report.controller.is_some_and(|c| c.status != Status::Disabled) {
            let difference = (report.length[0] - shadowed.length[0]).abs();
            assert!(difference < 1e-5, "{difference}");
            compared += 1;
        }
    }
    assert!(compared > 1000, "{compared}");
}

/// Beside another controller that moves the platform elsewhere: what the shadow would pull moves nothing.
#[test]
fn a_shadows_force_loop_does_not_wind_up() {
    let mut bench = bench();
    assert!(bench.start());
    bench.run(1.0);
    let parameters = bench.parameters();
    let mut shadows = [true, false].map(|force_loop| {
        let controller =
            LibraryController::new(cable_robot::plan::ControllerParameters { force_loop, ..parameters });
        (Bridge::shadow(config()), controller)
    });
    let mut out = FrameQueue::new();
    bench.run(0.1);
    bench.go_to(0.03, 0.0, 1.0);
    let mut apart = 0.0f64;
    for _ in 0..3000 {
        bench.cycle();
        let [with, without] = shadows.each_mut().map(|(shadow, controller)| {
            bench.heard().iter().for_each(|(bus, frame)| shadow.on_frame(*bus, frame, bench.now));
            shadow.cycle(bench.now, controller, &mut out).tension
        });
        apart = (0..with.len()).map(|i| (with[i] - without[i]).abs()).fold(0.0, f64::max);
    }
    println!("the force loop adds {apart:.2} N");
    assert!(apart < 1.0, "{apart} N");
}

/// A frame that may be anything, most often one that the bridge listens to.
fn any_frame(random: &mut rand_pcg::Pcg64) -> Frame {
    use rand::RngExt;
    let bases = [0x000, 0x080, 0x180, 0x200, 0x580, 0x600, 0x700];
    let id = bases[random.random_range(0..bases.len())] + random.random_range(0..18u16);
    let data: [u8; 8] = random.random();
    let kind = if random.random_range(0..50) == 0 { FrameKind::Remote } else { FrameKind::Data };
    Frame::new(kind, id, &data[..random.random_range(0..=8)]).unwrap()
}

#[test]
fn no_frames_make_the_bridge_panic_or_pull_more_than_allowed() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    for k in 0..60 {
        let mut bench = bench();
        match k % 4 {
            0 => {}
            1 => assert!(bench.run_until(State::Homing, 20.0)),
            2 => assert!(bench.start()),
            _ => bench = moving(bench, 0.3),
        }
        for _ in 0..300 {
            for _ in 0..random.random_range(0..3) {
                let frame = any_frame(&mut random);
                bench.inject(random.random_range(0..2), frame);
            }
            let commands = [
                OperatorCommand::Home,
                OperatorCommand::Release,
                OperatorCommand::Reset,
                OperatorCommand::Enable,
                OperatorCommand::Lower,
                OperatorCommand::Jog(2, JogDirection::In),
                OperatorCommand::Jog(2, JogDirection::Out),
            ];
            if random.random_range(0..20) == 0 {
                let _ = bench.bridge.operator(commands[random.random_range(0..commands.len())], bench.now);
            }
            let late = random.random_range(0..2_000_000);
            let report = bench.cycle_at(bench.now + 3_000_000 + late);
            for tension in report.tension {
                let allowed = if report.state == State::Jogging { -3.0..=3.0 } else { 0.0..=60.1 };
                assert!(allowed.contains(&tension), "{report:?}");
            }
            let has_torque = report.target_torque != [0; 6];
            assert!(!(has_torque && matches!(report.state, State::Configuring | State::Homing | State::Off)));
        }
    }
}

/// The force loop lets through more of the load cells' noise the slower it runs, and Table I's platform turns by 0.02 rad for 0.01 N.
#[test]
fn the_move_is_made_and_held_after_release_at_other_rates() {
    for rate in [100, 349] {
        let text = AKD.replacen("rate = 250.0", &format!("rate = {rate}"), 1);
        let imperfections = PlantParameters { load_cell_noise: 0.005, ..PlantParameters::default() };
        let mut bench = moving(Bench::new(parse(&text).unwrap(), imperfections).unwrap(), 0.0);
        let reports = bench.run(12.0);
        let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
        let there = bench.rig.plant().encoder_pose.position();
        bench.is_pressed = false;
        bench.bridge.operator(OperatorCommand::Release, bench.now).unwrap();
        bench.run(3.0);
        let turned = bench.rig.plant().encoder_pose.angles().amax();
        println!("{rate} Hz: smallest tension {least:.3} N, turned by {turned:.3} rad 3 s after release");
        assert!((there - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm() < 5e-3, "{rate} Hz: {there}");
        assert!(
            bench.bridge.state() == State::Safe && least > 0.3 && turned < 0.05,
            "{rate} Hz: {least} {turned}"
        );
    }
}
