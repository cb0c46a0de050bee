//! Whether commands act when they are said to. Derived in docs/controller.md, "When a command acts".

use serde::{Deserialize, Serialize};

use super::estimator::OBSERVER_POLE;
use crate::robot::Coordinates;

/// For how long what was seen counts, s.
const MEMORY: f64 = 1.0;
/// What is seen must be explained by a delay to this share (of the squares),
const EXPLAINED: f64 = 0.8;
/// and the delay must be this share of a step at least.
const LEAST: f64 = 0.5;

/// Compares what measurements correct the estimated rates by with what a delay of one step more would have changed in the commands: a command that acts a step
/// later is at any time that of the step before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DelayWatch {
    /// The mean commanded acceleration of the step before, m/s² and rad/s².
    before: Coordinates,
    /// What a step more would have changed, as it comes through the observer: filtered once and twice.
    once: Coordinates,
    change: Coordinates,
    /// Sums over the memory: change², change · correction, correction², and the time in them, s.
    squares: [f64; 3],
    seen: f64,
    found: Option<f64>,
}

impl DelayWatch {
    /// At rest.
    pub fn new() -> Self {
        let none = Coordinates::zeros();
        Self { before: none, once: none, change: none, squares: [0.0; 3], seen: 0.0, found: None }
    }

    /// A step of `dt` s with these mean accelerations commanded, in which measurements corrected the rates by `correction` s⁻¹ (all m/s² and rad/s²). Turns
    /// count at `radius` m.
    pub fn update(&mut self, commanded: &Coordinates, correction: &Coordinates, dt: f64, radius: f64) {
        let later = self.before - commanded;
        self.before = *commanded;
        let keep = libm::exp(-OBSERVER_POLE * dt);
        self.once = self.once * keep + later * (1.0 - keep);
        self.change = self.change * keep + self.once * (1.0 - keep);
        let product = |a: &Coordinates, b: &Coordinates| -> f64 {
            (0..6).map(|k| a[k] * b[k] * if k < 3 { 1.0 } else { radius * radius }).sum()
        };
        let forget = libm::exp(-dt / MEMORY);
        let now = [
            product(&self.change, &self.change),
            product(&self.change, correction),
            product(correction, correction),
        ];
        for (sum, now) in self.squares.iter_mut().zip(now) {
            *sum = *sum * forget + now * dt;
        }
        self.seen = self.seen * forget + dt;
        if self.found.is_none() {
            self.found = self.steps_late().map(|steps| steps * dt);
        }
    }

    /// How much later than was said commands act, s, as it was first found; less than 0 if earlier.
    pub fn late(&self) -> Option<f64> {
        self.found
    }

    /// The least squares, if a delay explains what is seen.
    fn steps_late(&self) -> Option<f64> {
        let [change, both, correction] = self.squares;
        let late = both / change;
        let is_explained = both * both > EXPLAINED * change * correction;
        (is_explained && late.abs() > LEAST && self.seen > 0.2 * MEMORY).then_some(late)
    }
}

impl Default for DelayWatch {
    fn default() -> Self {
        Self::new()
    }
}
