//! What the limits of the tensions ask of s'' and s'² at a place on a way through the six coordinates, for any rig.
//!
//! With q(s), slope D = dq/ds and bend B = d²q/ds², q' = D s', q'' = D s'' + B s'², and the wrench that the cables must give is w₀ + w₁ s'' + w₂ s'², Eq. (1). The wrenches of tensions
//! within their limits are a zonotope: between two planes for each five cables, with the normal c that all five of their columns are across to,
//!
//! ```text
//! Σ min over u_j of (c·W_j) u_j  ≤  c·w  ≤  Σ max over u_j of (c·W_j) u_j,   j over the other cables.
//! ```
//!
//! Of six cables these are the limits of one tension each.

use arrayvec::ArrayVec;
use nalgebra::{Matrix6, SMatrix, Vector6};

use super::polygon::{Condition, Polygon};
use crate::reach::certificate::section::Section;
use crate::robot::dynamics::Placed;
use crate::robot::{Coordinates, LEAST_CABLES, PerCable, Pose, Rig, TensionLimits};

/// A column, of about length one, of which less than this is across those before it, spans no plane with them.
const FLAT: f64 = 1e-9;
/// Accelerations looked at: up to this many times gravity, and what all cables together give.
const MOST_G: f64 = 100.0;

/// The s'' and s'² at the place s on a section with which there are tensions within `limits`; empty where there are none.
pub fn feasible(rig: &Rig, limits: &PerCable<TensionLimits>, section: &Section, s: f64) -> Polygon {
    let (pose, slope) = (&section.pose(s), &section.slope(s));
    let none = Coordinates::zeros();
    let placed = Placed::new(rig, pose);
    let at_rest = placed.required_wrench(&none, &none);
    let of_a = placed.wrench_of(slope);
    let of_x = placed.required_wrench(slope, &section.bend(s)) - at_rest;
    let most = most(rig, limits, slope);
    // Where the way does not lead on, nothing says how fast.
    if limits.len() != rig.cables.len() || !most.is_finite() {
        return Polygon::none();
    }
    let mut polygon = Polygon::rectangle(most, most);
    let wrenches = [at_rest, of_a, of_x];
    each_plane(rig, limits, pose, wrenches, |[rest, a, x], [least, greatest]| {
        if greatest.is_finite() {
            polygon.clip(&Condition { a, x, bound: greatest - rest });
        }
        if least.is_finite() {
            polygon.clip(&Condition { a: -a, x: -x, bound: rest - least });
        }
        !polygon.is_empty()
    });
    polygon
}

/// The least and the greatest factor f for which there are tensions within `limits` that give the wrench `rest` + f `way`, (N, N m); `None` where there is none.
pub fn between(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    pose: &Pose,
    rest: Vector6<f64>,
    way: Vector6<f64>,
) -> Option<[f64; 2]> {
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    each_plane(rig, limits, pose, [rest, way], |[rest, way], [least, greatest]| {
        let ends = [least - rest, greatest - rest];
        if way == 0.0 {
            let is_kept = ends[0] <= 0.0 && ends[1] >= 0.0;
            range = if is_kept { range } else { [f64::INFINITY, f64::NEG_INFINITY] };
        } else {
            let [a, b] = ends.map(|end| end / way);
            range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
        }
        range[0] <= range[1]
    });
    (range[0] <= range[1] && range[0].is_finite() && range[1].is_finite()).then_some(range)
}

/// Hands over, for each plane, the shares of the wrenches across it, and the least and the greatest that tensions within their limits give; until it is told to stop.
fn each_plane<const N: usize>(
    rig: &Rig,
    limits: &PerCable<TensionLimits>,
    pose: &Pose,
    wrenches: [Vector6<f64>; N],
    mut take: impl FnMut([f64; N], [f64; 2]) -> bool,
) {
    let radius = rig.platform_radius();
    // Torques count as forces at the platform's radius, so that lengths mean something.
    let scaled = |w: &Vector6<f64>| Vector6::from_fn(|k, _| if k < 3 { w[k] } else { w[k] / radius });
    let columns = rig.cables_at(pose).wrench_matrix().map(|column| scaled(&column));
    let wrenches = wrenches.map(|w| scaled(&w));
    if columns.len() < LEAST_CABLES {
        return;
    }
    if columns.len() == LEAST_CABLES {
        // The tensions themselves, u = W⁻¹ w, each within its limits.
        let matrix = Matrix6::from_columns(&std::array::from_fn::<_, LEAST_CABLES, _>(|i| columns[i]));
        let mut tensions = SMatrix::<f64, 6, N>::from_columns(&wrenches);
        if !matrix.lu().solve_mut(&mut tensions) {
            return;
        }
        (0..LEAST_CABLES)
            .all(|i| take(std::array::from_fn(|k| tensions[(i, k)]), [limits[i].min, limits[i].max]));
        return;
    }
    let whole: Basis = (0..6).map(|k| Vector6::ith(k, 1.0)).collect();
    each_normal(&columns, &whole, &mut |normal| {
        let (mut least, mut greatest) = (0.0, 0.0);
        for (column, limits) in columns.iter().zip(limits) {
            let share = normal.dot(column);
            let ends = [share * limits.min, share * limits.max];
            // The five themselves: whatever they pull.
            if share.abs() > FLAT {
                least += ends[0].min(ends[1]);
                greatest += ends[0].max(ends[1]);
            }
        }
        take(wrenches.map(|w| normal.dot(&w)), [least, greatest])
    });
}

