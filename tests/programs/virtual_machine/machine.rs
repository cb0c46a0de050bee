//! A virtual machine with a kernel that has CAN, which most build machines lack: Debian's, under software emulation.
//!
//! The kernel package is downloaded and unpacked once, not installed. Everything else in the machine is copied from
//! this one: programs with the libraries that `ldd` names, scripts, other files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

/// What the machine loads, in this order; vcan plays back what it sends only after netem and tbf have had it.
const MODULES: [&str; 8] = [
    "net/can/can.ko",
    "net/can/can-raw.ko",
    "net/can/can-gw.ko",
    "drivers/net/can/dev/can-dev.ko",
    "drivers/net/can/vcan.ko echo=1",
    "drivers/net/can/slcan/slcan.ko",
    "net/sched/sch_netem.ko",
    "net/sched/sch_tbf.ko",
];

/// Programs of this machine that scenarios use beside busybox, whose own shell would prefer its own `ip` and `tc`.
const PROGRAMS: [&str; 8] = ["sh", "candump", "cansend", "cangen", "cangw", "slcand", "ip", "tc"];

/// What a scenario printed and how it ended.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Of the script.
    pub exit_code: i32,
    /// Standard output and error.
    pub lines: Vec<String>,
}

/// What is put into the machine.
#[derive(Default)]
pub struct Machine {
    /// Programs, with their name in the machine.
    pub programs: Vec<(PathBuf, &'static str)>,
    /// Other files, with their path in the machine.
    pub files: Vec<(PathBuf, &'static str)>,
    /// Shell scripts; each is a scenario named after its file and has the bus `vcan0` for itself.
    pub scenarios: Vec<PathBuf>,
}

impl Machine {
    /// Boots the machine, runs all scenarios and switches it off; the outcomes by scenario.
    pub fn run(&self) -> Result<BTreeMap<String, Outcome>> {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("virtual_machine");
        let kernel = Kernel::prepare(&directory)?;
        let image = directory.join("initrd");
        self.write_image(&kernel, &directory.join("root"), &image)?;
        let console = boot(&kernel.image, &image)?;
        fs::write(directory.join("console.log"), &console)?;
        let outcomes = outcomes(&console)?;
        ensure!(outcomes.len() == self.scenarios.len(), "the machine stopped early:\n{console}");
        Ok(outcomes)
    }

    /// Lays the files out in `root` and packs them.
    fn write_image(&self, kernel: &Kernel, root: &Path, image: &Path) -> Result<()> {
        if root.exists() {
            fs::remove_dir_all(root)?;
        }
        for directory in ["bin", "busybox", "dev", "modules", "proc", "scenarios", "sys"] {
            fs::create_dir_all(root.join(directory))?;
        }
        copy(
            Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/programs/virtual_machine/init.sh")),
            &root.join("init"),
        )?;
        copy(&find("busybox")?, &root.join("bin/busybox"))?;
        for program in PROGRAMS {
            copy_program(&find(program)?, program, root)?;
        }
        for (program, name) in &self.programs {
            copy_program(program, name, root)?;
        }
        for (file, to) in &self.files {
            copy(file, &root.join(to.trim_start_matches('/')))?;
        }
        for script in &self.scenarios {
            copy(script, &root.join("scenarios").join(script.file_name().context("a script")?))?;
        }
        let mut order = String::new();
        for module in MODULES {
            let (file, parameters) = module.split_once(' ').unwrap_or((module, ""));
            let name = Path::new(file).file_name().context("a module")?.to_string_lossy();
            copy(&kernel.modules.join(file), &root.join("modules").join(&*name))?;
            order += &format!("{name} {parameters}\n");
        }
        fs::write(root.join("modules/order"), order)?;
        let pack = format!("find . | cpio --quiet -o -H newc > '{}'", image.display());
        run(Command::new("sh").args(["-c", &pack]).current_dir(root))?;
        Ok(())
    }
}

/// An unpacked kernel package.
struct Kernel {
    image: PathBuf,
    /// The directory of its modules.
    modules: PathBuf,
}

impl Kernel {
    /// Finds it below `directory`, or downloads it; the `cloud` kernels have no CAN.
    fn prepare(directory: &Path) -> Result<Self> {
        let unpacked = directory.join("kernel");
        if !unpacked.exists() {
            let parts = directory.join("kernel.part");
            fs::create_dir_all(&parts)?;
            let depends = run(Command::new("apt-cache").args(["depends", "linux-image-amd64"]))?;
            let package = depends
                .lines()
                .find_map(|line| line.trim().strip_prefix("Depends: "))
                .context("apt knows no package linux-image-amd64: run apt-get update first")?;
            run(Command::new("apt-get").args(["download", package]).current_dir(&parts))?;
            let unpack = "dpkg-deb --fsys-tarfile *.deb | tar x ./boot ./lib/modules && rm *.deb";
            run(Command::new("sh").args(["-c", unpack]).current_dir(&parts))?;
            fs::rename(&parts, &unpacked)?;
        }
        let only = |directory: PathBuf, start: &str| -> Result<PathBuf> {
            let mut entries = fs::read_dir(&directory)?.flatten();
            let entry = entries.find(|entry| entry.file_name().to_string_lossy().starts_with(start));
            Ok(entry.with_context(|| format!("no {start} in {}", directory.display()))?.path())
        };
        Ok(Self {
            image: only(unpacked.join("boot"), "vmlinuz")?,
            modules: only(unpacked.join("lib/modules"), "")?.join("kernel"),
        })
    }
}

/// Runs the machine until it switches itself off; what its console showed.
fn boot(kernel: &Path, image: &Path) -> Result<String> {
    let console = run(Command::new("timeout")
        .args(["900", "qemu-system-x86_64", "-no-user-config", "-nodefaults", "-display", "none"])
        .args(["-no-reboot", "-accel", "tcg", "-m", "192M", "-serial", "stdio", "-append"])
        .arg("console=ttyS0 quiet loglevel=3 panic=-1")
        .arg("-kernel")
        .arg(kernel)
        .arg("-initrd")
        .arg(image))?;
    Ok(console.replace('\r', ""))
}

fn outcomes(console: &str) -> Result<BTreeMap<String, Outcome>> {
    let mut outcomes = BTreeMap::new();
    let mut outcome = Outcome::default();
    for line in console.lines() {
        if line.starts_with("@@ begin ") {
            outcome.lines.clear();
        } else if let Some((name, code)) = line.strip_prefix("@@ end ").and_then(|end| end.split_once(' ')) {
            outcome.exit_code = code.parse().with_context(|| format!("an exit code in {line:?}"))?;
            outcomes.insert(name.to_owned(), std::mem::take(&mut outcome));
        } else {
            outcome.lines.push(line.to_owned());
        }
    }
    Ok(outcomes)
}

/// Copies a program, without what only a debugger needs, and the libraries that it needs.
fn copy_program(program: &Path, name: &str, root: &Path) -> Result<()> {
    run(Command::new("strip").arg("-o").arg(root.join("bin").join(name)).arg(program))?;
    // Of a static program ldd says that it is none, and fails.
    let libraries = Command::new("ldd").arg(program).output().context("ldd")?;
    let libraries = String::from_utf8_lossy(&libraries.stdout).into_owned();
    for library in libraries.split_whitespace().filter(|word| word.starts_with('/')) {
        copy(Path::new(library), &root.join(&library[1..]))?;
    }
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to.parent().context("a path in the machine")?)?;
    fs::copy(from, to).with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
    Ok(())
}

/// The path of a program of this machine.
fn find(program: &str) -> Result<PathBuf> {
    let path = std::env::var("PATH").unwrap_or_default() + ":/usr/sbin:/sbin";
    let found =
        path.split(':').map(|directory| Path::new(directory).join(program)).find(|path| path.exists());
    found.with_context(|| format!("{program} is not installed; {}", super::NEEDS))
}

/// Runs a command to its end; what it printed.
fn run(command: &mut Command) -> Result<String> {
    let output = command
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("cannot run {command:?}; {}", super::NEEDS))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        bail!("{command:?}: {}\n{text}{}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    Ok(text)
}
