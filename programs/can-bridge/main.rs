//! `can-bridge`: the packed controller against the drives and load cells of a rig on a CAN bus (docs/can-bridge.md).

#[cfg(target_os = "linux")]
mod program;

#[cfg(target_os = "linux")]
fn main() -> std::process::ExitCode {
    program::main()
}

#[cfg(not(target_os = "linux"))]
fn main() -> std::process::ExitCode {
    eprintln!("can-bridge: CAN interfaces and adapters are opened on Linux only");
    std::process::ExitCode::FAILURE
}
