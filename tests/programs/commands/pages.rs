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
    ("docs/architecture.md", 400),
    ("docs/can-addresses.md", 400),
    ("docs/can-bridge.md", 850),
    ("docs/can-peers.md", 350),
    ("docs/command-line.md", 750),
    ("docs/commissioning.md", 1250),
    ("docs/controller.md", 1150),
    ("docs/fmu.md", 950),
    ("docs/fuzzing.md", 400),
    ("docs/glossary.md", 450),
    ("docs/limits.md", 1050),
    ("docs/ls-bus.md", 650),
    ("docs/modelica.md", 450),
    ("docs/overview.md", 500),
    ("docs/own-robot.md", 500),
    ("docs/paper.md", 1000),
    ("docs/python.md", 450),
    ("docs/report.md", 800),
    ("docs/rig.md", 2100),
    ("docs/rigs.md", 600),
    ("docs/scenarios.md", 500),
    ("docs/studies.md", 650),
    ("docs/troubleshooting.md", 500),
    ("docs/trust.md", 550),
    ("docs/versioning.md", 250),
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

/// File and heading of each link in a page, but for those to other hosts.
fn links(page: &str) -> Vec<(&str, &str)> {
    let targets = page.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    let own = targets.filter(|target| !target.contains(':') && !target.contains(' '));
    own.map(|target| target.split_once('#').unwrap_or((target, ""))).collect()
}

/// As a heading is called in links: in small letters, without punctuation.
fn heading(line: &str) -> Option<String> {
    let text = line.strip_prefix('#')?.trim_start_matches('#').trim().to_lowercase();
    let spelled = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    Some(spelled.map(|c| if c == ' ' { '-' } else { c }).collect())
}

fn dead_links(place: &Path) -> Vec<String> {
    let page = fs::read_to_string(place).unwrap();
    let leads = |(file, part): &(&str, &str)| {
        let target = if file.is_empty() { place.to_owned() } else { place.with_file_name("").join(file) };
        let has = |text: String| text.lines().filter_map(heading).any(|name| name == *part);
        target.exists() && (part.is_empty() || fs::read_to_string(target).is_ok_and(has))
    };
    let dead = links(&page).into_iter().filter(|link| !leads(link));
    dead.map(|(file, part)| format!("{}: {file}#{part}", place.display())).collect()
}

/// A picture that nobody had put into the repository was missing on one page.
#[test]
fn every_link_leads_to_a_file_and_a_heading_of_the_repository() {
    let pages = ["", "docs"].map(|folder| fs::read_dir(Path::new(ROOT).join(folder)).unwrap());
    let places = pages.into_iter().flatten().map(|entry| entry.unwrap().path());
    let dead: Vec<_> =
        places.filter(|p| p.extension() == Some("md".as_ref())).flat_map(|p| dead_links(&p)).collect();
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}
