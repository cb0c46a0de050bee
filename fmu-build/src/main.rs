//! Packs the FMUs, runs the demo and every check of cable-robot.

mod bindings;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "fmu-build", about, version)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Regenerates src/fmi/bindings from the official FMI headers (needs libclang)
    Bindings {
        /// Compares with what is checked in and changes nothing
        #[arg(long)]
        check: bool,
    },
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Bindings { check } => bindings::run(check),
    }
}

/// The folder of the top level Cargo.toml.
fn project_root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("fmu-build lies in the project")
        .to_path_buf()
}
