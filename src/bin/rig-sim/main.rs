//! `rig-sim`: six drives, six load cells and the platform on a CAN bus, so that `can-bridge` can be tried without hardware.

#[cfg(target_os = "linux")]
mod port;
#[cfg(target_os = "linux")]
mod run;

#[cfg(target_os = "linux")]
fn main() -> anyhow::Result<()> {
    run::main()
}

#[cfg(not(target_os = "linux"))]
fn main() -> anyhow::Result<()> {
    anyhow::bail!("rig-sim needs Linux: its CAN links are those of Linux")
}
