//! Saved states in which something was changed and the checksum mended: what is taken up must be a state that a run can have left, or one from which all commands are
//! within the limits that it says, without a panic and in little time.

mod host;

use std::time::Duration;

use cable_robot_bindings::fmi3::Fmi3Library;
use rand::RngExt;
use rand_pcg::Pcg64;

use self::host::{DEFECT, Host};
use super::{Packed, night, packed, random_of, say_progress};

/// Before the payload: magic, format, token, length.
const LENGTH_AT: usize = 8 + 4 + 36;
const PAYLOAD_AT: usize = LENGTH_AT + 8;
const CHECKSUM: usize = 4;

/// Steps that a state that was taken up has to make.
const STEPS: usize = 3;
/// CPU time that no step may take, s: a plant in an extreme state makes 100,000 steps of integration before it gives up.
const SLOWEST: [f64; 2] = [0.5, 5.0];

const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// A run of the controller: what is set before it starts, its goal, what is set at a step of it, and how many it makes. The robot is where it is led.
struct Run {
    settings: &'static [(&'static str, f64)],
    goal: [f64; 6],
    then: &'static [(usize, &'static str, f64)],
    steps: usize,
}

const NEAR: [f64; 6] = [0.15, 0.15, 1.0, 0.0, 0.0, 0.0];
const TURNED: [f64; 6] = [0.1, 0.05, 1.1, 0.1, 0.0, 0.2];
const FAR: [f64; 6] = [3.0, 2.0, 0.9, 0.0, 0.0, 0.0];
const EXACT: (&str, f64) = ("plannerNumber", 2.0);
const FASTEST: (&str, f64) = ("plannerNumber", 3.0);

const RUNS: [Run; 12] = [
    Run { settings: &[], goal: NEAR, then: &[], steps: 200 },
    Run { settings: &[EXACT], goal: TURNED, then: &[], steps: 300 },
    Run { settings: &[FASTEST], goal: NEAR, then: &[], steps: 250 },
    Run { settings: &[FASTEST], goal: TURNED, then: &[], steps: 250 },
    Run { settings: &[FASTEST], goal: TURNED, then: &[(200, "goalPose.y", -0.1)], steps: 300 },
    Run { settings: &[FASTEST], goal: TURNED, then: &[(150, "encoderPose.z", 0.5)], steps: 160 },
    Run { settings: &[EXACT, ("forceLoop", 1.0)], goal: FAR, then: &[], steps: 60 },
    Run { settings: &[EXACT, ("commandDelay", 0.02)], goal: FAR, then: &[], steps: 52 },
    Run { settings: &[], goal: NEAR, then: &[(100, "encoderPose.z", 0.5)], steps: 120 },
    Run { settings: &[], goal: NEAR, then: &[(0, "encoderPose.z", 0.0)], steps: 2 },
    Run { settings: &[], goal: NEAR, then: &[(50, "enable", 0.0)], steps: 60 },
    Run {
        settings: &[EXACT, ("minTension", 1.0), ("maxTension", 60.0)],
        goal: NEAR,
        then: &[(120, "maxTension", 50.0), (125, "lambda", 4.0)],
        steps: 126,
    },
];

/// The states in which these runs end.
fn states_of_controllers(library: &Fmi3Library, packed: &Packed) -> Vec<Vec<u8>> {
    let end = |run: &Run| {
        let host = Host::new(library, packed);
        run.settings.iter().for_each(|(name, value)| host.set(name, *value));
        POSE.iter().zip(run.goal).for_each(|(axis, value)| host.set(&format!("goalPose.{axis}"), value));
        host.start();
        for k in 0..run.steps {
            for (_, name, value) in run.then.iter().filter(|(at, ..)| *at == k) {
                host.set(name, *value);
            }
            assert_eq!(host.step(), 0);
            for axis in POSE {
                let led = host.get(&format!("reference.{axis}"));
                host.set(&format!("encoderPose.{axis}"), led);
            }
        }
        host.saved()
    };
    RUNS.iter().map(end).collect()
}

/// Of plants without and with all that a rig's are not perfect in, in motion.
fn states_of_plants(library: &Fmi3Library, packed: &Packed) -> Vec<Vec<u8>> {
    let imperfect: &[(&str, f64)] =
        &[("friction", 1.0), ("motorLag", 0.02), ("encoderResolution", 1e-4), ("loadCellNoise", 0.1)];
    let end = |settings: &&[(&str, f64)]| {
        let host = Host::new(library, packed);
        settings.iter().for_each(|(name, value)| host.set(name, *value));
        host.start();
        host.set("motorTension[1]", 12.0);
        (0..50).for_each(|_| assert_eq!(host.step(), 0));
        host.saved()
    };
    [&[], imperfect].iter().map(end).collect()
}

/// Of plants for Model Exchange, without and with friction, in motion.
fn states_of_exchanges(library: &Fmi3Library, packed: &Packed) -> Vec<Vec<u8>> {
    let end = |friction: f64| {
        let host = Host::new(library, packed);
        host.set("friction", friction);
        host.set("motorTension[1]", 12.0);
        host.start();
        (0..50).for_each(|_| assert_eq!(host.step(), 0));
        host.saved()
    };
    [0.0, 1.0].map(end).into()
}

