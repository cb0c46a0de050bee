//! Bridge and simulated rig in simulated time: how many cycles each fault takes, exactly.

use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::bridge::{Cause, Event, Fault};
use cable_robot_fieldbus::cia402::{DriveState, MAX_TORQUE};
use cable_robot_fieldbus::simulated::{Bench, SimulatedDrive, Support};
use cable_robot_fieldbus::{Config, Files, Nanoseconds, OperatorCommand, State};

use crate::failures::{FAILURES, Failure};
use crate::table::{Row, count};
use crate::{Case, ensure};

const RIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml");
/// How long a move with something wrong is watched, s.
const LONG: f64 = 10.0;

/// Within this time a platform is down, and comes to its stand no faster, m/s.
const DOWN: Nanoseconds = 30_000_000_000;
const LANDING: f64 = 0.1;

/// All of them.
pub fn cases() -> Vec<Case> {
    let case = |name, run| Case { name, kind: "simulated", run };
    let mut cases: Vec<Case> = [
        ("1 % of the frames lost", "lose 1%"),
        ("3 % of the frames lost", "lose 3%"),
        ("20 % of the frames doubled", "double 20%"),
    ]
    .into_iter()
    .map(|(name, words)| case(name, Box::new(move || ridden_through(name, words)) as _))
    .collect();
    cases.extend(FAILURES.iter().map(|failure| case(failure.name, Box::new(|| ended(failure)) as _)));
    cases.push(case(
        "drive refuses the mode",
        Box::new(|| {
            refused_at_start("drive refuses the mode", "drive 2 refuses-mode", |fault| {
                *fault == Fault::ModeRefused { node: 2, found: 0 }
            })
        }),
    ));
    cases.push(case(
        "SDO abort at start",
        Box::new(|| {
            refused_at_start("SDO abort at start", "drive 2 refuses 0x6072 0x06090031", |fault| {
                *fault == Fault::Refused { node: 2, object: MAX_TORQUE, code: 0x0609_0031 }
            })
        }),
    ));
    for (name, words) in
        [("12 mm of slack in cable 1", "cable 1 slack 12"), ("49 mm of slack in cable 4", "cable 4 slack 49")]
    {
        cases.push(case(name, Box::new(move || starts(name, words)) as _));
    }
    cases.push(case("load cell shows a load with motors off", Box::new(loaded) as _));
    for (name, words) in [
        ("15 ms of delay each way", "delay 15"),
        ("25 ms of delay each way", "delay 25"),
        ("50 ms of delay each way", "delay 50"),
    ] {
        let is_slow = |fault: &Fault| matches!(fault, Fault::SlowReaction { .. });
        cases.push(case(name, Box::new(move || refused_at_start(name, words, is_slow)) as _));
    }
    for (name, mass) in [
        ("4 kg for 6 in the rig file", 4.0),
        ("5.5 kg for 6 in the rig file", 5.5),
        ("8 kg for 6 in the rig file", 8.0),
    ] {
        cases.push(case(name, Box::new(move || off_course(name, mass)) as _));
    }
    cases.push(case("gear of 5 for 1 at cable 3", Box::new(geared) as _));
    cases.push(case("kill -9", Box::new(killed) as _));
    cases
}

fn bench() -> Result<Bench, String> {
    bench_with(|_| {})
}

/// A rig that is not wholly as the bridge believes.
fn bench_with(differ: impl FnOnce(&mut Config)) -> Result<Bench, String> {
    let belief = Files::read(RIG.as_ref()).map_err(|error| error.to_string())?.config;
    let mut truth = belief.clone();
    differ(&mut truth);
    let imperfections = PlantParameters {
        friction: 0.2,
        motor_lag: 2e-3,
        load_cell_noise: 0.05,
        ..PlantParameters::default()
    };
    Bench::believing(truth, belief, imperfections).map_err(|error| error.to_string())
}

/// What is odd at the start is no fault: the rig is enabled, and hangs where the bridge believes.
fn starts(name: &str, words: &str) -> Result<Row, String> {
    let mut bench = bench()?;
    bench.suffer(words).map_err(|error| error.to_string())?;
    ensure(bench.start(), || format!("did not start: {:?}", bench.events.last()))?;
    let reports = bench.run(1.0);
    ensure(bench.bridge.state() == State::Enabled, || format!("ended: {:?}", bench.events.last()))?;
    let (believed, is) = (reports[reports.len() - 1].pose, bench.rig.plant().encoder_pose);
    let away = (believed.position() - is.position()).norm();
    ensure(away < 1e-3, || format!("the pose is wrong by {away} m"))?;
    finish(name, "goes on".to_owned(), [None, None], bench, "none".to_owned())
}

