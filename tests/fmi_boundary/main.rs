//! The C functions, called as an importer calls them: in order, out of order, and with everything wrong.
#![allow(unsafe_code, non_snake_case, reason = "this is the importer's side of a C interface")]

mod slave;

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use cable_robot::fmi::abi::{fmi2::*, fmi2_unsupported::*, fmi3::*, fmi3_unsupported::*, fmi3_values::*};
use cable_robot::fmi::variables::{Causality, Kind};
use cable_robot::fmi::{MODELS, Model};
use slave::{BOTH, DISCARD, ERROR, Fmi, Messages, OK, Slave, Three, Two, WARNING, callbacks, instantiate};

/// The scalars of type real with this causality: names and references.
fn reals(model: Model, causality: Causality) -> Vec<(String, u32)> {
    let rows = model.rows_with(causality).filter(|row| matches!(row.kind, Kind::Float64));
    rows.flat_map(|row| row.references().map(move |i| (row.scalar_name(i), i))).collect()
}

fn all_pairs() -> impl Iterator<Item = (Fmi, Model)> {
    BOTH.into_iter().flat_map(|fmi| MODELS.map(|model| (fmi, model)))
}

/// All reals that can be read, to see whether anything has changed.
fn picture(slave: &Slave) -> Vec<f64> {
    let all = [Causality::Parameter, Causality::Input, Causality::Output, Causality::Independent];
    let references: Vec<u32> = all
        .into_iter()
        .flat_map(|causality| reals(slave.model, causality))
        .map(|(_, reference)| reference)
        .collect();
    let (status, values) = slave.get_reals(&references);
    assert_eq!(status, OK, "{}", slave.last_message());
    values
}

/// A slave in the state with this letter: Instantiated, iNitialization, Step Mode, Terminated, Error.
fn in_state(letter: char, fmi: Fmi, model: Model) -> Slave {
    let slave = Slave::new(fmi, model);
    let ok = match letter {
        'I' => OK,
        'N' => slave.enter(0.0, None),
        'S' => slave.enter(0.0, None) + slave.exit(),
        'T' => slave.enter(0.0, None) + slave.exit() + slave.terminate(),
        _ => (slave.enter(0.0, None) + slave.exit() + slave.step(0.0, -1.0)).wrapping_sub(ERROR),
    };
    assert_eq!(ok, OK);
    slave
}

#[test]
fn every_call_is_allowed_exactly_where_the_standard_allows_it() {
    type Call = fn(&Slave) -> u32;
    let calls: [(&str, &str, &str, Call); 9] = [
        ("EnterInitializationMode|SetupExperiment", "I", "I", |s| s.enter(0.0, None)),
        ("ExitInitializationMode", "N", "N", |s| s.exit()),
        ("DoStep", "S", "S", |s| s.step(0.0, 1e-3)),
        ("Terminate", "S", "S", |s| s.terminate()),
        ("Reset", "INSTE", "INSTE", |s| s.reset()),
        ("SetReal|SetFloat64", "INS", "INS", |s| s.set_reals(&[100], &[1.0])),
        ("GetReal|GetFloat64", "NSTE", "INSTE", |s| s.get_reals(&[100]).0),
        ("SetDebugLogging", "INSTE", "INSTE", |s| s.set_debug_logging(true, &[])),
        ("FMUState", "INSTE", "INSTE", |s| s.restore(&s.save())),
    ];
    for (fmi, model) in all_pairs() {
        for (names, in_2, in_3, call) in calls {
            let allowed = if fmi == Two { in_2 } else { in_3 };
            for letter in "INSTE".chars() {
                let slave = in_state(letter, fmi, model);
                slave.take_messages();
                let status = call(&slave);
                if allowed.contains(letter) {
                    assert_eq!(status, OK, "{fmi:?} {names} in {letter}: {}", slave.last_message());
                } else {
                    let message = slave.last_message();
                    assert_eq!(status, ERROR, "{fmi:?} {names} in {letter}");
                    assert!(names.split('|').any(|name| message.contains(name)), "{message}");
                    assert!(message.contains("is not allowed in the state"), "{message}");
                    assert_eq!(slave.step(0.0, 1e-3), ERROR, "an error must not go unnoticed");
                    assert_eq!(slave.reset(), OK);
                    assert_eq!(slave.enter(0.0, None) + slave.exit() + slave.step(0.0, 1e-3), OK);
                }
            }
        }
    }
}

