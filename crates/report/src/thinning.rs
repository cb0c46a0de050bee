//! Which rows of a recording are drawn.

use std::ops::Range;

/// Rows at equal distances, for a smooth play.
const EVEN: usize = 1_000;
/// Groups of rows of which each column's extremes are drawn as well.
const GROUPS: usize = 300;

/// How many rows of a run of so many are a group: each column's extremes in it are drawn.
pub fn group(rows: usize) -> usize {
    rows.div_ceil(GROUPS).max(1)
}

/// Whether this row of a run of so many is one of the 1,000 at equal distances, or the last.
pub fn is_even(row: usize, rows: usize) -> bool {
    row.is_multiple_of(rows.div_ceil(EVEN).max(1)) || row + 1 == rows
}

/// The rows in which a column is least or greatest, for each column: in order, each once.
pub fn extremes(columns: &[&[f64]], rows: Range<usize>) -> Vec<usize> {
    let mut found = vec![];
    for column in columns {
        // The first of equals, so that a column at rest adds nothing.
        let by_value = |a: &usize, b: &usize| column[*a].total_cmp(&column[*b]).then(b.cmp(a));
        found.extend(rows.clone().max_by(by_value));
        found.extend(rows.clone().min_by(|a, b| column[*a].total_cmp(&column[*b])));
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Without the digits that no screen shows: `steps` of them to the unit.
pub fn rounded(value: f64, steps: f64) -> f64 {
    let rounded = (value * steps).round() / steps;
    if rounded.is_finite() { rounded } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_the_first_of_equals() {
        let mut column: Vec<f64> = (0..2_000).map(|k| (f64::from(k) / 3e3).sin()).collect();
        (column[777], column[778]) = (-9.0, 9.0);
        let rest = vec![1.0; 2_000];
        assert_eq!(extremes(&[&column, &rest], 100..1_000), [100, 777, 778]);
        assert_eq!(extremes(&[&rest], 1_999..2_000), [1_999]);
    }

    #[test]
    fn what_is_huge_stays_a_number() {
        assert_eq!((rounded(0.123_456_7, 1e6), rounded(1e305, 1e6)), (0.123_457, 1e305));
    }

    #[test]
    fn rows_at_equal_distances_are_a_thousand_at_most_and_the_last() {
        let count = |rows: usize| (0..rows).filter(|row| is_even(*row, rows)).count();
        assert_eq!([1, 3, 1_000, 1_001, 20_000, 1_000_001].map(count), [1, 3, 1_000, 501, 1_001, 1_001]);
        assert_eq!([0, 300, 301, 20_000].map(group), [1, 1, 2, 67]);
    }
}
