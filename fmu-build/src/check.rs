//! What a packed FMU must be: its description true, its library lean.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use cable_robot_fmi::{Model, Use};
use cable_robot_import::{Fmu, Instance};

use crate::library::cargo_home;
use crate::platforms::{GLIBC, Platform};
use crate::project_root;

/// Bytes that a packed FMU may have.
const LARGEST: u64 = 4_000_000;

/// Functions of C's mathematics library: they differ from platform to platform in the last digits.
const MATHEMATICS: [&str; 26] = [
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "exp", "exp2",
    "expm1", "fma", "fmod", "hypot", "log", "log10", "log1p", "log2", "pow", "sin", "sincos", "sinh", "tan",
    "tanh",
];

/// The library exports the functions of both standards and nothing else, and takes no mathematics from the platform.
pub fn symbols(library: &Path) -> Result<()> {
    let exported = listed(library, "--defined-only")?;
    let taken = listed(library, "--undefined-only")?;
    let mathematics: Vec<_> = MATHEMATICS.into_iter().filter(|name| taken.contains(*name)).collect();
    ensure!(mathematics.is_empty(), "the library takes from the platform {}", mathematics.join(", "));
    let bytes = fs::read(library)?;
    for folder in [project_root(), cargo_home()?].map(|folder| folder.display().to_string()) {
        let is_in_it = bytes.windows(folder.len()).any(|part| part == folder.as_bytes());
        ensure!(!is_in_it, "the library contains {folder}");
    }
    let standard = &declared("2.0", "FMI2_Export")? | &declared("3.0", "FMI3_Export")?;
    let list = |names: BTreeSet<String>| names.into_iter().collect::<Vec<_>>().join(", ");
    let (lacking, foreign) = (list(&standard - &exported), list(&exported - &standard));
    ensure!(lacking.is_empty(), "the library lacks {lacking}");
    ensure!(foreign.is_empty(), "the library also exports {foreign}");
    Ok(())
}

/// What a platform's library takes from it: no mathematics, of Linux an old C library, of Windows what every Windows has.
pub fn of_platform(platform: &Platform, library: &Path) -> Result<()> {
    if platform.is_windows() {
        return of_windows(library);
    }
    symbols(library)?;
    let text = output(Command::new("objdump").arg("-T").arg(library))?;
    let versions = text.split("GLIBC_").skip(1).filter_map(|rest| rest.split([')', ' ', '\n']).next());
    let number =
        |version: &str| version.split('.').filter_map(|part| part.parse().ok()).collect::<Vec<u32>>();
    let newest = versions.max_by_key(|version| number(version)).context("no version of the C library")?;
    ensure!(number(newest) <= number(GLIBC), "the library needs the C library {newest}; {GLIBC} is wanted");
    Ok(())
}

fn of_windows(library: &Path) -> Result<()> {
    const SYSTEM: [&str; 3] = ["kernel32.dll", "msvcrt.dll", "ntdll.dll"];
    let text = output(Command::new("x86_64-w64-mingw32-objdump").arg("-p").arg(library))?;
    let libraries = text.lines().filter_map(|line| line.trim().strip_prefix("DLL Name: "));
    let foreign = |name: &&str| {
        let name = name.to_lowercase();
        !SYSTEM.contains(&name.as_str()) && !name.starts_with("api-ms-win-core-")
    };
    let foreign: Vec<_> = libraries.filter(foreign).collect();
    ensure!(foreign.is_empty(), "the library needs {}", foreign.join(", "));
    let imported: BTreeSet<_> = text.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    let mathematics: Vec<_> = MATHEMATICS.into_iter().filter(|name| imported.contains(name)).collect();
    ensure!(mathematics.is_empty(), "the library takes from the platform {}", mathematics.join(", "));
    Ok(())
}

/// What a program of Debian's binutils writes.
pub fn output(command: &mut Command) -> Result<String> {
    let output = command.output().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    ensure!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).context("it writes no text")
}

/// Names, without versions, of the dynamic symbols of a kind.
fn listed(library: &Path, kind: &str) -> Result<BTreeSet<String>> {
    let text = output(Command::new("nm").args(["-D", kind]).arg(library))?;
    let names = text.lines().filter_map(|line| line.split_whitespace().last()?.split('@').next());
    Ok(names.map(str::to_owned).collect())
}

/// Names of the functions that the official header declares, on lines such as
/// `FMI3_Export fmi3ResetTYPE fmi3Reset;`.
fn declared(version: &str, export: &str) -> Result<BTreeSet<String>> {
    let header = project_root().join(format!("fmi-headers/{version}/fmi{}Functions.h", &version[..1]));
    let text = fs::read_to_string(&header).with_context(|| format!("cannot read {}", header.display()))?;
    let lines = text.lines().filter_map(|line| line.trim().strip_prefix(export)?.trim().strip_suffix(';'));
    let names: BTreeSet<_> =
        lines.filter_map(|line| line.split_whitespace().last()).map(str::to_owned).collect();
    ensure!(!names.is_empty(), "{} declares nothing with {export}", header.display());
    Ok(names)
}

/// The archive is small, and what its description declares is what its library has.
pub fn packed(path: &Path, model: Model) -> Result<()> {
    let size = fs::metadata(path)?.len();
    ensure!(size < LARGEST, "it has {size} bytes; {LARGEST} are allowed");
    if model.usage() != Use::CoSimulation {
        // Our importer is for co-simulation without events; fmpy's tests integrate and join the others.
        return Ok(());
    }
    let fmu = Fmu::open(path)?;
    let expected = path.file_stem().context("no file name")?.to_string_lossy();
    let identifier = &fmu.description().model_identifier;
    ensure!(*identifier == expected, "modelIdentifier is {identifier}, the file is called {expected}");
    // What it complains of stands in the error as well.
    let instance = fmu.instantiate("check", Box::new(|_| {}))?;
    instance.enter_initialization(0.0, None)?;
    starts_agree(&instance)?;
    instance.exit_initialization()?;
    // Reading with the function of the declared type fails if the library knows the variable as another.
    for variable in &fmu.description().variables {
        instance.get(instance.variable(&variable.name)?)?;
    }
    Ok(instance.terminate()?)
}

/// Every start value of the description is what the library starts with.
fn starts_agree(instance: &Instance) -> Result<()> {
    for variable in &instance.description().variables {
        let Some(start) = variable.start else { continue };
        let value = instance.get(instance.variable(&variable.name)?)?;
        if value != start {
            bail!("{} starts with {value} in the library, with {start} in the description", variable.name);
        }
    }
    Ok(())
}
