//! States that are saved and put back, and instances beside each other.

use cable_robot_fmi::abi::{fmi2::*, fmi3::*, fmi3_values::*};
use cable_robot_fmi::{CO_SIMULATION, Model};

use crate::slave::{BOTH, ERROR, Fmi, OK, Slave, Three, Two};
use crate::{all_pairs, picture};

/// Something to see in a run of either model.
fn drive(slave: &Slave, from: u32, steps: u32) -> Vec<f64> {
    let mut trace = Vec::new();
    for i in from..from + steps {
        let wave = (0.01 * f64::from(i)).sin();
        match slave.model {
            Model::Controller => slave.set_reals(&[100, 118, 119], &[1e-3 * wave, 0.15, 0.1]),
            Model::Plant | Model::PlantExchange | Model::Node(_) => {
                slave.set_reals(&[100, 107], &[10.0 + wave, 0.2 * wave])
            }
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
        let theirs = Slave::running(fmi, CO_SIMULATION[usize::from(model == Model::Controller)]).save();
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
    for model in CO_SIMULATION {
        assert_eq!(drive(&noisy(Two, model, 5), 0, 200), drive(&noisy(Three, model, 5), 0, 200));
    }
}
