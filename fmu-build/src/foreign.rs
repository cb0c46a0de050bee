//! The FMUs and `cable-robot` of all platforms, run here: under Wine, under QEMU, and as they are.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use cable_robot_fmi::CO_SIMULATION;
use cable_robot_fmi::describe::VERSIONS;

use crate::library::run;
use crate::platforms::{LINKER, PLATFORMS, Platform, folder};
use crate::{modelica, pack, project_root};

/// The bundled scenarios, and a move of eight cables, which FMUs of the paper's rig cannot make.
const SCENARIOS: [&str; 6] = ["paper", "experiment", "tour", "gust", "detour", "unreachable"];
const EIGHT: [&str; 6] = ["--rig", "rigs/eight.toml", "--to", "0.2,0.1,1.9,0.1,0,0.2", "--duration", "5"];

const WINE: &str = "/usr/lib/wine/wine64";
const QEMU: &str = "/usr/bin/qemu-aarch64";
const DEBIAN: &str = "needs Debian's wine64, qemu-user and libc6-arm64-cross: .ci/all installs them";

/// Packs the FMUs for all platforms, runs scenarios on each through the library and through both versions of the FMUs, and compares the runs byte for
/// byte with those of the library built for this machine alone. How many were compared.
pub fn compare() -> Result<usize> {
    pack::build_for_all()?;
    let pairs = VERSIONS.map(|version| {
        CO_SIMULATION.map(|model| pack::path_below(&folder(), model, version).to_string_lossy().into_owned())
    });
    let mut build = Command::new("cargo");
    build.args(["build", "--release", "--package", "cable-robot-programs", "--bin", "cable-robot"]);
    run(build.current_dir(project_root()), "building cable-robot")?;
    let native = |arguments: &[&str]| {
        simulated(&mut Command::new(project_root().join("target/release/cable-robot")), arguments)
    };
    let own = SCENARIOS.iter().map(|scenario| native(&[scenario])).collect::<Result<Vec<_>>>()?;
    let own_of_eight = native(&EIGHT)?;
    let mut compared = 0;
    for platform in &PLATFORMS {
        let program = platform.build_program("cable-robot-programs", "cable-robot")?;
        let mut same = |arguments: &[&str], own: &[u8]| -> Result<()> {
            let theirs = simulated(&mut launcher(platform, &program)?, arguments)?;
            compared += 1;
            ensure!(
                own == theirs,
                "{}: simulate {} gives other numbers",
                platform.target,
                arguments.join(" ")
            );
            Ok(())
        };
        same(&EIGHT, &own_of_eight)?;
        for (scenario, own) in SCENARIOS.iter().zip(&own) {
            same(&[scenario], own)?;
            for [controller, plant] in &pairs {
                // An emulated program cannot start itself.
                same(&[scenario, "--in-process", "--fmu", controller, "--fmu", plant], own)?;
            }
        }
    }
    modelica_under_wine()?;
    same_arithmetic()?;
    Ok(compared + 1 + PLATFORMS.len())
}

/// The functions and Taylor models of the certificates give the same bits on every platform, so what `checker/check_arithmetic.py` finds of them here holds there.
fn same_arithmetic() -> Result<()> {
    let mut build = Command::new("cargo");
    build.args(["build", "--release", "--package", "cable-robot", "--example", "arithmetic"]);
    run(build.current_dir(project_root()), "building the example arithmetic")?;
    let lines = |mut command: Command, kind: &str| -> Result<Vec<u8>> {
        let output = command.args([kind, "200000", "1"]).output()?;
        ensure!(output.status.success(), "{command:?} ended with {}", output.status);
        Ok(output.stdout)
    };
    for platform in &PLATFORMS {
        let program = platform.build_example("arithmetic")?;
        for kind in ["functions", "models"] {
            let own = lines(Command::new(project_root().join("target/release/examples/arithmetic")), kind)?;
            let theirs = lines(launcher(platform, &program)?, kind)?;
            ensure!(!own.is_empty() && own == theirs, "{}: other bits of {kind}", platform.target);
        }
    }
    Ok(())
}

