//! Model Exchange, called as an integrator calls it.

use cable_robot_bindings::fmi2::fmi2EventInfo;
use cable_robot_fmi::abi::{fmi2_exchange::*, fmi3_exchange::*};
use cable_robot_fmi::models::Scalar;
use cable_robot_fmi::variables::{Causality, Kind};
use cable_robot_fmi::{Model, Use};

use crate::slave::{BOTH, DISCARD, ERROR, Fmi, Messages, OK, Slave, Three, Two, instantiate};

const STATES: usize = 13;
/// Value references.
const MOTOR: u32 = 100;
const MEASURED: u32 = 218;
const POSITION: u32 = 600;
const OF_POSITION: u32 = 620;
const PULL: u32 = 640;

impl Slave {
    fn enter_events(&self) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2EnterEventMode(self.instance),
                Three => fmi3EnterEventMode(self.instance),
            }
        }
    }

    fn settle(&self) -> u32 {
        let no = fmi2EventInfo {
            newDiscreteStatesNeeded: 1,
            terminateSimulation: 1,
            nominalsOfContinuousStatesChanged: 1,
            valuesOfContinuousStatesChanged: 1,
            nextEventTimeDefined: 1,
            nextEventTime: 1.0,
        };
        let (mut info, mut flags, mut time) = (no, [true; 5], 1.0);
        let [a, b, c, d, e] = &mut flags;
        let status = unsafe {
            match self.fmi {
                Two => fmi2NewDiscreteStates(self.instance, &mut info),
                Three => fmi3UpdateDiscreteStates(self.instance, a, b, c, d, e, &mut time),
            }
        };
        let said = info.newDiscreteStatesNeeded + info.terminateSimulation + info.nextEventTimeDefined;
        assert!(status != OK || said == 0 || !flags.contains(&true));
        status
    }

    fn integrate(&self) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2EnterContinuousTimeMode(self.instance),
                Three => fmi3EnterContinuousTimeMode(self.instance),
            }
        }
    }

    fn set_time(&self, time: f64) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2SetTime(self.instance, time),
                Three => fmi3SetTime(self.instance, time),
            }
        }
    }

    fn set_states(&self, x: &[f64]) -> u32 {
        unsafe {
            match self.fmi {
                Two => fmi2SetContinuousStates(self.instance, x.as_ptr(), x.len()),
                Three => fmi3SetContinuousStates(self.instance, x.as_ptr(), x.len()),
            }
        }
    }

    fn array(&self, length: usize, two: Array, three: Array) -> (u32, Vec<f64>) {
        let mut x = vec![0.0; length];
        let get = if self.fmi == Two { two } else { three };
        (unsafe { get(self.instance, x.as_mut_ptr(), length) }, x)
    }

    fn states(&self) -> (u32, Vec<f64>) {
        self.array(STATES, fmi2GetContinuousStates, fmi3GetContinuousStates)
    }

    fn derivatives(&self) -> (u32, Vec<f64>) {
        self.array(STATES, fmi2GetDerivatives, fmi3GetContinuousStateDerivatives)
    }

    fn indicators(&self, length: usize) -> (u32, Vec<f64>) {
        self.array(length, fmi2GetEventIndicators, fmi3GetEventIndicators)
    }

    /// Sensitivities of the unknown variables.
    fn direction(&self, unknown: &[u32], known: &[u32], seed: &[f64]) -> (u32, Vec<f64>) {
        let mut out = vec![f64::NAN; unknown.len()];
        let (u, k, s, o) = (unknown.as_ptr(), known.as_ptr(), seed.as_ptr(), out.as_mut_ptr());
        let (n, m) = (unknown.len(), known.len());
        let status = unsafe {
            match self.fmi {
                Two => fmi2GetDirectionalDerivative(self.instance, u, n, k, m, s, o),
                Three => fmi3GetDirectionalDerivative(self.instance, u, n, k, m, s, m, o, n),
            }
        };
        (status, out)
    }

    /// Integrated at time 0.
    fn integrating(fmi: Fmi) -> Self {
        let slave = Self::running(fmi, Model::PlantExchange);
        assert_eq!(slave.settle() + slave.integrate(), OK, "{}", slave.last_message());
        slave
    }
}