#[test]
fn what_is_not_supported_says_so() {
    for model in MODELS {
        let two = Slave::running(Two, model);
        let three = Slave::running(Three, model);
        let (c, i) = (two.instance, three.instance);
        let mut instants = (0usize, 0.0);
        let refused = unsafe {
            [
                fmi2CancelStep(c),
                fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut()),
                fmi2SetRealInputDerivatives(c, null(), 0, null(), null()),
                fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()),
                fmi2EnterEventMode(c),
                fmi2NewDiscreteStates(c, null_mut()),
                fmi2EnterContinuousTimeMode(c),
                fmi2SetTime(c, 0.0),
                fmi2GetDerivatives(c, &mut instants.1, 1),
                fmi3EnterEventMode(i),
                fmi3EnterStepMode(i),
                fmi3EnterConfigurationMode(i),
                fmi3ExitConfigurationMode(i),
                fmi3EvaluateDiscreteStates(i),
                fmi3EnterContinuousTimeMode(i),
                fmi3GetNumberOfContinuousStates(i, &mut instants.0),
                fmi3GetNumberOfVariableDependencies(i, 200, &mut instants.0),
                fmi3GetOutputDerivatives(i, null(), 0, null(), null_mut(), 0),
                fmi3GetClock(i, null(), 0, null_mut()),
                fmi3ActivateModelPartition(i, 0, 0.0),
            ]
        };
        assert!(refused.iter().all(|&status| status == ERROR), "{refused:?}");
        let messages = [two.take_messages(), three.take_messages()].concat();
        assert_eq!(messages.len(), refused.len());
        for (_, category, text) in messages {
            assert_eq!(category, "logStatusError");
            assert!(text.contains("is not supported: "), "{text}");
        }
    }
}

#[test]
fn no_real_takes_a_number_that_is_none() {
    for (fmi, model) in all_pairs() {
        for (causality, letter) in [(Causality::Input, 'S'), (Causality::Parameter, 'N')] {
            for (name, reference) in reals(model, causality) {
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let slave = in_state(letter, fmi, model);
                    let (before, saved) = (picture(&slave), slave.save());
                    // The first value of the call is good, and is not taken either.
                    assert_eq!(slave.set_reals(&[100, reference], &[0.25, bad]), ERROR);
                    let message = slave.last_message();
                    assert!(message.contains(&name) && message.contains("finite"), "{message}");
                    assert_eq!(picture(&slave), before);
                    assert_eq!(slave.restore(&saved), OK);
                    assert_eq!(slave.set_reals(&[reference], &[1.0]), OK);
                }
            }
        }
    }
}

