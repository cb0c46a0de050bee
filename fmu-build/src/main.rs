//! Packs the FMUs, runs the demo and every check of cable-robot.

mod check;
mod demo;
mod foreign;
mod interop;
mod library;
mod modelica;
mod notices;
mod pack;
mod platforms;
mod python;
mod rig_demo;
mod verify;
mod wheel;

use cable_robot_fmi::describe::Version;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "fmu-build", about, version)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Packs the FMUs, or writes their descriptions
    #[command(subcommand)]
    Fmu(FmuTask),
    /// Packs the FMUs, runs the paper's manoeuvre through them, by its chain and in minimum time; writes target/demo/comparison.html, report.html and run.csv
    Demo {
        /// Version of FMI
        #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
        fmi: u8,
        /// The paper's experiment through can-bridge and a simulated rig instead, in real time, into target/demo-rig
        #[arg(long)]
        rig: bool,
        /// Goes there and back for so long
        #[arg(long, requires = "rig")]
        minutes: Option<f64>,
        /// Cycles a second, instead of what the fieldbus file says
        #[arg(long, requires = "rig")]
        rate: Option<f64>,
    },
    /// Puts the Modelica package with its library into target/modelica
    Modelica {
        /// With libraries for x86_64 Linux (glibc 2.17) and Windows, into target/platforms/modelica; .ci/all installs what that takes
        #[arg(long)]
        all: bool,
    },
    /// Builds the Python package with the FMUs and the command cable-robot, into target/wheels
    Wheel {
        /// For older Linux (glibc 2.17), with the FMUs of `cargo fmu build --all`, into target/platforms/wheels; .ci/all installs what that takes
        #[arg(long, conflicts_with = "debug")]
        all: bool,
        /// Without optimisation, which compiles in less time: for tests
        #[arg(long)]
        debug: bool,
    },
    /// Tries the FMUs in the tools of others, and writes docs/interop.md
    Interop,
    /// Runs every check and every test
    Verify {
        /// And what takes longer: memory, all platforms, all tools of others
        #[arg(long)]
        all: bool,
    },
}

#[derive(Subcommand)]
enum FmuTask {
    /// Builds the library, packs the FMUs into target/fmu and checks them
    Build {
        /// With libraries for x86_64-linux (glibc 2.17), aarch64-linux and x86_64-windows, into target/platforms/fmu, but for the nodes on CAN buses; .ci/all installs what that takes
        #[arg(long)]
        all: bool,
    },
    /// Writes what ships in the FMUs to modelDescription/, where it can be read
    Describe,
    /// Writes the licences of what is linked into the FMUs, which ship with them, and checks those of every package that is built, with whatever features
    Notices,
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Fmu(FmuTask::Build { all }) => {
            let here = || pack::build_everything_below(&project_root().join("target"));
            for path in if all { pack::build_for_all()? } else { here()? } {
                println!("{}", path.display());
            }
            Ok(())
        }
        Task::Fmu(FmuTask::Describe) => pack::describe(),
        Task::Fmu(FmuTask::Notices) => {
            println!("{}", notices::write()?.display());
            Ok(())
        }
        Task::Demo { rig: true, minutes, rate, .. } => rig_demo::run(&rig_demo::Wishes { minutes, rate }),
        Task::Demo { fmi: 2, .. } => demo::run(Version::Fmi2),
        Task::Demo { .. } => demo::run(Version::Fmi3),
        Task::Modelica { all } => {
            let package = if all { modelica::build_for_all()? } else { modelica::build()? };
            println!("{}", package.display());
            Ok(())
        }
        Task::Wheel { all, debug } => {
            let wheel = if all { wheel::build_for_all()? } else { wheel::build(!debug)? };
            println!("{}", wheel.display());
            Ok(())
        }
        Task::Interop => {
            println!("{} cells", interop::try_all(true)?);
            Ok(())
        }
        Task::Verify { all } => verify::verify(all),
    }
}

/// The folder of the top level Cargo.toml.
fn project_root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("fmu-build lies in the project")
        .to_path_buf()
}
