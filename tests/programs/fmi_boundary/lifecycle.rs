//! Which call is allowed when, and what a step may be.

use std::ptr::{null, null_mut};

use cable_robot_fmi::abi::{
    fmi2::*, fmi2_exchange::*, fmi2_unsupported::*, fmi3_buses::*, fmi3_exchange::*, fmi3_unsupported::*,
};
use cable_robot_fmi::{CO_SIMULATION, Model};

use crate::slave::{BOTH, DISCARD, ERROR, OK, Slave, Three, Two};
use crate::{all_pairs, in_state, picture};

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
    for model in CO_SIMULATION {
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
                fmi3SetClock(i, null(), 0, null()),
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

/// What it was not started for is discarded, and the master may make the step in parts.
#[test]
fn a_step_longer_than_the_largest_is_refused() {
    for fmi in BOTH {
        let slave = Slave::new(fmi, Model::Controller);
        assert_eq!(slave.set_enumeration("planner", 2) + slave.set("largestStep", 4e-3), OK);
        assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
        assert_eq!(slave.step(0.0, 4e-3), OK);
        let before = picture(&slave);
        assert_eq!(slave.step(4e-3, 5e-3), DISCARD);
        let message = slave.last_message();
        assert!(
            message.contains("0.005 s is too long") && message.contains("at most 4.000e-3 s"),
            "{message}"
        );
        assert_eq!(picture(&slave), before);
        assert_eq!(slave.step(4e-3, 4e-3), OK, "{}", slave.last_message());
        // (lambda + eta) times the step is 1 at most.
        let slave = Slave::new(fmi, Model::Controller);
        assert_eq!(slave.set_enumeration("planner", 2) + slave.set("lambda", 200.0), OK);
        assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
        assert_eq!(slave.step(0.0, 20e-3), DISCARD);
        assert!(slave.last_message().contains("at most 4.926e-3 s"), "{}", slave.last_message());
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