#[test]
fn pointers_are_checked() {
    let mut value = 0.0;
    let (mut int, mut flag) = (0, true);
    for (fmi, model) in all_pairs() {
        let fresh = || Slave::running(fmi, model);
        let one = 100u32;
        unsafe {
            let statuses = match fmi {
                Two => [
                    fmi2GetReal(fresh().instance, null(), 1, &mut value),
                    fmi2GetReal(fresh().instance, &one, 1, null_mut()),
                    fmi2SetReal(fresh().instance, null(), 1, &value),
                    fmi2SetReal(fresh().instance, &one, 1, null()),
                    fmi2GetReal(fresh().instance, &one, usize::MAX, &mut value),
                    fmi2GetFMUstate(fresh().instance, null_mut()),
                    fmi2SetFMUstate(fresh().instance, null_mut()),
                    fmi2SerializeFMUstate(fresh().instance, null_mut(), null_mut(), 0),
                    fmi2DeSerializeFMUstate(fresh().instance, null(), 10, &mut null_mut()),
                    fmi2GetRealStatus(fresh().instance, 2, null_mut()),
                ],
                Three => [
                    fmi3GetFloat64(fresh().instance, null(), 1, &mut value, 1),
                    fmi3GetFloat64(fresh().instance, &one, 1, null_mut(), 1),
                    fmi3SetFloat64(fresh().instance, null(), 1, &value, 1),
                    fmi3SetFloat64(fresh().instance, &one, 1, null(), 1),
                    fmi3GetFloat64(fresh().instance, &one, 1, &mut value, usize::MAX),
                    fmi3GetFMUState(fresh().instance, null_mut()),
                    fmi3SetFMUState(fresh().instance, null_mut()),
                    fmi3SerializeFMUState(fresh().instance, null_mut(), null_mut(), 0),
                    fmi3DeserializeFMUState(fresh().instance, null(), 10, &mut null_mut()),
                    fmi3DoStep(
                        fresh().instance,
                        0.0,
                        1e-3,
                        true,
                        null_mut(),
                        &mut flag,
                        &mut flag,
                        &mut value,
                    ),
                ],
            };
            assert_eq!(statuses, [ERROR; 10], "{fmi:?}");
        }
        let slave = fresh();
        assert_eq!(slave.set_reals(&[], &[]), OK, "no values need no arrays");
        unsafe {
            let without = match fmi {
                Two => [
                    fmi2GetString(slave.instance, null(), 0, null_mut()),
                    fmi2GetInteger(slave.instance, null(), 0, null_mut()),
                    fmi2FreeFMUstate(slave.instance, &mut null_mut()),
                    fmi2SetDebugLogging(slave.instance, 1, 3, null()),
                ],
                Three => [
                    fmi3GetString(slave.instance, null(), 0, null_mut(), 0),
                    fmi3SetInt8(slave.instance, null(), 0, null(), 0),
                    fmi3FreeFMUState(slave.instance, &mut null_mut()),
                    fmi3SetDebugLogging(slave.instance, true, 3, null()),
                ],
            };
            assert_eq!(without, [OK; 4], "{fmi:?}");
        }
    }
    let none: *mut c_void = null_mut();
    unsafe {
        fmi2FreeInstance(none);
        fmi3FreeInstance(none);
        assert_eq!(fmi2DoStep(none, 0.0, 1.0, 0), ERROR);
        assert_eq!(fmi2GetInteger(none, &1, 1, &mut int), ERROR);
        assert_eq!(fmi3Reset(none), ERROR);
        assert_eq!(fmi3GetBoolean(none, &1, 1, &mut flag, 1), ERROR);
        assert_eq!(fmi2CancelStep(none), ERROR);
    }
}

#[test]
fn references_of_no_or_of_another_variable_are_refused() {
    for (fmi, model) in all_pairs() {
        for unknown in [99, 300, u32::MAX] {
            let slave = Slave::running(fmi, model);
            assert_eq!(slave.get_reals(&[100, unknown]).0, ERROR);
            assert!(
                slave.last_message().contains(&format!("value reference {unknown}")),
                "{}",
                slave.last_message()
            );
        }
        for (output, not_settable) in [(200, "an output"), (0, "time"), (1, "fixed parameter")] {
            let slave = Slave::running(fmi, model);
            assert_eq!(slave.set_reals(&[output], &[1.0]), ERROR);
            assert!(slave.last_message().contains(not_settable), "{}", slave.last_message());
        }
    }
    // A real read as an integer, an enumeration as a real, and types that no variable has.
    type Call = fn(*mut c_void) -> u32;
    let wrong: [(Fmi, Call); 6] = [
        (Two, |c| unsafe { fmi2GetInteger(c, &100, 1, &mut 0) }),
        (Two, |c| unsafe { fmi2GetReal(c, &228, 1, &mut 0.0) }),
        (Two, |c| unsafe { fmi2SetString(c, &100, 1, &null()) }),
        (Three, |c| unsafe { fmi3GetInt32(c, &228, 1, &mut 0, 1) }),
        (Three, |c| unsafe { fmi3GetFloat32(c, &100, 1, &mut 0.0, 1) }),
        (Three, |c| unsafe { fmi3SetBinary(c, &100, 1, null(), null(), 0) }),
    ];
    for (fmi, call) in wrong {
        let slave = Slave::running(fmi, Model::Controller);
        assert_eq!(call(slave.instance), ERROR);
        assert!(
            slave.last_message().contains("which this function does not handle"),
            "{}",
            slave.last_message()
        );
    }
    let slave = Slave::running(Three, Model::Plant);
    let (references, values) = ([100u32, 101], [1.0; 3]);
    assert_eq!(unsafe { fmi3SetFloat64(slave.instance, references.as_ptr(), 2, values.as_ptr(), 3) }, ERROR);
    assert!(slave.last_message().contains("length 3; right is 2"), "{}", slave.last_message());
}

