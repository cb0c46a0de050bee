//! The least of a few straight lines, from left to right.

use arrayvec::ArrayVec;

/// From `s` on the value is `value` + `slope` (· - `s`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub s: f64,
    /// There.
    pub value: f64,
    /// Its growth.
    pub slope: f64,
}

impl Ray {
    /// The value at a place.
    pub fn at(&self, s: f64) -> f64 {
        self.value + self.slope * (s - self.s)
    }

    /// The same line from another place on.
    fn from(&self, s: f64) -> Self {
        Self { s, value: self.at(s), slope: self.slope }
    }
}

/// Appends to `row` the least of `lines`, which all begin at the same place, up to `end`: each of them makes one piece of it at most.
pub fn least<const N: usize>(lines: &[Ray], end: f64, row: &mut ArrayVec<Ray, N>) {
    let order = |a: &&Ray, b: &&Ray| (a.value, a.slope).partial_cmp(&(b.value, b.slope));
    let Some(first) = lines.iter().min_by(|a, b| order(a, b).unwrap_or(std::cmp::Ordering::Equal)).copied()
    else {
        return;
    };
    let mut lowest = first;
    row.push(lowest);
    loop {
        // Only lines that fall faster come below it.
        let crossings = lines.iter().filter(|line| line.slope < lowest.slope).map(|line| {
            let gap = line.at(lowest.s) - lowest.value;
            (lowest.s + gap.max(0.0) / (lowest.slope - line.slope), line)
        });
        let next = crossings.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.slope.total_cmp(&b.1.slope)));
        let Some((place, line)) = next.filter(|(place, _)| *place < end) else { return };
        lowest = line.from(place);
        row.push(lowest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_least_of_lines_is_found_everywhere() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        for case in 0..2000 {
            let mut any = || rng.random_range(-1.0..1.0);
            let lines: Vec<Ray> =
                (0..1 + case % 6).map(|_| Ray { s: 0.5, value: any(), slope: any() }).collect();
            let mut row: ArrayVec<Ray, 6> = ArrayVec::new();
            least(&lines, 3.0, &mut row);
            assert_eq!(row[0].s, 0.5);
            for k in 0..=100 {
                let s = 0.5 + 2.5 * f64::from(k) / 100.0;
                let wanted = lines.iter().map(|line| line.at(s)).fold(f64::INFINITY, f64::min);
                let found = row.iter().rfind(|ray| ray.s <= s).unwrap().at(s);
                assert!((found - wanted).abs() < 1e-12, "{lines:?} {s}");
            }
        }
    }
}
