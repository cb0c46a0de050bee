//! The fuzzers' targets (fuzz/) on seeded bytes: noise, and what people have with something changed. docs/fuzzing.md

#[path = "../../fuzz/src/lib.rs"]
mod fuzz;

use std::fs;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// One or a few changes, as a fuzzer makes them.
fn mutate(random: &mut Pcg64, bytes: &mut Vec<u8>) {
    for _ in 0..random.random_range(1..6) {
        let at = random.random_range(0..=bytes.len());
        let to = (at + random.random_range(0..20usize)).min(bytes.len());
        match random.random_range(0..6) {
            0 => bytes.insert(at, random.random()),
            1 => drop(bytes.drain(at..to)),
            2 => bytes.splice(at..at, bytes[at..to].to_vec()).for_each(drop),
            3 => bytes.truncate(at.max(1)),
            4 => bytes
                .iter_mut()
                .skip(at)
                .take(1)
                .for_each(|byte| *byte = b"0.-9eE#\r\n\"=[]{},"[usize::from(*byte) % 16]),
            _ => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (to % 8)),
        }
    }
}

/// `cases` of noise and `cases` of changed seeds.
fn try_many(target: fn(&[u8]), seeds: &[Vec<u8>], cases: usize) {
    let mut random = Pcg64::seed_from_u64(5);
    for seed in seeds {
        target(seed);
    }
    for k in 0..cases {
        let length = random.random_range(0..200);
        let noise: Vec<u8> = (0..length).map(|_| random.random()).collect();
        target(&noise);
        let mut changed = seeds[k % seeds.len()].clone();
        mutate(&mut random, &mut changed);
        target(&changed);
    }
}

/// The files in a folder of the project that end so.
fn files(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(folder);
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = paths.filter(|path| path.to_str().unwrap().ends_with(ending)).collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

#[test]
fn frames_as_text() {
    try_many(fuzz::frames, &files("fuzz/seeds/frames", ""), 100_000);
}

#[test]
fn recorded_runs() {
    try_many(fuzz::run_csv, &files("fuzz/seeds/run_csv", ""), 50_000);
}

#[test]
fn fieldbus_files() {
    try_many(fuzz::fieldbus_file, &files("rigs/can", ".toml"), 1500);
}

#[test]
fn scenario_and_robot_files() {
    let mut seeds = files("rigs", ".toml");
    seeds.extend(files("scenarios", ".toml"));
    try_many(fuzz::scenario, &seeds, 5000);
}

#[test]
fn a_bridge_on_a_bus_with_strangers() {
    try_many(fuzz::bridge, &files("fuzz/seeds/bridge", ""), 1500);
}
