//! `cargo interop`: the FMUs in the tools of others, and docs/interop.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::library::run;
use crate::{pack, project_root, python};

/// The scripts in fmpy-tests/interop and the file of what each needs there; most need no more than the other Python tests.
const TOOLS: [(&str, Option<&str>); 8] = [
    ("fmpy_now", None),
    ("fmpy_now", Some("fmpy-0.3.12")),
    ("ecos", None),
    ("cosim", None),
    ("toolbox", None),
    ("pathsim_fmi_tool", Some("pathsim-fmi")),
    ("cofmu", Some("cofmupy")),
    ("gemseo_fmu_tool", Some("gemseo-fmu")),
];

const ROWS: [&str; 8] = [
    "reads",
    "steps",
    "closes the loop",
    "saves a state",
    "Model Exchange",
    "terminals",
    "system",
    "system, closed",
];

/// What a tool could do: of each row, and there of each version of FMI, `yes`, `–` or `no` and why.
#[derive(Debug, Deserialize, Serialize)]
struct Column {
    tool: String,
    cells: BTreeMap<String, BTreeMap<String, String>>,
}

/// Tries all tools, and fails if one can do less than fmpy-tests/interop/expected.json says; how many cells there are. With `write` that file and
/// docs/interop.md are written anew.
pub fn try_all(write: bool) -> Result<usize> {
    let folder = project_root().join("fmpy-tests/interop");
    let work = packed()?;
    let columns = TOOLS.iter().map(|(script, needs)| column(&folder, script, *needs, &work));
    let columns = columns.collect::<Result<Vec<_>>>()?;
    refuse_others_too(&folder)?;
    let path = folder.join("expected.json");
    let expected: Vec<Column> = serde_json::from_str(&fs::read_to_string(&path)?)?;
    let lost: Vec<_> = expected.iter().flat_map(|before| lost(before, &columns)).collect();
    ensure!(lost.is_empty(), "less than before:\n{}", lost.join("\n"));
    if write {
        fs::write(&path, serde_json::to_string_pretty(&columns)? + "\n")?;
        let page = fs::read_to_string(folder.join("page.md"))?.replace("TABLE", &table(&columns));
        fs::write(project_root().join("docs/interop.md"), page)?;
    }
    Ok(columns.iter().flat_map(|column| column.cells.values()).map(BTreeMap::len).sum())
}

/// The folder with FMUs and systems of the paper's rig, and those with reals only.
fn packed() -> Result<std::path::PathBuf> {
    pack::build()?;
    let root = project_root();
    let work = root.join("target/interop");
    let mut build = Command::new("cargo");
    build.args(["build", "--package", "cable-robot-programs", "--bin", "cable-robot"]).current_dir(&root);
    run(&mut build, "building cable-robot")?;
    for (output, option) in [(work.clone(), "--ssp"), (work.join("reals"), "--reals")] {
        let mut fmu = Command::new(root.join("target/debug/cable-robot"));
        fmu.args(["fmu", "--rig", "rigs/paper.toml", option, "--output"]).arg(output).current_dir(&root);
        run(&mut fmu, "packing FMUs")?;
    }
    Ok(work)
}

fn column(folder: &Path, script: &str, needs: Option<&str>, work: &Path) -> Result<Column> {
    let environment = match needs {
        None => python::of_tests()?,
        Some(name) => {
            let requirements = folder.join(format!("requirements/{name}.txt"));
            python::environment(&requirements, &format!("tools/{name}"))?
        }
    };
    eprintln!("trying {script} in {}", environment.display());
    let mut python = Command::new(environment.join("bin/python"));
    let output = python.arg(folder.join(script).with_extension("py")).current_dir(work).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{script} ended with {}:\n{said}", output.status);
    let text = String::from_utf8(output.stdout)?;
    let line = text.lines().last().with_context(|| format!("{script} wrote nothing"))?;
    serde_json::from_str(line).with_context(|| format!("{script} wrote {line}"))
}

/// ecospy and libcosimpy refuse our system with inputs and outputs; so they do one with an FMU that somebody else made, gemseo-fmu's.
fn refuse_others_too(folder: &Path) -> Result<()> {
    let packages = project_root().join("target/tools/gemseo-fmu/lib");
    let version = fs::read_dir(&packages)?.next().context("no Python in the environment of gemseo-fmu")??;
    let foreign = version.path().join("site-packages/gemseo_fmu/problems/fmu_files/linux/ramp.fmu");
    let mut script = Command::new(python::of_tests()?.join("bin/python"));
    let output = script.arg(folder.join("foreign_system.py")).arg(foreign).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "the systems of others are not refused as ours are:\n{said}");
    Ok(())
}

/// What a tool could do, and now cannot.
fn lost(before: &Column, now: &[Column]) -> Vec<String> {
    let same = now.iter().find(|column| column.tool == before.tool);
    let mut lost = vec![];
    for (row, cells) in &before.cells {
        for (version, cell) in cells.iter().filter(|(_, cell)| *cell == "yes") {
            let now = same.and_then(|column| column.cells.get(row)?.get(version));
            if now != Some(cell) {
                lost.push(format!("{}, {row}, {version}: {now:?}", before.tool));
            }
        }
    }
    lost
}

fn table(columns: &[Column]) -> String {
    let mut lines =
        vec![format!("| tool | {} |", ROWS.join(" | ")), format!("|---|{}", "---|".repeat(ROWS.len()))];
    for column in columns {
        let cells = ROWS.map(|row| column.cells.get(row).map_or("–".to_owned(), cell));
        lines.push(format!("| {} | {} |", column.tool, cells.join(" | ")));
    }
    lines.join("\n")
}

/// Of both versions, in short where they are the same.
fn cell(of: &BTreeMap<String, String>) -> String {
    let get = |version: &str| of.get(version).map_or("–", String::as_str).trim_end_matches(':');
    match (get("fmi2"), get("fmi3")) {
        (two, three) if two == three => two.to_owned(),
        (two, "–") => format!("FMI 2: {two}"),
        ("–", three) => format!("FMI 3: {three}"),
        (two, three) => format!("FMI 2: {two}; FMI 3: {three}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(cell: &str) -> Column {
        let cells = BTreeMap::from([("fmi2".to_owned(), cell.to_owned())]);
        Column { tool: "a tool 1.0".to_owned(), cells: BTreeMap::from([("reads".to_owned(), cells)]) }
    }

    #[test]
    fn a_cell_that_turns_from_yes_to_no_or_goes_is_lost() {
        assert!(lost(&column("yes"), &[column("yes")]).is_empty());
        assert!(lost(&column("no: why"), &[column("yes")]).is_empty());
        assert_eq!(
            lost(&column("yes"), &[column("no: why")]),
            ["a tool 1.0, reads, fmi2: Some(\"no: why\")"]
        );
        assert_eq!(lost(&column("yes"), &[]).len(), 1);
    }
}
