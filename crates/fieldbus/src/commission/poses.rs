//! Where to place the platform, so that a wrong file shows.

use cable_robot::control::static_margin;
use cable_robot::robot::Pose;
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

use super::survey::{Accuracy, Placing};
use super::{Doubt, NEEDED, Quantity, World};
use crate::config::Config;

/// Poses are asked for until every doubt is cleared, at most so many.
const MOST: usize = 8;
/// Of so many the best is taken, one after the other.
const CANDIDATES: usize = 400;
/// A pose that clears less of a doubt than this is not worth its while, nor is a longer way.
const WORTH: f64 = 0.25;
/// Shares of the way from home to the walls of `limits.space`: what can be told near home is not asked for far away.
const REACHES: [f64; 3] = [0.25, 0.5, 1.0];

/// Poses to measure at, and what they tell.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Level ones, in the base frame.
    pub poses: Vec<Pose>,
    /// By how many standard deviations each doubt shows there. [`NEEDED`] are needed.
    pub doubts: Vec<(Doubt, f64)>,
    /// The least amount of each quantity that shows, m, rad or a share.
    pub quantities: Vec<(Quantity, f64)>,
}

impl Plan {
    /// A few poses within `limits.space` at which as many doubts show as a greedy search finds, as near to home as will do.
    pub fn new(config: &Config, accuracy: &Accuracy) -> Self {
        let file = World::of(config);
        let [near, middle, far] = REACHES.map(|reach| choose(config, &file, accuracy, reach));
        let enough = far.1 - WORTH;
        let (poses, _) =
            [near, middle, far].into_iter().find(|(_, cleared)| *cleared >= enough).unwrap_or_default();
        Self::at(&file, poses, accuracy)
    }

    /// What lengths read at these poses tell.
    pub fn at(file: &World, poses: Vec<Pose>, accuracy: &Accuracy) -> Self {
        let sizes = |doubts: &[Doubt]| {
            let looks: Vec<_> = poses.iter().map(|pose| Look::new(file, *pose, accuracy, doubts)).collect();
            sizes(&looks.iter().collect::<Vec<_>>(), accuracy)
        };
        let doubts = Doubt::all(file);
        let quantities = Quantity::all(file.scale.len());
        let units: Vec<_> = quantities.iter().map(|quantity| Doubt::Quantity(*quantity, 1.0)).collect();
        let least = sizes(&units).into_iter().map(|size| NEEDED / size);
        Self {
            quantities: quantities.into_iter().zip(least).collect(),
            doubts: sizes(&doubts).into_iter().zip(doubts).map(|(size, doubt)| (doubt, size)).collect(),
            poses,
        }
    }

    /// The doubts that stay.
    pub fn hidden(&self) -> impl Iterator<Item = &Doubt> {
        self.doubts.iter().filter(|(_, shown)| *shown < NEEDED).map(|(doubt, _)| doubt)
    }
}