#[test]
fn enumerations_and_booleans() {
    for fmi in BOTH {
        for bad in [0, 3, -1, 1 << 30] {
            let slave = Slave::new(fmi, Model::Controller);
            assert_eq!(slave.set_enumeration("poseSource", 2), OK);
            assert_eq!(slave.set_enumeration("poseSource", bad), ERROR);
            assert!(
                slave.last_message().contains("1 (EncoderPose), 2 (CableLengths)"),
                "{}",
                slave.last_message()
            );
        }
        let slave = Slave::new(fmi, Model::Controller);
        let enable = slave.reference("enable");
        unsafe {
            match fmi {
                // Any byte of C is a Boolean, not only 0 and 1.
                Three => assert_eq!(
                    fmi3SetBoolean(slave.instance, &enable, 1, std::ptr::from_ref(&2u8).cast(), 1),
                    OK
                ),
                Two => assert_eq!(fmi2SetBoolean(slave.instance, &enable, 1, &2), OK),
            }
        }
        assert_eq!(slave.enter(0.0, None), OK);
        assert_eq!(slave.get_enumeration("status"), 4, "at the goal");
        unsafe {
            match fmi {
                Three => assert_eq!(fmi3SetBoolean(slave.instance, &enable, 1, &false, 1), OK),
                Two => assert_eq!(fmi2SetBoolean(slave.instance, &enable, 1, &0), OK),
            }
        }
        assert_eq!(slave.get_enumeration("status"), 1, "disabled");
    }
}

#[test]
fn steps_that_are_none_are_refused() {
    for (fmi, model) in all_pairs() {
        for h in [0.0, -0.0, -1e-3, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let slave = Slave::running(fmi, model);
            let before = picture(&slave);
            assert_eq!(slave.step(0.0, h), ERROR, "h = {h}");
            assert!(slave.last_message().contains("communicationStepSize"), "{}", slave.last_message());
            assert_eq!(picture(&slave), before);
        }
        for point in [0.1, -0.1, f64::NAN, f64::INFINITY] {
            let slave = Slave::running(fmi, model);
            assert_eq!(slave.step(point, 1e-3), ERROR, "point = {point}");
            assert!(slave.last_message().contains("currentCommunicationPoint"), "{}", slave.last_message());
        }
        for (start, stop) in [(f64::NAN, None), (0.0, Some(f64::NAN)), (1.0, Some(0.5))] {
            assert_eq!(Slave::new(fmi, model).enter(start, stop), ERROR, "{start} {stop:?}");
        }
    }
}

/// FMPy issue 887: importers add and multiply step sizes, and 0.1 + 0.2 is not 0.3.
#[test]
fn communication_points_are_compared_with_a_tolerance() {
    for (fmi, model) in all_pairs() {
        let slave = Slave::running(fmi, model);
        assert_eq!(slave.step(0.0, 0.1), OK);
        assert_eq!(slave.step(0.1, 0.2), OK);
        assert_ne!(slave.get("time"), 0.3);
        assert_eq!(slave.step(0.3, 0.1), OK, "{}", slave.last_message());
        assert_eq!(slave.get("time"), 0.4);

        let slave = Slave::new(fmi, model);
        assert_eq!(slave.enter(0.0, Some(1.0)) + slave.exit(), OK);
        let mut time = 0.0;
        for _ in 0..10 {
            assert_eq!(slave.step(time, 0.1), OK, "{}", slave.last_message());
            time += 0.1;
        }
        assert_eq!(slave.step(time, 0.1), ERROR, "beyond the stop time");
        assert!(slave.last_message().contains("stopTime = 1"), "{}", slave.last_message());
    }
}

#[test]
fn outputs_follow_inputs_in_initialization_mode() {
    for fmi in BOTH {
        let controller = Slave::new(fmi, Model::Controller);
        controller.enter(0.0, None);
        assert_eq!(controller.get("setPoint.x"), 0.0);
        assert_eq!(controller.set("encoderPose.x", 0.05), OK);
        assert_eq!(controller.get("setPoint.x"), 0.05);
        let plant = Slave::new(fmi, Model::Plant);
        plant.set("initialPose.y", -0.1);
        plant.enter(0.0, None);
        assert_eq!(plant.get("encoderPose.y"), -0.1);
        assert_eq!(plant.set("motorTension[3]", 12.5), OK);
        assert_eq!(plant.get("measuredTension[3]"), 12.5);
        assert_eq!(plant.set("motorTension[3]", -5.0), OK);
        assert_eq!(plant.get("measuredTension[3]"), 0.0, "a cable does not push");
    }
}

