//! What the log says, and why there is no instance.

use std::ptr::{null, null_mut};

use cable_robot::robot::PerCable;
use cable_robot::sim::{Plant, PlantInputs, PlantParameters};
use cable_robot_fmi::abi::{fmi2::*, fmi3::*};
use cable_robot_fmi::{CO_SIMULATION, Model, Use};

use crate::slave::{BOTH, ERROR, Messages, OK, Slave, Three, Two, WARNING, callbacks, instantiate, log_3};

#[test]
fn a_percent_sign_in_a_message_is_one() {
    for fmi in BOTH {
        let messages = Messages::default();
        assert!(instantiate(fmi, Use::CoSimulation, "%s%n%d 100 %", false, &messages).is_null());
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
    let token = std::ffi::CString::new(Model::Plant.interface().token()).unwrap();
    let to = std::ptr::from_ref(&messages).cast_mut().cast();
    let callbacks = callbacks(&messages);
    unsafe {
        assert!(instantiate(Two, Use::CoSimulation, "nobody's", true, &messages).is_null());
        assert!(instantiate(Three, Use::CoSimulation, "nobody's", true, &messages).is_null());
        assert!(fmi2Instantiate(null(), 1, null(), null(), &callbacks, 0, 0).is_null());
        assert!(fmi2Instantiate(null(), 0, token.as_ptr(), null(), &callbacks, 0, 0).is_null());
        assert_eq!(messages.lock().unwrap().len(), 4);
        let [controller, plant] = CO_SIMULATION.map(Model::interface);
        for wanted in [controller.token(), plant.token(), "nobody's"] {
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
            Some(log_3),
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

/// A fault was a status and nothing else.
#[test]
fn a_fault_names_its_check_and_its_value() {
    for fmi in BOTH {
        let slave = Slave::logging(fmi, Model::Controller, true);
        assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
        assert_eq!(slave.step(0.0, 1e-3), OK);
        slave.take_messages();
        slave.set_reals(&[100], &[0.3]);
        assert_eq!(slave.step(1e-3, 1e-3) + slave.step(2e-3, 1e-3), OK);
        let messages = slave.take_messages();
        let warnings: Vec<_> = messages.iter().filter(|(_, c, _)| c == "logStatusWarning").collect();
        assert_eq!(warnings.len(), 1, "{messages:?}");
        let text = &warnings[0].2;
        assert!(text.contains("SensorFault at t = 0.001 s: encoderPose is 0.3000 m from where"), "{text}");
        assert!(text.contains("check PositionJump"), "{text}");
    }
}

/// A master that lets both step at once, or a motor that lags, cost what `holdCompensation` would have made up for, and nothing said so.
#[test]
fn commands_that_act_later_than_was_said_are_named_once() {
    for fmi in BOTH {
        for (is_late, said) in
            [(true, "commands act about 0.0010 s later than commandDelay = 0 s says"), (false, "")]
        {
            let slave = Slave::logging(fmi, Model::Controller, true);
            assert_eq!(slave.enter(0.0, None) + slave.exit(), OK);
            slave.set_reals(&[118, 119], &[0.1, 0.05]);
            let mut pull = PlantInputs::none(6);
            pull.motor_tension = tensions(&slave);
            let mut plant = Plant::new(PlantParameters::default(), &pull).unwrap();
            for k in 0..1000 {
                let pose = plant.outputs().encoder_pose;
                slave.set_reals(&[100, 101, 102, 103, 104, 105], pose.0.as_slice());
                let before = tensions(&slave);
                assert_eq!(slave.step(1e-3 * f64::from(k), 1e-3), OK);
                let now = tensions(&slave);
                pull.motor_tension = if is_late { before } else { now };
                plant.step(&pull, 1e-3).unwrap();
            }
            let messages = slave.take_messages();
            let found = messages.iter().filter(|(_, _, text)| text.contains("commandDelay"));
            let found: Vec<_> = found.map(|(_, _, text)| text).collect();
            assert_eq!(found.len(), usize::from(is_late), "{messages:?}");
            assert!(found.iter().all(|text| text.contains(said)), "{found:?}");
        }
    }
}

fn tensions(slave: &Slave) -> PerCable<f64> {
    PerCable::from_slice(&slave.get_reals(&[200, 201, 202, 203, 204, 205]).1).unwrap()
}
