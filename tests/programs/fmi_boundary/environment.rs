//! The host's floating-point environment: what it has set does not change what is computed, and it has it again after each call.

use std::arch::asm;

use cable_robot_fmi::Model;

use crate::slave::{Fmi, OK, Slave};
use crate::{all_pairs, picture};

/// Nothing is trapped, rounding is to nearest, no flag is up.
const USUAL: u32 = 0x1f80;
/// Traps on invalid operations, divisions by zero, overflow, underflow and inexact results alike; subnormal numbers are zero; rounding is upwards; a flag is up.
const HOSTILE: u32 = FLUSH_TO_ZERO | DENORMALS_ARE_ZERO | ROUND_UP | 0x20;
const FLUSH_TO_ZERO: u32 = 1 << 15;
const DENORMALS_ARE_ZERO: u32 = 1 << 6;
const ROUND_UP: u32 = 2 << 13;

#[inline(never)]
fn mxcsr() -> u32 {
    let mut found = 0;
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut found, options(nostack)) };
    found
}

#[inline(never)]
fn set_mxcsr(to: u32) {
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const to, options(nostack)) };
}

/// A call of a host with this environment, and the environment after it.
#[inline(never)]
fn in_environment<T>(environment: u32, call: impl FnOnce() -> T) -> T {
    set_mxcsr(environment);
    let answer = call();
    let after = mxcsr();
    set_mxcsr(USUAL);
    assert_eq!(after, environment, "the host's environment is another after the call");
    answer
}

/// Numbers that were computed before, so that the host itself computes nothing in its environment.
fn run(fmi: Fmi, model: Model, environment: u32) -> Vec<f64> {
    let slave = Slave::new(fmi, model);
    let mut seen = vec![];
    in_environment(environment, || assert_eq!((slave.enter(0.0, None), slave.exit()), (OK, OK)));
    for k in 0..150 {
        let (time, h) = (f64::from(k) * 1e-3, 1e-3);
        match model {
            Model::Controller => slave.set_reals(&[100, 118, 119], &[1e-4 * time, 0.15, 0.1]),
            _ => slave.set_reals(&[100, 107], &[10.0 + time, 0.2]),
        };
        in_environment(environment, || assert_eq!(slave.step(time, h), OK));
        seen.extend(picture(&slave));
    }
    seen
}

/// A step of the planner raised FE_INVALID and FE_DIVBYZERO: a host that traps these got SIGFPE.
#[test]
fn a_host_that_traps_flushes_to_zero_and_rounds_upwards_gets_the_same_bits_and_its_environment_back() {
    for (fmi, model) in all_pairs() {
        let expected = run(fmi, model, USUAL);
        assert_eq!(run(fmi, model, HOSTILE), expected);
        // Without the flag, which would trap as soon as it is set with its trap on.
        assert_eq!(run(fmi, model, ROUND_UP), expected);
    }
}