#[test]
fn parameters_that_make_no_sense_are_named_and_can_be_mended() {
    for (fmi, model) in all_pairs() {
        for (name, value, allowed) in [("m", -1.0, "greater than 0"), ("b", 0.5, "smaller than the base")] {
            let slave = Slave::new(fmi, model);
            assert_eq!(slave.set(name, value), OK);
            slave.enter(0.0, None);
            let output = reals(model, Causality::Output)[0].1;
            assert_eq!(slave.get_reals(&[output]).0, DISCARD, "no outputs, but no harm done");
            assert!(slave.last_message().contains(allowed), "{}", slave.last_message());
            assert_eq!(slave.exit(), ERROR);
            let message = slave.last_message();
            assert!(message.contains(&format!("{name} = {value}")) && message.contains(allowed), "{message}");
            assert_eq!(slave.reset() + slave.enter(0.0, None) + slave.exit() + slave.step(0.0, 1e-3), OK);
        }
        let slave = Slave::new(fmi, model);
        slave.enter(0.0, None);
        assert_eq!(slave.set("m", -1.0), OK);
        assert_eq!(slave.get_reals(&[200]).0, DISCARD);
        assert_eq!(slave.set("m", 5.0), OK);
        assert_eq!(slave.get_reals(&[200]).0, OK);
        assert_eq!(slave.exit(), OK);
    }
}

#[test]
fn a_step_that_cannot_be_computed_changes_nothing() {
    for fmi in BOTH {
        let slave = Slave::running(fmi, Model::Plant);
        assert_eq!(slave.step(0.0, 0.01), OK);
        assert_eq!(slave.set("motorTension[1]", 1e300), OK);
        let (before, saved) = (picture(&slave), slave.save());
        assert_eq!(slave.step(0.01, 0.01), ERROR);
        assert!(slave.last_message().contains("motorTension"), "{}", slave.last_message());
        assert_eq!(picture(&slave), before);
        assert_eq!(slave.restore(&saved), OK);
        assert_eq!(slave.set("motorTension[1]", 10.0) + slave.step(0.01, 0.01), OK);
    }
}

/// Something to see in a run of either model.
fn drive(slave: &Slave, from: u32, steps: u32) -> Vec<f64> {
    let mut trace = Vec::new();
    for i in from..from + steps {
        let wave = (0.01 * f64::from(i)).sin();
        match slave.model {
            Model::Controller => slave.set_reals(&[100, 118, 119], &[1e-3 * wave, 0.15, 0.1]),
            Model::Plant => slave.set_reals(&[100, 107], &[10.0 + wave, 0.2 * wave]),
        };
        assert_eq!(slave.step(f64::from(i) * 1e-3, 1e-3), OK, "{}", slave.last_message());
        trace.extend(picture(slave));
    }
    trace
}

fn noisy(fmi: Fmi, model: Model, seed: i32) -> Slave {
    let slave = Slave::new(fmi, model);
    if model == Model::Plant {
        let reference = slave.reference("noiseSeed");
        slave.set_reals(&[14, 15, 17], &[0.1, 0.01, 0.2]);
        unsafe {
            match fmi {
                Two => fmi2SetInteger(slave.instance, &reference, 1, &seed),
                Three => fmi3SetInt32(slave.instance, &reference, 1, &seed, 1),
            };
        }
    }
    assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
    slave
}

#[test]
fn a_saved_state_continues_bit_for_bit_also_in_the_other_version() {
    for (fmi, model) in all_pairs() {
        let slave = noisy(fmi, model, 3);
        drive(&slave, 0, 100);
        let (bytes, state) = (slave.save(), slave.state());
        let first = drive(&slave, 100, 100);
        assert_eq!(slave.set_state(state), OK);
        assert_eq!(drive(&slave, 100, 100), first);
        for other in BOTH {
            let fresh = Slave::new(other, model);
            assert_eq!(fresh.restore(&bytes), OK);
            assert_eq!(drive(&fresh, 100, 100), first);
        }
        // A state that is there already is used again.
        let mut again = state;
        let status = unsafe {
            match fmi {
                Two => fmi2GetFMUstate(slave.instance, &mut again),
                Three => fmi3GetFMUState(slave.instance, &mut again),
            }
        };
        assert_eq!((status, again), (OK, state));
        let (status, latest) = slave.serialize(state, None);
        assert_eq!((status, &latest), (OK, &slave.save()));
        assert_eq!(slave.serialize(state, Some(latest.len() - 1)).0, ERROR);
        slave.free_state(state);
    }
}

