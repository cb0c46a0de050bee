//! The host's floating-point environment: rounding, traps, flush-to-zero, and the flags of what has happened.
//!
//! A host may have set its own. Each call computes in the default one (round to nearest, nothing trapped, subnormal numbers as they are), so that it gives the
//! same bits in every host, and hands the host's back, flags included. Messages are logged in the default one too. x87's is never used: Rust computes in SSE.

use std::arch::asm;

/// What is computed in the default environment; afterwards the host's is as it was.
pub fn in_default_environment<T>(compute: impl FnOnce() -> T) -> T {
    let _host = Host::replace();
    outside_of_assembly(compute)
}

/// No arithmetic is moved out of here to where the environment is another.
#[inline(never)]
fn outside_of_assembly<T>(compute: impl FnOnce() -> T) -> T {
    compute()
}

/// The host's environment, for as long as it is replaced by the default one.
struct Host(Registers);

impl Host {
    fn replace() -> Self {
        let host = read();
        write(DEFAULT);
        Self(host)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        write(self.0);
    }
}

/// MXCSR: control and flags in one.
#[cfg(target_arch = "x86_64")]
type Registers = u32;
/// All exceptions masked.
#[cfg(target_arch = "x86_64")]
const DEFAULT: Registers = 0x1f80;

#[cfg(target_arch = "x86_64")]
fn read() -> Registers {
    let mut mxcsr = 0;
    // SAFETY: it is stored in a place for it.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut mxcsr, options(nostack)) };
    mxcsr
}

#[cfg(target_arch = "x86_64")]
fn write(mxcsr: Registers) {
    // SAFETY: a value that the register had, or the default, which has no reserved bit; Rust's arithmetic sees the default only.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const mxcsr, options(nostack)) };
}

/// FPCR and FPSR.
#[cfg(target_arch = "aarch64")]
type Registers = [u64; 2];
#[cfg(target_arch = "aarch64")]
const DEFAULT: Registers = [0; 2];

#[cfg(target_arch = "aarch64")]
fn read() -> Registers {
    let (control, flags);
    // SAFETY: both may be read always.
    unsafe {
        asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) flags, options(nostack));
    }
    [control, flags]
}

#[cfg(target_arch = "aarch64")]
fn write([control, flags]: Registers) {
    // SAFETY: values that the registers had, or the defaults; Rust's arithmetic sees the default only.
    unsafe { asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) flags, options(nostack)) };
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::hint::black_box;

    use super::*;

    /// Nothing masked, subnormal numbers are zero as operands and results, upwards, and a flag up.
    const HOSTILE: Registers = 1 << 15 | 1 << 6 | 2 << 13 | 0x20;

    fn third_and_subnormal() -> [f64; 4] {
        let [one, three, zero, nothing, small] = black_box([1.0, 3.0, 0.0, 0.0, f64::MIN_POSITIVE]);
        [one / three, small * one / three, one / zero, nothing / zero]
    }

    /// Division by zero, and of zero by zero, traps in this host.
    #[test]
    fn a_host_that_traps_gets_the_same_bits_and_its_environment_back() {
        let expected = third_and_subnormal().map(f64::to_bits);
        let usual = read();
        write(HOSTILE);
        let found = in_default_environment(third_and_subnormal);
        let after = read();
        write(usual);
        assert_eq!(after, HOSTILE);
        assert_eq!(found.map(f64::to_bits), expected);
        assert!(found[1] > 0.0 && found[1].is_subnormal());
    }
}
