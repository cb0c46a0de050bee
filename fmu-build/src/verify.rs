//! `cargo verify`: every check and every test, and a table of what ran.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use crate::{foreign, interop, notices, pack, project_root, python, wheel};

/// What became of one stage.
struct Row {
    stage: &'static str,
    outcome: Outcome,
    took: Duration,
}

enum Outcome {
    /// With the number of tests, one for a check that is no test suite.
    Passed(usize),
    Failed(String),
    Skipped(&'static str),
}

type Stage = (&'static str, fn(&Path) -> Result<Outcome>);

/// In the order of what is quickest to tell.
const STAGES: [Stage; 9] = [
    ("rustfmt", |root| run(root, "cargo", &["fmt", "--all", "--check"])),
    ("clippy", |root| {
        run(root, "cargo", &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])
    }),
    ("documentation", |root| run(root, "cargo", &["doc", "--workspace", "--no-deps", "--quiet"])),
    ("bindings", bindings),
    ("licences", |_| notices::check().map(|()| Outcome::Passed(1))),
    ("FMUs", fmus),
    ("Rust tests", |root| run(root, "cargo", &["test", "--workspace", "--no-fail-fast"])),
    ("virtual machine", virtual_machine),
    ("Python tests", python_tests),
];

/// What the tests in a virtual machine take from Debian's packages qemu-system-x86, busybox-static, can-utils, cpio and
/// iproute2, beside Debian itself.
const VIRTUAL_MACHINE: [&str; 6] = [
    "/usr/bin/qemu-system-x86_64",
    "/bin/busybox",
    "/usr/bin/candump",
    "/usr/bin/cpio",
    "/sbin/tc",
    "/usr/bin/apt-get",
];

/// What takes longer.
const LONGER: [Stage; 8] = [
    ("FMUs, built again", built_again),
    ("wheel, released", |root| pytest(root, &wheel::build(true)?, &[OF_THE_WHEEL])),
    ("export", exported),
    ("C boundary, valgrind", under_valgrind),
    ("C boundary, ASan", under_address_sanitizer),
    ("platforms", |_| Ok(Outcome::Passed(foreign::compare()?))),
    ("wheel, portable", |root| pytest(root, &wheel::build_for_all()?, &[OF_THE_WHEEL])),
    ("tools of others", |_| Ok(Outcome::Passed(interop::try_all(false)?))),
];

/// Runs every stage, also after a failure, and fails if one did.
pub fn verify(all: bool) -> Result<()> {
    let root = project_root();
    let mut rows = vec![];
    let longer = LONGER.into_iter().filter(|_| all);
    for (stage, check) in STAGES.into_iter().chain(longer) {
        eprintln!("\n== {stage}");
        let start = Instant::now();
        let outcome = check(&root).unwrap_or_else(|error| Outcome::Failed(format!("{error:#}")));
        rows.push(Row { stage, outcome, took: start.elapsed() });
    }
    print_table(&rows);
    if rows.iter().any(|row| matches!(row.outcome, Outcome::Failed(_))) {
        bail!("not everything passed");
    }
    Ok(())
}

fn print_table(rows: &[Row]) {
    let (mut passed, mut failed, mut skipped) = (0, 0, 0);
    println!("\n{:<20} {:<8} {:>7} {:>8}", "stage", "result", "tests", "seconds");
    for Row { stage, outcome, took } in rows {
        let seconds = took.as_secs_f64();
        match outcome {
            Outcome::Passed(count) => {
                passed += count;
                println!("{stage:<20} {:<8} {count:>7} {seconds:>8.1}", "passed");
            }
            Outcome::Failed(why) => {
                failed += 1;
                println!("{stage:<20} {:<8} {:>7} {seconds:>8.1}  {why}", "FAILED", "");
            }
            Outcome::Skipped(why) => {
                skipped += 1;
                println!("{stage:<20} {:<8} {:>7} {seconds:>8.1}  {why}", "skipped", "");
            }
        }
    }
    println!("{passed} passed, {failed} failed, {skipped} skipped");
}

/// Runs a command in the project, shows its output, counts the tests it reports as passed, and names those that failed.
fn run(root: &Path, program: &str, arguments: &[&str]) -> Result<Outcome> {
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(root)
        .env("RUSTDOCFLAGS", "-D warnings")
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| format!("cannot start {program}"))?;
    let output = child.stdout.take().context("no output to read")?;
    let (mut tests, mut failed) = (0, String::new());
    for line in BufReader::new(output).lines() {
        let line = line?;
        println!("{line}");
        tests += tests_passed(&line);
        if let Some(test) = failed_test(&line) {
            failed += &format!("; {test}");
        }
    }
    let status = child.wait()?;
    Ok(if status.success() {
        Outcome::Passed(tests.max(1))
    } else {
        Outcome::Failed(format!("{program} {} ended with {status}{failed}", arguments.join(" ")))
    })
}