/// The greatest s'' and s'² looked at, 1/s².
fn most(rig: &Rig, limits: &PerCable<TensionLimits>, slope: &Coordinates) -> f64 {
    let pulls = limits.iter().map(|limits| limits.max).filter(|max| max.is_finite());
    let fastest = MOST_G * rig.gravity.norm() + pulls.sum::<f64>() / rig.mass;
    let [linear, angular] = [0, 3].map(|k| slope.fixed_rows::<3>(k).norm());
    fastest / (linear + rig.platform_radius() * angular)
}

/// Orthonormal vectors.
type Basis = ArrayVec<Vector6<f64>, 6>;

/// Hands over the vector of length one across each five columns, until it is told to stop; none where five span no plane. `basis` spans what is across the columns chosen
/// before these; false once it was told to.
fn each_normal(
    columns: &[Vector6<f64>],
    basis: &Basis,
    take: &mut impl FnMut(&Vector6<f64>) -> bool,
) -> bool {
    if let [normal] = &basis[..] {
        return take(normal);
    }
    let more = basis.len() - 1;
    (more..=columns.len()).rev().all(|left| {
        let [column, others @ ..] = &columns[columns.len() - left..] else { return true };
        across(basis, column).is_none_or(|rest| each_normal(others, &rest, take))
    })
}

/// A basis of what of `basis` is across a column, too (a Householder reflection turns its first vector into what the column has there); `None` where the column has nothing there.
fn across(basis: &Basis, column: &Vector6<f64>) -> Option<Basis> {
    let mut shares: ArrayVec<f64, 6> = basis.iter().map(|vector| vector.dot(column)).collect();
    let length = shares.iter().map(|share| share * share).sum::<f64>().sqrt();
    if length.is_nan() || length < FLAT {
        return None;
    }
    let first = shares.first_mut()?;
    let factor = 1.0 / (length * (length + first.abs()));
    *first += length.copysign(*first);
    let mirror: Vector6<f64> = basis.iter().zip(&shares).map(|(vector, share)| vector * *share).sum();
    Some(
        basis.iter().zip(&shares).skip(1).map(|(vector, share)| vector - mirror * (factor * share)).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::distribution::widest_margin;
    use crate::robot::RigFile;
    use crate::robot::dynamics::required_wrench;
    use rand::{RngExt, SeedableRng};

    /// The tension distribution, which is another method, finds tensions where this says that there are some, and nowhere else.
    #[test]
    fn there_are_tensions_where_the_planes_say_so() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(6);
        for text in [
            include_str!("../../../rigs/paper.toml"),
            include_str!("../../../rigs/eight.toml"),
            include_str!("../../../rigs/public/acrobot.toml"),
        ] {
            let RigFile { rig, home, .. } = RigFile::parse(text).unwrap();
            let (mut inside, mut outside) = (0, 0);
            for _ in 0..300 {
                let mut any = |size: f64| Coordinates::from_fn(|_, _| rng.random_range(-size..size));
                let (size, pose) = (rig.radius(), Pose(home.0 + any(0.1)));
                let [mut way, mut bend] = [any(1.0), any(1.0)];
                (0..3).for_each(|k| (way[k], bend[k]) = (way[k] * 0.3 * size, bend[k] * 0.3 * size));
                let section = Section { begin: 0.0, coefficients: [pose.0, way, bend, any(1.0)] };
                let polygon = feasible(&rig, &rig.limits(), &section, 0.0);
                let (widest, highest) = (polygon.between(0.0).unwrap_or([-1.0, 1.0]), polygon.highest());
                let a = 1.5 * rng.random_range(widest[0]..widest[1]);
                let x = 1.5 * rng.random_range(0.0..highest.unwrap_or(1.0));
                let wrench =
                    required_wrench(&rig, &pose, &(way * f64::sqrt(x)), &(way * a + bend * (2.0 * x)));
                let margin = widest_margin(&rig, &rig.cables_at(&pose).wrench_matrix(), &wrench);
                let is_in =
                    polygon.between(x).is_some_and(|[least, greatest]| (least..=greatest).contains(&a));
                let is_looked_at =
                    a.abs() < most(&rig, &rig.limits(), &way) && x < most(&rig, &rig.limits(), &way);
                assert!(
                    !is_looked_at || is_in == (margin >= 0.0) || margin.abs() < 1e-6 * rig.weight(),
                    "{margin} {is_in}"
                );
                *(if is_in { &mut inside } else { &mut outside }) += 1;
            }
            println!("{} cables: {inside} inside, {outside} outside", rig.cables.len());
            assert!(inside > 20 && outside > 20);
        }
    }
}
