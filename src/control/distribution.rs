//! How six or more cables share a wrench: W u = w with lᵢ ≤ uᵢ ≤ hᵢ. Derived in `docs/distribution.md`.
//!
//! Six cables at a regular pose have one solution. Of more, u = ū + N z: the law takes the u nearest to a reference r that keeps a margin
//! from the limits,
//!
//! ```text
//! minimise  |u - r|²/2 + K/2 |excess over [l + m, h - m]|²   subject to  W u = w,  l ≤ u ≤ h          (D1)
//! ```
//!
//! The objective is strictly convex: u is one, and continuous in W and w.

use nalgebra::{Matrix6, Vector6};

use super::active_set::{MOST_UNKNOWNS, Outcome, Point, Programme, Row};
use crate::robot::{Cable, LEAST_CABLES, MOST_CABLES, PerCable, Rig, TensionLimits};

const _: () = assert!(MOST_CABLES <= MOST_UNKNOWNS);

/// K of (D1): the margin is given up by 1e-8 of how far the reference pulls beyond it.
pub const STIFFNESS: f64 = 1e8;
/// The same for the limits, once they cannot be kept.
const STIFFNESS_OF_LIMITS: f64 = 1e10;
/// Limits count as kept within this share of the largest tension and limit at hand.
const ROUNDING: f64 = 1e-12;
/// The wrench matrix counts as singular if a row of it adds less than this share of the largest to the others.
const RANK: f64 = 1e-9;
/// Margins are told up to this many times the largest tension at hand.
const WIDEST: f64 = 1e3;
/// Cuts in the search for the widest margin; four or five do.
const MOST_CUTS: usize = 60;

/// Whether the cables can give a wrench within their limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// They can, and these are the tensions, N.
    Feasible(PerCable<f64>),
    /// They cannot.
    Infeasible {
        /// Tensions that give the wrench and exceed the limits by little, N.
        nearest: PerCable<f64>,
        /// Which limits stand against the wrench: above 0 where the greatest tension does, below 0 where the least does. Their absolute
        /// values add up to 1. They are c = Wᵀ y for a y with yᵀ w > max cᵀ u over all u within the limits: no such u gives the wrench.
        weights: PerCable<f64>,
        /// yᵀ w - max cᵀ u, N: each limit would have to be wider by this much at least.
        shortfall: f64,
    },
}

/// All tensions that give a wrench.
#[derive(Clone, Copy, Debug)]
pub struct Solutions {
    /// The solution that is nearest to 0, N.
    least: PerCable<f64>,
    /// Columns of P, the projection on the null space of W.
    projection: [Point; MOST_CABLES],
}

/// The law's tensions for a wrench (N, N m): the only ones of six cables, (D1) of more. Where the limits cannot be kept, tensions that
/// give the wrench all the same: they exceed the limits by little, and continuously. `None` where the wrench matrix is singular.
pub fn share(
    rig: &Rig,
    columns: &PerCable<Vector6<f64>>,
    wrench: &Vector6<f64>,
    margin: f64,
) -> Option<PerCable<f64>> {
    if columns.len() == LEAST_CABLES {
        return only_tensions(columns, wrench);
    }
    let solutions = Solutions::new(columns, wrench, rig.platform_radius())?;
    let limits = rig.limits();
    Some(match solutions.distribute(&limits, &reference(rig), margin) {
        Distribution::Feasible(tensions) | Distribution::Infeasible { nearest: tensions, .. } => tensions,
    })
}

/// The greatest margin from the rig's limits that tensions can keep at once for a wrench, N: less than 0 where the limits cannot be kept, and
/// without bound where the wrench matrix is singular.
pub fn widest_margin(rig: &Rig, columns: &PerCable<Vector6<f64>>, wrench: &Vector6<f64>) -> f64 {
    if columns.len() > LEAST_CABLES {
        let solutions = Solutions::new(columns, wrench, rig.platform_radius());
        return solutions.map_or(f64::NEG_INFINITY, |solutions| solutions.widest_margin(&rig.limits()));
    }
    only_tensions(columns, wrench).map_or(f64::NEG_INFINITY, |tensions| {
        let margin = |(u, cable): (f64, &Cable)| cable.limits.margin(u);
        tensions.into_iter().zip(&rig.cables).map(margin).fold(f64::INFINITY, f64::min)
    })
}

