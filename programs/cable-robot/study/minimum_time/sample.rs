//! A sample of the study, small enough for every run of the tests.

use rayon::prelude::*;

use super::super::random_of;
use super::look::{Found, excess};
use super::moves::{Kind, Way};

const SEED: u64 = 12;
/// Motions of each kind.
const MOTIONS: u64 = 200;
/// Every so many lines one is compared with the optimum, on so many cells.
const COMPARED: u64 = 4;
const CELLS: u32 = 1000;

#[test]
fn a_sample_of_the_motions_and_their_stops_keeps_every_tension_within_its_limits() {
    for kind in Kind::ALL {
        let looked = (0..MOTIONS).into_par_iter().map(|k| look(kind, k));
        let (found, slowest) =
            looked.reduce(|| (Found::none(), f64::NEG_INFINITY), |a, b| (a.0.and(b.0), a.1.max(b.1)));
        println!("{}: {} motions, at most {slowest:.1e} slower than the optimum", kind.name(), found.motions);
        assert!(found.motions >= MOTIONS);
        assert_eq!((found.broken, found.undecided), (0, 0), "{}", kind.name());
        assert!(slowest < 1e-3, "{slowest}");
    }
}

/// A motion and a stop on it; of some lines by how much longer than the optimum it takes, as a share.
fn look(kind: Kind, k: u64) -> (Found, f64) {
    let mut rng = random_of(SEED, k);
    let planned = std::iter::repeat_with(|| kind.draw(&mut rng)).find_map(|planned| planned).unwrap();
    let mut found = Found::in_motion(&planned, &planned.timing);
    let [s, v, _] = planned.timing.at(0.4 * planned.timing.duration);
    if let Some(stop) = planned.stop(s, v) {
        found = found.and(Found::in_motion(&planned, &stop));
    }
    let slower = match &planned.way {
        Way::Line { line, .. } if k.is_multiple_of(COMPARED) => excess(&planned, line, CELLS).unwrap(),
        _ => f64::NEG_INFINITY,
    };
    (found, slower)
}
