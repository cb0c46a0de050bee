//! SocketCAN on a real kernel, in a virtual machine: `cargo verify` runs the tests in [`host`], which boot it once; it runs
//! this same executable inside for the tests in [`guest`].
//!
//! A further scenario is a script in `scenarios/`, with a test in [`host`] that judges its exit code and what it printed.
#![cfg(target_os = "linux")]

#[path = "../counting_allocator.rs"]
#[allow(unsafe_code, dead_code)]
mod counting_allocator;
mod guest;
mod guest_rig;
mod machine;

/// What these tests need.
const NEEDS: &str = "the tests in a virtual machine need the Debian packages \
                     qemu-system-x86 busybox-static can-utils cpio iproute2";

mod host {
    use std::collections::BTreeMap;
    use std::sync::OnceLock;

    use super::machine::{Machine, Outcome};
    use cable_robot_fieldbus::candump::Line;

    /// What became of a scenario; the machine is booted by the first test that asks.
    fn outcome(scenario: &str) -> &'static Outcome {
        static OUTCOMES: OnceLock<Result<BTreeMap<String, Outcome>, String>> = OnceLock::new();
        let outcomes = OUTCOMES.get_or_init(|| {
            let scripts = std::fs::read_dir(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../tests/programs/virtual_machine/scenarios"
            ))
            .unwrap();
            let machine = Machine {
                programs: vec![(std::env::current_exe().unwrap(), "virtual_machine")],
                scenarios: scripts.map(|entry| entry.unwrap().path()).collect(),
                ..Machine::default()
            };
            machine.run().map_err(|error| format!("{error:#}"))
        });
        &outcomes.as_ref().unwrap_or_else(|error| panic!("{error}"))[scenario]
    }

    #[test]
    #[ignore = "boots a virtual machine: cargo verify"]
    fn the_transport_does_in_a_real_kernel_what_it_says() {
        let Outcome { exit_code, lines } = outcome("transport");
        println!("{}", lines.join("\n"));
        assert_eq!(*exit_code, 0);
    }

    #[test]
    #[ignore = "boots a virtual machine: cargo verify"]
    fn the_log_of_candump_is_read_to_the_last_frame() {
        let Outcome { exit_code, lines } = outcome("candump");
        assert_eq!(*exit_code, 0);
        let frames: Vec<_> = lines.iter().map(|line| Line::parse(line).unwrap().frame.to_string()).collect();
        let sent = ["181#0011223344556677", "701#R1", "080#", "20000040#0000000000000000"];
        assert_eq!(frames, sent);
    }

    #[test]
    #[ignore = "boots a virtual machine: cargo verify"]
    fn a_scenario_that_fails_is_told_from_one_that_passes() {
        let Outcome { exit_code, lines } = outcome("failure");
        assert_eq!((*exit_code, lines.as_slice()), (3, &["about to fail".to_owned()][..]));
    }
}