type Array = unsafe extern "C" fn(*mut std::ffi::c_void, *mut f64, usize) -> u32;

/// Instantiated, iNitialization, eVent mode, Continuous-time mode, Terminated, Error.
fn in_state(letter: char, fmi: Fmi) -> Slave {
    if "CTE".contains(letter) {
        let slave = Slave::integrating(fmi);
        match letter {
            'T' => assert_eq!(slave.terminate(), OK),
            'E' => assert_eq!(slave.set_time(f64::NAN), ERROR),
            _ => {}
        }
        return slave;
    }
    let slave = Slave::new(fmi, Model::PlantExchange);
    let done = if letter == 'I' { OK } else { slave.enter(0.0, None) };
    assert_eq!(done + if letter == 'V' { slave.exit() } else { OK }, OK);
    slave
}

#[test]
fn every_call_is_allowed_exactly_where_the_standard_allows_it() {
    type Call = fn(&Slave) -> u32;
    let calls: [(&str, &str, Call); 11] = [
        ("NewDiscreteStates|UpdateDiscreteStates", "V", Slave::settle),
        ("EnterContinuousTimeMode", "V", Slave::integrate),
        ("EnterEventMode", "C", Slave::enter_events),
        ("SetTime", "VC", |s| s.set_time(0.1)),
        ("SetContinuousStates", "C", |s| s.set_states(&s.states().1)),
        ("GetContinuousStates", "NVCTE", |s| s.states().0),
        ("GetDerivatives|GetContinuousStateDerivatives", "NVCTE", |s| s.derivatives().0),
        ("GetEventIndicators", "NVCTE", |s| s.indicators(6).0),
        ("GetDirectionalDerivative", "NVCTE", |s| s.direction(&[OF_POSITION], &[603], &[1.0]).0),
        ("SetReal|SetFloat64", "INVC", |s| s.set_reals(&[MOTOR], &[1.0])),
        ("Terminate", "VC", |s| s.terminate()),
    ];
    for fmi in BOTH {
        for (names, allowed, call) in calls {
            for letter in "INVCTE".chars() {
                let slave = in_state(letter, fmi);
                slave.take_messages();
                let status = call(&slave);
                let message = slave.last_message();
                if allowed.contains(letter) {
                    assert_eq!(status, OK, "{fmi:?} {names} in {letter}: {message}");
                } else {
                    assert_eq!(status, ERROR, "{fmi:?} {names} in {letter}");
                    let is_named = names.split('|').any(|name| message.contains(name));
                    assert!(is_named && message.contains("is not allowed in the state"), "{message}");
                }
            }
        }
    }
}

#[test]
fn an_fmu_is_for_one_use_and_refuses_the_other_by_name() {
    let messages = Messages::default();
    for fmi in BOTH {
        for (usage, model) in [(Use::ModelExchange, Model::Plant), (Use::CoSimulation, Model::PlantExchange)]
        {
            assert!(instantiate(fmi, usage, model.interface().token(), false, &messages).is_null());
            let (_, _, text) = messages.lock().unwrap().pop().unwrap();
            assert!(text.contains(model.usage().refusal()), "{text}");
        }
        let slave = Slave::integrating(fmi);
        assert_eq!(slave.step(0.0, 1e-3), ERROR);
        assert!(slave.last_message().contains("Model Exchange only"), "{}", slave.last_message());
    }
}

