//! The table of docs/rig.md, "Coming down": every cause ends as it says, with the platform on its stand where its pose is known.

use super::*;
use crate::simulated::Support;
use cable_robot::robot::RigFile;

/// What a landing may be at most, m/s.
const LANDING_SPEED: f64 = 0.1;
const HOLD: Nanoseconds = 1_000_000_000;

/// A rig that differs from what the bridge believes, with friction.
fn rig(friction: f64, differ: impl FnOnce(&mut Config)) -> Bench {
    let mut belief = config();
    belief.safe.hold_time = HOLD;
    let mut truth = belief.clone();
    differ(&mut truth);
    let imperfections =
        PlantParameters { friction, motor_lag: 2e-3, load_cell_noise: 0.01, ..PlantParameters::default() };
    Bench::believing(truth, belief, imperfections).unwrap()
}

fn as_believed() -> Bench {
    rig(0.2, |_| {})
}

/// Hangs at rest aside of its stand and above it. The planner of minimum time goes upwards, too.
fn hanging(mut bench: Bench) -> Bench {
    plan_in_minimum_time(&mut bench);
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    bench.go_to(0.1, -0.05, 0.9);
    bench.run(4.0);
    assert_eq!(bench.rig.support(), Support::Cables, "{:?}", bench.events);
    println!("hangs at {:.3?}", bench.rig.plant().encoder_pose.0.as_slice());
    bench
}

/// How a platform came down.
#[derive(Debug)]
struct Descent {
    /// s, until it stood, or the end of the watch.
    time: f64,
    /// m/s and rad while it hung, and N in the cables until the motors are off.
    speed: f64,
    tilt: f64,
    least: f64,
    /// m/s, with which it came to its stand.
    landing: Option<f64>,
}

/// Watches until the bridge is in `end` or for `seconds`.
fn watch(bench: &mut Bench, end: State, seconds: f64) -> Descent {
    let begun = bench.now;
    let mut descent = Descent { time: 0.0, speed: 0.0, tilt: 0.0, least: f64::INFINITY, landing: None };
    let mut last = 0.0;
    while bench.bridge.state() != end && bench.now - begun < (seconds * 1e9) as Nanoseconds {
        bench.cycle();
        let plant = bench.rig.plant();
        let speed = plant.velocity.norm();
        // On its stand it is at rest, and may be lifted again at once.
        let has_landed = speed == 0.0 || bench.rig.support() == Support::Floor;
        if has_landed && last > 0.0 {
            descent.landing = Some(descent.landing.unwrap_or(0.0).max(last));
        }
        last = if has_landed { 0.0 } else { speed };
        if !matches!(bench.bridge.state(), State::Homing | State::Configuring | State::Fault | State::Off) {
            descent.least =
                descent.least.min(plant.measured_tension.iter().copied().fold(f64::INFINITY, f64::min));
        }
        match bench.rig.support() {
            Support::Cables => {
                descent.speed = descent.speed.max(speed);
                descent.tilt = descent.tilt.max(plant.encoder_pose.angles().amax());
                descent.time = (bench.now - begun) as f64 * 1e-9;
            }
            Support::Stand | Support::Floor => {}
        }
    }
    descent
}

/// From what happened until the bridge is in `end` with the motors off.
fn come_down(bench: &mut Bench, end: State) -> Descent {
    let held = watch(bench, State::Lowering, 12.0);
    let led = watch(bench, end, 30.0);
    Descent {
        speed: held.speed.max(led.speed),
        tilt: held.tilt.max(led.tilt),
        least: held.least.min(led.least),
        ..led
    }
}

fn assert_landed(name: &str, bench: &Bench, descent: &Descent) {
    println!("{name}: {descent:.3?}");
    assert_eq!(bench.rig.support(), Support::Stand, "{name}: {:?}", bench.events);
    assert!(descent.landing.is_some_and(|speed| speed < LANDING_SPEED), "{name}: {descent:?}");
}

