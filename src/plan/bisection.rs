//! The bisection after Eq. (17): the smallest admissible β in [0, 1], to within 2^-N.

/// β⁺ after `steps` (N) halvings; 0 at once if that is admissible, 1 if nothing else was found.
/// `admissible` must hold from some β on up to 1.
pub fn smallest_admissible(steps: i32, mut admissible: impl FnMut(f64) -> bool) -> f64 {
    if admissible(0.0) {
        return 0.0;
    }
    let (mut below, mut above) = (0.0, 1.0);
    for _ in 0..steps {
        let beta = 0.5 * (below + above);
        if admissible(beta) {
            above = beta;
        } else {
            below = beta;
        }
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_first_grid_point_above_the_threshold() {
        assert_eq!(smallest_admissible(8, |beta| beta >= 0.3), 77.0 / 256.0);
        assert_eq!(smallest_admissible(8, |_| true), 0.0);
        assert_eq!(smallest_admissible(8, |_| false), 1.0);
    }
}