/// A cell that shows a load while nothing pulls is refused before torque.
fn loaded() -> Result<Row, String> {
    let mut bench = bench()?;
    bench.suffer("cell 4 says 40").map_err(|error| error.to_string())?;
    ensure(bench.run_until(State::Homing, 20.0), || "no start".to_owned())?;
    bench.run(0.1);
    let refusal = bench.bridge.operator(OperatorCommand::Home, bench.now);
    let refusal = refusal.err().ok_or("it was taken")?.to_string();
    bench.run(1.0);
    ensure(bench.rig.oldest_command() == 0, || "a motor pulled".to_owned())?;
    let name = "load cell shows a load with motors off";
    finish(name, "no torque at all".to_owned(), [None, None], bench, refusal)
}

/// A platform of another mass goes away from where it is led, or never comes.
fn off_course(name: &str, mass: f64) -> Result<Row, String> {
    let mut bench = bench_with(|truth| truth.rig.mass = mass)?;
    ensure(bench.start(), || format!("did not start: {:?}", bench.events.last()))?;
    bench.run(2.0);
    bench.go_to(0.1, 0.0, 1.0);
    ensure(bench.run_until(State::Fault, LONG), || format!("in {}", bench.bridge.state()))?;
    let fault = bench.bridge.fault().ok_or("no fault")?;
    ensure(matches!(fault, Fault::OffCourse { .. }), || format!("ended by {fault:?}"))?;
    finish(name, "off course".to_owned(), [None, None], bench, fault.to_string())
}

/// A motor that pulls five times as much is found while slack is taken up, with the platform on its stand.
fn geared() -> Result<Row, String> {
    let mut bench = bench_with(|truth| truth.drives[2].winch.gear = 5.0)?;
    ensure(!bench.start(), || "enabled".to_owned())?;
    ensure(bench.rig.support() == Support::Stand, || "the platform left its stand".to_owned())?;
    let fault = bench.events.iter().find_map(|(_, event)| match event {
        Event::Fault(fault) => Some(*fault),
        _ => None,
    });
    let fault = fault.ok_or("nothing was logged")?;
    ensure(matches!(fault, Fault::LoadCellDisagrees { cable: 3, .. }), || format!("ended by {fault:?}"))?;
    finish("gear of 5 for 1 at cable 3", "on its stand".to_owned(), [None, None], bench, fault.to_string())
}

/// 0.4 s into the paper's move.
fn moving() -> Result<Bench, String> {
    let mut bench = bench()?;
    ensure(bench.start(), || format!("did not start: {:?}", bench.events.last()))?;
    bench.run(1.0);
    bench.go_to(0.15, 0.15, 1.0);
    bench.run(0.4);
    bench.events.clear();
    Ok(bench)
}

/// What goes wrong does not stop the move, and no cable gets slack.
fn ridden_through(name: &str, words: &str) -> Result<Row, String> {
    let mut bench = moving()?;
    bench.suffer(words).map_err(|error| error.to_string())?;
    let reports = bench.run(LONG);
    ensure(bench.bridge.state() == State::Enabled, || format!("ended: {:?}", bench.events.last()))?;
    let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
    ensure(least > 0.0, || format!("smallest tension {least} N"))?;
    finish(name, "goes on".to_owned(), [None, None], bench, format!("none; smallest tension {least:.1} N"))
}

/// What goes wrong ends the controller's tensions within the stated cycles, and the safe output follows after its ramp.
fn ended(failure: &Failure) -> Result<Row, String> {
    let mut bench = moving()?;
    let period = bench.bridge.config().period;
    let ramp = bench.bridge.config().cycles(bench.bridge.config().safe.ramp);
    if !failure.words.is_empty() {
        bench.suffer(failure.words).map_err(|error| error.to_string())?;
    }
    (failure.once)(&mut bench);
    let mut cycles = 0;
    // A fault that is a late cycle has had its cycle already.
    let mut until = |bench: &mut Bench, is_there: fn(State) -> bool, most: u32| {
        while !is_there(bench.bridge.state()) && cycles <= most {
            (failure.every_cycle)(bench);
            bench.cycle();
            cycles += 1;
        }
        cycles
    };
    let ended = until(&mut bench, |state| state != State::Enabled, failure.cycles).max(1);
    let safe =
        until(&mut bench, |state| matches!(state, State::Safe | State::Fault | State::Off), ended + ramp);
    ensure(ended <= failure.cycles, || {
        format!("the controller's tensions went on for more than {} cycles", failure.cycles)
    })?;
    ensure(safe <= ended + ramp, || format!("no safe output {ramp} cycles after cycle {ended}"))?;
    for _ in 0..bench.bridge.config().cycles(1_000_000_000) {
        (failure.every_cycle)(&mut bench);
        bench.cycle();
    }
    let stopped = bench.events.iter().find_map(|(_, event)| match event {
        Event::Stopped(cause) => Some(*cause),
        _ => None,
    });
    let cause = stopped.ok_or("nothing was logged")?;
    ensure((failure.cause)(&cause), || format!("ended by {cause:?}"))?;
    let time = |cycles: u32| Some(u64::from(cycles) * period);
    let line = match cause {
        Cause::Fault(fault) => fault.to_string(),
        cause => format!("{cause:?}"),
    };
    let stated = format!("{} ms", u64::from(failure.cycles) * period / 1_000_000);
    finish(failure.name, stated, [time(ended), time(safe)], bench, line)
}

