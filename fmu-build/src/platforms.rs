//! Libraries and programs for other machines than this one.
//!
//! All are compiled by one compiler, Debian's, with Rust's library from its sources. zig links those for Linux, against a C library as old as
//! the FMUs are to run with; Debian's MinGW those for Windows. Mathematics come from the crate libm, so all compute the same bits.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::{library, project_root, python};

/// A kind of machine.
pub struct Platform {
    /// Rust's name for it.
    pub target: &'static str,
    /// Its folders below `binaries/` in FMUs of FMI 2 and 3. FMI 2 has no name for Linux on other processors than x86.
    pub folders: [&'static str; 2],
    /// How shared libraries and programs end.
    pub library: &'static str,
    pub program: &'static str,
}

pub const PLATFORMS: [Platform; 3] = [
    Platform {
        target: "x86_64-unknown-linux-gnu",
        folders: ["linux64", "x86_64-linux"],
        library: ".so",
        program: "",
    },
    Platform {
        target: "aarch64-unknown-linux-gnu",
        folders: ["aarch64-linux", "aarch64-linux"],
        library: ".so",
        program: "",
    },
    Platform {
        target: "x86_64-pc-windows-gnu",
        folders: ["win64", "x86_64-windows"],
        library: ".dll",
        program: ".exe",
    },
];

/// The oldest C library of Linux that they run with.
pub const GLIBC: &str = "2.17";
/// What of Debian's it takes: compiler, its library's sources, the linker for Windows.
const COMPILER: &str = "/usr/bin/rustc";
const SOURCES: &str = "/usr/lib/rustlib/src/rust/library";
pub const LINKER: &str = "x86_64-w64-mingw32-gcc-win32";
const DEBIAN: &str =
    "needs Debian's rustc-web, rust-web-src and gcc-mingw-w64-x86-64-win32: .ci/all installs them";

impl Platform {
    pub fn is_windows(&self) -> bool {
        self.library == ".dll"
    }

    /// Builds the shared library of a package, which programs linked against it will look for under `name`; its path.
    pub fn build_library(&self, package: &str, name: &str) -> Result<PathBuf> {
        let link = format!("link-arg=-Wl,-soname,{name}");
        let link = if self.is_windows() { vec![] } else { vec!["-C", &link] };
        self.build(&["--package", package, "--lib", "--crate-type", "cdylib"], &link)?;
        let prefix = if self.is_windows() { "" } else { "lib" };
        Ok(self.built(&format!("{prefix}{}{}", package.replace('-', "_"), self.library)))
    }

    /// Builds a program; its path.
    pub fn build_program(&self, package: &str, program: &str) -> Result<PathBuf> {
        self.build(&["--package", package, "--bin", program], &[])?;
        Ok(self.built(&format!("{program}{}", self.program)))
    }

    /// Builds an example of the library; its path.
    pub fn build_example(&self, example: &str) -> Result<PathBuf> {
        self.build(&["--package", "cable-robot", "--example", example], &[])?;
        Ok(self.built(&format!("examples/{example}{}", self.program)))
    }

    fn built(&self, name: &str) -> PathBuf {
        folder().join(self.target).join("release").join(name)
    }

    fn build(&self, what: &[&str], link: &[&str]) -> Result<()> {
        ensure!(Path::new(COMPILER).exists() && Path::new(SOURCES).exists(), DEBIAN);
        let root = project_root();
        let mut flags = library::anonymous()?;
        let mut command = if self.is_windows() {
            // The time of linking is no part of it.
            flags.push("-Clink-arg=-Wl,--no-insert-timestamp".to_owned());
            let mut command = Command::new("cargo");
            command.env("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER", LINKER);
            command.args(["rustc", "--target", self.target]);
            command
        } else {
            let zig = zig()?;
            let mut command = Command::new(zig.join("cargo-zigbuild"));
            command.env("PATH", path_with(&zig));
            command.args(["rustc", "--target", &format!("{}.{GLIBC}", self.target)]);
            command
        };
        command
            .env("RUSTC", COMPILER)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"))
            .args(["-Zbuild-std=std,panic_unwind", "--release"])
            .args(what)
            .arg("--target-dir")
            .arg(folder())
            .args(["--", "-C", "strip=symbols"])
            .args(link)
            .current_dir(root);
        library::run(&mut command, &format!("building for {}", self.target))
    }
}

/// The programs of the environment that zig is in.
pub fn zig() -> Result<PathBuf> {
    let requirements = project_root().join("fmu-build/platforms/requirements.txt");
    Ok(python::environment(&requirements, "zig")?.join("bin"))
}

/// Where programs are looked for, in this folder first.
pub fn path_with(folder: &Path) -> String {
    format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default())
}

/// Where it all goes.
pub fn folder() -> PathBuf {
    project_root().join("target/platforms")
}
