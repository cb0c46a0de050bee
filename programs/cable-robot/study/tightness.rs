//! How much of what is truly admissible each domain accepts: horizontal steps from rest over the static workspace.

use anyhow::Result;
use cable_robot::control::response::instants;
use cable_robot::control::{Gains, Response, tensions};
use cable_robot::reach::exact::NEVER_SLACK;
use cable_robot::reach::{BoundedDomain, ExactDomain};
use cable_robot::robot::{Coordinates, Pose, Rig, RobotParameters};
use clap::Args;
use nalgebra::{Vector2, Vector3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use super::random_point;
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot study tightness --pairs 10000
The truth is dense sampling of the 6x6 inverse dynamics. \"refused\" counts truly admissible pairs that the exact domain refuses
(they fall between two samples), \"wrong\" those accepted by either that are not admissible.";

/// Instants at which the truth is sampled, denser at the start.
const INSTANTS: usize = 400;

#[derive(Args)]
pub struct Tightness {
    /// Random pairs of points of the static workspace, for each gain and height
    #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..))]
    pairs: u32,
    /// Seed of the random pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    gain: f64,
    z: f64,
    admissible: u32,
    bounded: u32,
    exact: u32,
    wrong: u32,
}

impl Tightness {
    pub fn run(&self) -> Result<Outcome> {
        let grid: Vec<(f64, f64)> =
            [1.0, 3.0, 5.0, 8.0].into_iter().flat_map(|gain| [0.5, 1.0, 2.0].map(|z| (gain, z))).collect();
        let progress = Progress::new("looking", grid.len() as u64 * u64::from(self.pairs));
        let cells: Vec<Cell> = grid.into_par_iter().map(|(gain, z)| self.cell(gain, z, &progress)).collect();
        drop(progress);
        if self.json {
            let rows: Vec<_> = cells.iter().map(|c| {
                json!({"gain": c.gain, "z": c.z, "pairs": self.pairs, "admissible": c.admissible, "bounded": c.bounded, "exact": c.exact, "wrong": c.wrong})
            }).collect();
            print_json(&json!({"seed": self.seed, "cells": rows}))?;
            return Ok(Outcome::Done);
        }
        let mut text = format!(
            "seed {}, {} pairs a row\nλ = η   z (m)   admissible    Bounded      Exact  refused  wrong\n",
            self.seed, self.pairs
        );
        for c in &cells {
            let share = |part: u32, of: u32| 100.0 * f64::from(part) / f64::from(of.max(1));
            text += &format!(
                "{:5}   {:5}   {:8.1} %   {:6.1} %   {:6.1} %  {:7}  {:5}\n",
                c.gain,
                c.z,
                share(c.admissible, self.pairs),
                share(c.bounded, c.admissible),
                share(c.exact, c.admissible),
                c.admissible - c.exact,
                c.wrong
            );
        }
        print(&text)?;
        Ok(Outcome::Done)
    }

    fn cell(&self, gain: f64, z: f64, progress: &Progress) -> Cell {
        let robot = RobotParameters::default();
        let gains = Gains { lambda: gain, eta: gain };
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let mut cell = Cell { gain, z, ..Cell::default() };
        for _ in 0..self.pairs {
            let (from, to) = (random_point(&mut rng, &robot, 0.0), random_point(&mut rng, &robot, 0.0));
            let start = Vector3::new(from.x, from.y, z);
            let exact = ExactDomain::new(&robot, &gains, NEVER_SLACK, start, Vector3::zeros());
            let exact = exact.contains(&Vector3::new(to.x, to.y, z));
            let bounded = BoundedDomain::new(&robot, &gains, from, z).contains(&to);
            if is_taut(&robot, &gains, &from, &to, z) {
                cell.admissible += 1;
                cell.bounded += u32::from(bounded);
                cell.exact += u32::from(exact);
            } else {
                cell.wrong += u32::from(bounded || exact);
            }
            progress.done(1);
        }
        cell
    }
}

/// Whether every sampled tension is positive.
fn is_taut(robot: &RobotParameters, gains: &Gains, from: &Vector2<f64>, to: &Vector2<f64>, z: f64) -> bool {
    let rig = Rig::paper(robot, NEVER_SLACK);
    let [from, to] = [from, to].map(|point| Pose::at(point.x, point.y, z));
    instants(15.0 / gains.lambda, INSTANTS).all(|t| {
        let (pose, rates, acceleration) = Response::at(gains, t).motion_of(&from, &Coordinates::zeros(), &to);
        let u = tensions(&rig, &pose, &rates, &acceleration, 0.0);
        u.is_some_and(|u| u.iter().all(|u| *u > 0.0))
    })
}