/// Numbers that stand where others should.
const NUMBERS: [f64; 10] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -3.6e91, -0.71, 0.0, 1e-320, 1e9, -1.0];

/// Changes a payload in one to three places, and mends what says that it was not.
fn mutate(random: &mut Pcg64, state: &mut Vec<u8>, other: &[u8]) {
    for _ in 0..random.random_range(1..=3) {
        let end = state.len() - CHECKSUM;
        let at = random.random_range(PAYLOAD_AT..end);
        match random.random_range(0..8) {
            0..=2 => state[at] ^= 1 << random.random_range(0..8),
            3 => state[at] = random.random(),
            4 | 5 if at + 8 <= end => {
                let number = match random.random_range(0..=NUMBERS.len()) {
                    k if k < NUMBERS.len() => NUMBERS[k],
                    _ => f64::from_bits(random.random()),
                };
                state[at..at + 8].copy_from_slice(&number.to_le_bytes());
            }
            6 if at + 8 <= end => {
                // One number for another of the same state, or of another state.
                let from = random.random_range(PAYLOAD_AT..other.len() - CHECKSUM - 8);
                state[at..at + 8].copy_from_slice(&other[from..from + 8]);
            }
            _ if random.random() => state.insert(at, random.random()),
            _ => drop(state.remove(at)),
        }
    }
    let end = state.len() - CHECKSUM;
    let length = ((end - PAYLOAD_AT) as u64).to_le_bytes();
    state[LENGTH_AT..PAYLOAD_AT].copy_from_slice(&length);
    let checksum = crc32fast::hash(&state[..end]).to_le_bytes();
    state[end..].copy_from_slice(&checksum);
}

fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// All commands are within the limits that the state says; while a change of these is pending, cables pull and do not push.
fn check_commands(host: &Host, case: u64) {
    let pending = host.integer("parametersPending") != 0;
    let [min, max] = ["minTension", "maxTension"].map(|name| host.get(name));
    for i in 1..=6 {
        let tension = host.get(&format!("motorTension[{i}]"));
        let kept =
            if pending { tension.is_finite() && tension >= 0.0 } else { min <= tension && tension <= max };
        assert!(kept, "case {case}: motorTension[{i}] = {tension} N, within {min} N and {max} N");
    }
}

fn run(model: &str, seed: u64, cases: u64) {
    let packed = packed(3, model);
    let library = unsafe { Fmi3Library::new(&packed.library) }.unwrap();
    let is_controller = model == "CableRobotController";
    let states = match model {
        "CableRobotController" => states_of_controllers(&library, &packed),
        "CableRobotPlantME" => states_of_exchanges(&library, &packed),
        _ => states_of_plants(&library, &packed),
    };
    let host = Host::new(&library, &packed);
    for (k, state) in states.iter().enumerate() {
        assert!(host.takes(state) && host.saved() == *state && host.step() == 0, "state {k}");
    }
    let (mut taken, mut steps, mut slowest) = (0, 0, (Duration::ZERO, 0));
    for case in 0..cases {
        say_progress(model, case, cases);
        let mut random = random_of(seed, case);
        let [mut state, other] = [0, 1].map(|_| states[random.random_range(0..states.len())].clone());
        mutate(&mut random, &mut state, &other);
        let takes = host.takes(&state);
        assert_eq!(DEFECT.take(), None, "case {case}");
        if !takes {
            continue;
        }
        taken += 1;
        for _ in 0..STEPS {
            let before = cpu_time();
            let status = host.step();
            slowest = slowest.max((cpu_time() - before, case));
            assert_eq!(DEFECT.take(), None, "case {case}");
            if status > 1 {
                break;
            }
            steps += 1;
            if is_controller {
                check_commands(&host, case);
            }
        }
    }
    let (time, case) = slowest;
    println!(
        "{model}, seed {seed}: {cases} states, {taken} taken up, {steps} steps; the slowest {time:?} in case {case}"
    );
    assert!(taken * 20 > cases, "hardly any is taken up");
    assert!(time.as_secs_f64() < SLOWEST[usize::from(!is_controller)], "case {case} took {time:?}");
}

#[test]
fn controllers_take_up_no_state_that_commands_what_they_may_not() {
    run("CableRobotController", 1, 80_000);
}

#[test]
fn plants_take_up_no_state_that_makes_them_panic() {
    run("CableRobotPlant", 1, 20_000);
}

#[test]
fn plants_for_model_exchange_take_up_no_state_that_makes_them_panic() {
    run("CableRobotPlantME", 1, 20_000);
}

#[test]
#[ignore = "ten million"]
fn night_of_controllers() {
    let (seed, cases) = night(10_000_000);
    run("CableRobotController", seed, cases);
}

#[test]
#[ignore = "ten million"]
fn night_of_plants() {
    let (seed, cases) = night(10_000_000);
    run("CableRobotPlant", seed, cases);
}

#[test]
#[ignore = "ten million"]
fn night_of_plants_for_model_exchange() {
    let (seed, cases) = night(10_000_000);
    run("CableRobotPlantME", seed, cases);
}