#[test]
fn states_that_are_none_are_refused() {
    let mut random = 1u32;
    let mut next = move || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        random >> 8
    };
    for (fmi, model) in all_pairs() {
        let slave = Slave::running(fmi, model);
        let good = slave.save();
        let theirs = Slave::running(fmi, MODELS[1 - model as usize]).save();
        for round in 0..500 {
            let mut bytes = good.clone();
            match round % 4 {
                0 => bytes = (0..next() % 4000).map(|_| next() as u8).collect(),
                1 => bytes.truncate(next() as usize % good.len()),
                2 => bytes[next() as usize % good.len()] ^= 1 + (next() % 255) as u8,
                _ => bytes.extend([next() as u8; 3]),
            }
            assert_eq!(slave.restore(&bytes), ERROR);
            assert!(slave.last_message().contains("not a usable FMU state"), "{}", slave.last_message());
        }
        assert_eq!(slave.restore(&theirs), ERROR);
        assert_eq!(slave.restore(&good), OK);
        assert_eq!(slave.step(0.0, 1e-3), OK);
    }
}

#[test]
fn a_state_of_the_other_model_is_refused_without_being_touched() {
    for fmi in BOTH {
        let (controller, plant) = (Slave::running(fmi, Model::Controller), Slave::running(fmi, Model::Plant));
        let state = plant.state();
        assert_eq!(controller.set_state(state), ERROR);
        assert!(controller.last_message().contains("CableRobotPlant"), "{}", controller.last_message());
        plant.free_state(state);
    }
}

#[test]
fn instances_do_not_know_of_each_other() {
    for (fmi, model) in all_pairs() {
        let alone = [1, 2].map(|seed| drive(&noisy(fmi, model, seed), 0, 60));
        let (a, b) = (noisy(fmi, model, 1), noisy(fmi, model, 2));
        let mut together = [Vec::new(), Vec::new()];
        for i in 0..60 {
            together[0].extend(drive(&a, i, 1));
            together[1].extend(drive(&b, i, 1));
        }
        assert_eq!(together, alone);
        let runs: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..8).map(|i| scope.spawn(move || drive(&noisy(fmi, model, 1 + i % 2), 0, 60))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        for (i, run) in runs.iter().enumerate() {
            assert_eq!(run, &alone[i % 2]);
        }
    }
}

#[test]
fn both_versions_give_the_same_bits() {
    for model in MODELS {
        assert_eq!(drive(&noisy(Two, model, 5), 0, 200), drive(&noisy(Three, model, 5), 0, 200));
    }
}

#[test]
fn a_percent_sign_in_a_message_is_one() {
    for fmi in BOTH {
        let messages = Messages::default();
        assert!(instantiate(fmi, "%s%n%d 100 %", false, &messages).is_null());
        let text = messages.lock().unwrap()[0].2.clone();
        assert!(text.contains("%s%n%d 100 %"), "{text}");

        let slave = Slave::new(fmi, Model::Plant);
        assert_eq!(slave.set_debug_logging(false, &[c"%s%s%s%n".as_ptr(), null()]), WARNING);
        assert!(slave.last_message().contains("%s%s%s%n"), "{}", slave.last_message());
        assert!(
            slave.last_message().contains("logStatusError, logStatusDiscard"),
            "{}",
            slave.last_message()
        );
        assert_eq!(slave.enter(0.0, None), OK, "an unknown category does not stop anybody");
    }
}