/// What is wrong before the first torque lets none come.
fn refused_at_start(name: &str, words: &str, is_expected: fn(&Fault) -> bool) -> Result<Row, String> {
    let mut bench = bench()?;
    bench.suffer(words).map_err(|error| error.to_string())?;
    ensure(!bench.start(), || "no fault".to_owned())?;
    let fault = bench.events.iter().find_map(|(_, event)| match event {
        Event::Fault(fault) => Some(*fault),
        _ => None,
    });
    let fault = fault.ok_or("nothing was logged")?;
    ensure(is_expected(&fault), || format!("ended by {fault:?}"))?;
    for command in [OperatorCommand::Home, OperatorCommand::Enable] {
        ensure(bench.bridge.operator(command, bench.now).is_err(), || format!("{command:?} was taken"))?;
    }
    bench.run(1.0);
    ensure(bench.rig.oldest_command() == 0, || "a motor pulled".to_owned())?;
    finish(name, "no torque at all".to_owned(), [None, None], bench, fault.to_string())
}

/// Without a bridge only the drives can act.
fn killed() -> Result<Row, String> {
    let mut bench = moving()?;
    let (killed, mut now) = (bench.now, bench.now);
    let watchdog = bench.bridge.config().heartbeat.drive_watchdog;
    let mut sent = vec![];
    while bench.rig.motor_tension() != [0.0; 6] {
        now += 1_000_000;
        bench.rig.tick(now, &mut sent);
        ensure(now - killed <= watchdog + 1_000_000, || "a motor still pulls".to_owned())?;
    }
    let time = Some(now - killed);
    let stated = format!("{} ms", watchdog / 1_000_000);
    Ok(Row {
        exit: None,
        ..row("kill -9", stated, [time, time], &bench, "none; EMCY 0x8130 of each drive".to_owned())
    })
}

/// Checks what holds in every case, ends the program and notes what was seen.
fn finish(
    name: &str,
    stated: String,
    times: [Option<Nanoseconds>; 2],
    mut bench: Bench,
    line: String,
) -> Result<Row, String> {
    let watchdog = bench.bridge.config().heartbeat.drive_watchdog;
    let period = bench.bridge.config().period;
    let oldest = bench.rig.oldest_command();
    ensure(oldest <= watchdog + period, || {
        format!("a motor followed a command for {} ms", oldest / 1_000_000)
    })?;
    let row = row(name, stated, times, &bench, line);
    bench.link.faults = Default::default();
    _ = bench.bridge.operator(OperatorCommand::Shutdown, bench.now);
    let down = come_down(&mut bench);
    ensure(bench.bridge.state() == State::Off, || format!("not off, but {}", bench.bridge.state()))?;
    let last = bench.cycle();
    bench.run(0.1);
    ensure(bench.rig.motor_tension() == [0.0; 6], || "a motor pulls after the end".to_owned())?;
    Ok(Row { exit: Some(if last.fault.is_some() { 5 } else { 0 }), down: down?, ..row })
}

/// Until the bridge is off: where the platform is then, and how fast it came there. With all drives at work that is its stand.
fn come_down(bench: &mut Bench) -> Result<String, String> {
    let begun = bench.now;
    // One that has left its mode is enabled, and pulls nothing.
    let pulls =
        |drive: &SimulatedDrive| drive.state() == DriveState::OperationEnabled && drive.tension() > 0.0;
    let is_whole = bench.rig.drives.iter().all(pulls);
    let mut landing = 0.0;
    while bench.bridge.state() != State::Off && bench.now - begun < DOWN {
        bench.cycle();
        if bench.rig.support() == Support::Cables {
            landing = bench.rig.plant().velocity.norm();
        }
    }
    let support = bench.rig.support();
    ensure(!is_whole || (support == Support::Stand && landing < LANDING), || {
        format!("it came down to {support:?} with {landing} m/s")
    })?;
    Ok(match support {
        Support::Stand if landing == 0.0 => "stands".to_owned(),
        Support::Stand => format!("stands, {landing:.2} m/s"),
        Support::Cables => "falls".to_owned(),
        Support::Floor => format!("on the floor, {landing:.2} m/s"),
    })
}

fn row(
    name: &str,
    stated: String,
    [ended, safe]: [Option<Nanoseconds>; 2],
    bench: &Bench,
    line: String,
) -> Row {
    let states = bench.rig.drives.iter().map(|drive| drive.state().to_string());
    let oldest = Some(bench.rig.oldest_command());
    Row {
        name: name.to_owned(),
        stated,
        ended,
        safe,
        oldest,
        drives: count(states),
        down: "-".to_owned(),
        exit: None,
        line,
    }
}
