//! What others wrote and the FMUs carry: their licences, checked, and their notices, in a file that every FMU has.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use crate::check::output;
use crate::platforms::PLATFORMS;
use crate::project_root;

/// Where it stands, and ships from.
const FILE: &str = "modelDescription/licenses/THIRD-PARTY.txt";

/// Licences that ask for no more than that their text goes along.
const ALLOWED: [&str; 11] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// How the names of files with licences and notices begin.
const NAMES: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "UNLICENSE", "NOTICE", "COPYRIGHT"];

const HEADERS: [&str; 2] = ["fmi-headers/2.0/fmi2Functions.h", "fmi-headers/3.0/fmi3Functions.h"];

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    license: Option<String>,
    authors: Vec<String>,
    manifest_path: PathBuf,
    /// `None` for what is in this project.
    source: Option<String>,
}

/// Writes the file.
pub fn write() -> Result<PathBuf> {
    let path = project_root().join(FILE);
    fs::write(&path, text()?).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}

/// Checks the licence of every package that is built, with whatever features, and that the file is the one of this lock file.
pub fn check() -> Result<()> {
    let written =
        fs::read_to_string(project_root().join(FILE)).with_context(|| format!("cannot read {FILE}"))?;
    ensure!(written == text()?, "{FILE} is not that of Cargo.lock: `cargo fmu notices` writes it");
    Ok(())
}

fn text() -> Result<String> {
    let packages = packages()?;
    for Package { name, version, license, .. } in packages.iter().filter(|package| package.source.is_some()) {
        let license = license.as_deref().unwrap_or("none");
        ensure!(
            is_allowed(license),
            "{name} {version} is under {license}; allowed are {}",
            ALLOWED.join(", ")
        );
    }
    let linked = linked()?;
    let of_others: Vec<&Package> = packages
        .iter()
        .filter(|package| package.source.is_some() && linked.contains(&package.id()))
        .collect();
    ensure!(!of_others.is_empty(), "`cargo tree` names no package");
    // The same text once, with all that it is the licence of.
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in of_others {
        for text in package.notices()? {
            let license = package.license.as_deref().unwrap_or_default();
            texts.entry(text).or_default().insert(format!("{} ({license})", package.id()));
        }
    }
    let mut parts = vec![HEAD.to_owned()];
    for header in HEADERS {
        parts.push(format!("FMI headers, {header}\n\n{}", licence_of(&project_root().join(header))?));
    }
    let mut crates: Vec<_> = texts.into_iter().map(|(text, of)| (of, text)).collect();
    crates.sort();
    for (of, text) in crates {
        let of: Vec<_> = of.into_iter().collect();
        parts.push(format!("{}\n\n{text}", of.join("\n")));
    }
    Ok(parts.join(&format!("\n{}\n\n", "-".repeat(80))))
}

const HEAD: &str = "\
The library in this FMU contains code of others, under these licences. What is under several is used under the one whose text stands here.

It also contains parts of the standard library of Rust, Copyright The Rust Project Contributors, MIT OR Apache-2.0: the texts of both licences
are in MIT.txt and Apache-2.0.txt beside this file.
";

impl Package {
    fn id(&self) -> String {
        format!("{} {}", self.name, self.version)
    }

    /// The texts in its sources: of several licences that of MIT, if it is one of them.
    fn notices(&self) -> Result<Vec<String>> {
        let folder = self.manifest_path.parent().context("a manifest is in a folder")?;
        let mut files = vec![];
        for entry in fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().to_uppercase();
            if entry.file_type()?.is_file() && NAMES.iter().any(|start| name.starts_with(start)) {
                files.push((name, entry.path()));
            }
        }
        files.sort();
        let has_mit = files.iter().any(|(name, _)| name.contains("MIT"));
        let is_other_licence = |name: &str| !name.contains("MIT") && !name.starts_with("NOTICE");
        files.retain(|(name, _)| !(has_mit && is_other_licence(name)));
        if files.is_empty() {
            let Self { authors, license, .. } = self;
            let license = license.as_deref().unwrap_or_default();
            return Ok(vec![format!(
                "Its package has no text of its licence, {license}, which is in MIT.txt or Apache-2.0.txt beside this file.\nAuthors: {}\n",
                authors.join(", ")
            )]);
        }
        let read = |(_, path): &(String, PathBuf)| {
            let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
            let lines: Vec<_> = text.trim().lines().map(str::trim_end).collect();
            Ok(lines.join("\n") + "\n")
        };
        files.iter().map(read).collect()
    }
}

fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(project_root());
    command
}

/// Of all programs and tests with all features, for the platforms that FMUs are made for.
fn packages() -> Result<Vec<Package>> {
    let mut command = cargo();
    command.args(["metadata", "--format-version", "1", "--locked", "--all-features"]);
    for platform in &PLATFORMS {
        command.args(["--filter-platform", platform.target]);
    }
    let metadata: Metadata = serde_json::from_str(&output(&mut command)?)?;
    // It also names what a dependency takes on other platforms only.
    let built = tree(&["--workspace", "--all-features", "--edges", "all"])?;
    Ok(metadata.packages.into_iter().filter(|package| built.contains(&package.id())).collect())
}

/// Names and versions of what is linked into the library of the FMUs, with the nodes on CAN buses.
fn linked() -> Result<BTreeSet<String>> {
    tree(&["--package", "cable-robot-fmi", "--features", "can", "--edges", "normal,no-proc-macro"])
}

/// Names and versions of what `cargo tree` shows of the platforms that FMUs are made for.
fn tree(arguments: &[&str]) -> Result<BTreeSet<String>> {
    let mut command = cargo();
    command.args(["tree", "--locked", "--prefix", "none", "--format", "{p}"]).args(arguments);
    for platform in &PLATFORMS {
        command.args(["--target", platform.target]);
    }
    let text = output(&mut command)?;
    let id = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{} {}", words.next()?, words.next()?.strip_prefix('v')?))
    };
    Ok(text.lines().filter_map(id).collect())
}

/// Whether one of the alternatives of an SPDX expression is allowed; `/` is what OR was before.
fn is_allowed(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ");
    let is_one = |license: &str| {
        let license = license.trim_matches(|character: char| " ()".contains(character));
        ALLOWED.contains(&license)
    };
    // `(A OR B) AND C`: every part needs an alternative.
    let parts: Vec<&str> = match expression.starts_with('(') || expression.ends_with(')') {
        true => expression.split(" AND ").collect(),
        false => vec![&expression],
    };
    parts.iter().all(|part| part.split(" OR ").any(|all| all.split(" AND ").all(is_one)))
}

/// What a header says of its copyright and licence, in the comment that it begins with.
fn licence_of(header: &Path) -> Result<String> {
    let text = fs::read_to_string(header).with_context(|| format!("cannot read {}", header.display()))?;
    let comment = text.split("*/").next().unwrap_or_default();
    let Some(found) = comment.find("Copyright").map(|begin| &comment[begin..]) else {
        bail!("{} has no copyright", header.display());
    };
    ensure!(found.contains("Redistribution"), "{} has no licence", header.display());
    let lines: Vec<_> = found.lines().map(str::trim).collect();
    Ok(lines.join("\n").trim().to_owned() + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_only_a_feature_builds_is_checked_too() {
        let packages = packages().unwrap();
        for name in ["mcap", "parquet"] {
            assert!(packages.iter().any(|package| package.name == name), "{name}");
        }
    }

    #[test]
    fn one_alternative_of_a_licence_must_be_allowed() {
        for good in [
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0 OR MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "Apache-2.0 AND MIT",
        ] {
            assert!(is_allowed(good), "{good}");
        }
        for bad in ["GPL-3.0", "MIT AND GPL-3.0", "(MIT OR Apache-2.0) AND GPL-3.0", "none", ""] {
            assert!(!is_allowed(bad), "{bad}");
        }
    }
}