/// The C harness of the Modelica package, which prints bits, says the same with the library for Windows as with that for Linux.
fn modelica_under_wine() -> Result<()> {
    let (package, root) = (modelica::build_for_all()?, project_root());
    let libraries = package.join("Resources/Library");
    let source = root.join("fmpy-tests/modelica");
    let compile = |compiler: &str, program: &Path, library: &str| {
        let mut command = Command::new(compiler);
        command.args(["-std=c11", "-D__USE_MINGW_ANSI_STDIO=1", "-I"]).arg(&source);
        command.arg("-I").arg(package.join("Resources/Include")).arg(source.join("harness.c"));
        command.arg("-o").arg(program).arg("-L").arg(libraries.join(library)).arg("-lCableRobot");
        run(&mut command, &format!("building {}", program.display()))
    };
    let [native, foreign] = ["harness", "harness.exe"].map(|name| folder().join(name));
    compile("gcc", &native, "linux64")?;
    compile(LINKER, &foreign, "win64")?;
    fs::copy(libraries.join("win64/CableRobot.dll"), folder().join("CableRobot.dll"))?;
    // A quarter of a second of a move, planned by `Exact`.
    let lines: String = (0..250)
        .map(|k| {
            let (time, x) = (f64::from(k) * 1e-3, f64::from(k) * 2e-4);
            format!("{time} 0.001 {x} {x} 1 0 0 0 0.15 0.1 1 0 0 0\n")
        })
        .collect();
    let answers = |target: &str, program: &Path| -> Result<Vec<u8>> {
        let platform =
            PLATFORMS.iter().find(|platform| platform.target == target).context("no such platform")?;
        let mut command = launcher(platform, program)?;
        command.args(["2", "3.0"]).env("LD_LIBRARY_PATH", libraries.join("linux64"));
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        child.stdin.take().context("no input")?.write_all(lines.as_bytes())?;
        let output = child.wait_with_output()?;
        ensure!(output.status.success(), "{} ended with {}", program.display(), output.status);
        // Windows ends lines in its own way.
        Ok(output.stdout.into_iter().filter(|byte| *byte != b'\r').collect())
    };
    let (wanted, found) =
        (answers("x86_64-unknown-linux-gnu", &native)?, answers("x86_64-pc-windows-gnu", &foreign)?);
    ensure!(!wanted.is_empty() && found == wanted, "the Modelica library for Windows gives other numbers");
    Ok(())
}

/// The rows of a run, as CSV.
fn simulated(command: &mut Command, arguments: &[&str]) -> Result<Vec<u8>> {
    let command = command.arg("simulate").args(arguments).current_dir(project_root());
    let output = command.output().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    // A goal that cannot be reached is no failure.
    ensure!(matches!(output.status.code(), Some(0 | 3)), "{command:?} ended with {}:\n{said}", output.status);
    ensure!(output.stdout.starts_with(b"time,"), "{command:?} wrote no rows:\n{said}");
    Ok(output.stdout)
}

/// What runs a program of a platform on this machine.
fn launcher(platform: &Platform, program: &Path) -> Result<Command> {
    let [mut wine, mut qemu] = [WINE, QEMU].map(Command::new);
    Ok(match platform.target.split('-').collect::<Vec<_>>()[..] {
        [_, "pc", "windows", _] => {
            ensure!(Path::new(WINE).exists(), DEBIAN);
            lend_random_numbers(program)?;
            wine.env("WINEPREFIX", folder().join("wine")).env("WINEDEBUG", "-all").arg(program);
            wine
        }
        ["aarch64", ..] => {
            ensure!(Path::new(QEMU).exists(), DEBIAN);
            qemu.args(["-L", "/usr/aarch64-linux-gnu"]).arg(program);
            qemu
        }
        _ => Command::new(program),
    })
}

/// Beside the program a library that this Wine lacks.
fn lend_random_numbers(program: &Path) -> Result<()> {
    let library: PathBuf = program.with_file_name("bcryptprimitives.dll");
    if fs::exists(&library)? {
        return Ok(());
    }
    let mut compile = Command::new(LINKER);
    compile.args(["-shared", "-O1", "-o"]).arg(library);
    compile.arg(project_root().join("fmu-build/platforms/bcryptprimitives.c")).arg("-ladvapi32");
    run(&mut compile, "building bcryptprimitives.dll")
}