#[test]
fn what_cannot_be_instantiated_says_why() {
    let messages = Messages::default();
    let token = std::ffi::CString::new(Model::Plant.token()).unwrap();
    let to = std::ptr::from_ref(&messages).cast_mut().cast();
    let callbacks = callbacks(&messages);
    unsafe {
        assert!(instantiate(Two, "nobody's", true, &messages).is_null());
        assert!(instantiate(Three, "nobody's", true, &messages).is_null());
        assert!(fmi2Instantiate(null(), 1, null(), null(), &callbacks, 0, 0).is_null());
        assert!(fmi2Instantiate(null(), 0, token.as_ptr(), null(), &callbacks, 0, 0).is_null());
        assert_eq!(messages.lock().unwrap().len(), 4);
        for wanted in [Model::Controller.token(), Model::Plant.token(), "nobody's"] {
            assert!(messages.lock().unwrap()[0].2.contains(wanted), "{wanted}");
        }
        assert!(messages.lock().unwrap()[3].2.contains("Co-Simulation only"));
        // Without callbacks, without names, without a place: nothing of it is needed.
        let two = fmi2Instantiate(null(), 1, token.as_ptr(), null(), null(), 0, 1);
        let three = fmi3InstantiateCoSimulation(
            null(),
            token.as_ptr(),
            null(),
            false,
            true,
            false,
            true,
            null(),
            0,
            null_mut(),
            None,
            None,
        );
        assert_eq!(fmi2DoStep(two, 0.0, 1.0, 0), ERROR);
        assert_eq!(fmi3Terminate(three), ERROR);
        assert_eq!((fmi2Reset(two), fmi3Reset(three)), (OK, OK));
        fmi2FreeInstance(two);
        fmi3FreeInstance(three);

        let (t, no) = (token.as_ptr(), null_mut());
        assert!(fmi3InstantiateModelExchange(null(), t, null(), false, false, no, None).is_null());
        assert!(
            fmi3InstantiateScheduledExecution(null(), t, null(), false, false, no, None, None, None, None)
                .is_null()
        );
        let with_events = fmi3InstantiateCoSimulation(
            null(),
            t,
            null(),
            false,
            false,
            true,
            false,
            null(),
            0,
            to,
            Some(slave::log_3),
            None,
        );
        assert!(with_events.is_null());
        assert!(messages.lock().unwrap().last().unwrap().2.contains("eventModeUsed must be false"));
    }
}

#[test]
fn warnings_and_events_come_with_logging_only_and_errors_always() {
    for fmi in BOTH {
        for on in [false, true] {
            let slave = Slave::logging(fmi, Model::Controller, on);
            assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
            slave.set_reals(&[118], &[0.15]);
            assert_eq!(slave.step(0.0, 1e-3) + slave.step(1e-3, 1e-3), OK);
            let messages = slave.take_messages();
            let has = |category: &str, text: &str| {
                messages.iter().any(|(status, c, t)| *status == OK && c == category && t.contains(text))
            };
            assert_eq!(has("logStatusWarning", "I3 = 0.075"), on, "{messages:?}");
            assert_eq!(has("logEvents", "initialised at t = 0 s"), on);
            assert_eq!(has("logEvents", "status changed from AtGoal to "), on);
            assert_eq!(messages.is_empty(), !on);
            assert_eq!(slave.step(0.0, -1.0), ERROR);
            assert_eq!(slave.take_messages().len(), 1);
        }
        let slave = Slave::new(fmi, Model::Controller);
        assert_eq!(slave.set_debug_logging(true, &[c"logEvents".as_ptr()]), OK);
        assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
        assert!(slave.take_messages().iter().all(|(_, category, _)| category == "logEvents"));
    }
}

#[test]
fn status_of_fmi_2_is_told_where_there_is_one() {
    let slave = Slave::running(Two, Model::Plant);
    assert_eq!(slave.step(0.0, 0.25), OK);
    let (mut time, mut ended, mut status) = (0.0, 1, 0);
    unsafe {
        assert_eq!((fmi2GetRealStatus(slave.instance, 2, &mut time), time), (OK, 0.25));
        assert_eq!((fmi2GetBooleanStatus(slave.instance, 3, &mut ended), ended), (OK, 0));
        assert_eq!(fmi2GetStatus(slave.instance, 0, &mut status), DISCARD);
        assert_eq!(fmi2GetStringStatus(slave.instance, 1, &mut null()), DISCARD);
        assert_eq!(fmi2GetIntegerStatus(slave.instance, 0, &mut 0), DISCARD);
    }
    assert!(slave.last_message().contains("never pending"), "{}", slave.last_message());
    assert_eq!(slave.step(0.25, 0.25), OK, "a discarded call does no harm");
}