/// r of (D1): above the least tension by the platform's weight, or in the middle of the range if that is less.
pub fn reference(rig: &Rig) -> PerCable<f64> {
    let weight = rig.weight();
    rig.limits().map(|limits| limits.min + (0.5 * (limits.max - limits.min)).min(weight))
}

/// The tensions of six cables, N; `None` where the wrench matrix is singular.
fn only_tensions(columns: &PerCable<Vector6<f64>>, wrench: &Vector6<f64>) -> Option<PerCable<f64>> {
    let matrix = Matrix6::from_fn(|row, column| columns[column][row]);
    let tension = matrix.lu().solve(wrench)?;
    tension.iter().all(|u| u.is_finite()).then(|| PerCable::from_fn(LEAST_CABLES, |i| tension[i]))
}

impl Solutions {
    /// Torques are compared with forces at `radius` (m). `None` where the wrench matrix is singular, or not finite.
    ///
    /// The rows of W, torques over the radius, are made orthonormal one after the other (Gram and Schmidt, twice, so that rounding does
    /// not add up): W = L Q. Then the least solution is Qᵀ L⁻¹ w, and P = 1 - Qᵀ Q.
    pub fn new(columns: &PerCable<Vector6<f64>>, wrench: &Vector6<f64>, radius: f64) -> Option<Self> {
        let count = columns.len();
        let scale = |k: usize| if k < 3 { 1.0 } else { 1.0 / radius };
        let mut q = [[0.0; MOST_CABLES]; 6];
        let mut y = [0.0; 6];
        let dot =
            |a: &[f64; MOST_CABLES], b: &[f64; MOST_CABLES]| (0..count).map(|i| a[i] * b[i]).sum::<f64>();
        let largest =
            (0..6).flat_map(|k| columns.iter().map(move |c| (c[k] * scale(k)).abs())).fold(0.0, f64::max);
        for k in 0..6 {
            for i in 0..count {
                q[k][i] = columns[i][k] * scale(k);
            }
            let mut known = wrench[k] * scale(k);
            for _ in 0..2 {
                for j in 0..k {
                    let share = dot(&q[j], &q[k]);
                    known -= share * y[j];
                    for i in 0..count {
                        q[k][i] -= share * q[j][i];
                    }
                }
            }
            let size = dot(&q[k], &q[k]).sqrt();
            if size.is_nan() || size <= RANK * largest {
                return None;
            }
            q[k].iter_mut().for_each(|value| *value /= size);
            y[k] = known / size;
        }
        let least = PerCable::from_fn(count, |i| (0..6).map(|k| q[k][i] * y[k]).sum());
        let mut projection = [[0.0; MOST_UNKNOWNS]; MOST_CABLES];
        for i in 0..count {
            for j in 0..count {
                let along: f64 = (0..6).map(|k| q[k][i] * q[k][j]).sum();
                projection[i][j] = f64::from(u8::from(i == j)) - along;
            }
        }
        Some(Self { least, projection })
    }

    /// The solution of (D1): within the limits if there are such tensions.
    pub fn distribute(
        &self,
        limits: &PerCable<TensionLimits>,
        reference: &PerCable<f64>,
        margin: f64,
    ) -> Distribution {
        let near = self.nearest_to(reference);
        let margins = limits.map(|limits| shrunk(&limits, margin));
        let soft = rows(&near, &margins, 1.0 / STIFFNESS);
        let of = |compliance: f64| {
            let hard = rows(&near, limits, compliance);
            let mut all = [Row::default(); 4 * MOST_CABLES];
            let count = 2 * near.len();
            all[..count].copy_from_slice(&soft[..count]);
            all[count..2 * count].copy_from_slice(&hard[..count]);
            self.solve(&near, limits, &all[..2 * count])
        };
        // z is in the null space but for rounding, which the projection takes away.
        let moved = |z: &Point| PerCable::from_fn(near.len(), |i| near[i] + self.projected(i, z));
        match of(0.0) {
            Outcome::Nearest(z) => Distribution::Feasible(moved(&z)),
            Outcome::Contradiction(_) => {
                let nearest = match of(1.0 / STIFFNESS_OF_LIMITS) {
                    Outcome::Nearest(z) => moved(&z),
                    _ => near,
                };
                let (weights, shortfall) = self.refusal(&near, limits);
                Distribution::Infeasible { nearest, weights, shortfall }
            }
            Outcome::Unfinished => {
                Distribution::Infeasible { nearest: near, weights: near.map(|_| 0.0), shortfall: 0.0 }
            }
        }
    }

