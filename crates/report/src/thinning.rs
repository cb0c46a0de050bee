//! Which rows of a recording are drawn.

/// Rows at equal distances, for a smooth play.
const EVEN: usize = 1_000;
/// Groups of rows of which each column's extremes are drawn as well.
const GROUPS: usize = 300;

/// At most 1,000 rows at equal distances, in each of 300 groups of rows the least and the greatest value of every column, and the rows
/// in `also`: in order, each once.
pub fn drawn_rows(rows: usize, columns: &[&[f64]], also: &[usize]) -> Vec<usize> {
    let mut drawn: Vec<usize> = (0..rows).step_by(rows.div_ceil(EVEN).max(1)).collect();
    drawn.extend(rows.checked_sub(1));
    drawn.extend(also);
    for start in (0..rows).step_by(rows.div_ceil(GROUPS).max(1)) {
        let end = rows.min(start + rows.div_ceil(GROUPS));
        for column in columns {
            // The first of equals, so that a column at rest adds nothing.
            let by_value = |a: &usize, b: &usize| column[*a].total_cmp(&column[*b]).then(b.cmp(a));
            drawn.extend((start..end).max_by(by_value));
            drawn.extend((start..end).min_by(|a, b| column[*a].total_cmp(&column[*b])));
        }
    }
    drawn.sort_unstable();
    drawn.dedup();
    drawn
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
    fn extremes_ends_and_what_was_asked_for_are_kept() {
        let mut column: Vec<f64> = (0..20_000).map(|k| (f64::from(k) / 3e3).sin()).collect();
        (column[7_777], column[7_778]) = (-9.0, 9.0);
        let drawn = drawn_rows(20_000, &[&column, &vec![1.0; 20_000]], &[13]);
        assert!(drawn.is_sorted_by(|a, b| a < b));
        for row in [0, 13, 7_777, 7_778, 19_999] {
            assert!(drawn.contains(&row), "{row}");
        }
        assert!(drawn.len() < EVEN + 3 * GROUPS, "{}", drawn.len());
    }

    #[test]
    fn what_is_huge_stays_a_number() {
        assert_eq!((rounded(0.123_456_7, 1e6), rounded(1e305, 1e6)), (0.123_457, 1e305));
    }

    #[test]
    fn short_recordings_are_kept_whole() {
        assert_eq!(drawn_rows(3, &[&[2.0, 1.0, 3.0]], &[]), [0, 1, 2]);
        assert_eq!(drawn_rows(1, &[&[2.0]], &[]), [0]);
    }
}
