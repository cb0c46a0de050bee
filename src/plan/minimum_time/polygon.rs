//! Convex polygons of accelerations and speeds along a path: (s'', s'²) that keep every tension within its limits at a place.

use arrayvec::ArrayVec;

/// Corners kept: every condition that cuts adds one at most, and few of them do.
const MOST_CORNERS: usize = 48;

/// Two corners that differ by less than this, as a share of what they are, are one: the line through them says nothing.
const ROUNDING: f64 = 1e-12;

/// Corners in order round it; none where it is empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: ArrayVec<[f64; 2], MOST_CORNERS>,
}

/// The points (a, x) with `a` a + `x` x ≤ `bound`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Factor of s''.
    pub a: f64,
    /// Factor of s'².
    pub x: f64,
    /// The bound.
    pub bound: f64,
}

impl Condition {
    /// What is left of the bound, less than 0 outside.
    fn left(&self, [a, x]: [f64; 2]) -> f64 {
        self.bound - self.a * a - self.x * x
    }
}

impl Polygon {
    /// |s''| ≤ `a`, 0 ≤ s'² ≤ `x`.
    pub fn rectangle(a: f64, x: f64) -> Self {
        Self { corners: [[-a, 0.0], [a, 0.0], [a, x], [-a, x]].into_iter().collect() }
    }

    /// Nothing.
    pub fn none() -> Self {
        Self { corners: ArrayVec::new() }
    }

    /// Whether the platform may rest: whether s'' = s'² = 0 is in it.
    pub fn has_rest(&self) -> bool {
        self.between(0.0).is_some_and(|[least, greatest]| least <= 0.0 && greatest >= 0.0)
    }

    /// Whether no point is in it.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Leaves what meets a condition (Sutherland and Hodgman). With more corners than are kept, nothing.
    pub fn clip(&mut self, condition: &Condition) {
        let inside = |corner: &[f64; 2]| condition.left(*corner) >= 0.0;
        if self.corners.iter().all(inside) {
            return;
        }
        let mut clipped = ArrayVec::new();
        for (k, corner) in self.corners.iter().enumerate() {
            let next = self.corners[(k + 1) % self.corners.len()];
            let (here, there) = (condition.left(*corner), condition.left(next));
            let crossing = |share: f64| [0, 1].map(|i| corner[i] + (next[i] - corner[i]) * share);
            let is_crossed = (here >= 0.0) != (there >= 0.0);
            let added =
                [(here >= 0.0).then_some(*corner), is_crossed.then(|| crossing(here / (here - there)))];
            if added.into_iter().flatten().any(|corner| clipped.try_push(corner).is_err()) {
                clipped.clear();
                break;
            }
        }
        self.corners = clipped;
    }

    /// Leaves what leads into `next` at a place `ds` farther on: with s'² = x + 2 s'' ds there.
    pub fn clip_to_reach(&mut self, next: &Self, ds: f64) {
        if next.is_empty() {
            self.corners.clear();
        }
        for (k, [a0, x0]) in next.corners.iter().enumerate() {
            let [a1, x1] = next.corners[(k + 1) % next.corners.len()];
            // Inside is on the left of each edge: (a1 - a0)(x - x0) - (x1 - x0)(a - a0) ≥ 0.
            let (across, along) = (x1 - x0, a1 - a0);
            let at_next = Condition { a: across, x: -along, bound: across * a0 - along * x0 };
            let is_rounding = |length: f64, a: f64, b: f64| length.abs() <= ROUNDING * a.abs().max(b.abs());
            if is_rounding(along, *a0, a1) && is_rounding(across, *x0, x1) {
                continue;
            }
            self.clip(&Condition { a: at_next.a + 2.0 * ds * at_next.x, ..at_next });
        }
    }

    /// The greatest s'² in it.
    pub fn highest(&self) -> Option<f64> {
        self.corners.iter().map(|corner| corner[1]).reduce(f64::max)
    }

    /// The least and the greatest s'' at an s'².
    pub fn between(&self, x: f64) -> Option<[f64; 2]> {
        let mut range: Option<[f64; 2]> = None;
        let mut include = |a: f64| {
            let [least, greatest] = range.unwrap_or([a, a]);
            range = Some([least.min(a), greatest.max(a)]);
        };
        for (k, [a0, x0]) in self.corners.iter().enumerate() {
            let [a1, x1] = self.corners[(k + 1) % self.corners.len()];
            if *x0 == x {
                include(*a0);
            } else if (*x0 < x) != (x1 < x) && x1 != x {
                include(a0 + (a1 - a0) * ((x - x0) / (x1 - x0)));
            }
        }
        range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn what_is_left_is_what_meets_every_condition() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        let mut kept = 0;
        for _ in 0..500 {
            let mut any = || rng.random_range(-1.0..1.0);
            let conditions: Vec<Condition> =
                (0..12).map(|_| Condition { a: any(), x: any(), bound: 0.6 + 0.5 * any() }).collect();
            let mut polygon = Polygon::rectangle(2.0, 3.0);
            conditions.iter().for_each(|condition| polygon.clip(condition));
            for _ in 0..50 {
                let point = [2.0 * any(), 1.5 + 1.5 * any()];
                let worst = conditions.iter().map(|c| c.left(point)).fold(f64::INFINITY, f64::min);
                let range = polygon.between(point[1]);
                let is_in = range.is_some_and(|[least, greatest]| (least..=greatest).contains(&point[0]));
                assert!(worst.abs() < 1e-9 || is_in == (worst > 0.0), "{point:?} {worst} {range:?}");
                kept += usize::from(is_in);
            }
            if let Some(highest) = polygon.highest() {
                assert!(
                    polygon.between(highest - 1e-9).is_some() && polygon.between(highest + 1e-9).is_none()
                );
            }
        }
        assert!(kept > 500, "{kept}");
    }

    /// An edge as short as rounding pointed anywhere, and left nothing of what led there: ways of eight cables along an axis had no motion.
    #[test]
    fn corners_that_are_one_but_for_rounding_cut_nothing() {
        let corner: f64 = -37.807_663_675_714_63;
        let next = Polygon {
            corners: [[-41.8, 0.0], [32.5, 0.0], [32.5, 0.0], [corner, 131.917], [corner.next_up(), 131.917]]
                .into_iter()
                .collect(),
        };
        let mut here = Polygon::rectangle(30.0, 120.0);
        here.clip_to_reach(&next, 0.015);
        assert!(here.has_rest() && here.highest().unwrap() > 100.0);
    }

    #[test]
    fn what_leads_into_the_next_is_left() {
        let mut here = Polygon::rectangle(1.0, 4.0);
        let next = Polygon::rectangle(1.0, 1.0);
        here.clip_to_reach(&next, 0.5);
        // x + a within [0, 1], a within [-1, 1].
        assert!((here.highest().unwrap() - 2.0).abs() < 1e-12);
        let [least, greatest] = here.between(1.5).unwrap();
        assert!((least + 1.0).abs() < 1e-12 && (greatest + 0.5).abs() < 1e-12, "{least} {greatest}");
        let [least, greatest] = here.between(0.0).unwrap();
        assert!(least.abs() < 1e-12 && (greatest - 1.0).abs() < 1e-12);
    }
}