#[test]
fn states_and_inputs_act_at_once_and_slackness_when_events_are_done() {
    for fmi in BOTH {
        let slave = Slave::integrating(fmi);
        let (_, mut x) = slave.states();
        assert_eq!((x[2], x[6]), (1.0, 1.0));
        // At rest: the start values of the motors hold the weight.
        assert!(slave.derivatives().1.iter().all(|rate| rate.abs() < 1e-9));
        x[3] = 0.25;
        assert_eq!(slave.set_states(&x) + slave.set_time(0.5), OK);
        assert_eq!(slave.get_reals(&[0, OF_POSITION]).1, [0.5, 0.25]);
        assert_eq!(slave.set_reals(&[MOTOR], &[-2.0]), OK);
        assert_eq!(
            (slave.indicators(6).1[0], slave.get_reals(&[PULL, MEASURED]).1),
            (-2.0, vec![-2.0, -2.0])
        );
        assert_eq!(slave.enter_events() + slave.settle() + slave.integrate(), OK);
        assert_eq!(slave.get_reals(&[PULL, MEASURED]).1, [-2.0, 0.0]);
        if fmi == Three {
            let mut numbers = [0; 2];
            let [states, indicators] = &mut numbers;
            unsafe {
                fmi3GetNumberOfContinuousStates(slave.instance, states);
                fmi3GetNumberOfEventIndicators(slave.instance, indicators);
            }
            assert_eq!(numbers, [STATES, 6]);
        }
    }
}

#[test]
fn states_that_are_no_numbers_or_not_as_many_are_refused_and_named() {
    for fmi in BOTH {
        let slave = Slave::integrating(fmi);
        let (_, good) = slave.states();
        for (k, name) in [(2, "state.position.z"), (6, "state.quaternion.w"), (12, "state.angularVelocity.z")]
        {
            let slave = Slave::integrating(fmi);
            let mut x = good.clone();
            x[k] = f64::NAN;
            assert_eq!(slave.set_states(&x), ERROR);
            assert!(slave.last_message().contains(&format!("{name} = NaN")), "{}", slave.last_message());
            assert_eq!(slave.states().1, good);
        }
        let mut no_rotation = good.clone();
        no_rotation[6] = 0.0;
        assert_eq!(slave.set_states(&no_rotation), OK);
        assert_eq!(slave.derivatives().0, DISCARD);
        assert!(slave.last_message().contains("der(state."), "{}", slave.last_message());
        assert_eq!(slave.direction(&[OF_POSITION + 6], &[POSITION + 6], &[1.0]).0, DISCARD);
        assert_eq!(slave.restore(&slave.save()), OK, "{}", slave.last_message());
        assert_eq!(slave.set_states(&good) + slave.derivatives().0, OK);
        let other = Slave::integrating(fmi);
        assert_eq!(other.direction(&[OF_POSITION], &[MOTOR], &[f64::INFINITY]).0, ERROR);
        assert!(other.last_message().contains("motorTension[1] = inf"), "{}", other.last_message());
        assert_eq!(slave.set_states(&good[1..]), ERROR);
        assert!(slave.last_message().contains("right is 13"), "{}", slave.last_message());
    }
}

#[test]
fn directional_derivatives_are_differences_in_the_limit() {
    const STEP: f64 = 1e-6;
    for fmi in BOTH {
        let slave = Slave::integrating(fmi);
        let start: Vec<f64> =
            slave.states().1.iter().zip(0..).map(|(x, k)| x + 0.01 * f64::from(k)).collect();
        let unknown: Vec<u32> = (200..206).chain(209..224).chain(OF_POSITION..OF_POSITION + 13).collect();
        for k in 0..STATES {
            let at = |by: f64| {
                let mut x = start.clone();
                x[k] += by;
                assert_eq!(slave.set_states(&x), OK);
                slave.get_reals(&unknown).1
            };
            let (after, before) = (at(STEP), at(-STEP));
            assert_eq!(slave.set_states(&start), OK);
            let (status, said) = slave.direction(&unknown, &[POSITION + k as u32], &[1.0]);
            assert_eq!(status, OK);
            for (i, said) in said.iter().enumerate() {
                let seen = (after[i] - before[i]) / (2.0 * STEP);
                assert!((said - seen).abs() < 1e-6 * (1.0 + seen.abs()), "{k} {}: {said} {seen}", unknown[i]);
            }
        }
        // Of cables with the same seed, half of it.
        let (_, one) = slave.direction(&[623, 630], &[MOTOR, 105], &[1.0, 1.0]);
        let (_, two) = slave.direction(&[623, 630], &[MOTOR, 105], &[0.5, 0.5]);
        assert_eq!(one, two.iter().map(|value| 2.0 * value).collect::<Vec<_>>());
        assert!(one[0] != 0.0);
        for (unknown, known, name) in
            [(POSITION, MOTOR, "state.position.x"), (PULL, 3, "m is no known variable")]
        {
            let slave = Slave::integrating(fmi);
            assert_eq!(slave.direction(&[unknown], &[known], &[1.0]).0, ERROR);
            assert!(slave.last_message().contains(name), "{}", slave.last_message());
        }
    }
}

