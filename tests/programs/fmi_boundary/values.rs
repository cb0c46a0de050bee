//! Values in and out: what is refused, and what follows from what.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use cable_robot_fmi::abi::{fmi2::*, fmi2_unsupported::*, fmi3::*, fmi3_buses::*, fmi3_values::*};
use cable_robot_fmi::variables::{ABOVE_ZERO, Causality, Kind};
use cable_robot_fmi::{CO_SIMULATION, Model};

use crate::slave::{BOTH, DISCARD, ERROR, Fmi, OK, Slave, Three, Two};
use crate::{all_pairs, in_state, picture, reals};

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

/// A disturbance of 1e160 N gave lengths of inf, a mass of 1e160 kg a margin of inf, with status OK.
#[test]
fn numbers_beyond_any_rig_give_no_infinite_result() {
    for (fmi, model) in all_pairs() {
        let outputs: Vec<u32> = reals(model, Causality::Output).into_iter().map(|(_, at)| at).collect();
        let set = [Causality::Parameter, Causality::Input].map(|causality| reals(model, causality));
        for (name, reference) in set.into_iter().flatten() {
            for value in [1e155, -1e160, 1e300, f64::MAX, f64::MIN] {
                let slave = Slave::new(fmi, model);
                assert_eq!(slave.set_reals(&[reference], &[value]), OK);
                let mut status = slave.enter(0.0, None);
                status = if status == OK { slave.exit() } else { status };
                for k in 0..5 {
                    if status != OK {
                        break;
                    }
                    let (read, results) = slave.get_reals(&outputs);
                    assert_eq!(read, OK);
                    assert!(results.iter().all(|x| x.is_finite()), "{name} = {value}: {results:?}");
                    status = slave.step(f64::from(k) * 0.01, 0.01);
                }
                assert!(status == OK || !slave.last_message().is_empty());
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
        (Three, |c| unsafe { fmi3GetInt32(c, &100, 1, &mut 0, 1) }),
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
    // An enumeration as Int32, as fmpy reads it up to 0.3.23.
    let (slave, mut status) = (Slave::running(Three, Model::Controller), 0);
    assert_eq!((unsafe { fmi3GetInt32(slave.instance, &228, 1, &mut status, 1) }, status), (OK, 4));
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

/// gemseo-fmu writes all parameters again before every step: that killed the instance.
#[test]
fn a_fixed_parameter_may_be_written_again_with_the_value_it_has() {
    for fmi in BOTH {
        let slave = Slave::logging(fmi, Model::Controller, true);
        assert_eq!(slave.set("m", 5.0), OK);
        assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
        slave.take_messages();
        for k in 0..3 {
            assert_eq!(slave.set("m", 5.0) + slave.step(1e-3 * f64::from(k), 1e-3), OK);
        }
        let messages = slave.take_messages();
        let said = messages.iter().filter(|(_, _, text)| text.contains("m was written again")).count();
        assert_eq!(said, 1, "{messages:?}");
        assert_eq!(slave.set("m", 6.0), ERROR);
        assert!(slave.last_message().contains("fixed parameter"), "{}", slave.last_message());
    }
}

/// 0 was within the range that the XML says, and refused.
#[test]
fn what_must_be_greater_than_zero_says_so() {
    for model in CO_SIMULATION {
        let interface = model.interface();
        for scalar in interface.scalars().filter(|scalar| scalar.row.causality == Causality::Parameter) {
            let Some(min) = scalar.row.min.filter(|_| matches!(scalar.row.kind, Kind::Float64)) else {
                continue;
            };
            let slave = Slave::new(Two, model);
            assert_eq!(slave.set(&scalar.name(), 0.0), OK);
            let is_refused = slave.enter(0.0, None) + slave.exit() != OK;
            assert_eq!(is_refused, min == ABOVE_ZERO, "{} = 0: {}", scalar.name(), slave.last_message());
        }
    }
}

/// ecospy and libcosimpy show no enumerations: planner, poseSource and status were out of reach.
#[test]
fn enumerations_can_be_had_as_numbers() {
    let number = |slave: &Slave, name: &str, value: i32| {
        let reference = slave.reference(name);
        unsafe {
            match slave.fmi {
                Two => fmi2SetInteger(slave.instance, &reference, 1, &value),
                Three => fmi3SetInt32(slave.instance, &reference, 1, &value, 1),
            }
        }
    };
    for fmi in BOTH {
        let start = |numbers: &[(&str, i32)]| {
            let slave = Slave::new(fmi, Model::Controller);
            for (name, value) in numbers {
                assert_eq!(number(&slave, name, *value), OK, "{}", slave.last_message());
            }
            let status = slave.enter(0.0, None).max(slave.exit());
            (slave, status)
        };
        // Exact makes for goals at another height, which Bounded calls unreachable.
        for (planner, status) in [(0, 5), (1, 5), (2, 3)] {
            let (slave, started) = start(&[("plannerNumber", planner)]);
            assert_eq!(started, OK);
            assert_eq!(slave.set("goalPose.z", 1.1) + slave.step(0.0, 1e-3), OK);
            assert_eq!(slave.get_number("status"), status, "planner {planner}");
            assert_eq!((slave.get_number("statusNumber"), slave.get_number("faultNumber")), (status, 1));
        }
        let (slave, started) = start(&[("plannerNumber", 2), ("planner", 2)]);
        assert_eq!(started, OK, "{}", slave.last_message());
        let (slave, started) = start(&[("plannerNumber", 1), ("planner", 2)]);
        let message = slave.last_message();
        assert!(started == ERROR && message.contains("plannerNumber = 1"), "{message}");
        assert!(message.contains("planner = 2 says otherwise"), "{message}");
        let (slave, started) = start(&[("poseSourceNumber", 3)]);
        let message = slave.last_message();
        assert!(started == ERROR && message.contains("must be 0 or from 1 to 2"), "{message}");
    }
}

/// Gains and limits were fixed for good once a simulation ran.
#[test]
fn gains_and_limits_change_between_steps_and_mass_does_not() {
    for fmi in BOTH {
        let slave = Slave::new(fmi, Model::Controller);
        assert_eq!(slave.set_enumeration("planner", 2) + slave.enter(0.0, None) + slave.exit(), OK);
        let pending = || slave.get_number("parametersPending");
        assert_eq!(slave.step(0.0, 1e-3), OK);
        assert_eq!(slave.set("lambda", 8.0) + slave.set("maxTension", 50.0), OK, "{}", slave.last_message());
        assert_eq!((slave.step(1e-3, 1e-3), pending()), (OK, 1));
        // A state between has it as well.
        let saved = slave.save();
        for k in 2..60 {
            assert_eq!(slave.step(f64::from(k) * 1e-3, 1e-3), OK);
        }
        assert_eq!((pending(), slave.get("lambda")), (0, 8.0));
        let there = picture(&slave);
        assert_eq!(slave.restore(&saved), OK);
        for k in 2..60 {
            assert_eq!(slave.step(f64::from(k) * 1e-3, 1e-3), OK);
        }
        assert_eq!(picture(&slave), there);
        assert_eq!(slave.set("m", 7.0), ERROR);
        assert!(slave.last_message().contains("fixed parameter"), "{}", slave.last_message());

        let slave = Slave::running(fmi, Model::Controller);
        assert_eq!(slave.set("eta", -1.0) + slave.step(0.0, 1e-3), ERROR);
        assert!(slave.last_message().contains("parameter eta = -1"), "{}", slave.last_message());
    }
}
