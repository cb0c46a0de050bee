//! The Rust bindings of the official FMI headers, made with bindgen and checked in.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

/// Exit code where libclang is not installed.
const NO_LIBCLANG: u8 = 3;

/// Regenerates both binding files; with `--check` compares them with what is checked in and changes nothing.
fn main() -> Result<ExitCode> {
    if clang_sys::load().is_err() {
        eprintln!("libclang is not installed (Debian: libclang1-14)");
        return Ok(ExitCode::from(NO_LIBCLANG));
    }
    run(std::env::args().any(|argument| argument == "--check"))?;
    Ok(ExitCode::SUCCESS)
}

fn run(check: bool) -> Result<()> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    for (version, name) in [("2.0", "fmi2"), ("3.0", "fmi3")] {
        let file = root.join(format!("crates/bindings/src/{name}.rs"));
        let fresh = generate(&root.join("fmi-headers").join(version), name)?;
        if !check {
            std::fs::write(&file, fresh).with_context(|| format!("cannot write {}", file.display()))?;
            eprintln!("wrote {}", file.display());
        } else if std::fs::read_to_string(&file).unwrap_or_default() != fresh {
            bail!("{} differs from what the FMI headers give: run `cargo bindings`", file.display());
        }
    }
    Ok(())
}

/// One version's binding: types, constants, and a struct of function pointers loaded with libloading.
fn generate(headers: &Path, name: &str) -> Result<String> {
    let header = headers.join(format!("{name}Functions.h"));
    let loader = if name == "fmi2" { "Fmi2Library" } else { "Fmi3Library" };
    let mut builder = bindgen::Builder::default()
        .header(header.to_string_lossy())
        .allowlist_item(format!("{name}.*"))
        .dynamic_library_name(loader)
        .dynamic_link_require_all(false)
        .rust_target(bindgen::RustTarget::stable(85, 0).expect("a Rust version that bindgen knows"))
        .rust_edition(bindgen::RustEdition::Edition2024)
        .wrap_unsafe_ops(true)
        .layout_tests(false)
        .generate_comments(false)
        .formatter(bindgen::Formatter::Prettyplease);
    if let Some(include) = compiler_include() {
        builder = builder.clang_arg("-isystem").clang_arg(include.to_string_lossy());
    }
    let bindings =
        builder.generate().context("bindgen failed: is libclang installed (Debian: libclang1-14)?")?;
    Ok(bindings.to_string())
}

/// libclang without clang has no `stddef.h` of its own; gcc's serves.
fn compiler_include() -> Option<PathBuf> {
    let output = Command::new("gcc").arg("-print-file-name=include").output().ok()?;
    let path = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
    path.is_absolute().then_some(path)
}