/// InitialUnknowns name parameters, the initial pose and inputs: a derivative with respect to one of these ended the instance.
#[test]
fn in_initialization_mode_derivatives_with_respect_to_the_start_are_differences_in_the_limit() {
    const STEP: f64 = 1e-6;
    for fmi in BOTH {
        let slave = Slave::new(fmi, Model::PlantExchange);
        let interface = Model::PlantExchange.interface();
        assert_eq!(slave.enter(0.0, None) + slave.set("friction", 0.3), OK);
        let turned = [("x", 0.05), ("roll", 0.1), ("pitch", -0.2), ("yaw", 0.3)];
        for (name, value) in turned {
            assert_eq!(slave.set(&format!("initialPose.{name}"), value), OK);
        }
        let is_real = |scalar: &Scalar| matches!(scalar.row.kind, Kind::Float64);
        let references = |wanted: fn(Causality) -> bool| -> Vec<u32> {
            let scalars = interface.scalars().filter(|scalar| wanted(scalar.row.causality));
            scalars.filter(is_real).map(|scalar| scalar.reference).collect()
        };
        let unknown = references(|causality| matches!(causality, Causality::Output | Causality::Local));
        let known = references(|causality| matches!(causality, Causality::Parameter | Causality::Input));
        assert_eq!((unknown.len(), known.len()), (56, 26));
        for &known in &known {
            let (_, start) = slave.get_reals(&[known]);
            let at = |by: f64| {
                assert_eq!(slave.set_reals(&[known], &[start[0] + by]), OK);
                slave.get_reals(&unknown).1
            };
            let step = if known == slave.reference("friction") { 0.0 } else { STEP };
            let (after, before) = (at(step), at(-step));
            assert_eq!(slave.set_reals(&[known], &start), OK);
            let (status, said) = slave.direction(&unknown, &[known], &[1.0]);
            assert_eq!(status, OK, "{}", slave.last_message());
            for (i, said) in said.iter().enumerate() {
                let seen = (after[i] - before[i]) / (2.0 * STEP);
                assert!(
                    (said - seen).abs() < 1e-6 * (1.0 + seen.abs()),
                    "{known} {}: {said} {seen}",
                    unknown[i]
                );
            }
        }
        assert_eq!(slave.exit(), OK);
    }
}

#[test]
fn a_state_saved_between_events_goes_on_bit_for_bit_in_the_other_version() {
    let slave = Slave::integrating(Two);
    let (_, mut x) = slave.states();
    (x[0], x[5], x[11]) = (0.1, 0.2, 0.3);
    assert_eq!(slave.set_states(&x) + slave.set_reals(&[MOTOR, 107], &[-1.0, 2.0]) + slave.set_time(0.3), OK);
    let other = Slave::new(Three, Model::PlantExchange);
    assert_eq!(other.restore(&slave.save()), OK, "{}", other.last_message());
    assert_eq!(other.derivatives(), slave.derivatives());
    assert_eq!(
        (other.indicators(6), other.get_reals(&[0, MEASURED])),
        (slave.indicators(6), slave.get_reals(&[0, MEASURED]))
    );
    assert_eq!(other.enter_events() + other.settle(), OK);
}