/// One command after the other, until one fails.
fn run_all<const N: usize>(root: &Path, commands: [(&str, Vec<&str>); N]) -> Result<Outcome> {
    let mut passed = 0;
    for (program, arguments) in commands {
        match run(root, program, &arguments)? {
            Outcome::Passed(tests) => passed += tests,
            other => return Ok(other),
        }
    }
    Ok(Outcome::Passed(passed))
}

/// The figure in `test result: ok. 12 passed; 0 failed` of cargo and `12 passed in 3.45s` of pytest.
fn tests_passed(line: &str) -> usize {
    let is_summary =
        line.starts_with("test result:") || line.contains(" passed in ") || line.contains(" passed, ");
    let mut words = line.split_whitespace().peekable();
    while let (true, Some(word)) = (is_summary, words.next()) {
        if words.peek().is_some_and(|next| next.trim_end_matches([',', ';']) == "passed") {
            return word.parse().unwrap_or(0);
        }
    }
    0
}

/// The tests of the C functions in a machine that watches memory: nothing is read that was not written, nothing is lost.
/// Of the floating-point environment this machine keeps the rounding only: what asks for traps and flushing to zero is left out.
fn under_valgrind(root: &Path) -> Result<Outcome> {
    const RUNNER: &str = "CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=valgrind --quiet --error-exitcode=9 \
                          --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite";
    let test = ["cargo", "test", "--package", "cable-robot-programs", "--test", "fmi_boundary"];
    let left_out = ["--", "--skip", "environment::a_host_that_traps"];
    run(root, "env", &[&[RUNNER], &test[..], &left_out].concat())
}

/// The same tests with AddressSanitizer in the code: nothing beyond what was allocated is read or written, nothing is used after it was freed. A stable compiler ships
/// the runtime for this target, and takes the option of nightly ones where RUSTC_BOOTSTRAP is set.
fn under_address_sanitizer(root: &Path) -> Result<Outcome> {
    const TARGET: &str = "x86_64-unknown-linux-gnu";
    let compiler = ["RUSTC_BOOTSTRAP=1", "RUSTFLAGS=-Zsanitizer=address"];
    let test = ["cargo", "test", "--package", "cable-robot-programs", "--test", "fmi_boundary"];
    let place = ["--target", TARGET, "--target-dir", "target/asan"];
    run(root, "env", &[&compiler[..], &test, &place].concat())
}

/// The generated bindings against the headers; libclang is the one thing that a user may lack, continuous integration may not.
fn bindings(root: &Path) -> Result<Outcome> {
    let status = Command::new("cargo").args(["bindings", "--check"]).current_dir(root).status()?;
    match status.code() {
        Some(3) if std::env::var_os("CI").is_none() => {
            Ok(Outcome::Skipped("libclang is not installed (Debian: libclang1-14)"))
        }
        Some(0) => Ok(Outcome::Passed(1)),
        _ => Ok(Outcome::Failed("cargo bindings --check".to_owned())),
    }
}

/// The transport and the rig on a kernel that has CAN; a user may lack what it takes, continuous integration may not.
fn virtual_machine(root: &Path) -> Result<Outcome> {
    let missing = VIRTUAL_MACHINE.iter().any(|program| !Path::new(program).exists());
    if missing && std::env::var_os("CI").is_none() {
        return Ok(Outcome::Skipped(
            "needs Debian's qemu-system-x86, busybox-static, can-utils, cpio and iproute2",
        ));
    }
    let suites = [&["virtual_machine", "host", "--", "--ignored"][..], &["fault_matrix", "--", "--ignored"]];
    // Of the workspace, whose features the tests before were compiled with.
    run_all(root, suites.map(|suite| ("cargo", [&["test", "--workspace", "--test"], suite].concat())))
}