    /// The tensions of (D1) without margin, within other limits than the rig's; nearly within them if there are none.
    pub fn tensions_within(&self, limits: &PerCable<TensionLimits>, rig: &Rig) -> PerCable<f64> {
        match self.distribute(limits, &reference(rig), 0.0) {
            Distribution::Feasible(tensions) | Distribution::Infeasible { nearest: tensions, .. } => tensions,
        }
    }

    /// The greatest s with l + s ≤ u ≤ h - s for tensions u that give the wrench, N: less than 0 where the limits cannot be kept, infinite
    /// where nothing binds.
    ///
    /// From an s that is too large, each contradiction says how much less it must be: Newton's method on a concave function with
    /// straight pieces, which ends at the exact value.
    pub fn widest_margin(&self, limits: &PerCable<TensionLimits>) -> f64 {
        self.widest(limits).0
    }

    /// The same, and with it the weights of the contradiction that bounds it: all 0 if none was met.
    fn widest(&self, limits: &PerCable<TensionLimits>) -> (f64, PerCable<f64>) {
        let count = self.least.len();
        let mut weights = PerCable::filled(count, 0.0);
        let scale = scale_of(&self.least, limits);
        let half = |limits: &TensionLimits| 0.5 * (limits.max - limits.min);
        let most = limits.iter().map(half).fold(WIDEST * scale, f64::min);
        let mut margin = most;
        for _ in 0..MOST_CUTS {
            let shrunk = limits.map(|limits| limits.shrunk(margin));
            let rows = rows(&self.least, &shrunk, 0.0);
            match self.solve(&self.least, limits, &rows[..2 * count]) {
                Outcome::Contradiction(multipliers) => {
                    weights = PerCable::filled(count, 0.0);
                    for (row, multiplier) in multipliers.iter() {
                        weights[row % count] += if row < count { -multiplier } else { multiplier };
                    }
                    // Normals add up to nothing, bounds to less; each bound grows as the margin shrinks.
                    let (sum, bound) =
                        multipliers.iter().fold((0.0, 0.0), |(sum, bound), (row, multiplier)| {
                            (sum + multiplier, bound + multiplier * rows[row].bound)
                        });
                    let shortfall = -bound / sum;
                    if shortfall <= ROUNDING * scale {
                        break;
                    }
                    margin -= shortfall;
                }
                Outcome::Nearest(_) if margin == WIDEST * scale => return (f64::INFINITY, weights),
                Outcome::Nearest(_) => break,
                Outcome::Unfinished => return (f64::NEG_INFINITY, weights),
            }
        }
        (margin, weights)
    }

    /// The solution that is nearest to 0, N.
    pub fn least(&self) -> &PerCable<f64> {
        &self.least
    }

    /// An orthonormal basis of the null space of W: of the projection's columns the largest, what it leaves of the others, and so on.
    pub fn null_space(&self) -> PerCable<Point> {
        let count = self.least.len();
        let mut columns = self.projection;
        PerCable::from_fn(count - LEAST_CABLES, |_| {
            let square = |column: &Point| column.iter().map(|value| value * value).sum::<f64>();
            let largest = (0..count).max_by(|i, j| square(&columns[*i]).total_cmp(&square(&columns[*j])));
            let picked = columns[largest.unwrap_or(0)];
            let size = square(&picked).sqrt();
            let unit = picked.map(|value| value / size);
            for column in &mut columns[..count] {
                let share: f64 = (0..count).map(|i| unit[i] * column[i]).sum();
                (0..count).for_each(|i| column[i] -= share * unit[i]);
            }
            unit
        })
    }