fn assert_motors_off(name: &str, bench: &mut Bench) {
    bench.run(0.04);
    assert_eq!(bench.rig.motor_tension(), PerCable::filled(bench.rig.drives.len(), 0.0), "{name}");
    let off = |state| matches!(state, DriveState::SwitchOnDisabled | DriveState::Fault);
    assert!(bench.rig.drives.iter().all(|drive| off(drive.state())), "{name}");
}

fn entered(bench: &Bench, state: State) -> Option<Nanoseconds> {
    let found = bench.events.iter().find(|(_, event)| *event == Event::Entered(state));
    found.map(|(time, _)| *time)
}

fn command(bench: &mut Bench, command: OperatorCommand) {
    bench.is_pressed = false;
    bench.bridge.operator(command, bench.now).unwrap();
}

/// State x cause: how long it is held, and where it ends.
#[test]
fn a_hanging_platform_is_let_down_as_the_table_says() {
    type Row = (&'static str, fn(&mut Bench), Nanoseconds, State);
    let rows: [Row; 7] = [
        ("release", |b| command(b, OperatorCommand::Release), HOLD, State::Homing),
        ("enable not given again", |b| b.is_pressed = false, HOLD, State::Homing),
        ("load cell at fault", |b| b.suffer("cell 4 says nan").unwrap(), HOLD, State::Fault),
        ("lower", |b| command(b, OperatorCommand::Lower), 0, State::Homing),
        ("reset", |b| command(b, OperatorCommand::Reset), 0, State::Configuring),
        ("shutdown", |b| command(b, OperatorCommand::Shutdown), 0, State::Off),
        (
            "released, then reset",
            |b| {
                command(b, OperatorCommand::Release);
                b.run(0.1);
                command(b, OperatorCommand::Reset);
            },
            100_000_000,
            State::Configuring,
        ),
    ];
    for (name, cause, hold, end) in rows {
        let mut bench = hanging(as_believed());
        bench.events.clear();
        cause(&mut bench);
        let descent = come_down(&mut bench, end);
        assert_eq!(bench.bridge.state(), end, "{name}: {:?}", bench.events);
        assert_landed(name, &bench, &descent);
        assert!(descent.tilt < 0.05 && descent.least > 0.0, "{name}: {descent:?}");
        let stopped = entered(&bench, State::Stopping).unwrap();
        let lowers = entered(&bench, State::Lowering).unwrap();
        let expected = hold.max(bench.bridge.config.safe.ramp);
        let period = bench.bridge.config.period;
        assert!(
            (expected..=expected + 3 * period).contains(&(lowers - stopped)),
            "{name}: {} ns",
            lowers - stopped
        );
        assert_motors_off(name, &mut bench);
    }
}

/// As before homing: the operator may begin anew.
#[test]
fn once_it_is_down_it_can_be_homed_and_lifted_again() {
    let mut bench = hanging(as_believed());
    command(&mut bench, OperatorCommand::Lower);
    watch(&mut bench, State::Homing, 30.0);
    assert!(bench.take_up_slack(), "{:?}", bench.events);
    bench.is_pressed = true;
    assert!(bench.run_until(State::Enabled, 1.0), "{:?}", bench.events);
}

#[test]
fn on_its_stand_whatever_happens_the_motors_are_off_at_once() {
    for (given, end) in [
        (OperatorCommand::Lower, State::Homing),
        (OperatorCommand::Release, State::Homing),
        (OperatorCommand::Reset, State::Configuring),
        (OperatorCommand::Shutdown, State::Off),
    ] {
        let mut bench = as_believed();
        assert!(bench.run_until(State::Homing, 20.0));
        bench.run(0.1);
        assert!(bench.take_up_slack());
        command(&mut bench, given);
        assert_eq!(bench.bridge.state(), end, "{given:?}");
        assert_motors_off("on its stand", &mut bench);
        assert_eq!(bench.rig.support(), Support::Stand);
    }
}

/// What the bridge believes of mass, friction and pulleys is not so.
#[test]
fn a_rig_that_is_not_as_believed_lands_as_softly() {
    type Truth = (&'static str, f64, fn(&mut Config));
    // A platform of another mass hangs as much farther from where it is led.
    const FOLLOWING: f64 = 0.06;
    let truths: [Truth; 6] = [
        ("8 % heavier", 0.2, |truth| truth.rig.mass *= 1.08),
        ("8 % lighter", 0.2, |truth| truth.rig.mass *= 0.92),
        ("no friction", 0.0, |_| {}),
        ("friction of 0.5 N", 0.5, |_| {}),
        ("pulleys 2 % larger", 0.2, |truth| {
            truth.drives.iter_mut().for_each(|d| d.winch.pulley_radius *= 1.02)
        }),
        ("pulleys 2 % smaller", 0.2, |truth| {
            truth.drives.iter_mut().for_each(|d| d.winch.pulley_radius *= 0.98)
        }),
    ];
    for (name, friction, differ) in truths {
        let mut bench = rig(friction, differ);
        bench.bridge.config.limits.following = FOLLOWING;
        let mut bench = hanging(bench);
        command(&mut bench, OperatorCommand::Lower);
        let end = if bench.bridge.fault.is_some() { State::Off } else { State::Homing };
        let descent = watch(&mut bench, end, 20.0);
        assert_landed(name, &bench, &descent);
        assert!(descent.tilt < 0.1 && descent.least > 0.0, "{name}: {descent:?}");
        assert_motors_off(name, &mut bench);
    }
}

/// Its winch pulls what gravity asks for, the others resist: on the way, and while it hangs aside of its stand and above it.
#[test]
fn with_one_encoder_lost_it_comes_down_slowly_and_nearly_level() {
    for cable in 1..=6 {
        let words = ["jumps 20000", "frozen", "silent"][cable % 3];
        let is_moving = words == "frozen";
        let mut bench = if is_moving { moving(as_believed(), 0.4) } else { hanging(as_believed()) };
        let name = format!("drive {cable} {words}");
        bench.suffer(&name).unwrap();
        let descent = come_down(&mut bench, State::Fault);
        assert_landed(&name, &bench, &descent);
        assert!(descent.tilt < 0.1 && descent.least > 0.0, "{name}: {descent:?}");
        assert_motors_off(&name, &mut bench);
    }
}

#[test]
fn with_two_encoders_lost_the_drives_stop_by_themselves() {
    for words in ["jumps 20000", "silent"] {
        let mut bench = moving(as_believed(), 0.4);
        bench.suffer(&format!("drive 2 {words}")).unwrap();
        bench.suffer(&format!("drive 5 {words}")).unwrap();
        let begun = bench.now;
        let is_stopped = |bench: &Bench| {
            let stops = |state| matches!(state, DriveState::QuickStopActive | DriveState::SwitchOnDisabled);
            bench.rig.drives.iter().all(|drive| stops(drive.state()))
        };
        while !is_stopped(&bench) {
            bench.cycle();
            assert!(bench.now - begun < 1_000_000_000, "{words}: {:?}", bench.events);
        }
        println!("{words}: quick stop after {} ms", (bench.now - begun) / 1_000_000);
        let most = bench.bridge.config.heartbeat.timeout + 3 * bench.bridge.config.period;
        assert!(bench.now - begun <= most, "{words}");
        bench.run(1.0);
        assert_eq!(bench.bridge.state(), State::Fault);
        assert_motors_off(words, &mut bench);
    }
}

/// A bus that is silent for a moment has not lost the lengths.
#[test]
fn encoders_that_are_silent_for_a_moment_are_believed_again() {
    let mut bench = hanging(as_believed());
    for cable in [2, 5] {
        bench.suffer(&format!("drive {cable} silent")).unwrap();
    }
    bench.run(0.06);
    for cable in [2, 5] {
        bench.suffer(&format!("drive {cable} well")).unwrap();
    }
    bench.run(0.04);
    assert!(matches!(bench.bridge.fault, Some(Fault::EncoderSilent { .. })), "{:?}", bench.events);
    let descent = watch(&mut bench, State::Off, 20.0);
    assert_landed("silent for a moment", &bench, &descent);
    assert!(descent.tilt < 0.05, "{descent:?}");
}

/// A length that is carried on over missing values is no motion beside which an encoder that says nothing stands still.
#[test]
fn encoders_that_all_are_silent_while_it_comes_down_are_not_called_frozen() {
    let mut bench = rig(0.2, |_| {});
    bench.bridge.config.limits.lost_cycles = 100;
    let mut bench = hanging(bench);
    command(&mut bench, OperatorCommand::Lower);
    watch(&mut bench, State::Lowering, 5.0);
    bench.run(2.0);
    let speed = bench.rig.plant().velocity.norm();
    for words in ["silent", "well"] {
        (1..=6).for_each(|cable| bench.suffer(&format!("drive {cable} {words}")).unwrap());
        bench.run(0.3);
    }
    let travel = bench.bridge.config.limits.freeze_travel;
    assert!(0.3 * speed > travel, "{speed} m/s: slower than what would be found");
    assert_eq!(bench.bridge.fault, None, "{:?}", bench.events);
    let descent = watch(&mut bench, State::Homing, 20.0);
    assert_landed("all silent", &bench, &descent);
}

/// Five cables do not carry it level: it swings aside, is held askew, and comes down so, to its stand or beside it to the floor.
#[test]
fn with_one_drive_lost_it_is_let_down_until_nothing_pulls() {
    for cable in [1, 2, 4] {
        let mut bench = as_believed();
        bench.bridge.config.safe.hold_time = 5 * HOLD;
        let mut bench = hanging(bench);
        bench.suffer(&format!("drive {cable} emcy 0x2310")).unwrap();
        let swing = watch(&mut bench, State::Lowering, 10.0);
        let descent = watch(&mut bench, State::Fault, 30.0);
        let name = format!("drive {cable} lost");
        println!("{name}: {swing:.3?}, then {descent:.3?}, {:?}", bench.rig.support());
        assert_eq!(bench.bridge.state(), State::Fault, "{name}: {:?}", bench.events);
        assert_ne!(bench.rig.support(), Support::Cables, "{name}");
        assert!(swing.speed < 1.0 && swing.tilt < 1.2, "{name}: {swing:?}");
        assert!(descent.landing.is_some_and(|speed| speed < 0.2), "{name}: {descent:?}");
        assert_motors_off(&name, &mut bench);
    }
}

/// The bridge believes it 8 cm higher than it is.
#[test]
fn a_stand_that_is_not_there_is_a_fault_and_the_platform_is_held() {
    let mut bench = hanging(as_believed());
    bench.bridge.config.home.0[2] -= 0.08;
    bench.bridge.home_length = bench.bridge.config.rig.cables_at(&bench.bridge.config.home).length;
    command(&mut bench, OperatorCommand::Shutdown);
    let descent = watch(&mut bench, State::Fault, 30.0);
    println!("{descent:.3?} {:?}", bench.bridge.fault);
    assert!(matches!(bench.bridge.fault, Some(Fault::OffStand { .. })), "{:?}", bench.events);
    let descent = watch(&mut bench, State::Off, 3.0);
    assert_eq!((bench.bridge.state(), bench.rig.support()), (State::Fault, Support::Cables), "{descent:?}");
    assert!(descent.speed < LANDING_SPEED, "{descent:?}");
}

#[test]
fn a_rig_of_eight_cables_comes_down_too() {
    let rig = RigFile::parse(include_str!("../../../../../rigs/eight.toml")).unwrap();
    let config = Config::parse(include_str!("../../../../../rigs/can/eight.toml"), &rig).unwrap();
    let imperfections = PlantParameters {
        friction: 0.5,
        motor_lag: 2e-3,
        load_cell_noise: 0.1,
        ..PlantParameters::default()
    };
    let mut bench = Bench::new(config, imperfections).unwrap();
    assert!(bench.start(), "{:?}", bench.events);
    bench.run(1.0);
    bench.go_to(0.1, 0.1, 1.9);
    bench.run(4.0);
    command(&mut bench, OperatorCommand::Lower);
    let descent = watch(&mut bench, State::Homing, 60.0);
    assert_landed("eight cables", &bench, &descent);
    assert!(descent.tilt < 0.05 && descent.least > 0.0, "{descent:?}");
}
