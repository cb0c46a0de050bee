//! 100,000 seeded random sequences of calls against the packed library, and more by night (docs/fuzzing.md), right and wrong ones mixed: NULL pointers, unknown value
//! references, NaN, steps of no length, garbage for states, every order of calls. The host must live, every refusal must come with a
//! message, and after a reset each instance must initialise and step as if nothing had been.
//!
//! `cargo fmu build` makes the library that is called here.
#![allow(unsafe_code)]

mod fmi2;
mod fmi3;
#[cfg(target_os = "linux")]
mod mutated;

use std::cell::Cell;
use std::io::Read;
use std::path::PathBuf;

use cable_robot_import::ModelDescription;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Sequences for each of two models in each of two versions.
const SEQUENCES: u64 = 25_000;
/// Calls in a sequence, at most.
const LENGTH: usize = 24;

thread_local! {
    /// Messages that the loggers of this thread got since it was last set to zero.
    static MESSAGES: Cell<usize> = const { Cell::new(0) };
}

fn count_message() {
    MESSAGES.set(MESSAGES.get() + 1);
}

/// A packed FMU: its library as a file of its own, and its token.
struct Packed {
    library: tempfile::TempPath,
    token: String,
    references: Vec<u32>,
    description: ModelDescription,
}

fn packed(version: u8, model: &str) -> Packed {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let path = root.join(format!("target/fmu/fmi{version}/{model}.fmu"));
    let file = std::fs::File::open(&path).unwrap_or_else(|error| {
        panic!("{}: {error}: run `cargo fmu build` first", path.display());
    });
    let mut archive = zip::ZipArchive::new(file).unwrap();
    let name =
        archive.file_names().flatten().find(|name| name.starts_with("binaries/")).unwrap().into_owned();
    let mut library = tempfile::NamedTempFile::new().unwrap();
    std::io::copy(&mut archive.by_name(&name).unwrap(), &mut library).unwrap();
    let mut xml = String::new();
    archive.by_name("modelDescription.xml").unwrap().read_to_string(&mut xml).unwrap();
    // The importer reads co-simulation only; variables are described alike.
    let description = ModelDescription::parse(&xml.replace("ModelExchange", "CoSimulation")).unwrap();
    Packed {
        library: library.into_temp_path(),
        token: description.token.clone(),
        references: description.variables.iter().map(|variable| variable.reference).collect(),
        description,
    }
}

/// The random numbers of one case: others for each, and for each of another seed.
fn random_of(seed: u64, case: u64) -> Pcg64 {
    let key: u64 = Pcg64::seed_from_u64(seed).random();
    Pcg64::seed_from_u64(key ^ case)
}

/// For the tests that are asked for by name: the seed and the number of cases in `SEED` and `CASES`, or 2 and so many.
fn night(cases: u64) -> (u64, u64) {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse().unwrap());
    (number("SEED").unwrap_or(2), number("CASES").unwrap_or(cases))
}

/// Says of a million cases or more at each hundredth how many are done.
fn say_progress(what: &str, done: u64, cases: u64) {
    if cases >= 1_000_000 && done.is_multiple_of(cases / 100) {
        eprintln!("{what}: {done} of {cases}");
    }
}

/// Where the randomness of one sequence comes from.
struct Dice<'a> {
    rng: Pcg64,
    references: &'a [u32],
}

impl<'a> Dice<'a> {
    fn new(seed: u64, sequence: u64, references: &'a [u32]) -> Self {
        Self { rng: random_of(seed, sequence), references }
    }

    fn below(&mut self, n: usize) -> usize {
        self.rng.random_range(0..n)
    }

    fn chance(&mut self, one_in: usize) -> bool {
        self.below(one_in) == 0
    }

    /// Mostly a number that makes sense, at times one that never does.
    fn real(&mut self) -> f64 {
        match self.below(12) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => -1e300,
            3 => 0.0,
            4 => 1e-320,
            _ => self.rng.random_range(-2.0..20.0),
        }
    }

    fn integer(&mut self) -> i32 {
        if self.chance(8) { self.rng.random() } else { self.rng.random_range(-1..8) }
    }

    /// Up to three value references, mostly known ones.
    fn references(&mut self) -> Vec<u32> {
        let count = self.below(4);
        (0..count)
            .map(|_| {
                let known = self.below(self.references.len());
                if self.chance(10) { self.rng.random() } else { self.references[known] }
            })
            .collect()
    }

    fn bytes(&mut self) -> Vec<u8> {
        let length = self.below(200);
        (0..length).map(|_| self.rng.random()).collect()
    }

    /// The pointer, or NULL at times.
    fn pointer<T>(&mut self, pointer: *const T) -> *const T {
        if self.chance(20) { std::ptr::null() } else { pointer }
    }

    fn pointer_mut<T>(&mut self, pointer: *mut T) -> *mut T {
        if self.chance(20) { std::ptr::null_mut() } else { pointer }
    }
}

/// An error or a discarded call comes with a message (a warning only if its category is on).
fn explained(function: &str, status: u32) {
    assert!(status <= 3, "{function} returned {status}");
    assert!(status <= 1 || MESSAGES.get() > 0, "{function} returned {status} without a word");
    MESSAGES.set(0);
}