    /// The solution that is nearest to `reference`.
    fn nearest_to(&self, reference: &PerCable<f64>) -> PerCable<f64> {
        PerCable::from_fn(self.least.len(), |i| self.least[i] + self.projected(i, reference))
    }

    /// Component i of P v.
    fn projected(&self, i: usize, v: &[f64]) -> f64 {
        (0..self.least.len()).map(|j| self.projection[i][j] * v[j]).sum()
    }

    fn solve(&self, near: &PerCable<f64>, limits: &PerCable<TensionLimits>, rows: &[Row]) -> Outcome {
        let unknowns = near.len();
        let tolerance = ROUNDING * scale_of(near, limits);
        let rank = unknowns - LEAST_CABLES;
        Programme { unknowns, rank, normals: &self.projection[..unknowns], rows, tolerance }.solve()
    }

    /// Weights and shortfall of limits that contradict each other: of all contradictions the one with the greatest shortfall.
    fn refusal(&self, near: &PerCable<f64>, limits: &PerCable<TensionLimits>) -> (PerCable<f64>, f64) {
        let (_, weights) = self.widest(limits);
        let sum: f64 = weights.iter().map(|c| c.abs()).sum();
        let weights = weights.map(|c| c / sum.max(f64::MIN_POSITIVE));
        let most = |i: usize| match weights[i] {
            0.0 => 0.0,
            c if c > 0.0 => c * limits[i].max,
            c => c * limits[i].min,
        };
        let shortfall = (0..near.len()).map(|i| weights[i] * near[i] - most(i)).sum();
        (weights, shortfall)
    }
}

/// A bound of |du|/|dw| of (D1), torques taken over `radius` (m): the greatest |B⁻¹| of all regular choices B of six columns. See (D3) of
/// `docs/distribution.md`. For set-up and tests: twelve cables have 924 choices.
pub fn lipschitz(columns: &PerCable<Vector6<f64>>, radius: f64) -> f64 {
    let scaled = columns.map(|column| {
        let mut column = column;
        column.fixed_rows_mut::<3>(3).unscale_mut(radius);
        column
    });
    let mut bound: f64 = 0.0;
    for choice in 0..1_u32 << columns.len() {
        if choice.count_ones() as usize != LEAST_CABLES {
            continue;
        }
        let mut picked = (0..columns.len()).filter(|i| choice >> i & 1 == 1);
        let matrix =
            Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(|_| scaled[picked.next().unwrap_or(0)]));
        let smallest = matrix.singular_values().min();
        if smallest > RANK {
            bound = bound.max(1.0 / smallest);
        }
    }
    bound
}

/// Limits with the margin kept from them; where they are too near to each other, the middle.
fn shrunk(limits: &TensionLimits, margin: f64) -> TensionLimits {
    limits.shrunk(margin.min(0.5 * (limits.max - limits.min)))
}

/// u ≥ min of each cable, then u ≤ max of each, in z where u = near + z.
fn rows(near: &PerCable<f64>, limits: &PerCable<TensionLimits>, compliance: f64) -> [Row; 2 * MOST_CABLES] {
    let mut rows = [Row::default(); 2 * MOST_CABLES];
    for (i, TensionLimits { min, max }) in limits.iter().enumerate() {
        rows[i] = Row { normal: i, sign: -1.0, bound: near[i] - min, compliance };
        rows[limits.len() + i] = Row { normal: i, sign: 1.0, bound: max - near[i], compliance };
    }
    rows
}

/// The largest tension and finite limit at hand, N: what rounding is measured by.
fn scale_of(near: &PerCable<f64>, limits: &PerCable<TensionLimits>) -> f64 {
    let tensions = near.iter().map(|u| u.abs());
    tensions.chain(limits.iter().map(|limits| limits.min)).fold(f64::MIN_POSITIVE, f64::max)
}

#[cfg(test)]
mod tests;
