//! The paper's figures: what `cable-robot figure all` makes is what stands in docs/.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const NUMBERS: [u32; 7] = [2, 3, 5, 6, 7, 8, 9];
/// The curves may differ by this part of the greatest value in each: processors and C libraries round differently.
const TOLERANCE: f64 = 1e-3;

fn figure(which: &str, folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(["figure", which, "--output"])
        .arg(folder)
        .output()
        .unwrap()
}

/// The points of each series by panel and name, in their order.
fn series(path: &Path) -> BTreeMap<(String, String), Vec<[f64; 2]>> {
    let mut found: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for row in csv::Reader::from_path(path).unwrap().deserialize() {
        let (panel, name, x, y): (String, String, f64, f64) = row.unwrap();
        found.entry((panel, name)).or_default().push([x, y]);
    }
    found
}

#[test]
fn figures_are_those_of_the_documentation() {
    let folder = tempfile::tempdir().unwrap();
    let output = figure("all", folder.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let docs = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/figures"));
    for number in NUMBERS {
        let name = format!("figure-{number}.csv");
        let (made, kept) = (series(&folder.path().join(&name)), series(&docs.join(&name)));
        assert!(made.keys().eq(kept.keys()), "{name}: other series");
        for (key, made) in &made {
            let kept = &kept[key];
            assert_eq!(made.len(), kept.len(), "{name}, {key:?}");
            for k in [0, 1] {
                let greatest = kept.iter().fold(0.0, |greatest: f64, point| greatest.max(point[k].abs()));
                for (made, kept) in made.iter().zip(kept) {
                    let difference = (made[k] - kept[k]).abs();
                    assert!(difference <= TOLERANCE * greatest, "{name}, {key:?}: {made:?}, not {kept:?}");
                }
            }
        }
        assert!(docs.join(format!("figure-{number}.png")).exists());
    }

    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/paper.md")).unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let findings: Vec<_> = said.lines().filter(|line| line.starts_with("  ")).collect();
    assert!(findings.len() >= 2 * NUMBERS.len(), "{said}");
    for line in findings {
        assert!(page.contains(line.trim()), "docs/paper.md does not say: {line}");
    }
}

#[test]
fn pictures_are_pictures() {
    let folder = tempfile::tempdir().unwrap();
    assert!(figure("2", folder.path()).status.success());
    let png = fs::read(folder.path().join("figure-2.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let svg = fs::read_to_string(folder.path().join("figure-2.svg")).unwrap();
    for text in ["<svg", "damping ratio ξ", "Z_M = max x_s", "0.13534"] {
        assert!(svg.contains(text), "{text}");
    }
}

#[test]
fn a_figure_that_does_not_exist_or_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let output = figure("4", folder.path());
    assert_eq!(output.status.code(), Some(2));
    let file = folder.path().join("taken");
    fs::write(&file, "").unwrap();
    let output = figure("2", &file);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && error.contains("taken"), "{error}");
}