/// The poses that clear most doubts, one after the other, and how many they clear.
fn choose(config: &Config, file: &World, accuracy: &Accuracy, reach: f64) -> (Vec<Pose>, f64) {
    let doubts = Doubt::all(file);
    let look = |pose| Look::new(file, pose, accuracy, &doubts);
    let candidates: Vec<_> = candidates(config, reach).into_iter().map(look).collect();
    let (mut chosen, mut cleared) = (vec![], 0.0);
    while chosen.len() < MOST {
        let with = |look| cleared_by(&[&chosen[..], &[look]].concat(), accuracy);
        let left =
            candidates.iter().filter(|look| chosen.iter().all(|taken: &&Look| taken.pose != look.pose));
        let best = left.map(|look| (look, with(look))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((look, now)) = best.filter(|(_, now)| *now >= cleared + WORTH) else { break };
        chosen.push(look);
        cleared = now;
    }
    (chosen.into_iter().map(|look| look.pose).collect(), cleared)
}

/// What one pose tells of each doubt.
struct Look {
    pose: Pose,
    /// J_hᵀ A⁻¹ J_h.
    at_home: Matrix6<f64>,
    /// dᵀ A⁻¹ d and J_hᵀ A⁻¹ d of each doubt's deviation d.
    shows: Vec<(f64, Vector6<f64>)>,
}

impl Look {
    fn new(file: &World, pose: Pose, accuracy: &Accuracy, doubts: &[Doubt]) -> Self {
        let placing = Placing::new(file, &pose, accuracy);
        let show = |doubt: &Doubt| {
            let whitened = placing.whiten(&doubt.deviation(file, &pose));
            (whitened.norm_squared(), placing.explained_at_home(&whitened))
        };
        Self { pose, at_home: placing.at_home(), shows: doubts.iter().map(show).collect() }
    }
}

/// By how many standard deviations the poses together show each doubt: the product of a survey (survey.rs) with itself.
fn sizes(looks: &[&Look], accuracy: &Accuracy) -> Vec<f64> {
    let information = accuracy.at_home() + looks.iter().map(|look| look.at_home).sum::<Matrix6<f64>>();
    let home = information.cholesky().expect("a positive definite matrix with more added stays so");
    let doubts = looks.first().map_or(0, |look| look.shows.len());
    let size = |doubt: usize| {
        let square: f64 = looks.iter().map(|look| look.shows[doubt].0).sum();
        let at_home: Vector6<f64> = looks.iter().map(|look| look.shows[doubt].1).sum();
        (square - at_home.dot(&home.solve(&at_home))).max(0.0).sqrt()
    };
    (0..doubts).map(size).collect()
}

/// How many doubts are cleared, one that shows half counting for a quarter.
fn cleared_by(looks: &[&Look], accuracy: &Accuracy) -> f64 {
    sizes(looks, accuracy).into_iter().map(|size| (size / NEEDED).min(1.0)).map(|share| share * share).sum()
}

/// Level poses, turned within `limits.tilt`, spread over what is within reach: above the stand, where the cables can hold the
/// platform and their pretension does not lift it.
fn candidates(config: &Config, reach: f64) -> Vec<Pose> {
    let step = round_step(config.rig.radius());
    let (space, turn) = (config.limits.space, config.limits.tilt.to_degrees());
    let (up, home) = (-config.rig.gravity.normalize(), config.home.position());
    (1..=CANDIDATES)
        .map(|k| {
            let within = |axis: usize, base| {
                let [low, high] = space[axis].map(|wall| home[axis] + reach * (wall - home[axis]));
                let at = low + (high - low) * radical_inverse(k, base);
                (at / step).round() * step
            };
            let position = Vector3::new(within(0, 2), within(1, 3), within(2, 5));
            let degrees = (turn * (2.0 * radical_inverse(k, 7) - 1.0)).round();
            Pose::from_parts(&position, &Rotation3::from_scaled_axis(up * degrees.to_radians()))
        })
        .filter(|pose| config.rig.can_be_at(pose) && static_margin(&config.rig, pose) > 0.0)
        .filter(|pose| up.dot(&(pose.position() - home)) >= 0.0 && stays_down(config, pose))
        .collect()
}

/// Whether the platform stays on its blocks with the pretension in all cables.
fn stays_down(config: &Config, pose: &Pose) -> bool {
    let up = -config.rig.gravity.normalize();
    let lift: f64 = config.rig.cables_at(pose).direction.iter().map(|direction| direction.dot(&up)).sum();
    config.slack.pretension * lift < config.rig.weight()
}

/// A power of ten, about a hundredth of the rig: positions are whole multiples of it, for whoever places the platform.
fn round_step(radius: f64) -> f64 {
    let mut step = 1.0;
    while step > 0.02 * radius {
        step /= 10.0;
    }
    while step < 0.002 * radius {
        step *= 10.0;
    }
    step
}

/// The digits of k in a base, mirrored at the point: evenly spread in (0, 1) (Halton).
fn radical_inverse(mut k: usize, base: usize) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while k > 0 {
        place /= base as f64;
        value += (k % base) as f64 * place;
        k /= base;
    }
    value
}