/// Compiled, packed and checked.
fn fmus(root: &Path) -> Result<Outcome> {
    pack::build_everything_below(&root.join("target")).map(|_| Outcome::Passed(1))
}

/// Compiling and packing anew gives the same bytes.
fn built_again(root: &Path) -> Result<Outcome> {
    let read = |paths: &[PathBuf]| paths.iter().map(std::fs::read).collect::<Result<Vec<_>, _>>();
    let first = read(&pack::build_everything_below(&root.join("target"))?)?;
    let second = read(&pack::build_everything_below(&root.join("target/again"))?)?;
    ensure!(first == second, "two builds of the same sources differ");
    Ok(Outcome::Passed(1))
}

const TWO_AT_ONCE: [&str; 3] = ["--numprocesses=2", "--dist", "loadfile"];

/// The interpreter of [`python::of_tests`].
const PYTEST: &str = "target/python/bin/python";

/// The tests of the wheel alone.
const OF_THE_WHEEL: &str = "fmpy-tests/test_wheel.py";

/// A file of tests after the other on each of two cores; the wheel is not optimised.
fn python_tests(root: &Path) -> Result<Outcome> {
    let suites = ["fmpy-tests", "checker", "benches/peers"];
    pytest(root, &wheel::build(false)?, &[&TWO_AT_ONCE[..], &suites].concat())
}

/// pytest in an environment of its own, with this wheel.
fn pytest(root: &Path, wheel: &Path, arguments: &[&str]) -> Result<Outcome> {
    python::of_tests()?;
    let wheel = format!("CABLE_ROBOT_WHEEL={}", wheel.display());
    run(root, "env", &[&[&wheel, PYTEST, "-m", "pytest", "--quiet"], arguments].concat())
}

/// Runs as MCAP and Parquet, which the other stages do not build, read by the libraries of others.
fn exported(root: &Path) -> Result<Outcome> {
    const PACKAGES: [&str; 6] =
        ["--package", "cable-robot-report", "--package", "cable-robot-programs", "--features", "export"];
    let requirements = root.join("fmpy-tests/export/requirements.txt");
    let python = python::environment(&requirements, "tools/export")?.join("bin/python");
    let python = python.display().to_string();
    let steps = [
        ("cargo", [&["clippy"], &PACKAGES[..], &["--all-targets", "--", "-D", "warnings"]].concat()),
        ("cargo", [&["test"], &PACKAGES[..], &["--lib", "export"]].concat()),
        ("cargo", [&["build"], &PACKAGES[..], &["--bin", "cable-robot"]].concat()),
        (&python, vec!["-m", "pytest", "--quiet", "fmpy-tests/export/exported.py"]),
    ];
    run_all(root, steps)
}

/// The name in `test NAME ... FAILED` of cargo and `FAILED NAME - why` of pytest.
fn failed_test(line: &str) -> Option<&str> {
    let of_cargo = line.strip_prefix("test ").and_then(|rest| rest.strip_suffix(" ... FAILED"));
    let of_pytest =
        || line.strip_prefix("FAILED ").map(|rest| rest.split_once(" - ").map_or(rest, |(name, _)| name));
    of_cargo.map(str::trim_end).or_else(of_pytest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_of_cargo_and_pytest_are_counted() {
        assert_eq!(tests_passed("test result: ok. 12 passed; 0 failed; 0 ignored"), 12);
        assert_eq!(tests_passed("55 passed in 10.01s"), 55);
        assert_eq!(tests_passed("1 failed, 54 passed in 10.01s"), 54);
        assert_eq!(tests_passed("all tests passed today"), 0);
    }

    #[test]
    fn tests_that_failed_are_named() {
        assert_eq!(failed_test("test rig: cell (cangw)   ... FAILED"), Some("rig: cell (cangw)"));
        assert_eq!(
            failed_test("FAILED fmpy-tests/test_a.py::test_b - assert 1 == 2"),
            Some("fmpy-tests/test_a.py::test_b")
        );
        assert_eq!(failed_test("test rig: cell ... ok"), None);
        assert_eq!(failed_test("test result: FAILED. 6 passed; 1 failed"), None);
    }
}
