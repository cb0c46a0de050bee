//! The hand-written pages keep to their budgets of words: who adds to one takes out what it no longer needs.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Not counted: derivations and proofs, and pages that a command writes whole.
const WITHOUT: [&str; 10] = [
    "docs/benchmarks.md",
    "docs/certificate.md",
    "docs/distribution.md",
    "docs/exact.md",
    "docs/interop.md",
    "docs/kinematics.md",
    "docs/minimum-time.md",
    "docs/orbit.md",
    "docs/proof.md",
    "docs/violations.md",
];

const BUDGETS: [(&str, usize); 26] = [
    ("README.md", 450),
    ("docs/architecture.md", 500),
    ("docs/can-addresses.md", 400),
    ("docs/can-bridge.md", 950),
    ("docs/can-peers.md", 350),
    ("docs/command-line.md", 1300),
    ("docs/commissioning.md", 1300),
    ("docs/controller.md", 1700),
    ("docs/fmu.md", 1300),
    ("docs/fuzzing.md", 500),
    ("docs/glossary.md", 600),
    ("docs/limits.md", 1450),
    ("docs/ls-bus.md", 650),
    ("docs/modelica.md", 500),
    ("docs/overview.md", 600),
    ("docs/own-robot.md", 600),
    ("docs/paper.md", 1450),
    ("docs/python.md", 600),
    ("docs/report.md", 1500),
    ("docs/rig.md", 2400),
    ("docs/rigs.md", 950),
    ("docs/scenarios.md", 700),
    ("docs/studies.md", 1050),
    ("docs/troubleshooting.md", 700),
    ("docs/trust.md", 700),
    ("docs/versioning.md", 300),
];

/// But for code, printed sessions (fenced, or four spaces in) and what lies between marks of a command's output.
fn words(page: &str) -> usize {
    let (mut fenced, mut generated, mut count) = (false, false, 0);
    for line in page.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if line.starts_with("<!--") {
            generated = line.starts_with("<!-- generated");
        } else if !fenced && !generated && !line.starts_with("    ") {
            count += line.split_whitespace().count();
        }
    }
    count
}

#[test]
fn each_hand_written_page_keeps_its_budget_of_words() {
    let over: Vec<_> = BUDGETS
        .iter()
        .map(|&(name, budget)| {
            (name, words(&fs::read_to_string(Path::new(ROOT).join(name)).unwrap()), budget)
        })
        .filter(|(_, count, budget)| count > budget)
        .map(|(name, count, budget)| format!("{name} has {count} words, its budget is {budget}"))
        .collect();
    assert!(over.is_empty(), "{}", over.join("\n"));
}

#[test]
fn each_page_has_a_budget_or_is_not_counted() {
    let folder = fs::read_dir(Path::new(ROOT).join("docs")).unwrap();
    let names = folder.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let pages: BTreeSet<_> =
        names.filter(|name| name.ends_with(".md")).map(|name| format!("docs/{name}")).collect();
    let listed = BUDGETS.iter().map(|(name, _)| *name).chain(WITHOUT).filter(|name| *name != "README.md");
    assert_eq!(pages, listed.map(String::from).collect());
}

#[test]
fn code_and_generated_tables_are_no_words_of_a_page() {
    let page = "# A page\n\ntwo words\n\n    code\n\n```\nmore code\n```\n<!-- generated: cargo x -->\n| a | b |\n<!-- end of generated -->\nlast\n";
    assert_eq!(words(page), 6);
}
